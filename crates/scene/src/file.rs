//! Files as bytes, up to a limit that is said.

use crate::reader::grouped;
use std::fs::File;
use std::io::Read;
use std::path::Path;

/// Most bytes of a scene or robot file: enough for 100 000 points of full precision.
const MOST_TOML: usize = 6_000_000;
/// Most words and signs of such a file: the tree of its keys takes some hundred bytes for each.
const MOST_TOKENS: usize = 1_000_000;
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

/// The text of a scene or robot file.
pub(crate) fn read_toml(path: &Path) -> Result<String, String> {
    let text = String::from_utf8(read(path, MOST_TOML)?).map_err(|error| {
        let at = error.utf8_error().valid_up_to();
        format!("cannot be read: byte {at} is no UTF-8")
    })?;
    check_toml(&text).map(|()| text)
}

/// Why a text is too large for a scene or robot file.
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
