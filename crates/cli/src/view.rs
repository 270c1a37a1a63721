//! `robhaz view`: shows runs, or a scene while it is simulated.

use crate::interrupt;
use crate::live::{Rerun, Viewing};
use crate::output_file::{Format, OutputFile};
use crate::progress::{self, Pace, Progress};
use crate::terminal::{say, warn, word};
use miette::{IntoDiagnostic, Result, WrapErr, bail};
use robhaz_run::{Run, Sink};
use robhaz_scene::Scene;
use std::path::{Path, PathBuf};

/// Arguments of `robhaz view`.
#[derive(clap::Args)]
pub struct Args {
    /// Folders of runs or their recordings (.rrd), shown in one viewer. Or one scene file (.toml):
    /// it is simulated and shown live.
    #[arg(required = true, value_name = "RUN|SCENE")]
    what: Vec<PathBuf>,
    /// Saves a picture of the viewer (PNG) instead of opening it; needs no screen.
    #[arg(long, value_name = "FILE")]
    screenshot: Option<PathBuf>,
    /// Simulated time that the picture shows, s; by default the middle of the run.
    #[arg(long, value_name = "SECONDS", requires = "screenshot")]
    at: Option<f64>,
    /// Size of the picture in pixels.
    #[arg(long, value_name = "WIDTHxHEIGHT", requires = "screenshot", value_parser = size, default_value = "1400x900")]
    size: [u32; 2],
    /// Replaces an existing picture.
    #[arg(long)]
    force: bool,
    /// Speed of the simulation of a scene; `real-time` by default.
    #[arg(long, value_enum)]
    pace: Option<Pace>,
    /// Sets a key of the scene, in place of the file's value. Can be repeated.
    #[arg(long, value_name = "KEY=VALUE")]
    set: Vec<String>,
}

/// The resolved scene in the folder of a run.
const SCENE: &str = "scene.toml";

const PICTURE: Format = ("pictures", "png");

/// Opens the viewer with the runs or the scene, or saves a picture.
pub fn run(args: &Args) -> Result<()> {
    check(args)?;
    if let [scene] = args.what.as_slice()
        && is_scene(scene)
    {
        let scene = Scene::load(scene, &args.set)?;
        warn(&scene);
        return live(&scene, args.pace.unwrap_or(Pace::RealTime));
    }
    let Some(picture) = &args.screenshot else {
        interrupt::listen()?;
        let recordings = args.what.iter().map(|run| recording(run));
        let recordings = recordings.collect::<Result<Vec<_>>>()?;
        return robhaz_viewer::open(&recordings, &interrupt::cause).into_diagnostic();
    };
    let [run] = args.what.as_slice() else {
        bail!("--screenshot takes one run");
    };
    // Checked before the work, so that a bad file name costs no time.
    let file = OutputFile::create(picture, PICTURE, &[recording(run)?], args.force)?;
    let stop = || interrupt::cause();
    robhaz_viewer::picture(&recording(run)?, file.path(), args.size, args.at, &stop)
        .into_diagnostic()?;
    say(&format!("Picture in {}", file.finish()?.display()))
}

/// Refuses arguments that cannot be combined.
fn check(args: &Args) -> Result<()> {
    if let Some(scene) = args.what.iter().find(|path| is_scene(path)) {
        if args.what.len() > 1 || args.screenshot.is_some() {
            bail!(
                "{} is a scene: run it first, then `robhaz view` its folder",
                scene.display()
            );
        }
        return Ok(());
    }
    if let Some(set) = args.set.first() {
        bail!("--set {set} is for scenes; a run has been simulated already");
    }
    if args.pace.is_some() {
        bail!("--pace is for scenes; a run has been simulated already");
    }
    if args.force && args.screenshot.is_none() {
        bail!("--force is for --screenshot: nothing else is written");
    }
    Ok(())
}

/// Simulates a scene and shows it live; writes no files.
fn live(scene: &Scene, pace: Pace) -> Result<()> {
    let mut viewing = Viewing::open(&Rerun::Live(None))?;
    interrupt::listen()?;
    let (mut progress, mut pace) = (Progress::new(), progress::pace(pace));
    let mut sinks: Vec<&mut dyn Sink> = viewing.sinks().collect();
    sinks.push(&mut progress);
    sinks.push(&mut pace);
    Run::new(scene)
        .and_then(|run| run.until(&mut sinks, &interrupt::cause))
        .into_diagnostic()
        .wrap_err_with(|| format!("cannot finish {}", scene.name))?;
    viewing.finish(None)
}

fn is_scene(path: &Path) -> bool {
    path.extension().is_some_and(|e| e == "toml")
}

/// The recording of a run: the file itself, or the one in the folder.
fn recording(run: &Path) -> Result<PathBuf> {
    let file = match run.is_dir() {
        true => run.join("run.rrd"),
        false => run.to_path_buf(),
    };
    if file.extension().is_none_or(|e| e != "rrd") {
        bail!(
            "{} is neither the folder of a run, nor a recording (.rrd), nor a scene (.toml)",
            run.display()
        );
    }
    if !file.is_file() {
        bail!(
            "{} is not there: `robhaz view {}` simulates the run again and shows it; a run by a robhaz with the viewer, \
             without `--rerun off`, keeps a recording",
            file.display(),
            word(&file.with_file_name(SCENE))
        );
    }
    Ok(file)
}

/// Width and height as in 1400x900.
fn size(text: &str) -> Result<[u32; 2], String> {
    let allowed = 200..=4000;
    let parsed = text.split_once('x');
    let parsed = parsed.and_then(|(w, h)| Some([w.parse().ok()?, h.parse().ok()?]));
    parsed
        .filter(|size: &[u32; 2]| size.iter().all(|s| allowed.contains(s)))
        .ok_or_else(|| "allowed is WIDTHxHEIGHT with 200 to 4000 pixels each".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_are_two_numbers_within_reason() {
        assert_eq!(size("1400x900"), Ok([1400, 900]));
        for bad in ["", "1400", "1400x", "x900", "10x10", "99999x900", "-1x900"] {
            assert!(size(bad).is_err(), "{bad}");
        }
    }
}
