//! The journal: one line of JSON for each finished run, in the order in which they finish.
//!
//! A line is appended with one write. A killed process can leave the last line torn; it is cut off at the next start, and its
//! run is repeated. A line that cannot be read for another reason (a broken disk) counts as not there.

use crate::error::{SweepError, io_error};
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

/// The finished runs of a journal, and its length up to the last complete line. No runs if there is no such file.
pub fn scan(path: &Path) -> Result<(Vec<Place>, u64), SweepError> {
    let file = match File::open(path) {
        Ok(file) => file,
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok((Vec::new(), 0)),
        Err(error) => return Err(io_error("read", path)(error)),
    };
    let mut reader = BufReader::new(file);
    let (mut places, mut offset, mut line) = (Vec::new(), 0, Vec::new());
    loop {
        line.clear();
        let length = reader
            .read_until(b'\n', &mut line)
            .map_err(io_error("read", path))?;
        if length == 0 || line.last() != Some(&b'\n') {
            return Ok((places, offset));
        }
        let record: Result<RunRecord, _> = serde_json::from_slice(&line);
        if let (Ok(record), Ok(length)) = (record, u32::try_from(length)) {
            places.push(Place {
                run: record.run,
                offset,
                length,
            });
        }
        offset += length as u64;
    }
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
        let written = serde_json::to_vec(record)
            .map_err(std::io::Error::from)
            .and_then(|mut line| {
                line.push(b'\n');
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
        serde_json::from_slice(&line)
            .map_err(|error| io_error("read", &self.path)(std::io::Error::from(error)))
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
            let (places, length) = scan(&path)?;
            assert_eq!(places.len(), cut / line, "{cut}");
            let mut journal = Journal::open(&path, length)?;
            journal.append(&record(7))?;
            let (places, _) = scan(&path)?;
            let mut reader = JournalReader::open(&path)?;
            let last = places.last().expect("a run");
            assert_eq!(reader.read(last)?, record(7));
            // Backwards, too.
            assert_eq!(reader.read(&places[0])?.rows, record(4).rows);
        }
        Ok(())
    }

    /// A line that cannot be read is left out; its run counts as not done.
    #[test]
    fn a_damaged_line_is_left_out() -> Result<(), SweepError> {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("runs.jsonl");
        let mut journal = Journal::open(&path, 0)?;
        journal.append(&record(1))?;
        journal.append(&record(2))?;
        let mut bytes = std::fs::read(&path).expect("the journal");
        bytes[3] = 0;
        std::fs::write(&path, &bytes).expect("written");
        let (places, length) = scan(&path)?;
        let runs: Vec<u64> = places.iter().map(|place| place.run).collect();
        assert_eq!((runs, length), (vec![2], bytes.len() as u64));
        Ok(())
    }
}
