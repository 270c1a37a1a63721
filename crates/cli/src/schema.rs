//! `robhaz schema`: JSON Schema of the files that people write.

use crate::choice::{Choice, choice, choices};
use crate::terminal::print_json;
use miette::Result;
use robhaz_scene::{SchemaKind, schema};

/// Arguments of `robhaz schema`.
#[derive(clap::Args)]
pub struct Args {
    /// Kind of file.
    #[arg(value_parser = choice(KINDS))]
    kind: SchemaKind,
}

const KINDS: &[Choice<SchemaKind>] = choices! {
    "scene", "Scenes, and files with the section robot of a scene" => SchemaKind::Scene;
    "study", "Studies of `robhaz study`" => SchemaKind::Study;
    "geometry", "Geometries of robots, as in robots/geometry-a.toml" => SchemaKind::Geometry;
    "mass", "Masses of robots, as in robots/mass-caption.toml" => SchemaKind::Mass;
    "sensors", "Descriptions of logs, as in examples/logs/SENSORS.toml" => SchemaKind::Sensors;
};

/// Prints the schema.
pub fn run(args: &Args) -> Result<()> {
    print_json(&schema(args.kind))
}
