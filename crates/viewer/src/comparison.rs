//! Several recorded runs in one recording.
//!
//! Every entity of a run stands under `run1/`, `run2/` and so on; `compared/` holds the true N of all runs in common plots, and
//! how far those of later runs are from the first.

use crate::ViewerError;
use crate::colours::{WHEELS, by_place};
use crate::compared::{ComparedRun, root};
use crate::key::{self, Entry};
use crate::layout;
use crate::plot::{Line, Plot};
use crate::reading::{for_each_chunk, nanoseconds_to_seconds, scalars};
use crate::writer::{RrdFile, Writer};
use rerun::EntityPath;
use rerun::archetypes::{RecordingInfo, Scalars};
use rerun::components::Scalar;
use robhaz_run::Stop;
use std::collections::HashMap;
use std::path::Path;

/// The entity of the errors that are compared.
const RMS_ERROR: &str = "/series/error_of_normal_force/rms";

/// Writes one recording of several recorded runs to `out`, with a layout that shows them side by side.
///
/// # Errors
/// [`ViewerError`]: fewer than two runs, a recording that cannot be read, `out` is one of them or cannot be written, or
/// `stop` names a cause.
pub fn save_comparison(
    runs: &[ComparedRun<'_>],
    out: &Path,
    stop: Stop<'_>,
) -> Result<(), ViewerError> {
    if runs.len() < 2 {
        return Err(ViewerError::TooFew { found: runs.len() });
    }
    // Written into itself, a recording would grow until the disk is full. A file that is not there is not the same.
    let is_read =
        |run: &ComparedRun<'_>| same_file::is_same_file(run.recording, out).unwrap_or(false);
    if runs.iter().any(is_read) {
        let path = out.to_owned();
        return Err(ViewerError::Input { path });
    }
    let destination = out.display().to_string();
    let file = RrdFile::begin(RrdFile::create(out)?).map_err(ViewerError::write(&destination))?;
    let name = runs.iter().map(|r| r.label).collect::<Vec<_>>().join(" - ");
    let mut writer = Writer::start(
        &destination,
        Box::new(file),
        &name,
        crate::recorder::hash(&name),
    )?;
    layout::comparison::log(&mut writer, runs, largest_error(runs)?)?;
    writer.constant(
        EntityPath::properties(),
        &RecordingInfo::update_fields().with_name(name.as_str()),
    )?;
    let entries = runs.iter().enumerate().map(|(k, run)| {
        let label = format!("true N: {}", run.label);
        match k {
            0 => Entry::of_wheels(&label),
            _ => Entry::of_place(&label, colour_place(k)),
        }
    });
    key::log(&mut writer, "compared/key", &entries.collect::<Vec<_>>())?;

    let mut first: [HashMap<i64, f64>; 3] = Default::default();
    for (k, run) in runs.iter().enumerate() {
        let line = |i: usize| match k {
            0 => Line::truth(format!("{} [N]", run.label), WHEELS[i]),
            _ => Line::estimate(format!("{} [N]", run.label), by_place(colour_place(k))),
        };
        let plots = |quantity: &str| {
            [0, 1, 2].map(|i| {
                let entity = format!("compared/{quantity}/wheel{}/run{}", i + 1, k + 1);
                Plot::new(entity, vec![line(i)])
            })
        };
        let (mut truth, mut difference) = (plots("normal_force"), plots("difference"));
        for_each_chunk(run.recording, |chunk| {
            if let Some(cause) = stop() {
                return Err(ViewerError::Stopped { cause });
            }
            let entity = chunk.entity_path().to_string();
            if chunk.entity_path().starts_with(&EntityPath::properties()) {
                return Ok(());
            }
            if let Some(i) = (0..3).find(|i| entity == true_normal_force(*i)) {
                for (time, value) in scalars(chunk) {
                    let seconds = nanoseconds_to_seconds(time);
                    truth[i].push(seconds, [value]);
                    if k == 0 {
                        first[i].insert(time, value);
                    } else if let Some(reference) = first[i].get(&time) {
                        difference[i].push(seconds, [value - reference]);
                    }
                }
            }
            writer.copy(
                chunk,
                format!("{}{}", root(k), entity.trim_start_matches('/')),
            )
        })?;
        for plot in truth.iter_mut().chain(&mut difference) {
            plot.flush(&mut writer)?;
        }
    }
    writer.finish()
}

/// Largest RMS error of N of any estimator in any of the runs, N: what can be compared has one scale.
fn largest_error(runs: &[ComparedRun<'_>]) -> Result<f64, ViewerError> {
    let mut largest = 0.0_f64;
    for run in runs {
        for_each_chunk(run.recording, |chunk| {
            if chunk.entity_path().to_string() == RMS_ERROR {
                let component = Scalars::descriptor_scalars().component;
                for row in chunk.iter_component::<Scalar>(component) {
                    let finite = row.as_slice().iter().map(|v| v.0.0);
                    largest = finite.filter(|v| v.is_finite()).fold(largest, f64::max);
                }
            }
            Ok(())
        })?;
    }
    Ok(largest)
}

fn true_normal_force(wheel: usize) -> String {
    format!("/series/normal_force/wheel{}/actual", wheel + 1)
}

/// Later runs are white, yellow and so on: what stands out before the wheels' colours.
fn colour_place(run: usize) -> usize {
    run + 2
}
