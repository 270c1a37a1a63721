//! `robhaz view`: shows runs, or a scene while it is simulated.

use crate::interrupt::Interrupt;
use crate::live::{Rerun, Viewing};
use crate::output_file::{Format, OutputFile};
use crate::pace::{Pace, PaceSink};
use crate::progress::Progress;
use crate::terminal::{remark, say, warn};
use miette::{IntoDiagnostic, Result, WrapErr, bail};
use robhaz_log::LogPlace;
use robhaz_record::Summary;
use robhaz_run::{RunDescription, Sink};
use robhaz_scene::{LogChoice, RecordChoice, Scene};
use robhaz_viewer::{ComparedRun, PictureOptions};
use std::path::{Path, PathBuf};

/// Arguments of `robhaz view`.
#[derive(clap::Args)]
pub struct Args {
    /// Folders of runs or their recordings (.rrd); several are shown side by side. Or one scene file (.toml): it is
    /// simulated and shown live.
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
    /// Replaces an existing file of --save or --screenshot.
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

const PICTURE: Format = Format {
    what: "pictures",
    extension: "png",
};
/// Recordings for the viewer.
const RECORDING: Format = Format {
    what: "recordings",
    extension: "rrd",
};

/// Opens the viewer with the runs or the scene, or saves a picture or a comparison.
pub fn run(args: &Args, interrupt: &Interrupt) -> Result<()> {
    check(args)?;
    if let [scene] = args.what.as_slice()
        && is_scene(scene)
    {
        let scene = Scene::load(scene, &args.set)?;
        warn(&scene);
        return live(&scene, args.pace.unwrap_or(Pace::RealTime), interrupt);
    }
    let inputs = inputs(&args.what)?;
    // Checked before the work, so that a bad file name costs no time.
    let output = |file: &Option<PathBuf>, format| {
        let create = |file: &PathBuf| OutputFile::create(file, format, &inputs, args.force);
        file.as_ref().map(create).transpose()
    };
    let (picture, comparison) = (
        output(&args.screenshot, PICTURE)?,
        output(&args.save, RECORDING)?,
    );
    interrupt.listen()?;
    if let [run] = args.what.as_slice() {
        return show(&recording(run)?, args, picture, interrupt);
    }
    if let Some(file) = comparison {
        compare(&args.what, file.path(), interrupt)?;
        return say(&format!("Comparison in {}", file.finish()?.display()));
    }
    let file = tempfile::Builder::new()
        .prefix("robhaz-comparison-")
        .suffix(".rrd")
        .tempfile()
        .into_diagnostic()?
        .into_temp_path();
    compare(&args.what, &file, interrupt)?;
    show(&file, args, picture, interrupt)
}

/// Refuses arguments that cannot be combined.
fn check(args: &Args) -> Result<()> {
    let scene = args.what.iter().find(|path| is_scene(path));
    match (args.what.as_slice(), scene) {
        ([_], Some(scene)) if args.screenshot.is_some() || args.save.is_some() => bail!(
            "{} is a scene: run it first, then `robhaz view` its folder",
            scene.display()
        ),
        ([_], Some(_)) => return Ok(()),
        (_, Some(scene)) => bail!(
            "{} is a scene: several can only be compared after `robhaz run`",
            scene.display()
        ),
        (_, None) => {}
    }
    if let Some(set) = args.set.first() {
        bail!("--set {set} is for scenes; a run has been simulated already");
    }
    if args.pace.is_some() {
        bail!("--pace is for scenes; a run has been simulated already");
    }
    if args.force && args.save.is_none() && args.screenshot.is_none() {
        bail!("--force is for --save and --screenshot: nothing else is written");
    }
    if let ([_], Some(file)) = (args.what.as_slice(), &args.save) {
        bail!(
            "--save {} is for several runs; one run has its recording already",
            file.display()
        );
    }
    Ok(())
}

fn show(
    recording: &Path,
    args: &Args,
    picture: Option<OutputFile>,
    interrupt: &Interrupt,
) -> Result<()> {
    let stop = || interrupt.cause();
    let Some(file) = picture else {
        return robhaz_viewer::open(&[recording.to_path_buf()], &stop).into_diagnostic();
    };
    let options = PictureOptions {
        size: args.size,
        at: args.at,
    };
    robhaz_viewer::picture(recording, file.path(), options, &stop).into_diagnostic()?;
    say(&format!("Picture in {}", file.finish()?.display()))
}

/// Simulates a scene and shows it live; writes no files.
fn live(scene: &Scene, pace: Pace, interrupt: &Interrupt) -> Result<()> {
    let mut viewing = Viewing::open(&Rerun::Spawn)?;
    interrupt.listen()?;
    let (mut progress, mut pace) = (Progress::new(), PaceSink::new(pace, interrupt));
    let mut sinks: Vec<&mut dyn Sink> = viewing.sinks().collect();
    sinks.push(&mut progress);
    sinks.push(&mut pace);
    robhaz_run::run_until(scene, &mut sinks, &|| interrupt.cause())
        .into_diagnostic()
        .wrap_err_with(|| format!("cannot finish {}", scene.name))?;
    viewing.finish(interrupt)
}

/// Writes the comparison of runs.
fn compare(runs: &[PathBuf], file: &Path, interrupt: &Interrupt) -> Result<()> {
    let mut found = Vec::new();
    for run in runs {
        let label = run.display().to_string();
        found.push((label, described(run)?, recording(run)?));
    }
    let runs: Vec<ComparedRun<'_>> = found
        .iter()
        .map(|(label, description, recording)| ComparedRun {
            label: label.trim_end_matches('/'),
            description,
            recording,
        })
        .collect();
    robhaz_viewer::save_comparison(&runs, file, &|| interrupt.cause()).into_diagnostic()
}

/// The files that are read: recordings, and in a comparison the scenes.
fn inputs(runs: &[PathBuf]) -> Result<Vec<PathBuf>> {
    let mut inputs = Vec::new();
    for run in runs {
        if runs.len() > 1 {
            inputs.push(description_file(run)?);
        }
        inputs.push(recording_file(run)?);
    }
    Ok(inputs)
}

/// The resolved scene of a run to be compared, or the description of an estimated log.
fn description_file(run: &Path) -> Result<PathBuf> {
    let names = [SCENE, LogPlace::DESCRIPTION];
    let mut paths = names.iter().map(|name| run.join(name));
    let Some(path) = paths.find(|path| path.is_file()) else {
        bail!(
            "{} has no {SCENE} or {}: a comparison takes the folders of runs",
            run.display(),
            LogPlace::DESCRIPTION
        );
    };
    Ok(path)
}

/// What was known of a run before its first record.
fn described(run: &Path) -> Result<RunDescription> {
    let file = description_file(run)?;
    if file.ends_with(SCENE) {
        return RunDescription::of(&Scene::load(&file, &[])?).into_diagnostic();
    }
    let choice = LogChoice::load(&file, LogChoice::default())?;
    let summary = Summary::read(run).into_diagnostic()?;
    let record = RecordChoice {
        duration: summary.duration_s,
        rate: summary.record_rate_hz,
        compare_from: summary.compare_from_s,
    };
    // A comparison has one recording of its own: no fingerprint tells runs apart.
    Ok(RunDescription::of_log(&summary.scene, 0, record, &choice))
}

fn is_scene(path: &Path) -> bool {
    path.extension().is_some_and(|e| e == "toml")
}

/// The recording of a run. Warns if it is incomplete.
fn recording(run: &Path) -> Result<PathBuf> {
    let file = recording_file(run)?;
    if !robhaz_viewer::recording_is_closed(&file).into_diagnostic()? {
        let end = robhaz_viewer::recording_end(&file).into_diagnostic()?;
        let Some(end) = end else {
            bail!(
                "{} is cut off before its first data: its run was killed, or the file is damaged",
                file.display()
            );
        };
        remark(&format!(
            "Warning: {} is cut off at {end:.3} s: its run was killed or is still going on, or the file is damaged. \
             The data before that are shown.",
            file.display(),
        ));
    }
    Ok(file)
}

/// The recording of a run: the file itself, or the one in the folder.
fn recording_file(run: &Path) -> Result<PathBuf> {
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
            "{} is not there: `robhaz view {}` simulates the run again and shows it; a run by a robhaz with the viewer, \
             without `--rerun off`, keeps a recording",
            file.display(),
            file.with_file_name(SCENE).display()
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
