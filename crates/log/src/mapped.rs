//! Channels of a log whose description says which column is which reading.

use crate::error::LogError;
use crate::formula::{Formula, Source, Upward, across};
use crate::mcap_events::Clock;
use crate::plan::{ChannelPlan, Rows, stem};
use crate::readings::Reading;
use crate::rows::{ColumnInfo, TimeColumn};
use crate::stamp::TimeUnit;
use robhaz_scene::{ChannelChoice, ImuChoice, InclinationSource, Mapping};
use std::path::{Path, PathBuf};

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
        channels.push(empty(table, stem(table), None)?);
    }
    // The channel of this name states the clock of the truth.
    for choice in mapping
        .channels
        .iter()
        .filter(|c| c.name != ChannelChoice::TRUTH)
    {
        let path = file(log, table, choice)?;
        channels.push(empty(&path, choice.name.clone(), Some(choice))?);
    }
    for reading in &mapping.readings {
        let channel = named(&mut channels, &reading.channel);
        let formula = Formula {
            source: Source::Cell(channel.cell(&reading.column)),
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
        let folder = Some(log).filter(|log| log.is_dir()).or(log.parent());
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
    let problem = |message: &str| LogError::place(path, format!("channel {name}"), message);
    let channel = match choice.filter(|c| !c.topic.is_empty()) {
        None if is_mcap(path) => {
            let message =
                "state the `topic` of each channel of an MCAP file, [[channel]] in the description";
            return Err(problem(message));
        }
        None => ChannelPlan::of_table(name, path, time(choice))?,
        Some(ChannelChoice { topic, .. }) if !is_mcap(path) => {
            return Err(problem(&format!(
                "topic {topic} needs an MCAP file (.mcap)"
            )));
        }
        Some(choice) => {
            let clock = match choice.time.as_str() {
                "" | "header" => Clock::Header,
                "log" => Clock::Log,
                other => {
                    let allowed = "allowed: \"header\", \"log\"";
                    return Err(problem(&format!("time: found {other:?}, {allowed}")));
                }
            };
            ChannelPlan::new(name, path, Rows::Topic(choice.topic.clone(), clock))
        }
    };
    Ok(ChannelPlan {
        offset: choice.map_or(0.0, |c| c.offset),
        ..channel
    })
}

/// The time column of a table as its channel states it; by default `time` in seconds.
pub fn time(choice: Option<&ChannelChoice>) -> TimeColumn {
    let name = choice.map_or("", |c| c.time.as_str());
    TimeColumn {
        name: if name.is_empty() { "time" } else { name }.to_owned(),
        unit: TimeUnit(choice.map_or(1, ChannelChoice::time_units_per_second)),
    }
}

/// Whether a file is of topics, by its extension.
pub fn is_mcap(path: &Path) -> bool {
    let extension = path.extension();
    extension.is_some_and(|e| e.eq_ignore_ascii_case("mcap"))
}

/// The channel of a name; the first for none. Names were checked when the description was read.
fn named<'a>(channels: &'a mut [ChannelPlan], name: &str) -> &'a mut ChannelPlan {
    let found = channels.iter().position(|c| c.name == name);
    &mut channels[found.filter(|_| !name.is_empty()).unwrap_or(0)]
}

impl ChannelPlan {
    /// The cell of a column, which is read from now on.
    fn cell(&mut self, column: &str) -> usize {
        let known = self.columns.iter().position(|c| c == column);
        known.unwrap_or_else(|| {
            self.columns.push(column.to_owned());
            self.columns.len() - 1
        })
    }

    fn add(&mut self, name: &str, formula: Formula) {
        let reading = Reading::all().find(|r| r.name() == name);
        self.readings
            .extend(reading.map(|reading| (reading, formula)));
    }

    fn add_imu(&mut self, imu: &ImuChoice) {
        let (force, orientation) = (imu.acceleration.each_ref(), imu.orientation.each_ref());
        let up = match imu.inclination {
            InclinationSource::Acceleration => Upward::SpecificForce(force.map(|c| self.cell(c))),
            InclinationSource::Orientation => {
                Upward::Orientation(orientation.map(|c| self.cell(c)))
            }
        };
        let inclination = Formula {
            source: Source::Inclination(up, [imu.forward, imu.up]),
            factor: 1.0,
            offset: imu.inclination_offset,
        };
        let velocity = imu.angular_velocity.each_ref().map(|c| self.cell(c));
        let rate = Formula {
            source: Source::Rate(velocity, across(imu.forward, imu.up)),
            factor: imu.rate_factor,
            offset: imu.rate_offset,
        };
        self.add(&format!("{}_inclination", imu.link), inclination);
        self.add(&format!("{}_rate", imu.link), rate);
    }
}

/// Checks that the file of a channel has its columns.
fn check(channel: &ChannelPlan) -> Result<(), LogError> {
    let found = channel.found()?;
    let time = match &channel.rows {
        Rows::Topic(..) => None,
        Rows::Table(_, time) => Some(&time.name),
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
    Err(LogError::whole(&channel.path, message))
}
