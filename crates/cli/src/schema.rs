//! `robhaz schema`: JSON Schema of the files that people write.

use crate::terminal::print_json;
use miette::Result;
use robhaz_scene::{SchemaKind, schema};

/// Arguments of `robhaz schema`.
#[derive(clap::Args)]
pub struct Args {
    /// Kind of file.
    kind: Kind,
}

#[derive(Clone, Copy, clap::ValueEnum)]
enum Kind {
    /// Scenes, and files with the section robot of a scene.
    Scene,
    /// Studies of `robhaz study`.
    Study,
    /// Geometries of robots, as in robots/geometry-a.toml.
    Geometry,
    /// Masses of robots, as in robots/mass-caption.toml.
    Mass,
    /// Descriptions of logs, as in examples/logs/SENSORS.toml.
    Sensors,
}

/// Prints the schema.
pub fn run(args: &Args) -> Result<()> {
    let kind = match args.kind {
        Kind::Scene => SchemaKind::Scene,
        Kind::Study => SchemaKind::Study,
        Kind::Geometry => SchemaKind::Geometry,
        Kind::Mass => SchemaKind::Mass,
        Kind::Sensors => SchemaKind::Sensors,
    };
    print_json(&schema(kind))
}
