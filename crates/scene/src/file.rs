//! Reads files up to a size limit.

use crate::reader::grouped;
use std::fs::File;
use std::io::Read;
use std::path::Path;
use tracing::debug;

/// Largest size of a scene or robot file, bytes: enough for 100 000 points of full precision.
const MOST_TOML: usize = 6_000_000;
/// Largest number of words and signs of such a file: each takes some hundred bytes of memory.
const MOST_TOKENS: usize = 1_000_000;
/// Largest size of a track, bytes.
pub(crate) const MOST_TRACK: usize = 100_000_000;

/// The content of a file of at most `most` bytes; the error completes the sentence "FILE ...".
pub(crate) fn read(path: &Path, most: usize) -> Result<Vec<u8>, String> {
    let cannot = |error: std::io::Error| format!("cannot be read: {error}");
    let file = File::open(path).map_err(cannot)?;
    let mut bytes = Vec::new();
    // Reading one byte more than allowed detects larger files, also pipes, which have no length.
    let mut file = file.take(most as u64 + 1);
    file.read_to_end(&mut bytes).map_err(cannot)?;
    match bytes.len() > most {
        true => Err(too_large(most)),
        false => {
            debug!(path = %path.display(), bytes = bytes.len(), "read");
            Ok(bytes)
        }
    }
}

/// The text of a scene or robot file.
pub(crate) fn read_toml(path: &Path) -> Result<String, String> {
    let text = String::from_utf8(read(path, MOST_TOML)?).map_err(|error| {
        let at = error.utf8_error().valid_up_to();
        format!("cannot be read: byte {at} is no UTF-8")
    })?;
    check_toml(&text).map(|()| text)
}

/// Checks the size of the text of a scene or robot file.
pub(crate) fn check_toml(text: &str) -> Result<(), String> {
    if text.len() > MOST_TOML {
        return Err(too_large(MOST_TOML));
    }
    let mut before = b' ';
    let tokens = text.bytes().filter(|b| {
        let is_space = |b: u8| b == b' ' || b == b'\t';
        let starts = b",=[]{}\"'.\n".contains(b) || is_space(*b) && !is_space(before);
        before = *b;
        starts
    });
    if tokens.count() > MOST_TOKENS {
        let most = grouped(MOST_TOKENS);
        return Err(format!(
            "is too large, allowed: at most {most} words and signs"
        ));
    }
    Ok(())
}

fn too_large(most: usize) -> String {
    format!("is too large, allowed: at most {} bytes", grouped(most))
}
