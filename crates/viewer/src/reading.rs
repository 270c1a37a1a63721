//! Reads recordings that were written before.

use crate::ViewerError;
use rerun::StoreKind;
use rerun::archetypes::Scalars;
use rerun::components::Scalar;
use rerun::external::re_log_encoding::{Decodable as _, Decoder, StreamFooter};
use rerun::log::{Chunk, LogMsg};
use std::fs::File;
use std::io::{BufReader, Read as _, Seek as _, SeekFrom};
use std::path::Path;

/// Time of the newest row of a recording, s. `None`: it has no rows.
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

/// Whether a recording ends with its index. Otherwise the file was truncated, or its run was killed or has not ended.
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

/// Calls `each` with every chunk of a recording, without the chunks of its layout. A file that ends within a message,
/// as that of a killed run, is read up to that message.
///
/// # Errors
/// [`ViewerError::Read`], and the errors of `each`.
pub(crate) fn for_each_chunk(
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

/// Times (ns) and values of the rows of a chunk of scalars.
pub(crate) fn scalars(chunk: &Chunk) -> Vec<(i64, Vec<f64>)> {
    let Some(times) = chunk.timelines().values().next() else {
        return Vec::new();
    };
    let component = Scalars::descriptor_scalars().component;
    let values = chunk.iter_component::<Scalar>(component);
    let values = values.map(|row| row.as_slice().iter().map(|v| v.0.0).collect());
    times.times_raw().iter().copied().zip(values).collect()
}

/// A time in s, from ns.
#[expect(clippy::cast_precision_loss, reason = "exact up to a hundred days")]
pub(crate) fn nanoseconds_to_seconds(time: i64) -> f64 {
    time as f64 * 1e-9
}
