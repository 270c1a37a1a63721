//! Whether a log has what its estimators need, and what is left out where it does not.

use crate::{Channel, Channels, Formula, Frames, LogError, Rows, Source, Upward, own_names};
use robhaz_scene::{LogChoice, LogSides, Reading};
use std::path::PathBuf;

/// How a log is read.
#[derive(Clone, Debug, Default)]
pub struct LogOptions {
    /// A table of the truth to compare with.
    pub truth: Option<PathBuf>,
    /// Whether contact angles are used; `None`: if the log has them.
    pub contact_angles: Option<bool>,
    /// Whether the estimators were named by the user: they then run without contact angles where
    /// there are none.
    pub named_estimators: bool,
    /// Whether a reading may have no value in the whole log; no estimator runs on such a log.
    pub allows_empty: bool,
}

/// Turn of a wheel that shows a drive, rad.
const TURNS: f64 = 0.1;

/// Refuses a reading without a value in the whole log where its messages state that they do not
/// have it, and, unless the log may have one, any other. Returns the torques that are 0 throughout,
/// as drives write them that do not measure any.
pub fn check_values(channels: &[Channel], allows_empty: bool) -> Result<Option<String>, LogError> {
    let (mut zeros, mut drives) = (Vec::new(), false);
    for channel in channels {
        for (reading, formula) in &channel.readings {
            let values = channel.rows().map(|row| formula.value(row));
            let name = reading.name();
            if let Some(first) = values.clone().flatten().next() {
                drives |= reading.is_wheel_angle()
                    && values.clone().flatten().any(|v| (v - first).abs() > TURNS);
                let is_zero = |value: f64| value.abs() <= 0.0;
                if reading.is_torque() && is_zero(first) && values.flatten().all(is_zero) {
                    zeros.push(name);
                }
                continue;
            }
            let is_topic = matches!(channel.rows, Rows::Topic(..));
            let rows = format!(
                "{name} has no value in {} {}",
                channel.times.len(),
                if is_topic { "messages" } else { "rows" }
            );
            let remedy = match formula.source {
                Source::Inclination(Upward::Orientation(..), ..) if is_topic => {
                    "the messages have no orientation (orientation_covariance[0] = -1, or a quaternion of zeros); state inclination = \"acceleration\""
                }
                Source::Inclination(..) if is_topic => {
                    "the messages have no linear_acceleration (linear_acceleration_covariance[0] = -1, or zeros); state the channel that has it, or inclination = \"orientation\""
                }
                Source::Rate(..) if is_topic => {
                    "the messages have no angular_velocity (angular_velocity_covariance[0] = -1); state rate_channel, the channel of the gyroscope"
                }
                // Of a wheel that is not steered it is 0.
                _ if allows_empty || reading.is_optional() => continue,
                Source::Cell(cell) if channel.columns[cell].ends_with(".position") => {
                    "allowed: numbers; of joints without a position column = \"NAME.velocity\" integrates the speed"
                }
                _ => {
                    "allowed: numbers, since every estimator needs it; find out why it was not recorded"
                }
            };
            return Err(channel.problem(format!("{rows}: {remedy}")));
        }
    }
    let notice = format!(
        "{} is 0 in the whole log while wheels turn: was it measured?",
        zeros.join(", ")
    );
    Ok((drives && !zeros.is_empty()).then_some(notice))
}

/// Leaves out contact angles without a value in the whole log, as in the folder of an estimate without them. Whether there
/// are some.
pub fn drop_empty_angles(channels: &mut [Channel]) -> bool {
    let mut is_found = false;
    for channel in channels {
        let is_empty = |(reading, formula): &(Reading, Formula)| {
            reading.is_contact_angle() && channel.rows().all(|row| formula.value(row).is_none())
        };
        let empty: Vec<bool> = channel.readings.iter().map(is_empty).collect();
        is_found |= empty.contains(&true);
        let mut empty = empty.into_iter();
        channel.readings.retain(|_| !empty.next().unwrap_or(false));
    }
    is_found
}

/// Refuses a truth of which no row is compared with in a log that ends at `end`, s. Returns what the user should know
/// of the other rows.
pub fn check_truth(
    channels: &Channels,
    end: f64,
    compare_from: f64,
) -> Result<Option<String>, LogError> {
    let mut all = channels.all.iter();
    let found = all.find_map(|channel| Some((channel, channel.truth.as_ref()?.required())));
    let Some((channel, cells)) = found else {
        return Ok(None);
    };
    let table = "the table of --truth";
    let refused = |message: String| Err(LogError::place(&channel.path, table, message));
    let lacking = cells.iter().filter_map(|cell| {
        let empty = channel.rows().filter(|row| row[*cell].is_nan()).count();
        (empty > 0).then(|| format!("{} in {empty}", channel.columns[*cell]))
    });
    let lacking: Vec<String> = lacking.collect();
    let (rows, columns) = (channel.report.rows, lacking.join(", "));
    let lacks = format!("of {rows} rows there is no number for {columns}");
    let is_whole = |(_, row): &(_, &[f64])| cells.iter().all(|cell| row[*cell].is_finite());
    let whole = channel.times.iter().zip(channel.rows()).filter(is_whole);
    let mut times = whole.map(|(time, _)| *time);
    let Some(first) = times.next() else {
        return refused(format!(
            "no row can be compared with: {lacks}; allowed: N and T of each wheel in a row, or no --truth"
        ));
    };
    let last = times.next_back().unwrap_or(first);
    if last < compare_from || first > end {
        return refused(format!(
            "no row can be compared with: it has N and T of each wheel from {first:.3} to {last:.3} s \
             after the start of the log, and errors count from record.compare_from = {compare_from} s to \
             the end at {end:.3} s; set record.compare_from, or the `offset` of the channel truth if its \
             clock differs"
        ));
    }
    let notice = format!("the truth is compared with where it has N and T of each wheel: {lacks}");
    Ok((!lacking.is_empty()).then_some(notice))
}

/// Says where only some of the frames can be compared with the truth.
pub fn few_compared(frames: &Frames, compare_from: f64) -> Option<String> {
    /// Share of the frames that may lack a truth: ends, single rows.
    const FEW: f64 = 0.01;
    let (count, with) = frames.frames_with_truth(compare_from)?;
    // Counts of frames.
    let lacking = (count - with) as f64;
    (lacking > FEW * count as f64).then(|| {
        format!(
            "the truth has a row for {with} of the {count} frames that count: errors are those of these frames"
        )
    })
}

/// Checks that a log of both sides has all that is needed, of a rover that can be estimated.
pub fn check_both(
    channels: &Channels,
    choice: &mut LogChoice,
    options: &LogOptions,
) -> Result<(), LogError> {
    let refused = |message: String| Err(LogError::whole(&channels.source, message));
    if choice.states("sides") && choice.sides != LogSides::Both {
        return refused(format!(
            "has readings of both sides, and the description states sides = \"{}\"; allowed: \"both\", or readings of one side",
            choice.sides.name()
        ));
    }
    if !channels.is_of_both() {
        return Err(own_names::none_of_both(&channels.source, choice));
    }
    let rover = own_names::rover(&channels.source, choice)?;
    choice.sides = LogSides::Both;
    let needed = Reading::of_both(rover.coupling).filter(|r| !r.is_optional() && !channels.has(*r));
    let missing: Vec<&str> = needed.map(Reading::name).collect();
    if !missing.is_empty() {
        return refused(format!(
            "has no {}, and a log of both sides needs each; allowed to be missing: steering of wheels that are not steered. Inclination, roll and their rates and that of yaw may come from one [imu.body]; of a bogie without a sensor, or of one side alone, map that side's readings as wheel1_angle ... and state sides = \"one of two\"",
            missing.join(", ")
        ));
    }
    if options.contact_angles == Some(true) {
        return refused("the estimator of both sides finds contact angles and takes none; allowed: --contact-angles none".to_owned());
    }
    let kept = choice.keep_one_of_both(options.named_estimators);
    kept.map_err(|error| LogError::whole(&channels.source, error))
}

/// The columns of tables that have the names of readings that a log may lack, and are not mapped.
pub fn unmapped(channels: &Channels) -> Result<Option<String>, LogError> {
    let of_both = channels.is_of_both();
    let is_free = |r: &Reading| r.is_optional() && r.is_of_both() == of_both && !channels.has(*r);
    let free: Vec<&str> = Reading::all().filter(is_free).map(Reading::name).collect();
    let mut names = Vec::new();
    let is_table = |channel: &&Channel| matches!(channel.rows, Rows::Table(..));
    for table in channels.all.iter().filter(is_table) {
        let columns = table.found()?.into_iter().map(|column| column.name);
        names.extend(columns.filter(|name| free.contains(&name.as_str())));
    }
    let notice = format!(
        "{} of the table are not mapped, so they do not count",
        names.join(", ")
    );
    Ok((!names.is_empty()).then_some(notice))
}

/// Leaves out contact angles, or the estimators that need them. Returns what the user should know.
pub fn use_contact_angles(
    channels: &mut Channels,
    choice: &mut LogChoice,
    options: &LogOptions,
) -> Result<Option<String>, LogError> {
    let refused = |message: String| Err(LogError::whole(&channels.source, message));
    let absent = channels.absent().into_iter();
    let (absent, others): (Vec<_>, Vec<_>) = absent.partition(|r| r.is_contact_angle());
    if let Some(reading) = others.first() {
        return refused(format!(
            "has no {}: every estimator needs it; allowed to be missing: contact angles",
            reading.name()
        ));
    }
    let some = (1..3).contains(&absent.len()) && options.contact_angles != Some(false);
    let some = some.then(|| {
        let absent: Vec<&str> = absent.iter().map(|r| r.name()).collect();
        format!(
            "the log has no {}, and contact angles count of all three wheels or of none: the others are left out",
            absent.join(", ")
        )
    });
    let needing = choice.needing_contact_angles();
    if options.contact_angles == Some(true) && !absent.is_empty() && !needing.is_empty() {
        let absent: Vec<&str> = absent.iter().map(|r| r.name()).collect();
        let (absent, needing) = (absent.join(", "), needing.join(", "));
        return refused(format!(
            "has no {absent}, which {needing} need; allowed: --contact-angles none, or a log with them"
        ));
    }
    if options.contact_angles.unwrap_or(absent.is_empty()) {
        return Ok(None);
    }
    for channel in &mut channels.all {
        channel.readings.retain(|(r, _)| !r.is_contact_angle());
    }
    let left_out = choice.without_contact_angles(options.named_estimators);
    let left_out = left_out.map_err(|error| LogError::whole(&channels.source, error))?;
    let names: Vec<&str> = left_out.iter().map(|e| e.name.as_str()).collect();
    let names = names.join(", ");
    let could = left_out.iter().filter(|e| e.rolls());
    let could: Vec<String> = could.map(|e| format!("--estimator {}", e.name)).collect();
    let mut notice = format!("no contact angles: {names} take them from the log and are left out");
    if !could.is_empty() {
        notice += &format!("; {} runs without them", could.join(" or "));
    }
    let notices = [some, (!left_out.is_empty()).then_some(notice)];
    let notices: Vec<String> = notices.into_iter().flatten().collect();
    Ok((!notices.is_empty()).then(|| notices.join("; ")))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Clock;
    use crate::mapped::{FORWARD, UP, direction};
    use std::path::Path;

    /// Messages without an orientation are named as such, of a link as of a body that rolls.
    #[test]
    fn messages_without_an_orientation_are_named() {
        for (name, both) in [("link1_inclination", false), ("body_inclination", true)] {
            let reading = Reading::named(name).expect("a reading");
            let upward = Upward::Orientation([0, 1, 2, 3], 1.0);
            let topic = Rows::Topic(String::new(), Clock::Header);
            let channel = Channel {
                columns: vec![String::new(); 4],
                times: vec![0.0],
                cells: vec![f64::NAN; 4],
                readings: vec![(reading, direction(name, upward, [FORWARD, UP], both))],
                ..Channel::new(String::new(), Path::new(""), topic)
            };
            for allows_empty in [false, true] {
                let found = check_values(std::slice::from_ref(&channel), allows_empty);
                let error = found.expect_err("no value").to_string();
                assert!(error.contains("no orientation"), "{error}");
            }
        }
    }
}
