//! The journal: one line of JSON for each finished run, in the order in which they finish.
//!
//! A line is appended with one write. A killed process can leave the last line torn; it is cut off
//! at the next start, and its run is repeated. Each line ends with a checksum of the identity of
//! the study and of what is before it. A line that does not match its checksum is damaged, or of
//! another study: it counts as not there, and is reported.

use crate::error::{Result, StudyError};
use fnv::FnvHasher;
use robhaz_record::io_error;
use serde::{Deserialize, Serialize};
use std::fs::{File, OpenOptions, TryLockError};
use std::hash::Hasher as _;
use std::io::{BufRead as _, BufReader, Error, ErrorKind, Seek as _, SeekFrom, Write as _};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Time between two waits for the disk: a computer that loses its power loses at most the lines
/// since then.
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
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Row {
    /// Label of the estimator; `None` for a failed run.
    pub estimator: Option<String>,
    /// Scores in the order of [`robhaz_record::ScoreColumn::all`]; empty for a failed run.
    pub scores: Vec<Option<f64>>,
}

/// What was found in a journal beside its runs.
#[derive(Debug, Default)]
pub struct Scanned {
    /// Length up to the last complete line, bytes.
    pub length: u64,
    /// Number of damaged lines.
    pub damaged: u64,
}

/// Hands the finished runs in the journal of the study with the hash `study` to `each`. There are
/// none if there is no such file.
pub fn scan(path: &Path, study: &str, each: &mut dyn FnMut(RunRecord)) -> Result<Scanned> {
    let mut scanned = Scanned::default();
    let file = match File::open(path) {
        Ok(file) => file,
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(scanned),
        Err(error) => Err(io_error("read", path)(error))?,
    };
    let (mut reader, mut line) = (BufReader::new(file), Vec::new());
    loop {
        line.clear();
        let length = reader.read_until(b'\n', &mut line);
        let length = length.map_err(io_error("read", path))?;
        if line.last() != Some(&b'\n') {
            return Ok(scanned);
        }
        match decode(&line, study) {
            Ok(record) => each(record),
            Err(_) => scanned.damaged += 1,
        }
        scanned.length += length as u64;
    }
}

/// The checksum is the last key of a line's object.
const CHECKSUM: &[u8] = br#","fnv1a":""#;

/// Value of [`CHECKSUM`], its closing quote and brace, and the line break.
fn ending(before: &[u8], study: &str) -> String {
    let mut hash = FnvHasher::default();
    hash.write(study.as_bytes());
    hash.write(before);
    format!("{:016x}\"}}\n", hash.finish())
}

/// The line of a run.
fn encode(record: &RunRecord, study: &str) -> Result<Vec<u8>, Error> {
    let mut line = serde_json::to_vec(record)?;
    // The object goes on.
    line.pop();
    line.extend_from_slice(CHECKSUM);
    let ending = ending(&line, study);
    line.extend_from_slice(ending.as_bytes());
    Ok(line)
}

/// The run of a line.
fn decode(line: &[u8], study: &str) -> Result<RunRecord, Error> {
    const ENDING: usize = 16 + 3;
    let split = line.len().checked_sub(ENDING);
    let matches = split.is_some_and(|at| {
        let (before, found) = line.split_at(at);
        before.ends_with(CHECKSUM) && found == ending(before, study).as_bytes()
    });
    if !matches {
        let why = "a line does not match its checksum";
        return Err(Error::new(ErrorKind::InvalidData, why));
    }
    Ok(serde_json::from_slice(line)?)
}

/// A journal to which runs are appended. No other process opens it meanwhile.
#[derive(Debug)]
pub struct Journal {
    file: File,
    path: PathBuf,
    study: String,
    length: u64,
    synced: Instant,
}

impl Journal {
    /// Opens a journal, and hands its runs to `each`. A torn last line is cut off.
    ///
    /// # Errors
    /// [`StudyError::Folder`]: another process has it open.
    pub fn open(
        path: &Path,
        study: &str,
        each: &mut dyn FnMut(RunRecord),
    ) -> Result<(Self, Scanned)> {
        let mut options = OpenOptions::new();
        let options = options.create(true).write(true).truncate(false);
        let mut file = options.open(path).map_err(io_error("open", path))?;
        // A file system without locks: the study goes on without that protection.
        if matches!(file.try_lock(), Err(TryLockError::WouldBlock)) {
            let why = format!("another process is writing {}", path.display());
            return Err(StudyError::Folder(why, "wait for its end"));
        }
        let scanned = scan(path, study, each)?;
        file.set_len(scanned.length)
            .and_then(|()| file.seek(SeekFrom::End(0)))
            .map_err(io_error("write", path))?;
        let journal = Self {
            file,
            path: path.to_path_buf(),
            study: study.to_owned(),
            length: scanned.length,
            synced: Instant::now(),
        };
        Ok((journal, scanned))
    }

    /// Appends a run, completely or not at all.
    pub fn append(&mut self, record: &RunRecord) -> Result {
        let written = encode(record, &self.study).and_then(|line| {
            self.file.write_all(&line)?;
            Ok(line.len() as u64)
        });
        match written {
            Ok(length) => self.length += length,
            Err(error) => {
                // If this fails too, the torn line is cut off at the next start. The first error is
                // reported.
                let _ = self.file.set_len(self.length);
                return Err(io_error("write", &self.path)(error).into());
            }
        }
        if self.synced.elapsed() > SYNC_TIME {
            self.sync()?;
        }
        Ok(())
    }

    /// Waits until the disk has every line.
    pub fn sync(&mut self) -> Result {
        self.synced = Instant::now();
        Ok((self.file.sync_data()).map_err(io_error("write", &self.path))?)
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
                estimator: Some("kalman".to_owned()),
                scores: vec![Some(0.1 + 0.2), None, Some(1e-300)],
            }],
        }
    }

    /// The runs of a journal, and its number of damaged lines.
    fn read(path: &Path, study: &str) -> Result<(Vec<RunRecord>, u64), StudyError> {
        let mut found = Vec::new();
        let scanned = scan(path, study, &mut |record| found.push(record))?;
        Ok((found, scanned.damaged))
    }

    /// Cut at any byte, the complete lines stay, and what is appended then can be read. Numbers
    /// keep their bits.
    #[test]
    fn a_journal_that_is_cut_keeps_its_complete_lines() -> Result<(), StudyError> {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("runs.jsonl");
        let (mut journal, _) = Journal::open(&path, "mine", &mut |_| {})?;
        for run in [4, 2, 9] {
            journal.append(&record(run))?;
        }
        drop(journal);
        let whole = std::fs::read(&path).expect("the journal");
        let line = whole.len() / 3;
        for cut in 0..whole.len() {
            std::fs::write(&path, &whole[..cut]).expect("written");
            let (found, damaged) = read(&path, "mine")?;
            assert_eq!((found.len(), damaged), (cut / line, 0));
            assert_eq!(read(&path, "other")?.1, cut as u64 / line as u64);
            let (mut journal, _) = Journal::open(&path, "mine", &mut |_| {})?;
            journal.append(&record(7))?;
            let (found, _) = read(&path, "mine")?;
            let whole = [4, 2, 9].into_iter().take(cut / line).chain([7]);
            assert_eq!(found, whole.map(record).collect::<Vec<_>>());
        }
        Ok(())
    }

    /// Any other byte in a line is found, whatever it makes of the line: another number, another
    /// key. The line is left out, and its run counts as not done.
    #[test]
    fn a_changed_byte_is_found() -> Result<(), StudyError> {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("runs.jsonl");
        let (mut journal, _) = Journal::open(&path, "mine", &mut |_| {})?;
        journal.append(&record(1))?;
        journal.append(&record(2))?;
        let whole = std::fs::read(&path).expect("the journal");
        // All bytes of the first line but its line break, without which both lines are one.
        for place in 0..whole.len() / 2 - 1 {
            for byte in [b'7', b' ', 0] {
                let mut bytes = whole.clone();
                bytes[place] = byte;
                std::fs::write(&path, &bytes).expect("written");
                let mut runs = Vec::new();
                let scanned = scan(&path, "mine", &mut |record| runs.push(record.run))?;
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
