//! `robhaz view`: looks at runs, or at a scene while it is simulated.

use crate::live::{Rerun, Viewing};
use crate::pace::{Pace, PaceSink};
use crate::progress::Progress;
use crate::terminal::{say, warn};
use miette::{IntoDiagnostic, Result, WrapErr, bail};
use robhaz_run::Sink;
use robhaz_scene::Scene;
use robhaz_viewer::{ComparedRun, PictureOptions};
use std::path::{Path, PathBuf};

/// Arguments of `robhaz view`.
#[derive(clap::Args)]
pub struct Args {
    /// Folders of runs or their recordings (.rrd); several are shown side by side. Or one scene file (.toml): it is simulated and
    /// shown live.
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
    /// Saves the comparison of several runs as one recording instead of opening it.
    #[arg(long, value_name = "FILE", conflicts_with = "screenshot")]
    save: Option<PathBuf>,
    /// How fast a scene is simulated.
    #[arg(long, value_enum, default_value_t = Pace::RealTime)]
    pace: Pace,
    /// Sets a key of the scene, over what the file says. Can be repeated.
    #[arg(long, value_name = "KEY=VALUE")]
    set: Vec<String>,
}

/// Opens the viewer on what was named, or saves what was asked for.
pub fn run(args: &Args) -> Result<()> {
    if let [scene] = args.what.as_slice()
        && is_scene(scene)
    {
        if args.screenshot.is_some() || args.save.is_some() {
            bail!(
                "{} is a scene: run it first, then `robhaz view` its folder",
                scene.display()
            );
        }
        let scene = Scene::load(scene, &args.set)?;
        warn(&scene);
        return live(&scene, args.pace);
    }
    if let Some(scene) = args.what.iter().find(|path| is_scene(path)) {
        bail!(
            "{} is a scene: several can only be compared after `robhaz run`",
            scene.display()
        );
    }
    if let Some(set) = args.set.first() {
        bail!("--set {set} is for scenes; a run has been simulated already");
    }
    let single = args.what.len() == 1;
    if let (true, Some(file)) = (single, &args.save) {
        bail!(
            "--save {} is for several runs; one run has its recording already",
            file.display()
        );
    }
    if single {
        return show(&recording(&args.what[0])?, args);
    }
    if let Some(file) = &args.save {
        compare(&args.what, file)?;
        return say(&format!("Comparison in {}", file.display()));
    }
    let file = Temporary::new();
    compare(&args.what, &file.0)?;
    show(&file.0, args)
}

fn show(recording: &Path, args: &Args) -> Result<()> {
    let Some(picture) = &args.screenshot else {
        return robhaz_viewer::open(&[recording.to_path_buf()]).into_diagnostic();
    };
    let options = PictureOptions {
        size: args.size,
        at: args.at,
    };
    robhaz_viewer::picture(recording, picture, options).into_diagnostic()?;
    say(&format!("Picture in {}", picture.display()))
}

/// Simulates a scene and shows it while it goes on; nothing is kept.
fn live(scene: &Scene, pace: Pace) -> Result<()> {
    let mut viewing = Viewing::open(&Rerun::Spawn)?;
    let (mut progress, mut pace) = (Progress::new(), PaceSink::new(pace));
    let mut sinks: Vec<&mut dyn Sink> = viewing.sinks().collect();
    sinks.push(&mut progress);
    sinks.push(&mut pace);
    robhaz_run::run(scene, &mut sinks)
        .into_diagnostic()
        .wrap_err_with(|| format!("cannot finish {}", scene.name))?;
    viewing.finish()
}

/// Writes the comparison of finished runs.
fn compare(runs: &[PathBuf], file: &Path) -> Result<()> {
    let mut found = Vec::new();
    for run in runs {
        let scene = run.join("scene.toml");
        if !scene.is_file() {
            bail!(
                "{} has no scene.toml: a comparison takes the folders of runs",
                run.display()
            );
        }
        let label = run.display().to_string();
        found.push((label, Scene::load(&scene, &[])?, recording(run)?));
    }
    let runs: Vec<ComparedRun<'_>> = found
        .iter()
        .map(|(label, scene, recording)| ComparedRun {
            label: label.trim_end_matches('/'),
            scene,
            recording,
        })
        .collect();
    robhaz_viewer::save_comparison(&runs, file).into_diagnostic()
}

fn is_scene(path: &Path) -> bool {
    path.extension().is_some_and(|e| e == "toml")
}

/// The recording of a run: the file itself, or the one in the folder.
fn recording(run: &Path) -> Result<PathBuf> {
    let file = if run.is_dir() {
        run.join("run.rrd")
    } else {
        run.to_path_buf()
    };
    if file.extension().is_none_or(|e| e != "rrd") {
        bail!(
            "{} is neither the folder of a run, nor a recording (.rrd), nor a scene (.toml)",
            run.display()
        );
    }
    if !file.is_file() {
        bail!(
            "{} is not there: run the scene without `--rerun off`",
            file.display()
        );
    }
    Ok(file)
}

/// Width and height as in 1400x900.
fn size(text: &str) -> Result<[u32; 2], String> {
    let allowed = 200..=4000;
    let parsed = text
        .split_once('x')
        .and_then(|(w, h)| Some([w.parse().ok()?, h.parse().ok()?]));
    parsed
        .filter(|size: &[u32; 2]| size.iter().all(|s| allowed.contains(s)))
        .ok_or_else(|| "allowed is WIDTHxHEIGHT with 200 to 4000 pixels each".to_owned())
}

/// A file that is gone when it was looked at.
struct Temporary(PathBuf);

impl Temporary {
    fn new() -> Self {
        let name = format!("robhaz-comparison-{}.rrd", std::process::id());
        Self(std::env::temp_dir().join(name))
    }
}

impl Drop for Temporary {
    fn drop(&mut self) {
        // Where it was never written there is nothing to remove.
        let _ = std::fs::remove_file(&self.0);
    }
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
