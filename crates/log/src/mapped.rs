//! Channels of a log whose description says which column is which reading.

use crate::bag::{self, is_mcap};
use crate::channel::stem;
use crate::formula::across;
use crate::{
    Channel, Clock, ColumnInfo, Formula, LogError, Rows, Source, TimeColumn, TimeUnit, Upward,
};
use robhaz_scene::{
    ChannelChoice, ImuChoice, InclinationSource, Kind, Mapping, Reading, ReadingChoice, Unit, World,
};
use std::f64::consts::{FRAC_PI_2, TAU};
use std::path::{Path, PathBuf};

/// The channels of a log; the first is the time base. `files` are its table, or those of a bag.
///
/// # Errors
/// [`LogError`] with all columns that a file does not have.
pub fn channels(
    log: &Path,
    files: &[PathBuf],
    mapping: &Mapping,
) -> Result<Vec<Channel>, LogError> {
    let mut channels = Vec::new();
    if mapping.channels.is_empty() {
        let Some(table) = files.first() else {
            let message = "is a folder: state its tables, [[channel]] with name and table, in the description";
            return Err(LogError::whole(log, message));
        };
        channels.push(empty(table, stem(table), None)?);
    }
    // The channel of this name states the clock of the truth.
    let choices = || mapping.channels.iter();
    for choice in choices().filter(|c| c.name != ChannelChoice::TRUTH) {
        let own = files.first();
        let own = own.filter(|file| is_mcap(file) || !log.is_dir());
        let path = file(log, own.map(PathBuf::as_path), choice)?;
        let channel = empty(&path, choice.name.clone(), Some(choice))?;
        let is_topic = matches!(channel.rows, Rows::Topic(..));
        channels.push(Channel {
            splits: files.iter().skip(1).filter(|_| is_topic).cloned().collect(),
            ..channel
        });
    }
    for reading in &mapping.readings {
        named(&mut channels, &reading.channel).add_reading(reading);
    }
    let both = mapping.readings.iter().any(|r| r.reading().is_of_both());
    for imu in &mapping.imus {
        add_imu(&mut channels, imu, both);
    }
    for channel in &mut channels {
        check(channel, mapping)?;
    }
    if let Some(base) = &mapping.time_base {
        channels.sort_by_key(|channel| channel.name != *base);
    }
    // A channel without a reading would be read for nothing.
    let mut is_first = true;
    channels.retain(|c| std::mem::take(&mut is_first) || !c.readings.is_empty());
    Ok(channels)
}

/// The file of a channel: that of the log itself, or a file beside it or in its folder.
fn file(log: &Path, own: Option<&Path>, choice: &ChannelChoice) -> Result<PathBuf, LogError> {
    if !choice.table.is_empty() {
        let folder = Some(log).filter(|log| log.is_dir()).or(log.parent());
        let path = folder.unwrap_or(Path::new("")).join(&choice.table);
        if path.exists() {
            return Ok(path);
        }
        let (at, table, path) = (&choice.table_at.0, &choice.table, path.display());
        return Err(LogError::Problem(format!(
            "{at}: channel.table: found {table:?}, and there is no {path}; allowed: a file beside the log, or in its folder"
        )));
    }
    own.map(Path::to_path_buf).ok_or_else(|| {
        let message = "the log is a folder: state the channel's `table`, a file in it";
        LogError::place(log, format!("channel {}", choice.name), message)
    })
}

/// A channel that reads nothing yet.
fn empty(path: &Path, name: String, choice: Option<&ChannelChoice>) -> Result<Channel, LogError> {
    let problem = |message: &str| LogError::place(path, format!("channel {name}"), message);
    let channel = match choice.filter(|c| !c.topic.is_empty()) {
        None if is_mcap(path) => {
            let message =
                "state the `topic` of each channel of an MCAP file, [[channel]] in the description";
            return Err(problem(message));
        }
        None => Channel::of_table(name, path, time(choice))?,
        Some(_) if let Some(advice) = bag::advice(path) => return Err(problem(&advice)),
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
            Channel::new(name, path, Rows::Topic(choice.topic.clone(), clock))
        }
    };
    Ok(Channel {
        offset: choice.map_or(0.0, |c| c.offset),
        frame: choice.map_or(String::new(), |c| c.frame.clone()),
        ..channel
    })
}

/// The time column of a table as its channel states it; by default `time` in seconds.
pub fn time(choice: Option<&ChannelChoice>) -> TimeColumn {
    let name = choice.map_or("", |c| c.time.as_str());
    TimeColumn {
        name: if name.is_empty() { "time" } else { name }.to_owned(),
        unit: TimeUnit(choice.map_or(1, |choice| choice.time_unit.1)),
        nanoseconds: choice
            .map(|c| c.nanoseconds.clone())
            .filter(|name| !name.is_empty()),
    }
}

/// The channel of a name; the first for none. Names were checked when the description was read.
fn named<'a>(channels: &'a mut [Channel], name: &str) -> &'a mut Channel {
    let found = channels.iter().position(|c| c.name == name);
    &mut channels[found.filter(|_| !name.is_empty()).unwrap_or(0)]
}

impl Channel {
    /// The cell of a column, which is read from now on.
    pub fn cell(&mut self, column: &str) -> usize {
        let known = self.columns.iter().position(|c| c == column);
        known.unwrap_or_else(|| {
            self.columns.push(column.to_owned());
            self.columns.len() - 1
        })
    }

    /// A reading of a column. A speed of a wheel is integrated: one in a unit of speed, or of a topic
    /// that of a joint.
    fn add_reading(&mut self, reading: &ReadingChoice) {
        let is_speed = is_speed(reading)
            || reading.reading().is_wheel_angle()
                && matches!(self.rows, Rows::Topic(..))
                && reading.column.ends_with(".velocity");
        let wraps = reading.wrap > 0.0;
        let cell = match is_speed || wraps {
            // A cell of its own: another reading may take the column as it is.
            true => {
                self.columns.push(reading.column.clone());
                self.columns.len() - 1
            }
            false => self.cell(&reading.column),
        };
        if is_speed {
            self.speeds.push(cell);
        } else if wraps {
            self.wraps.push((cell, reading.wrap));
        }
        let formula = Formula {
            factor: reading.factor,
            offset: reading.offset,
            // A sensor that hangs upside down; a wrong unit shows in the angles as they are.
            is_direction: reading.name.ends_with("_inclination")
                && reading.offset.abs() > FRAC_PI_2,
            ..Formula::of_cell(cell)
        };
        self.readings.push((reading.reading(), formula));
    }
}

/// The axes forward and up of a sensor as in ROS.
pub const FORWARD: [f64; 3] = [1.0, 0.0, 0.0];
/// See [`FORWARD`].
pub const UP: [f64; 3] = [0.0, 0.0, 1.0];

/// Inclination or roll, of a body with `both` sides or in the plane, by the direction up and the sensor's axes forward
/// and up.
pub fn direction(name: &str, from: Upward, axes: [[f64; 3]; 2], both: bool) -> Formula {
    let [forward, up] = axes;
    let source = match name {
        "body_roll" => Source::Inclination(from, [across(up, forward), up], false),
        _ => Source::Inclination(from, axes, both),
    };
    Formula {
        is_direction: true,
        ..Formula::of(source)
    }
}

/// Adds the readings of a sensor, but those that have a column of their own; of a log of `both`
/// sides roll and yaw, too.
fn add_imu(channels: &mut [Channel], imu: &ImuChoice, both: bool) {
    let axes = [imu.forward, imu.up];
    let across = across(imu.forward, imu.up);
    // Each rate with its axis.
    for (part, of_plane, axis, offset) in [
        ("inclination", true, None, imu.inclination_offset),
        ("roll", false, None, imu.roll_offset),
        ("rate", true, Some(across), imu.rate_offset),
        ("roll_rate", false, Some(imu.forward), imu.roll_rate_offset),
        ("yaw_rate", false, Some(imu.up), imu.yaw_rate_offset),
    ] {
        let name = format!("{}_{part}", imu.link);
        let is_free = |r: &Reading| channels.iter().all(|c| !c.has(*r));
        let reading = Reading::named(&name).filter(is_free);
        let Some(reading) = reading.filter(|_| both || of_plane) else {
            continue;
        };
        let own = axis.map_or(&imu.channel, |_| of_rate(imu));
        let channel = named(channels, own);
        let formula = match axis {
            Some(axis) => {
                let cells = imu.angular_velocity.each_ref().map(|c| channel.cell(c));
                Formula {
                    factor: imu.rate_factor,
                    ..Formula::of(Source::Rate(cells, axis))
                }
            }
            None => direction(&name, upward(channel, imu), axes, both),
        };
        let formula = Formula { offset, ..formula };
        channel.readings.push((reading, formula));
    }
}

/// The channel of a sensor's rates.
fn of_rate(imu: &ImuChoice) -> &String {
    match imu.rate_channel.is_empty() {
        true => &imu.channel,
        false => &imu.rate_channel,
    }
}

/// Where a sensor shows the direction up.
fn upward(channel: &mut Channel, imu: &ImuChoice) -> Upward {
    match imu.inclination {
        InclinationSource::Acceleration => {
            Upward::SpecificForce(imu.acceleration.each_ref().map(|c| channel.cell(c)))
        }
        InclinationSource::Orientation => {
            let up = if imu.world == World::Ned { -1.0 } else { 1.0 };
            Upward::Orientation(imu.orientation.each_ref().map(|c| channel.cell(c)), up)
        }
    }
}

/// Whether a reading is the angle of a wheel, and its unit one of a speed.
fn is_speed(reading: &ReadingChoice) -> bool {
    let kind = Unit::of(reading.unit).map(|unit| unit.kind);
    reading.reading().is_wheel_angle() && kind == Some(Kind::Rate)
}

/// Checks that the file of a channel has its columns, in the units that the description states, and
/// finds the columns of its time.
fn check(channel: &mut Channel, mapping: &Mapping) -> Result<(), LogError> {
    let found = channel.found()?;
    let mut choices = mapping.channels.iter();
    let choice = choices.find(|choice| choice.name == channel.name);
    if let Rows::Table(_, time) = &mut channel.rows {
        time.resolve(&found, choice.is_some_and(|c| !c.time.is_empty()));
    }
    check_names(channel, &found)?;
    // Messages state no units.
    let Rows::Table(_, time) = &channel.rows else {
        return Ok(());
    };
    // Columns, what is stated of them, unit and scale, and what is allowed.
    let mut columns: Vec<(&String, Option<Unit>, f64, String)> = Vec::new();
    let is_named = |name: &str| name == channel.name || name.is_empty();
    for reading in mapping.readings.iter().filter(|r| is_named(&r.channel)) {
        let allowed = format!(
            "the `unit` of reading.{} that the column has, or, of a unit that no key states, its factor to SI as `scale`",
            reading.name
        );
        columns.push((&reading.column, stated(reading), reading.scale, allowed));
    }
    for imu in mapping.imus.iter().filter(|i| is_named(of_rate(i))) {
        let is_degrees = imu.rate_factor < 1.0;
        let name = if is_degrees { "deg/s" } else { "rad/s" };
        for column in &imu.angular_velocity {
            let allowed = format!("the `rate_unit` of imu.{} that the column has", imu.link);
            columns.push((column, Unit::of(name), 1.0, allowed));
        }
    }
    // Two columns have no unit.
    if time.nanoseconds.is_none() {
        let stated = Unit::of(choice.map_or("s", |choice| choice.time_unit.0));
        let allowed = "the `time_unit` of the [[channel]] that the column has: s, ms, us, ns";
        columns.push((&time.name, stated, 1.0, allowed.to_owned()));
    }
    for (name, stated, scale, allowed) in columns {
        let Some(stated) = stated else { continue };
        let taken_for = match stated.kind {
            Kind::Current => Kind::Torque,
            kind => kind,
        };
        // A time stamp has the unit of its type.
        let mut own = found.iter().filter(|c| c.name == *name && !c.is_time_stamp);
        let unit = own.next().and_then(|own| own.stated_unit(taken_for));
        if let Some(unit) = unit.filter(|unit| !stated.agrees(scale, unit)) {
            let message = format!(
                "its unit is {}, and the description states {}; allowed: {allowed}, or rename the column",
                unit.name, stated.name
            );
            let place = format!("column {name}");
            return Err(LogError::place(&channel.path, place, message));
        }
    }
    Ok(())
}

/// Checks that the file of a channel has all columns that are named.
fn check_names(channel: &Channel, found: &[ColumnInfo]) -> Result<(), LogError> {
    let time = match &channel.rows {
        Rows::Topic(..) => None,
        Rows::Table(_, time) => Some(time),
    };
    let is_missing = |name: &&String| !found.iter().any(|c| c.name == **name);
    let wanted = time.into_iter().flat_map(TimeColumn::columns);
    let wanted = wanted.chain(&channel.columns);
    let missing: Vec<&str> = wanted.filter(is_missing).map(String::as_str).collect();
    if missing.is_empty() {
        return Ok(());
    }
    let message = format!(
        "has no column {}, which the description names for channel {}; found {}{}{}",
        missing.join(", "),
        channel.name,
        ColumnInfo::list(found),
        instead(&missing, found),
        ColumnInfo::meant(missing.iter().copied(), found, &channel.columns),
    );
    Err(LogError::whole(&channel.path, message))
}

/// The unit that is stated of a reading's column; of counts that of the angle.
fn stated(reading: &ReadingChoice) -> Option<Unit> {
    let mut unit = Unit::of(reading.unit)?;
    if unit.kind == Kind::Counts {
        (unit.kind, unit.factor) = (Kind::Angle, TAU / reading.counts.max(1.0));
    }
    Some(unit)
}

/// What can be read in place of missing columns: the speed of a joint without a position.
fn instead(missing: &[&str], found: &[ColumnInfo]) -> String {
    let speed = missing.iter().find_map(|name| {
        let speed = format!("{}.velocity", name.strip_suffix(".position")?);
        found.iter().any(|c| c.name == speed).then_some(speed)
    });
    speed.map_or(String::new(), |speed| {
        format!("; column = \"{speed}\" integrates the speed")
    })
}
