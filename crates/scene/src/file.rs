//! Files as bytes, up to a limit that is said.

use crate::reader::grouped;
use std::fs::File;
use std::io::Read;
use std::path::Path;

/// Most bytes of a scene or robot file: a tree of its keys takes some twenty times as much memory.
pub(crate) const MOST_TOML: usize = 6_000_000;
/// Most bytes of a track.
pub(crate) const MOST_TRACK: usize = 100_000_000;

/// The content of a file, or why it cannot be read.
pub(crate) fn read(path: &Path, most: usize) -> Result<Vec<u8>, String> {
    let cannot = |error: std::io::Error| format!("cannot be read: {error}");
    let file = File::open(path).map_err(cannot)?;
    let mut bytes = Vec::new();
    // One byte more than allowed shows that there is more, also of what has no length, such as a pipe.
    let mut file = file.take(most as u64 + 1);
    file.read_to_end(&mut bytes).map_err(cannot)?;
    match bytes.len() > most {
        true => Err(too_large(most)),
        false => Ok(bytes),
    }
}

/// A file of text in UTF-8.
pub(crate) fn read_text(path: &Path, most: usize) -> Result<String, String> {
    String::from_utf8(read(path, most)?).map_err(|error| {
        let at = error.utf8_error().valid_up_to();
        format!("cannot be read: byte {at} is no UTF-8")
    })
}

pub(crate) fn too_large(most: usize) -> String {
    format!("is too large, allowed: at most {} bytes", grouped(most))
}
