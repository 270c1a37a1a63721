//! The channels of a log: what is read from which file, how a reading follows from the cells of a row,
//! and the rows themselves.

use crate::mcap_events::{self, Wanted};
use crate::truth::TruthColumns;
use crate::{
    AddRow, Clock, ColumnInfo, Formula, LogError, Row, TimeColumn, bag, csv_table, parquet_rows,
};
use robhaz_run::ChannelReport;
use robhaz_scene::{Reading, Values};
use std::collections::BTreeSet;
use std::fmt::Display;
use std::path::{Path, PathBuf};
use std::slice::Chunks;

/// Format of a table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TableFormat {
    /// Text.
    Csv,
    /// Apache Parquet.
    Parquet,
}

impl TableFormat {
    /// Formats by the extension of a file.
    pub const ALL: [(&'static str, Self); 4] = [
        ("parquet", Self::Parquet),
        ("csv", Self::Csv),
        ("tsv", Self::Csv),
        ("txt", Self::Csv),
    ];

    /// The format of a file, by its extension; `None` for another one.
    pub fn of(path: &Path) -> Option<Self> {
        let extension = path.extension()?;
        let mut formats = Self::ALL.into_iter();
        Some(formats.find(|(e, _)| extension.eq_ignore_ascii_case(e))?.1)
    }

    /// The error of a file without such an extension.
    fn refusal(path: &Path) -> LogError {
        let endings = Self::ALL.map(|(extension, _)| format!(".{extension}"));
        if let Some(advice) = bag::advice(path) {
            return LogError::whole(path, advice);
        }
        if path
            .extension()
            .is_some_and(|ending| ending.eq_ignore_ascii_case("toml"))
        {
            let message = "is a description, allowed: a log; `robhaz run` runs a scene, `robhaz verify` checks it and its robot";
            return LogError::whole(path, message);
        }
        let endings = endings.join(", ");
        let topics = match bag::is_mcap(path) {
            true => "",
            false => ", and .mcap of topics",
        };
        LogError::whole(
            path,
            format!("is no table, allowed endings: {endings}{topics}"),
        )
    }

    /// The columns of a file.
    pub fn columns(self, path: &Path) -> Result<Vec<ColumnInfo>, LogError> {
        match self {
            Self::Csv => csv_table::columns(path),
            Self::Parquet => parquet_rows::columns(path),
        }
    }

    /// Hands all rows of a file to `add`, with the cells of chosen columns. Returns why it ends
    /// before its end: it was cut off.
    pub fn read(
        self,
        path: &Path,
        time: &TimeColumn,
        columns: &[String],
        add: &mut AddRow<'_>,
    ) -> Result<Option<String>, LogError> {
        match self {
            Self::Csv => csv_table::read(path, time, columns, add),
            // Without its end a Parquet file cannot be read at all.
            Self::Parquet => parquet_rows::read(path, time, columns, add).map(|()| None),
        }
    }
}

/// The name of a table: that of its file without extension.
pub fn stem(path: &Path) -> String {
    let stem = path.file_stem().unwrap_or_default();
    stem.to_string_lossy().into_owned()
}

/// Which rows of its file a channel has.
#[derive(Clone, Debug, PartialEq)]
pub enum Rows {
    /// Those of a table, and its time.
    Table(TableFormat, TimeColumn),
    /// The messages of a topic.
    Topic(String, Clock),
}

/// A channel of a log: rows with time stamps of one clock.
#[derive(Clone, Debug)]
pub struct Channel {
    /// Its name in messages.
    pub name: String,
    /// Its file.
    pub path: PathBuf,
    /// Further files of its topic, in the order of the recording: a bag may be split.
    pub splits: Vec<PathBuf>,
    /// Its rows in the file.
    pub rows: Rows,
    /// The `frame_id` of its messages; empty: any one.
    pub frame: String,
    /// Added to its time stamps, s.
    pub offset: f64,
    /// Names of the columns that are read.
    pub columns: Vec<String>,
    /// Places of those that are speeds of wheels, whose integral is read.
    pub speeds: Vec<usize>,
    /// Places of those that start anew after a range, and that range, in their units.
    pub wraps: Vec<(usize, f64)>,
    /// The readings that follow from them.
    pub readings: Vec<(Reading, Formula)>,
    /// Of a table of the truth, how its rows are read.
    pub truth: Option<TruthColumns>,
    /// Times of the rows that count since the first frame, s; rows are there once they were read.
    pub times: Vec<f64>,
    /// Their cells, one row after the other; not a number where a cell has none.
    pub cells: Vec<f64>,
    /// What became of all rows of its file.
    pub report: ChannelReport,
}

impl Channel {
    /// A channel that reads nothing yet.
    pub fn new(name: String, path: &Path, rows: Rows) -> Self {
        Self {
            name,
            path: path.to_path_buf(),
            splits: Vec::new(),
            rows,
            frame: String::new(),
            offset: 0.0,
            columns: Vec::new(),
            speeds: Vec::new(),
            wraps: Vec::new(),
            readings: Vec::new(),
            truth: None,
            times: Vec::new(),
            cells: Vec::new(),
            report: ChannelReport::default(),
        }
    }

    /// A table in a file with an extension of its format, which reads nothing yet.
    pub fn of_table(name: String, path: &Path, time: TimeColumn) -> Result<Self, LogError> {
        let format = TableFormat::of(path).ok_or_else(|| TableFormat::refusal(path))?;
        Ok(Self::new(name, path, Rows::Table(format, time)))
    }

    /// The columns of its rows; of a topic, those of the messages until all that it reads were
    /// seen.
    pub fn found(&self) -> Result<Vec<ColumnInfo>, LogError> {
        match &self.rows {
            Rows::Table(format, _) => format.columns(&self.path),
            Rows::Topic(topic, _) => {
                mcap_events::columns(&self.files(), topic, &self.frame, &self.columns)
            }
        }
    }

    /// Its files in their order.
    pub fn files(&self) -> Vec<&Path> {
        let splits = self.splits.iter().map(PathBuf::as_path);
        std::iter::once(&*self.path).chain(splits).collect()
    }

    /// A problem of it.
    pub fn problem(&self, message: impl Display) -> LogError {
        LogError::place(&self.path, format!("channel {}", self.name), message)
    }

    /// Its rows, of which each has all columns.
    pub fn rows(&self) -> Chunks<'_, f64> {
        self.cells.chunks(self.columns.len().max(1))
    }

    /// The cells of a row; `None` beyond its ends.
    pub fn row(&self, row: usize) -> Option<&[f64]> {
        let columns = self.columns.len();
        self.cells.get(row * columns..(row + 1) * columns)
    }

    /// Whether it has a reading.
    pub fn has(&self, reading: Reading) -> bool {
        self.readings.iter().any(|(own, _)| *own == reading)
    }

    /// The finite cells of a column, each with the time of its row, s.
    pub fn column_mut(&mut self, cell: usize) -> impl Iterator<Item = (f64, &mut f64)> {
        let columns = self.columns.len().max(1);
        let cells = self.cells.iter_mut().skip(cell).step_by(columns);
        let cells = self.times.iter().copied().zip(cells);
        cells.filter(|(_, cell)| cell.is_finite())
    }

    /// The readings of a row's cells.
    pub fn values(&self, cells: &[f64]) -> Values {
        let mut values: Values = [None; Reading::COUNT];
        for (reading, formula) in &self.readings {
            values[reading.index()] = formula.value(cells);
        }
        values
    }
}

/// All channels of a log; the first is the time base.
#[derive(Clone, Debug)]
pub struct Channels {
    /// The file or folder, as the user named it.
    pub source: PathBuf,
    /// The channels.
    pub all: Vec<Channel>,
}

impl Channels {
    /// All files, each once.
    pub fn files(&self) -> Vec<PathBuf> {
        let mut seen = BTreeSet::new();
        let files = self.all.iter().flat_map(Channel::files);
        let files = files.filter(|file| seen.insert(*file));
        files.map(Path::to_path_buf).collect()
    }

    /// Hands all rows with the numbers of their channels to `add`, those of a channel in the order
    /// of its file. Returns why each channel ends before its end: it was cut off.
    ///
    /// # Errors
    /// [`LogError`] of a file, or of `add`.
    pub fn read(
        &self,
        mut add: impl FnMut(usize, Row) -> Result<(), LogError>,
    ) -> Result<Vec<Option<String>>, LogError> {
        let mut cut_off = vec![None; self.all.len()];
        let mut topics = Vec::new();
        for (i, channel) in self.all.iter().enumerate() {
            let Channel {
                path,
                columns,
                frame,
                ..
            } = channel;
            match &channel.rows {
                Rows::Table(format, time) => {
                    cut_off[i] = format.read(path, time, columns, &mut |row| add(i, row))?;
                }
                Rows::Topic(topic, clock) => {
                    topics.push(Wanted::new(i, topic, *clock, frame, columns));
                }
            }
        }
        // Topics are of one file or bag, that of the log, and are read together.
        if let Some(first) = topics.first() {
            let files = self.all[first.channel].files();
            let why = mcap_events::read(&files, &mut topics, &mut add)?;
            topics
                .iter()
                .for_each(|t| cut_off[t.channel].clone_from(&why));
        }
        Ok(cut_off)
    }

    /// Whether a channel has a reading.
    pub fn has(&self, reading: Reading) -> bool {
        self.all.iter().any(|channel| channel.has(reading))
    }

    /// Whether readings of the body stand in place of those of the links.
    pub fn is_of_body(&self) -> bool {
        let is_of_body = |r: Reading| r.is_of_body() == Some(true) && self.has(r);
        !self.is_of_both() && Reading::all().any(is_of_body)
    }

    /// Whether it has readings of both sides.
    pub fn is_of_both(&self) -> bool {
        Reading::all().any(|r| r.is_of_both() && self.has(r))
    }

    /// The readings that no channel has, of those that one side needs.
    pub fn absent(&self) -> Vec<Reading> {
        let needed = Reading::of_side(self.is_of_body());
        needed.filter(|r| !self.has(*r)).collect()
    }
}
