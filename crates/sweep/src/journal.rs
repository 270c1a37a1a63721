//! The journal: one line of JSON for each finished run, in the order in which they finish.
//!
//! A line is appended with one write. A killed process can leave the last line torn; it is cut off
//! at the next start, and its run is repeated. Each line ends with a checksum of what is before it.
//! A line that does not match its checksum is damaged: it counts as not there, and is reported.

use crate::error::{SweepError, io_error};
use robhaz_sim::random::Fnv1a;
use serde::{Deserialize, Serialize};
use std::fs::{File, OpenOptions};
use std::io::{BufRead, BufReader, Read as _, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Time between two waits for the disk: a computer that loses its power loses at most the lines since then.
const SYNC_TIME: Duration = Duration::from_secs(1);

/// A finished run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RunRecord {
    /// Index of the run.
    pub run: u64,
    /// Why it failed; `None` for a complete run.
    pub error: Option<String>,
    /// One row an estimator; of a failed run, and of one without estimators, one row.
    pub rows: Vec<Row>,
}

/// The scores of one estimator.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Row {
    /// Label of the estimator; `None` for a failed run.
    pub estimator: Option<String>,
    /// Scores in the order of [`crate::ScoreColumn::all`]; empty for a failed run.
    pub scores: Vec<Option<f64>>,
}

/// Where the line of a run is.
#[derive(Clone, Copy, Debug)]
pub struct Place {
    /// Index of the run.
    pub run: u64,
    /// In bytes.
    pub offset: u64,
    /// In bytes, with the line break.
    pub length: u32,
}

/// What a journal holds.
#[derive(Debug, Default)]
pub struct Scanned {
    /// The finished runs.
    pub places: Vec<Place>,
    /// Length up to the last complete line, bytes.
    pub length: u64,
    /// Number of damaged lines.
    pub damaged: u64,
}

/// Reads through a journal. It is empty if there is no such file.
pub fn scan(path: &Path) -> Result<Scanned, SweepError> {
    let mut scanned = Scanned::default();
    let file = match File::open(path) {
        Ok(file) => file,
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(scanned),
        Err(error) => return Err(io_error("read", path)(error)),
    };
    let (mut reader, mut line) = (BufReader::new(file), Vec::new());
    loop {
        line.clear();
        let length = reader
            .read_until(b'\n', &mut line)
            .map_err(io_error("read", path))?;
        if length == 0 || line.last() != Some(&b'\n') {
            return Ok(scanned);
        }
        match (decode(&line), u32::try_from(length)) {
            (Ok(record), Ok(length)) => scanned.places.push(Place {
                run: record.run,
                offset: scanned.length,
                length,
            }),
            _ => scanned.damaged += 1,
        }
        scanned.length += length as u64;
    }
}

/// The checksum is the last key of a line's object.
const CHECKSUM: &[u8] = br#","fnv1a":""#;

/// Value of [`CHECKSUM`], its closing quote and brace, and the line break.
fn ending(before: &[u8]) -> String {
    let mut hash = Fnv1a::default();
    hash.add(before);
    format!("{:016x}\"}}\n", hash.value())
}

/// The line of a run.
fn encode(record: &RunRecord) -> Result<Vec<u8>, std::io::Error> {
    let mut line = serde_json::to_vec(record)?;
    // The object goes on.
    line.pop();
    line.extend_from_slice(CHECKSUM);
    let ending = ending(&line);
    line.extend_from_slice(ending.as_bytes());
    Ok(line)
}

/// The run of a line.
fn decode(line: &[u8]) -> Result<RunRecord, std::io::Error> {
    const ENDING: usize = 16 + 3;
    let split = line.len().checked_sub(ENDING);
    let matches = split.is_some_and(|at| {
        let (before, found) = line.split_at(at);
        before.ends_with(CHECKSUM) && found == ending(before).as_bytes()
    });
    if !matches {
        let why = "a line does not match its checksum";
        return Err(std::io::Error::new(std::io::ErrorKind::InvalidData, why));
    }
    Ok(serde_json::from_slice(line)?)
}

/// A journal to which runs are appended.
#[derive(Debug)]
pub struct Journal {
    file: File,
    path: PathBuf,
    length: u64,
    synced: Instant,
}

impl Journal {
    /// Opens a journal of which `length` bytes are complete lines; the rest is cut off.
    pub fn open(path: &Path, length: u64) -> Result<Self, SweepError> {
        let mut options = OpenOptions::new();
        let options = options.create(true).write(true).truncate(false);
        let mut file = options.open(path).map_err(io_error("open", path))?;
        file.set_len(length)
            .and_then(|()| file.seek(SeekFrom::End(0)))
            .map_err(io_error("write", path))?;
        Ok(Self {
            file,
            path: path.to_path_buf(),
            length,
            synced: Instant::now(),
        })
    }

    /// Appends a run, completely or not at all.
    pub fn append(&mut self, record: &RunRecord) -> Result<(), SweepError> {
        let written = encode(record).and_then(|line| {
            self.file.write_all(&line)?;
            Ok(line.len() as u64)
        });
        match written {
            Ok(length) => self.length += length,
            Err(error) => {
                // If this fails too, the torn line is cut off at the next start. The first error is reported.
                let _ = self.file.set_len(self.length);
                return Err(io_error("write", &self.path)(error));
            }
        }
        if self.synced.elapsed() > SYNC_TIME {
            self.sync()?;
        }
        Ok(())
    }

    /// Waits until the disk has every line.
    pub fn sync(&mut self) -> Result<(), SweepError> {
        self.synced = Instant::now();
        self.file.sync_data().map_err(io_error("write", &self.path))
    }
}

/// Reads single lines of a journal.
#[derive(Debug)]
pub struct JournalReader {
    reader: BufReader<File>,
    path: PathBuf,
    position: u64,
}

impl JournalReader {
    /// Opens a journal.
    pub fn open(path: &Path) -> Result<Self, SweepError> {
        Ok(Self {
            reader: BufReader::new(File::open(path).map_err(io_error("read", path))?),
            path: path.to_path_buf(),
            position: 0,
        })
    }

    /// The run at a place.
    pub fn read(&mut self, place: &Place) -> Result<RunRecord, SweepError> {
        let mut line = vec![0; place.length as usize];
        // Runs are nearly in order: most seeks stay in the buffer.
        let distance = place.offset.wrapping_sub(self.position).cast_signed();
        self.reader
            .seek_relative(distance)
            .and_then(|()| self.reader.read_exact(&mut line))
            .map_err(io_error("read", &self.path))?;
        self.position = place.offset + u64::from(place.length);
        decode(&line).map_err(io_error("read", &self.path))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn record(run: u64) -> RunRecord {
        RunRecord {
            run,
            error: None,
            rows: vec![Row {
                estimator: Some("best".to_owned()),
                scores: vec![Some(0.1 + 0.2), None, Some(1e-300)],
            }],
        }
    }

    /// Cut at any byte, the complete lines stay, and what is appended then can be read. Numbers keep their bits.
    #[test]
    fn a_journal_that_is_cut_keeps_its_complete_lines() -> Result<(), SweepError> {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("runs.jsonl");
        let mut journal = Journal::open(&path, 0)?;
        for run in [4, 2, 9] {
            journal.append(&record(run))?;
        }
        let whole = std::fs::read(&path).expect("the journal");
        let line = whole.len() / 3;
        for cut in 0..whole.len() {
            std::fs::write(&path, &whole[..cut]).expect("written");
            let scanned = scan(&path)?;
            assert_eq!((scanned.places.len(), scanned.damaged), (cut / line, 0));
            let mut journal = Journal::open(&path, scanned.length)?;
            journal.append(&record(7))?;
            let places = scan(&path)?.places;
            let mut reader = JournalReader::open(&path)?;
            let last = places.last().expect("a run");
            assert_eq!(reader.read(last)?, record(7));
            // Backwards, too.
            assert_eq!(reader.read(&places[0])?.rows, record(4).rows);
        }
        Ok(())
    }

    /// Any other byte in a line is found, whatever it makes of the line: another number, another
    /// key. The line is left out, and its run counts as not done.
    #[test]
    fn a_changed_byte_is_found() -> Result<(), SweepError> {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("runs.jsonl");
        let mut journal = Journal::open(&path, 0)?;
        journal.append(&record(1))?;
        journal.append(&record(2))?;
        let whole = std::fs::read(&path).expect("the journal");
        // All bytes of the first line but its line break, without which both lines are one.
        for place in 0..whole.len() / 2 - 1 {
            for byte in [b'7', b' ', 0] {
                let mut bytes = whole.clone();
                bytes[place] = byte;
                std::fs::write(&path, &bytes).expect("written");
                let scanned = scan(&path)?;
                let runs: Vec<u64> = scanned.places.iter().map(|place| place.run).collect();
                let expected = if bytes == whole {
                    (vec![1, 2], 0)
                } else {
                    (vec![2], 1)
                };
                assert_eq!((runs, scanned.damaged), expected, "byte {place}");
                assert_eq!(scanned.length, bytes.len() as u64);
            }
        }
        Ok(())
    }
}
