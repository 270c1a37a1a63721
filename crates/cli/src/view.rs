//! `robhaz view`: shows runs.

use crate::interrupt;
use crate::output_file::{Format, OutputFile};
use crate::terminal::say;
use miette::{IntoDiagnostic, Result, bail};
use std::path::{Path, PathBuf};

/// Arguments of `robhaz view`.
#[derive(clap::Args)]
pub struct Args {
    /// Folders of runs or their recordings (.rrd), shown in one viewer.
    #[arg(required = true, value_name = "RUN")]
    runs: Vec<PathBuf>,
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
    #[arg(long, requires = "screenshot")]
    force: bool,
}

const PICTURE: Format = ("pictures", "png");

/// Opens the viewer with the runs, or saves a picture.
pub fn run(args: &Args) -> Result<()> {
    let recordings = args.runs.iter().map(|run| recording(run));
    let recordings = recordings.collect::<Result<Vec<_>>>()?;
    let Some(picture) = &args.screenshot else {
        interrupt::listen()?;
        return robhaz_viewer::open(&recordings, &interrupt::cause).into_diagnostic();
    };
    let [recording] = recordings.as_slice() else {
        bail!("--screenshot takes one run");
    };
    // Checked before the work, so that a bad file name costs no time.
    let file = OutputFile::create(picture, PICTURE, &recordings, args.force)?;
    let stop = || interrupt::cause();
    robhaz_viewer::picture(recording, file.path(), args.size, args.at, &stop).into_diagnostic()?;
    say(&format!("Picture in {}", file.finish()?.display()))
}

/// The recording of a run: the file itself, or the one in the folder.
fn recording(run: &Path) -> Result<PathBuf> {
    let file = match run.is_dir() {
        true => run.join("run.rrd"),
        false => run.to_path_buf(),
    };
    if file.extension().is_none_or(|e| e != "rrd") {
        bail!(
            "{} is neither the folder of a run nor a recording (.rrd); `robhaz run SCENE --rerun live` shows a scene",
            run.display()
        );
    }
    if !file.is_file() {
        bail!(
            "{} is not there: a run by a robhaz with the viewer, without `--rerun off`, keeps a recording",
            file.display()
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
