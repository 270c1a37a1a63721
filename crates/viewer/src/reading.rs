//! Reads recordings that were written before.

use crate::ViewerError;
use rerun::StoreKind;
use rerun::external::re_log_encoding::{Decodable as _, Decoder, StreamFooter};
use rerun::log::{Chunk, LogMsg};
use std::fs::File;
use std::io::{BufReader, Read as _, Seek as _, SeekFrom};
use std::path::Path;

/// Time of the newest row of a recording, s. `None`: it has no rows. A file that ends within a
/// message, as that of a killed run, is read up to that message.
///
/// # Errors
/// [`ViewerError::Io`]
pub fn recording_end(path: &Path) -> Result<Option<f64>, ViewerError> {
    let mut end: Option<i64> = None;
    let file = File::open(path).map_err(ViewerError::io("read the recording", path.display()))?;
    let messages = Decoder::decode_eager(BufReader::new(file))
        .map_err(ViewerError::io("read the recording", path.display()))?;
    for message in messages {
        let message: LogMsg =
            message.map_err(ViewerError::io("read the recording", path.display()))?;
        if let LogMsg::ArrowMsg(store, message) = message
            && store.kind() == StoreKind::Recording
        {
            let chunk = Chunk::from_arrow_msg(&message)
                .map_err(ViewerError::io("read the recording", path.display()))?;
            let newest = chunk.timelines().values().flat_map(|t| t.times_raw()).max();
            end = end.max(newest.copied());
        }
    }
    // Exact up to a hundred days.
    Ok(end.map(|ns| ns as f64 * 1e-9))
}

/// Whether a recording ends with its index. Otherwise the file was truncated, or its run was killed
/// or has not ended.
///
/// # Errors
/// [`ViewerError::Io`]
pub fn recording_is_closed(path: &Path) -> Result<bool, ViewerError> {
    let mut file =
        File::open(path).map_err(ViewerError::io("read the recording", path.display()))?;
    let length = file
        .metadata()
        .map_err(ViewerError::io("read the recording", path.display()))?
        .len();
    let mut end = [0; StreamFooter::ENCODED_SIZE_BYTES];
    let Some(start) = length.checked_sub(end.len() as u64) else {
        return Ok(false);
    };
    file.seek(SeekFrom::Start(start))
        .and_then(|_| file.read_exact(&mut end))
        .map_err(ViewerError::io("read the recording", path.display()))?;
    Ok(StreamFooter::from_rrd_bytes(&end).is_ok())
}
