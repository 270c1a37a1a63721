//! What is read from which channel, and how a reading follows from the cells of a row.

use crate::error::LogError;
use crate::formula::Formula;
use crate::mcap_events::{self, TopicPlace, Wanted};
use crate::readings::{Reading, Values};
use crate::rows::{AddRow, ColumnInfo, Row, TimeColumn};
use crate::truth;
use crate::{csv_table, parquet_rows};
use robhaz_sim::Truth;
use std::path::{Path, PathBuf};

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
        let extension = path.extension()?.to_str()?.to_ascii_lowercase();
        let found = Self::ALL.iter().find(|(e, _)| *e == extension);
        found.map(|(_, format)| *format)
    }

    /// The error of a file without such an extension.
    fn refusal(path: &Path) -> LogError {
        let endings = Self::ALL.map(|(extension, _)| format!(".{extension}"));
        let killed = if path.extension().is_some_and(|e| e == "arrows") {
            "; a stream of an earlier version's killed run: pyarrow.ipc.open_stream reads it, \
             pyarrow.parquet.write_table makes Parquet of it"
        } else {
            ""
        };
        let message = format!(
            "is no table, allowed endings: {}{killed}",
            endings.join(", ")
        );
        LogError::whole(path, message)
    }

    /// The columns of a file.
    pub fn columns(self, path: &Path) -> Result<Vec<ColumnInfo>, LogError> {
        match self {
            Self::Csv => csv_table::columns(path),
            Self::Parquet => parquet_rows::columns(path),
        }
    }
}

/// A table and its time.
#[derive(Clone, Debug, PartialEq)]
pub struct TablePlace {
    /// The file.
    pub path: PathBuf,
    /// Its format.
    pub format: TableFormat,
    /// Its time.
    pub time: TimeColumn,
}

impl TablePlace {
    /// A table in a file with an extension of its format.
    pub fn new(path: &Path, time: TimeColumn) -> Result<Self, LogError> {
        Ok(Self {
            path: path.to_path_buf(),
            format: TableFormat::of(path).ok_or_else(|| TableFormat::refusal(path))?,
            time,
        })
    }

    /// The name of a table: that of its file without extension.
    pub fn stem(path: &Path) -> String {
        let stem = path.file_stem().unwrap_or_default();
        stem.to_string_lossy().into_owned()
    }

    /// Hands all rows to `add`, with the cells of chosen columns. Returns why the table ends before
    /// its end: it was cut off.
    pub fn read(
        &self,
        columns: &[String],
        add: &mut AddRow<'_>,
    ) -> Result<Option<String>, LogError> {
        match self.format {
            TableFormat::Csv => csv_table::read(&self.path, &self.time, columns, add),
            // Without its end a Parquet file cannot be read at all.
            TableFormat::Parquet => {
                parquet_rows::read(&self.path, &self.time, columns, add).map(|()| None)
            }
        }
    }
}

/// Where the rows of a channel come from.
#[derive(Clone, Debug, PartialEq)]
pub enum ChannelPlace {
    /// A table.
    Table(TablePlace),
    /// A topic.
    Topic(TopicPlace),
}

impl ChannelPlace {
    /// The file.
    pub fn path(&self) -> &Path {
        match self {
            Self::Table(table) => &table.path,
            Self::Topic(topic) => &topic.path,
        }
    }
}

/// A channel of a log: rows with time stamps of one clock.
#[derive(Clone, Debug, PartialEq)]
pub struct ChannelPlan {
    /// Its name in messages.
    pub name: String,
    /// Where its rows come from.
    pub place: ChannelPlace,
    /// Added to its time stamps, s.
    pub offset: f64,
    /// Names of the columns that are read.
    pub columns: Vec<String>,
    /// The readings that follow from them.
    pub readings: Vec<(Reading, Formula)>,
    /// Whether the columns are those of the truth.
    pub is_truth: bool,
}

/// What a row of a channel gives.
#[derive(Clone, Debug, Default)]
pub struct Content {
    /// Readings.
    pub readings: Values,
    /// Truth.
    pub truth: Option<Truth>,
}

impl ChannelPlan {
    /// A channel that reads nothing yet.
    pub fn new(name: String, place: ChannelPlace) -> Self {
        Self {
            name,
            place,
            offset: 0.0,
            columns: Vec::new(),
            readings: Vec::new(),
            is_truth: false,
        }
    }

    /// What a row's cells give.
    pub fn content(&self, cells: &[Option<f64>]) -> Content {
        let mut content = Content::default();
        if self.is_truth {
            content.truth = truth::of_row(&self.columns, cells);
        }
        for (reading, formula) in &self.readings {
            content.readings[reading.index()] = formula.value(cells);
        }
        content
    }
}

/// All channels of a log; the first is the time base.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// The file or folder, as the user named it.
    pub source: PathBuf,
    /// The channels.
    pub channels: Vec<ChannelPlan>,
}

impl Plan {
    /// Hands all rows with the numbers of their channels to `add`, those of a channel in the order
    /// of its file. Returns why each channel ends before its end: it was cut off.
    ///
    /// # Errors
    /// [`LogError`] of a file, or of `add`.
    pub fn read(
        &self,
        mut add: impl FnMut(usize, Row) -> Result<(), LogError>,
    ) -> Result<Vec<Option<String>>, LogError> {
        let mut cut_off = vec![None; self.channels.len()];
        let mut topics = Vec::new();
        for (i, channel) in self.channels.iter().enumerate() {
            if let ChannelPlace::Topic(topic) = &channel.place {
                topics.push(Wanted::new(i, topic, &channel.columns));
            }
        }
        for (i, channel) in self.channels.iter().enumerate() {
            match &channel.place {
                ChannelPlace::Table(table) => {
                    cut_off[i] = table.read(&channel.columns, &mut |row| add(i, row))?;
                }
                // Topics are of one file, that of the log, and are read together.
                ChannelPlace::Topic(topic) => {
                    let mut all = std::mem::take(&mut topics);
                    if !all.is_empty() {
                        let why = mcap_events::read(&topic.path, &mut all, &mut add)?;
                        all.iter().for_each(|t| cut_off[t.channel].clone_from(&why));
                    }
                }
            }
        }
        Ok(cut_off)
    }

    /// Whether a channel has a reading.
    pub fn has(&self, reading: Reading) -> bool {
        let mut readings = self.channels.iter().flat_map(|c| &c.readings);
        readings.any(|(r, _)| *r == reading)
    }

    /// Leaves out the contact angles.
    pub fn drop_contact_angles(&mut self) {
        for channel in &mut self.channels {
            channel.readings.retain(|(r, _)| !r.is_contact_angle());
        }
    }

    /// Whether readings of the body stand in place of those of the links.
    pub fn is_of_body(&self) -> bool {
        Reading::all().any(|r| r.is_of_body() && self.has(r))
    }

    /// The readings that no channel has, of those that are needed.
    pub fn absent(&self) -> Vec<Reading> {
        let of_body = self.is_of_body();
        let needed = Reading::all().filter(|r| match of_body {
            true => !r.is_of_link(),
            false => !r.is_of_body(),
        });
        needed.filter(|r| !self.has(*r)).collect()
    }
}
