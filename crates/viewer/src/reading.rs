//! Reads recordings that were written before.

use crate::error::{Cause, Result, ViewerError};
use re_chunk::Chunk;
use re_log_encoding::Decoder;
use re_log_types::LogMsg;
use re_log_types::StoreKind;
use std::fs::File;
use std::io::BufReader;
use std::path::Path;

/// Time of the newest row of a recording, s. `None`: it has no rows. A file that ends within a
/// message, as that of a killed run, is read up to that message.
///
/// # Errors
/// [`ViewerError::Io`]
pub fn recording_end(path: &Path) -> Result<Option<f64>> {
    let end = newest(path).map_err(ViewerError::io("read the recording", path.display()))?;
    // Exact up to a hundred days.
    Ok(end.map(|ns| ns as f64 * 1e-9))
}

/// Time of the newest row, ns.
fn newest(path: &Path) -> Result<Option<i64>, Cause> {
    let mut end: Option<i64> = None;
    for message in Decoder::<LogMsg>::decode_eager(BufReader::new(File::open(path)?))? {
        if let LogMsg::ArrowMsg(store, message) = message?
            && store.kind() == StoreKind::Recording
        {
            let chunk = Chunk::from_arrow_msg(&message)?;
            let newest = chunk.timelines().values().flat_map(|t| t.times_raw()).max();
            end = end.max(newest.copied());
        }
    }
    Ok(end)
}
