//! Several recorded runs in one recording.
//!
//! Every entity of a run stands under `run1/`, `run2/` and so on; `compared/` holds the true N of all runs in common plots, and
//! how far those of later runs are from the first.

use crate::ViewerError;
use crate::colours::{WHEELS, by_place};
use crate::key::{self, Entry};
use crate::layout;
use crate::plot::{Line, Plot};
use crate::writer::{RrdFile, Writer};
use rerun::archetypes::{RecordingInfo, Scalars};
use rerun::components::Scalar;
use rerun::external::re_log_encoding::{Decodable as _, Decoder, StreamFooter};
use rerun::log::{Chunk, LogMsg};
use rerun::{EntityPath, StoreKind};
use robhaz_run::{RunDescription, Stop};
use std::collections::HashMap;
use std::fs::File;
use std::io::{BufReader, Read as _, Seek as _, SeekFrom};
use std::path::Path;

/// A run to be compared.
#[derive(Clone, Copy, Debug)]
pub struct ComparedRun<'a> {
    /// How the run is called.
    pub label: &'a str,
    /// Its description.
    pub description: &'a RunDescription,
    /// Its recording, written by [`crate::RecordingSink`].
    pub recording: &'a Path,
}

/// The entity of the errors that are compared.
const RMS_ERROR: &str = "/series/error_of_normal_force/rms";

/// The entity that a run stands under, by its place.
pub(crate) fn root(place: usize) -> String {
    format!("/run{}/", place + 1)
}

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

/// Time of the newest row of a recording, s. `None` where it has no row.
///
/// # Errors
/// [`ViewerError::Read`]
pub fn recording_end(path: &Path) -> Result<Option<f64>, ViewerError> {
    let mut end: Option<i64> = None;
    for_each_chunk(path, |chunk| {
        let newest = chunk.timelines().values().flat_map(|t| t.times_raw()).max();
        end = end.max(newest.copied());
        Ok(())
    })?;
    Ok(end.map(nanoseconds_to_seconds))
}

/// Does a recording end in the index that closes it? One without was cut, or its run was killed or is still going on.
///
/// # Errors
/// [`ViewerError::Read`]
pub fn recording_is_closed(path: &Path) -> Result<bool, ViewerError> {
    let mut file = File::open(path).map_err(ViewerError::read(path))?;
    let length = file.metadata().map_err(ViewerError::read(path))?.len();
    let mut end = [0; StreamFooter::ENCODED_SIZE_BYTES];
    let Some(start) = length.checked_sub(end.len() as u64) else {
        return Ok(false);
    };
    file.seek(SeekFrom::Start(start))
        .and_then(|_| file.read_exact(&mut end))
        .map_err(ViewerError::read(path))?;
    Ok(StreamFooter::from_rrd_bytes(&end).is_ok())
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

/// Hands every chunk of a recording on, layout left out. A file that ends in mid-message, as that of a killed run may, is one
/// that ends before it.
fn for_each_chunk(
    path: &Path,
    mut each: impl FnMut(&Chunk) -> Result<(), ViewerError>,
) -> Result<(), ViewerError> {
    let file = File::open(path).map_err(ViewerError::read(path))?;
    let messages = Decoder::decode_eager(BufReader::new(file)).map_err(ViewerError::read(path))?;
    for message in messages {
        let message: LogMsg = message.map_err(ViewerError::read(path))?;
        if let LogMsg::ArrowMsg(store, message) = message
            && store.kind() == StoreKind::Recording
        {
            let chunk = Chunk::from_arrow_msg(&message).map_err(ViewerError::read(path))?;
            each(&chunk)?;
        }
    }
    Ok(())
}

fn true_normal_force(wheel: usize) -> String {
    format!("/series/normal_force/wheel{}/actual", wheel + 1)
}

/// Times (ns) and first values of a chunk of scalars.
fn scalars(chunk: &Chunk) -> Vec<(i64, f64)> {
    let Some(times) = chunk.timelines().values().next() else {
        return Vec::new();
    };
    let component = Scalars::descriptor_scalars().component;
    let values = chunk.iter_component::<Scalar>(component);
    let rows = times.times_raw().iter().zip(values);
    rows.filter_map(|(time, row)| row.as_slice().first().map(|value| (*time, value.0.0)))
        .collect()
}

/// Later runs are white, yellow and so on: what stands out before the wheels' colours.
fn colour_place(run: usize) -> usize {
    run + 2
}

#[expect(clippy::cast_precision_loss, reason = "exact up to a hundred days")]
fn nanoseconds_to_seconds(time: i64) -> f64 {
    time as f64 * 1e-9
}
