//! Several recorded runs in one recording.
//!
//! The entities of the runs are below `run1/`, `run2/` and so on. `compared/` has the true N of all runs.

use crate::ViewerError;
use crate::colours::{WHEELS, by_index};
use crate::key::{self, Entry};
use crate::layout::comparison::{ComparedRun, root};
use crate::layout::{self, Playing};
use crate::plot::{Line, Plot};
use crate::reading::{for_each_chunk, nanoseconds_to_seconds, scalars};
use crate::writer::{RrdFile, Writer};
use rerun::EntityPath;
use robhaz_run::Stop;
use std::path::Path;
use std::time::Duration;

/// Entity of the RMS error of N in the recording of a run.
const RMS_ERROR: &str = "/series/error_of_normal_force/rms";

/// Copies several recorded runs into one recording at `out`, with a layout that shows them side by side.
///
/// # Errors
/// - [`ViewerError::TooFew`]: fewer than two runs. [`ViewerError::Input`]: `out` is one of their recordings.
/// - [`ViewerError::Read`]: a recording cannot be read.
/// - [`ViewerError::Create`], [`ViewerError::Write`]: `out` cannot be written.
/// - [`ViewerError::Stopped`]: `stop` named a cause.
pub fn save_comparison(
    runs: &[ComparedRun<'_>],
    out: &Path,
    stop: Stop<'_>,
) -> Result<(), ViewerError> {
    if runs.len() < 2 {
        return Err(ViewerError::TooFew { found: runs.len() });
    }
    // A recording that is copied into itself grows until the disk is full. An error means that `out` does not exist.
    let is_read =
        |run: &ComparedRun<'_>| same_file::is_same_file(run.recording, out).unwrap_or(false);
    if runs.iter().any(is_read) {
        let path = out.to_owned();
        return Err(ViewerError::Input { path });
    }
    let destination = out.display().to_string();
    let file = RrdFile::begin(RrdFile::create(out)?).map_err(ViewerError::write(&destination))?;
    let name = runs.iter().map(|r| r.label).collect::<Vec<_>>().join(" - ");
    let mut writer = Writer::start(&destination, file, Duration::MAX, &name, fingerprint(runs))?;
    let entries = runs.iter().enumerate().map(|(k, run)| {
        let label = format!("true N: {}", run.label);
        match k {
            0 => Entry::of_wheels(&label),
            _ => Entry::of_index(&label, colour_index(k)),
        }
    });
    key::log(&mut writer, "compared/key", &entries.collect::<Vec<_>>())?;

    // Largest RMS error of N of any estimator in any run, N: all runs use the same scale.
    let mut largest_error = 0.0_f64;
    for (k, run) in runs.iter().enumerate() {
        let line = |i: usize| match k {
            0 => Line::truth(format!("{} [N]", run.label), WHEELS[i]),
            _ => Line::estimate(format!("{} [N]", run.label), by_index(colour_index(k))),
        };
        let mut truth = [0, 1, 2].map(|i| {
            let entity = format!("compared/normal_force/wheel{}/run{}", i + 1, k + 1);
            Plot::new(entity, vec![line(i)])
        });
        for_each_chunk(run.recording, |chunk| {
            if let Some(cause) = stop() {
                return Err(ViewerError::Stopped { cause });
            }
            let entity = chunk.entity_path().to_string();
            if chunk.entity_path().starts_with(&EntityPath::properties()) {
                return Ok(());
            }
            if entity == RMS_ERROR {
                let errors = scalars(chunk).into_iter().flat_map(|(_, errors)| errors);
                largest_error = errors
                    .filter(|e| e.is_finite())
                    .fold(largest_error, f64::max);
            }
            if let Some(i) = (0..3).find(|i| entity == true_normal_force(*i)) {
                for (time, values) in scalars(chunk) {
                    truth[i].push(nanoseconds_to_seconds(time), values);
                }
            }
            let entity = format!("{}{}", root(k), entity.trim_start_matches('/'));
            writer.copy(chunk, entity)?;
            writer.send_all()
        })?;
        truth
            .iter_mut()
            .try_for_each(|plot| plot.flush(&mut writer))?;
    }
    let views = layout::comparison::layout(runs, largest_error);
    layout::log(&mut writer, &views, Playing::FromStart)?;
    writer.finish(0)
}

/// Distinguishes comparisons of runs with the same labels.
fn fingerprint(runs: &[ComparedRun<'_>]) -> u64 {
    runs.iter().fold(0, |all, run| {
        all.rotate_left(1) ^ run.description.fingerprint
    })
}

fn true_normal_force(wheel: usize) -> String {
    format!("/series/normal_force/wheel{}/actual", wheel + 1)
}

/// Index of the colour of a later run: white, yellow and so on, which differ most from the wheels' colours.
fn colour_index(run: usize) -> usize {
    run + 2
}
