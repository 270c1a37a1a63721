//! Tables with the column names that a run writes.

use crate::channel::stem;
use crate::mapped::{self, FORWARD, UP, direction};
use crate::{Channel, Clock, ColumnInfo, Formula, LogError, Rows, TimeColumn, Upward, truth};
use robhaz_model::{Suspension, WholeRover};
use robhaz_scene::{ChannelChoice, Kind, LogChoice, LogSides, Reading, Unit};
use std::path::Path;

/// Name of the time column.
const TIME: &str = "time";
/// What helps when a table has other columns.
const REMEDY: &str = "rename the columns, or say with --sensors SENSORS.toml which column is which reading and its unit (docs/logs.md)";
/// What helps when a table has columns of both sides.
const BOTH_REMEDY: &str =
    "it has columns of both sides: state sides = \"both\", or none, in the description";
/// What helps when a table of both sides has other columns.
const OF_BOTH_REMEDY: &str = "rename the columns, or map them with --sensors SENSORS.toml (docs/logs.md#both-sides); body_specific_force_x, _y and _z stand in for body_inclination and body_roll; of one side alone state sides = \"one of two\"";
/// What to do about a table of the truth. A description does not map its columns.
const TRUTH_REMEDY: &str = "rename the columns as in the table truth of a run: time, and wheelN_normal_force and wheelN_traction of each wheel, of both sides left_wheelN_... and right_wheelN_...";

/// The topic with the readings of an exported run.
pub const TOPIC: &str = "/robhaz/readings";

/// The metadata of an exported run: its description.
pub const METADATA: &str = "robhaz";

/// The channel of an exported run, of one side or of both: its readings to the bit.
///
/// # Errors
///
/// [`LogError`] where the file has no such topic, or its rover is none of both sides.
pub fn topic(path: &Path, choice: &LogChoice) -> Result<Channel, LogError> {
    let rows = Rows::Topic(TOPIC.to_owned(), Clock::Header);
    let empty = Channel::new(TOPIC.to_owned(), path, rows);
    let found = empty.found()?;
    let is_of_both = |c: &ColumnInfo| Reading::all().any(|r| r.is_of_both() && r.name() == c.name);
    let readings = of_log(found.iter().any(is_of_both), path, choice)?;
    let cells = (0..).map(Formula::of_cell);
    Ok(Channel {
        columns: readings.iter().map(|r| r.name().to_owned()).collect(),
        readings: readings.into_iter().zip(cells).collect(),
        ..empty
    })
}

/// The channel of a table of readings with the names of a run's table `sensors`. Contact angles may
/// be absent. A table with wheels of both sides is one of both, unless `choice` states what it is of.
///
/// # Errors
///
/// [`LogError`] with all missing columns and wrong units.
pub fn readings(path: &Path, choice: &LogChoice) -> Result<Channel, LogError> {
    let mut table = Table::open(path, mapped::time(None))?;
    let is_wheel =
        |c: &ColumnInfo| c.name.starts_with("left_wheel") || c.name.starts_with("right_wheel");
    let has_both = table.found.iter().any(is_wheel);
    // Of a table with neither the error names the columns that its robot asks for.
    let has_one = table.found.iter().any(|c| c.name.starts_with("wheel"));
    let may_be = has_both || !has_one && choice.robot.whole_rover().is_some();
    if choice.sides == LogSides::Both && has_one && !has_both {
        return Err(none_of_both(path, choice));
    }
    let is_of_both = choice.sides == LogSides::Both || may_be && !choice.states("sides");
    // In place of inclination and roll of a body.
    let force = ["x", "y", "z"].map(|axis| format!("body_specific_force_{axis}"));
    let has = |name: &String| table.found.iter().any(|c| bare(c) == name);
    let has_force = is_of_both && force.iter().all(has);
    for reading in of_log(is_of_both, path, choice)? {
        let name = reading.name();
        let is_of_force = has_force && ["body_inclination", "body_roll"].contains(&name);
        let may_lack = reading.is_optional() || reading.is_contact_angle() || is_of_force;
        let formula = match table.column(name, reading.unit(), may_lack) {
            Some(name) => Formula::of_cell(table.channel.cell(&name)),
            None if is_of_force => {
                let cells = force.each_ref().map(|name| {
                    let name = table.column(name, "m/s^2", true).unwrap_or_default();
                    table.channel.cell(&name)
                });
                direction(name, Upward::SpecificForce(cells), [FORWARD, UP], true)
            }
            None => continue,
        };
        table.channel.readings.push((reading, formula));
    }
    table.find_time();
    table.checked(match (is_of_both, has_both) {
        (true, _) => OF_BOTH_REMEDY,
        (false, true) => BOTH_REMEDY,
        (false, false) => REMEDY,
    })
}

/// The error of a log of one side that is stated to be one of both.
pub fn none_of_both(log: &Path, choice: &LogChoice) -> LogError {
    let (at, log) = (&choice.sides_at.0, log.display());
    LogError::Problem(format!(
        "{at}: sides: found \"both\", and {log} has readings of one side alone (wheel1_angle, ...); allowed: \"one of two\", \"plane\", or readings of both sides (left_wheel1_angle, ...)"
    ))
}

/// The readings that a log can have, of one side or of `both`.
fn of_log(both: bool, path: &Path, choice: &LogChoice) -> Result<Vec<Reading>, LogError> {
    Ok(match both {
        true => Reading::of_both(rover(path, choice)?.coupling).collect(),
        false => Reading::of_frame().collect(),
    })
}

/// The channel of a table of the truth with the names of a run's table `truth`: at least N and T of
/// each wheel. `clock` states its time.
///
/// # Errors
///
/// As [`readings`].
pub fn truth(path: &Path, clock: Option<&ChannelChoice>, both: bool) -> Result<Channel, LogError> {
    let mut table = Table::open(path, mapped::time(clock))?;
    let required = truth::required(both);
    let is_missing = |name: &&String| !table.found.iter().any(|c| bare(c) == **name);
    table.missing = required.iter().filter(is_missing).cloned().collect();
    if clock.is_none() {
        table.find_time();
    } else if let Rows::Table(_, time) = &mut table.channel.rows {
        time.resolve(&table.found, true);
        let is_missing = |name: &&String| !table.found.iter().any(|c| c.name == **name);
        let missing = time.columns().filter(is_missing);
        table.missing.extend(missing.cloned());
    }
    let known = truth::columns(both);
    let is_column = |name: &str| known.iter().any(|column| column == name);
    let (mut columns, mut names, mut factors) = (Vec::new(), Vec::new(), Vec::new());
    for column in table.found.iter().filter(|c| is_column(bare(c))) {
        let name = bare(column).to_owned();
        // The same quantity again, in another unit.
        if names.contains(&name) {
            continue;
        }
        match factor(column) {
            Ok(factor) => factors.push(factor),
            Err(problem) => table.problems.push(problem),
        }
        columns.push(column.name.clone());
        names.push(name);
    }
    table.channel.columns.clone_from(&columns);
    Ok(Channel {
        offset: clock.map_or(0.0, |c| c.offset),
        truth: Some(truth::TruthColumns::new(names, factors)),
        columns,
        ..table.checked(TRUTH_REMEDY)?
    })
}

/// The rover of a log of both sides.
///
/// # Errors
/// [`LogError`] where the robot does not state what lies across, or cannot.
pub fn rover(path: &Path, choice: &LogChoice) -> Result<WholeRover, LogError> {
    let robot = &choice.robot;
    robot.whole_rover().ok_or_else(|| {
        let what = match robot.robot.geometry.suspension {
            Suspension::FourBar => "is a four-bar: how two of them share the body's moment, statics do not say; allowed: --robot ROBOT.toml of one with suspension.kind = \"bogie\", or the readings of one side",
            Suspension::Bogie { .. } => "has no [robot.across]; allowed: a robot file with this section (docs/scenes.md#across), by --robot ROBOT.toml, or the readings of one side",
        };
        let name = &robot.geometry_name;
        let message = format!("has readings of both sides, and the robot {name} {what}");
        LogError::whole(path, message)
    })
}

/// Name of a column without its unit in brackets.
fn bare(column: &ColumnInfo) -> &str {
    let name = column.name.split(['[', '(']).next();
    name.unwrap_or_default().trim()
}

/// The factor of a column of the truth to the unit of a run's table: forces may be in kN, angles in degrees.
fn factor(column: &ColumnInfo) -> Result<f64, String> {
    let (kind, allowed) = match bare(column) {
        name if name.ends_with("_force") || name.ends_with("_traction") => (Kind::Force, "N or kN"),
        name if name.ends_with("_angle") => (Kind::Angle, "rad or deg"),
        _ => return Ok(1.0),
    };
    let Some(found) = &column.unit else {
        return Ok(1.0);
    };
    let unit = Unit::of(found).filter(|unit| unit.kind == kind);
    let name = &column.name;
    unit.map(|unit| unit.factor)
        .ok_or_else(|| format!("column {name} has the unit {found}, allowed: {allowed}"))
}

/// A table in which columns are looked for by their names.
struct Table {
    channel: Channel,
    found: Vec<ColumnInfo>,
    problems: Vec<String>,
    missing: Vec<String>,
}

impl Table {
    fn open(path: &Path, time: TimeColumn) -> Result<Self, LogError> {
        let channel = Channel::of_table(stem(path), path, time)?;
        Ok(Self {
            found: channel.found()?,
            channel,
            problems: Vec::new(),
            missing: Vec::new(),
        })
    }

    /// The full name of a column, which may have its unit in brackets. Another unit is a problem, and so is a
    /// column that is not there, unless the table `may_lack` it.
    fn column(&mut self, name: &str, allowed: &str, may_lack: bool) -> Option<String> {
        let Some(column) = self.found.iter().find(|column| bare(column) == name) else {
            self.missing.extend((!may_lack).then(|| name.to_owned()));
            return None;
        };
        let is_other = |unit: &&str| !Unit::is_same(unit, allowed);
        let other = column.unit.as_deref().filter(is_other);
        if let Some(found) = other.filter(|_| !column.is_time_stamp) {
            let name = &column.name;
            let problem = format!("column {name} has the unit {found}, allowed: {allowed}");
            self.problems.push(problem);
        }
        Some(column.name.clone())
    }

    fn find_time(&mut self) {
        if let Rows::Table(_, time) = &mut self.channel.rows {
            time.resolve(&self.found, false);
            if time.nanoseconds.is_some() {
                return;
            }
        }
        let name = self.column(TIME, "s", false);
        if let (Some(name), Rows::Table(_, time)) = (name, &mut self.channel.rows) {
            time.name = name;
        }
    }

    /// The channel, if nothing is missing or wrong.
    fn checked(mut self, remedy: &str) -> Result<Channel, LogError> {
        if !self.missing.is_empty() {
            let missing = format!("has no column {}", self.missing.join(", "));
            self.problems.insert(0, missing);
        }
        if self.problems.is_empty() {
            return Ok(self.channel);
        }
        let (problems, found) = (self.problems.join("; "), ColumnInfo::list(&self.found));
        let instead = {
            let missing = self.missing.iter().map(String::as_str);
            ColumnInfo::meant(missing, &self.found, &self.channel.columns)
        };
        let message = format!("{problems}; found {found}{instead}; {remedy}");
        Err(LogError::whole(&self.channel.path, message))
    }
}
