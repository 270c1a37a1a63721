//! Tables with the column names that a run writes.

use crate::error::LogError;
use crate::formula::Formula;
use crate::mapped;
use crate::mcap_events::{self, Clock, TopicPlace};
use crate::plan::{ChannelPlace, ChannelPlan, TableFormat, TablePlace};
use crate::readings::Reading;
use crate::rows::{ColumnInfo, TimeColumn};
use crate::stamp::TimeUnit;
use crate::truth;
use robhaz_scene::ChannelChoice;
use std::path::Path;

/// Name of the time column.
const TIME: &str = "time";
/// What helps when a table has other columns.
const REMEDY: &str = "rename the columns, or say with --sensors SENSORS.toml which column is which reading and its unit (docs/logs.md)";
/// What to do about a table of the truth. A description does not map its columns.
const TRUTH_REMEDY: &str = "rename the columns as in the table truth of a run: time, and wheelN_normal_force and wheelN_traction of each wheel";

/// The topic with the readings of an exported run.
pub const TOPIC: &str = "/robhaz/readings";

/// The channel of an exported run: its readings to the bit.
///
/// # Errors
/// [`LogError`] where the file has no such topic.
pub fn topic(path: &Path) -> Result<ChannelPlan, LogError> {
    mcap_events::columns(path, &[(TOPIC, &[])])?;
    let readings = Reading::all().enumerate();
    Ok(ChannelPlan {
        name: TOPIC.to_owned(),
        place: ChannelPlace::Topic(TopicPlace {
            path: path.to_path_buf(),
            topic: TOPIC.to_owned(),
            clock: Clock::Header,
        }),
        offset: 0.0,
        columns: Reading::all().map(|r| r.name().to_owned()).collect(),
        readings: readings.map(|(i, r)| (r, Formula::of_cell(i))).collect(),
        is_truth: false,
    })
}

/// The channel of a table of readings with the names of a run's table `sensors`. Contact angles may be absent.
///
/// # Errors
/// [`LogError`] with all missing columns and wrong units.
pub fn readings(path: &Path) -> Result<ChannelPlan, LogError> {
    let (format, found) = open(path)?;
    let (mut problems, mut missing) = (Vec::new(), Vec::new());
    let (mut columns, mut formulas) = (Vec::new(), Vec::new());
    for reading in Reading::all() {
        match find(&found, reading.name()) {
            Some(column) => {
                problems.extend(wrong_unit(column, reading.unit()));
                formulas.push((reading, Formula::of_cell(columns.len())));
                columns.push(column.name.clone());
            }
            None if reading.is_contact_angle() => {}
            None => missing.push(reading.name().to_owned()),
        }
    }
    let time = time(&found, &mut problems, &mut missing);
    check(path, &found, problems, &missing, REMEDY)?;
    Ok(ChannelPlan {
        name: TablePlace::stem(path),
        place: ChannelPlace::Table(TablePlace {
            path: path.to_path_buf(),
            format,
            time,
        }),
        offset: 0.0,
        columns,
        readings: formulas,
        is_truth: false,
    })
}

/// The channel of a table of the truth with the names of a run's table `truth`: at least N and T of each wheel. `clock`
/// states its time.
///
/// # Errors
/// As [`readings`].
pub fn truth(path: &Path, clock: Option<&ChannelChoice>) -> Result<ChannelPlan, LogError> {
    let (format, found) = open(path)?;
    let (mut problems, mut missing) = (Vec::new(), Vec::new());
    for name in truth::required() {
        match find(&found, &name) {
            Some(column) => problems.extend(wrong_unit(column, "N")),
            None => missing.push(name),
        }
    }
    let time = match clock {
        Some(_) => {
            let time = mapped::time(clock);
            if !found.iter().any(|c| c.name == time.name) {
                missing.push(time.name.clone());
            }
            time
        }
        None => time(&found, &mut problems, &mut missing),
    };
    check(path, &found, problems, &missing, TRUTH_REMEDY)?;
    let columns = found.into_iter().map(|c| c.name);
    Ok(ChannelPlan {
        name: TablePlace::stem(path),
        place: ChannelPlace::Table(TablePlace {
            path: path.to_path_buf(),
            format,
            time,
        }),
        offset: clock.map_or(0.0, |c| c.offset),
        columns: columns.filter(|name| truth::is_column(name)).collect(),
        readings: Vec::new(),
        is_truth: true,
    })
}

fn open(path: &Path) -> Result<(TableFormat, Vec<ColumnInfo>), LogError> {
    let format = TableFormat::of(path).ok_or_else(|| TableFormat::refusal(path))?;
    Ok((format, format.columns(path)?))
}

/// A column by its name, with or without a unit in brackets.
fn find<'a>(columns: &'a [ColumnInfo], name: &str) -> Option<&'a ColumnInfo> {
    let bare = |column: &ColumnInfo| {
        let text = column.name.split(['[', '(']).next().unwrap_or_default();
        text.trim() == name
    };
    columns.iter().find(|column| bare(column))
}

fn wrong_unit(column: &ColumnInfo, allowed: &str) -> Option<String> {
    let found = column.unit.as_deref().filter(|unit| *unit != allowed)?;
    let name = &column.name;
    Some(format!(
        "column {name} has the unit {found}, allowed: {allowed}"
    ))
}

fn time(
    columns: &[ColumnInfo],
    problems: &mut Vec<String>,
    missing: &mut Vec<String>,
) -> TimeColumn {
    let found = find(columns, TIME);
    match found {
        Some(column) => problems.extend(wrong_unit(column, "s")),
        None => missing.push(TIME.to_owned()),
    }
    TimeColumn {
        name: found.map_or(TIME, |column| &column.name).to_owned(),
        unit: TimeUnit::SECOND,
    }
}

fn check(
    path: &Path,
    found: &[ColumnInfo],
    mut problems: Vec<String>,
    missing: &[String],
    remedy: &str,
) -> Result<(), LogError> {
    if !missing.is_empty() {
        problems.insert(0, format!("has no column {}", missing.join(", ")));
    }
    if problems.is_empty() {
        return Ok(());
    }
    let message = format!(
        "{}; found {}; {remedy}",
        problems.join("; "),
        ColumnInfo::list(found)
    );
    Err(LogError::whole(path, message))
}
