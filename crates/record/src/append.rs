//! Files without incomplete pieces: files that grow by whole pieces, and files that are written at once.

use crate::error::{RecordError, io_error};
use std::fs::File;
use std::io::{self, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

/// Time of the run after which rows go to the file, s. A killed run loses at most this much.
pub const FLUSH_TIME: f64 = 1.0;

/// Decides when rows have to go to the file.
#[derive(Debug, Default)]
pub struct FlushClock {
    last: f64,
}

impl FlushClock {
    /// Whether [`FLUSH_TIME`] has passed since the last flush. `time` in s.
    pub fn is_due(&mut self, time: f64) -> bool {
        // Times are sums of steps: a rounding error must not delay a flush by a record.
        let due = time - self.last >= FLUSH_TIME * (1.0 - 1e-9);
        if due {
            self.last = time;
        }
        due
    }
}

/// A file to which pieces are appended, each completely or not at all.
///
/// A full disk leaves no torn piece behind. Only a killed process can: at the end of the file, where readers can leave it out.
#[derive(Debug)]
pub struct Appender {
    file: File,
    path: PathBuf,
    length: u64,
}

impl Appender {
    /// An empty file; an older one of that name is replaced.
    pub fn create(path: &Path) -> Result<Self, RecordError> {
        Ok(Self {
            file: File::create(path).map_err(io_error("create", path))?,
            path: path.to_path_buf(),
            length: 0,
        })
    }

    /// Appends a piece.
    pub fn append(&mut self, piece: &[u8]) -> Result<(), RecordError> {
        if let Err(error) = self.file.write_all(piece) {
            // If this fails too, the incomplete piece stays. The first error is reported.
            let _ = self.cut();
            return Err(io_error("write", &self.path)(error));
        }
        self.length += piece.len() as u64;
        Ok(())
    }

    /// Where the file is.
    pub fn path(&self) -> &Path {
        &self.path
    }

    fn cut(&mut self) -> io::Result<()> {
        self.file.set_len(self.length)?;
        self.file.seek(SeekFrom::Start(self.length))?;
        Ok(())
    }
}

/// Writes a small file completely or not at all: a file of that name is replaced when the new one is complete.
pub fn write_whole(path: &Path, content: &[u8]) -> Result<(), RecordError> {
    let mut partial = path.as_os_str().to_owned();
    partial.push(".partial");
    let partial = PathBuf::from(partial);
    let done = std::fs::write(&partial, content)
        .map_err(io_error("write", path))
        .and_then(|()| std::fs::rename(&partial, path).map_err(io_error("write", path)));
    if done.is_err() {
        // It may not exist; the error that counts is the first.
        let _ = std::fs::remove_file(&partial);
    }
    done
}

#[cfg(test)]
mod tests {
    use super::*;

    /// At any rate of records, rows wait at most a second and one record.
    #[test]
    fn rows_wait_for_a_second_at_most() {
        for rate in [0.3, 1.0, 10.0, 999.0, 1000.0] {
            let mut clock = FlushClock::default();
            let mut last = 0.0;
            for k in 1..5000 {
                let time = f64::from(k) / rate;
                if clock.is_due(time) {
                    last = time;
                }
                assert!(time - last < FLUSH_TIME, "{rate} Hz, {time} s");
            }
        }
    }
}
