//! Channels of a log whose description says which column is which reading.

use crate::error::LogError;
use crate::formula::{Formula, Upward, across};
use crate::mcap_events::{self, Clock, TopicPlace};
use crate::plan::{ChannelPlace, ChannelPlan, TablePlace};
use crate::readings::Reading;
use crate::rows::{ColumnInfo, TimeColumn};
use crate::stamp::TimeUnit;
use robhaz_scene::{ChannelChoice, ImuChoice, InclinationSource, Mapping};
use std::path::{Path, PathBuf};

/// Name of the channel that states the clock of the table of the truth.
pub const TRUTH: &str = "truth";

/// The channels of a log; the first is the time base.
///
/// # Errors
/// [`LogError`] with all columns that a file does not have.
pub fn channels(
    log: &Path,
    table: Option<&Path>,
    mapping: &Mapping,
) -> Result<Vec<ChannelPlan>, LogError> {
    let mut channels = Vec::new();
    if mapping.channels.is_empty() {
        let Some(table) = table else {
            let message = "is a folder: state its tables, [[channel]] with name and table, in the description";
            return Err(LogError::whole(log, message));
        };
        channels.push(empty(table, TablePlace::stem(table), None)?);
    }
    // The channel of this name states the clock of the truth.
    for choice in mapping.channels.iter().filter(|c| c.name != TRUTH) {
        let path = file(log, table, choice)?;
        channels.push(empty(&path, choice.name.clone(), Some(choice))?);
    }
    for reading in &mapping.readings {
        let channel = named(&mut channels, &reading.channel);
        let formula = Formula::Cell {
            cell: channel.cell(&reading.column),
            factor: reading.factor,
            offset: reading.offset,
        };
        channel.add(reading.name, formula);
    }
    for imu in &mapping.imus {
        named(&mut channels, &imu.channel).add_imu(imu);
    }
    channels.iter().try_for_each(check)?;
    if let Some(base) = &mapping.time_base
        && let Some(i) = channels.iter().position(|c| c.name == *base)
    {
        let base = channels.remove(i);
        channels.insert(0, base);
    }
    // A channel without a reading would be read for nothing.
    let mut is_first = true;
    channels.retain(|c| std::mem::take(&mut is_first) || !c.readings.is_empty());
    Ok(channels)
}

/// The file of a channel: the log itself, or a file beside it or in its folder.
fn file(log: &Path, table: Option<&Path>, choice: &ChannelChoice) -> Result<PathBuf, LogError> {
    if !choice.table.is_empty() {
        let folder = if log.is_dir() {
            Some(log)
        } else {
            log.parent()
        };
        return Ok(folder.unwrap_or(Path::new("")).join(&choice.table));
    }
    let own = table.filter(|_| !log.is_dir());
    own.map(Path::to_path_buf).ok_or_else(|| {
        let message = "the log is a folder: state the channel's `table`, a file in it";
        LogError::place(log, format!("channel {}", choice.name), message)
    })
}

/// A channel that reads nothing yet.
fn empty(
    path: &Path,
    name: String,
    choice: Option<&ChannelChoice>,
) -> Result<ChannelPlan, LogError> {
    let place = match choice.filter(|c| !c.topic.is_empty()) {
        Some(choice) => ChannelPlace::Topic(topic(path, choice)?),
        None if is_mcap(path) => {
            let message =
                "state the `topic` of each channel of an MCAP file, [[channel]] in the description";
            return Err(LogError::place(path, format!("channel {name}"), message));
        }
        None => ChannelPlace::Table(TablePlace::new(path, time(choice))?),
    };
    Ok(ChannelPlan {
        offset: choice.map_or(0.0, |c| c.offset),
        ..ChannelPlan::new(name, place)
    })
}

/// The time column of a table as its channel states it; by default `time` in seconds.
pub fn time(choice: Option<&ChannelChoice>) -> TimeColumn {
    let name = choice.map_or("", |c| c.time.as_str());
    TimeColumn {
        name: if name.is_empty() { "time" } else { name }.to_owned(),
        unit: TimeUnit {
            per_second: choice.map_or(1, ChannelChoice::time_units_per_second),
        },
    }
}

fn topic(path: &Path, choice: &ChannelChoice) -> Result<TopicPlace, LogError> {
    let problem =
        |message: String| LogError::place(path, format!("channel {}", choice.name), message);
    if !is_mcap(path) {
        let message = format!("topic {} needs an MCAP file (.mcap)", choice.topic);
        return Err(problem(message));
    }
    Ok(TopicPlace {
        path: path.to_path_buf(),
        topic: choice.topic.clone(),
        clock: match choice.time.as_str() {
            "" | "header" => Clock::Header,
            "log" => Clock::Log,
            other => {
                return Err(problem(format!(
                    "time: found {other:?}, allowed: \"header\", \"log\""
                )));
            }
        },
    })
}

/// Whether a file is of topics, by its extension.
pub fn is_mcap(path: &Path) -> bool {
    path.extension()
        .is_some_and(|e| e.eq_ignore_ascii_case("mcap"))
}

/// The channel of a name; the first for none. Names were checked when the description was read.
fn named<'a>(channels: &'a mut [ChannelPlan], name: &str) -> &'a mut ChannelPlan {
    let found = channels.iter().position(|c| c.name == name);
    &mut channels[found.filter(|_| !name.is_empty()).unwrap_or(0)]
}

impl ChannelPlan {
    /// The cell of a column, which is read from now on.
    fn cell(&mut self, column: &str) -> usize {
        if let Some(found) = self.columns.iter().position(|c| c == column) {
            return found;
        }
        self.columns.push(column.to_owned());
        self.columns.len() - 1
    }

    fn add(&mut self, name: &str, formula: Formula) {
        let reading = Reading::all().find(|r| r.name() == name);
        self.readings
            .extend(reading.map(|reading| (reading, formula)));
    }

    fn add_imu(&mut self, imu: &ImuChoice) {
        let up = match imu.inclination {
            InclinationSource::Acceleration => {
                Upward::SpecificForce(imu.acceleration.each_ref().map(|c| self.cell(c)))
            }
            InclinationSource::Orientation => {
                Upward::Orientation(imu.orientation.each_ref().map(|c| self.cell(c)))
            }
        };
        let inclination = Formula::Inclination {
            up,
            forward_axis: imu.forward,
            up_axis: imu.up,
            offset: imu.inclination_offset,
        };
        let rate = Formula::Rate {
            cells: imu.angular_velocity.each_ref().map(|c| self.cell(c)),
            axis: across(imu.forward, imu.up),
            factor: imu.rate_factor,
            offset: imu.rate_offset,
        };
        self.add(&format!("{}_inclination", imu.link), inclination);
        self.add(&format!("{}_rate", imu.link), rate);
    }
}

/// Checks that the file of a channel has its columns.
fn check(channel: &ChannelPlan) -> Result<(), LogError> {
    let (found, time) = match &channel.place {
        ChannelPlace::Topic(topic) => {
            let found = mcap_events::columns(&topic.path, &topic.topic, &channel.columns)?;
            (found, None)
        }
        ChannelPlace::Table(table) => (table.format.columns(&table.path)?, Some(&table.time.name)),
    };
    let is_missing = |name: &&String| !found.iter().any(|c| c.name == **name);
    let wanted = time.into_iter().chain(&channel.columns);
    let missing: Vec<&str> = wanted.filter(is_missing).map(String::as_str).collect();
    if missing.is_empty() {
        return Ok(());
    }
    let message = format!(
        "has no column {}, which the description names for channel {}; found {}",
        missing.join(", "),
        channel.name,
        ColumnInfo::list(&found),
    );
    Err(LogError::whole(channel.place.path(), message))
}
