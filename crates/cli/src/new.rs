//! `robhaz new`: a scene to edit.

use crate::choice::{Choice, choice, choices};
use crate::output_file::{Format, OutputFile};
use crate::terminal::{shown, tell, word};
use miette::{Result, bail};
use serde_json::json;
use std::path::PathBuf;

const SCENE: Format = ("scenes", "toml");

/// The robots, each with the text of its scene.
const ROBOTS: &[Choice<&str>] = choices! {
    "four-bar", "A four-bar linkage on each side, as ROBHAZ-6WHEEL: geometry A" => include_str!("new_scene.toml");
    "rocker-bogie", "A rocker, fixed to the body by the differential, with the rear wheel, and a bogie with two in front: with the dimensions of the Open Source Rover" => include_str!("../../../robots/open-source-rover.toml");
    "rocker-bogie-rear", "The same with the bogie at the rear: with the dimensions of Curiosity" => include_str!("../../../robots/curiosity.toml");
    "triple-bogie", "A bogie with two wheels on each side, and one across the rear: with the dimensions of ExoMy" => include_str!("../../../robots/exomy.toml");
};

/// Arguments of `robhaz new`.
#[derive(clap::Args)]
pub struct Args {
    /// Name of the scene; its file is NAME.toml. A path puts it elsewhere.
    name: PathBuf,
    /// Its robot; each number of a rover has its source beside it, to be replaced by your own
    #[arg(long, value_parser = choice(ROBOTS), default_value = "four-bar")]
    robot: &'static str,
    /// Replaces an existing file.
    #[arg(long)]
    force: bool,
}

/// Writes the file.
pub fn run(args: &Args) -> Result<()> {
    // Without a slash at the end.
    let mut target: PathBuf = args.name.components().collect();
    if target.file_name().is_none() || target.is_dir() {
        bail!(
            "{} is a folder; allowed: the name of a scene, such as {}",
            args.name.display(),
            target.join("my-scene").display()
        );
    }
    if target.extension().is_none_or(|e| e != SCENE.1) {
        target.as_mut_os_string().push(".toml");
    }
    let file = OutputFile::create(&target, SCENE, &[], args.force)?;
    file.write(args.robot)?;
    let path = file.finish()?;
    let (shown, word) = (shown(&path), word(&path));
    let text =
        format!("{shown}: edit it, then `robhaz run {word}`. `robhaz keys` explains its keys.");
    tell(&text, &json!({"scene": shown}))
}
