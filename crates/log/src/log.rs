//! A log that is ready to be estimated.

use crate::check::{Agreement, StatedBoth, contradiction, signs_are_lost};
use crate::error::LogError;
use crate::formula::{Formula, Source, Upward};
use crate::frames::Frames;
use crate::held;
use crate::integral;
use crate::jitter::Jitter;
use crate::mapped;
use crate::measured;
use crate::own_names;
use crate::place::{LogPlace, no_table};
use crate::plan::{Plan, Rows};
use crate::readings::Reading;
use crate::survey::{Survey, survey};
use crate::wrap;
use fnv::FnvHasher;
use robhaz_estimator::Method;
use robhaz_estimator::whole::WholeEstimator;
use robhaz_model::BodyMount;
use robhaz_run::{BothDescription, EstimatorDescription, Run, RunDescription, Source as Samples};
use robhaz_scene::{
    ChannelChoice, EstimatorChoice, LogChoice, LogSides, RecordChoice, is_wheel_angle,
};
use std::fs::File;
use std::hash::Hasher as _;
use std::io::Read as _;
use std::path::PathBuf;

/// Turn of a wheel that shows a drive, rad.
const TURNS: f64 = 0.1;

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

/// A log that is ready to be estimated.
pub struct Log {
    /// Its name.
    pub name: String,
    /// Robot, noise budget and estimators.
    pub choice: LogChoice,
    /// Duration, rate, and the time from which means count.
    pub record: RecordChoice,
    /// What the user should know, one line each.
    pub warnings: Vec<String>,
    frames: Frames,
    fingerprint: u64,
    /// Errors of its time stamps, measured by the wheels.
    jitter: Jitter,
}

impl Log {
    /// Reads the time stamps of a log and checks all that can be checked before it is estimated.
    ///
    /// # Errors
    /// [`LogError`]
    pub fn open(place: LogPlace, options: &LogOptions) -> Result<Self, LogError> {
        let LogPlace {
            path,
            name,
            table,
            splits,
            mut choice,
            mut warnings,
            ..
        } = place;
        let channels = match (&choice.mapping, &table) {
            (Some(mapping), table) => {
                mapped::channels(&path, table.as_deref(), splits.as_deref(), mapping)?
            }
            (None, Some(table)) if mapped::is_mcap(table) => {
                vec![own_names::topic(table, &choice)?]
            }
            (None, Some(table)) => vec![own_names::readings(table, &choice)?],
            (None, None) => return Err(no_table(&path)),
        };
        let mut files: Vec<PathBuf> = Vec::new();
        for channel in &channels {
            for file in channel.files() {
                if !files.iter().any(|known| known == file) {
                    files.push(file.to_path_buf());
                }
            }
        }
        let mut plan = Plan {
            source: path,
            channels,
        };
        warnings.extend(unmapped(&plan)?);
        if plan.is_of_both() || choice.sides == LogSides::Both {
            check_both(&plan, &mut choice, options)?;
        } else {
            warnings.extend(use_contact_angles(&mut plan, &mut choice, options)?);
        }
        if let Some(truth) = &options.truth {
            let channels = choice.mapping.iter().flat_map(|m| &m.channels);
            let clock = channels
                .into_iter()
                .find(|c| c.name == ChannelChoice::TRUTH);
            plan.channels
                .push(own_names::truth(truth, clock, plan.is_of_both())?);
            files.push(truth.clone());
        }
        let mut survey = survey(&plan)?;
        for (channel, found) in plan.channels.iter().zip(&mut survey.channels) {
            for (cell, range) in &channel.wraps {
                wrap::go_on(&mut found.cells, channel.columns.len(), *cell, *range);
            }
        }
        warnings.extend(held::leave_out(&plan, &mut survey));
        warnings.extend(integrate(&plan, &mut survey, &mut choice));
        warnings.extend(check_values(&plan, &survey, options.allows_empty)?);
        warnings.extend(measured::take_counts(
            &plan,
            &survey,
            &mut choice.budget.encoder_counts,
        ));
        if !choice.states_torque_noise {
            let noise = &mut choice.budget.torque_noise;
            *noise = measured::noise_of_torques(&plan, &survey, *noise, options.allows_empty);
        }
        if !options.allows_empty {
            warnings.extend(measured::take_noise_of_pins(
                &plan,
                &survey,
                &mut choice.pin[0],
            ));
        }
        let mount = plan.is_of_body().then(|| {
            let robot = &choice.robot.robot;
            let mount = BodyMount::new(&robot.geometry, choice.pin[0]);
            let budget = &choice.budget;
            choice.body = Some([budget.inclination_noise, budget.rate_noise]);
            choice.budget = budget.of_body_sensors(robot, choice.pin);
            // A check looks for what an estimate leaves out.
            match options.allows_empty {
                true => mount.keeping_jumps(),
                false => mount,
            }
        });
        let record = record(&survey, &choice, &mut warnings);
        choice.compare_from = record.compare_from;
        warnings.extend(check_truth(&plan, &survey, record.compare_from)?);
        let mut frames = Frames::new(plan, survey, mount);
        warnings.extend(few_compared(&frames, record.compare_from));
        let fingerprint = fingerprint(&files, &choice)?;
        let mut sides = vec![frames.all(0)];
        if choice.sides == LogSides::Both {
            sides.push(frames.all(1));
        }
        let jitter = Jitter::of(&sides[0], choice.budget.encoder_counts);
        let robot = &choice.robot.robot;
        let lost = sides.iter().any(|side| signs_are_lost(side, robot));
        if !options.allows_empty && lost {
            return Err(LogError::whole(
                &frames.source(),
                "all torques touch zero and never pass it, so their signs are lost, and no forces follow from them; allowed: signed currents or torques: log them, or the drivers' direction with them",
            ));
        }
        if jitter.exceeds(choice.budget.jitter) {
            let [measured, stated] = [jitter.sigma, choice.budget.jitter].map(|s| 1e3 * s);
            warnings.push(format!(
                "the time stamps err by {measured:.2} ms, measured by the wheels; budget.jitter is {stated} ms: the measured one counts"
            ));
        }
        Ok(Self {
            fingerprint,
            name,
            choice,
            record,
            warnings,
            frames,
            jitter,
        })
    }

    /// The run of its estimators.
    ///
    /// # Errors
    /// [`LogError`] of a rover that cannot be estimated.
    pub fn into_run(mut self) -> Result<Run, LogError> {
        let mut choice = self.choice.clone();
        choice.budget.jitter = self.jitter.counted(choice.budget.jitter);
        let mut description =
            RunDescription::of_log(&self.name, self.fingerprint, self.record, &choice);
        description.has_truth = self.frames.has_truth();
        let Some(estimator) = self.whole_estimator(&choice)? else {
            return Ok(Run::of(description, self.into_source()));
        };
        if let (Some(rover), [one]) = (choice.robot.whole_rover(), &description.estimators[..]) {
            let side = |side: &str| EstimatorDescription {
                label: format!("{}-{side}", one.label),
                ..one.clone()
            };
            let stated = StatedBoth {
                rover: &rover,
                settings: one.settings,
                joint: choice.pin,
            };
            let Agreement {
                contradiction,
                unconfirmed,
            } = contradiction(&self.frames.all_of_both(), &stated);
            description.both = Some(BothDescription {
                label: one.label.clone(),
                coupling: rover.coupling,
                contradiction,
                unconfirmed,
            });
            description.estimators = ["left", "right"].map(side).into();
        }
        Ok(Run::of_both(description, self.into_source(), estimator))
    }

    /// The estimator of a log of both sides; `None` of another log.
    fn whole_estimator(&self, choice: &LogChoice) -> Result<Option<WholeEstimator>, LogError> {
        let (LogSides::Both, [listed]) = (choice.sides, &choice.estimators[..]) else {
            return Ok(None);
        };
        let source = self.frames.source();
        let rover = own_names::rover(&source, choice)?;
        let estimator = WholeEstimator::new(&rover, choice.settings(listed), choice.pin);
        let estimator = estimator.map_err(|e| LogError::whole(&source, e))?;
        Ok(Some(estimator))
    }

    /// Its readings alone.
    pub fn into_source(self) -> Box<dyn Samples + Send> {
        Box::new(self.frames)
    }
}

/// Makes angles of the speeds of wheels. The budget then has an encoder whose steps err as much, if
/// that is coarser. Returns what the user should know.
fn integrate(plan: &Plan, survey: &mut Survey, choice: &mut LogChoice) -> Vec<String> {
    let mut notices = Vec::new();
    for (channel, found) in plan.channels.iter().zip(&mut survey.channels) {
        for cell in &channel.speeds {
            let columns = channel.columns.len();
            let of_cell =
                |(_, formula): &&(Reading, Formula)| formula.source == Source::Cell(*cell);
            let Some((reading, formula)) = channel.readings.iter().find(of_cell) else {
                continue;
            };
            let rows = found.cells.chunks(columns);
            let speeds: Vec<f64> = rows.map(|row| row[*cell] * formula.factor).collect();
            let counts = integral::counts(&speeds, found.report.period);
            integral::integrate(&found.times, &mut found.cells, columns, *cell);
            let budget = &mut choice.budget.encoder_counts;
            if counts < *budget || *budget <= 0.0 && counts.is_finite() {
                *budget = counts;
            }
            notices.push(format!(
                "{} is the integral of {}, a speed; by its noise it counts as an encoder of {budget:.0} counts a turn",
                reading.name(),
                channel.columns[*cell],
            ));
        }
    }
    notices
}

/// Refuses a reading without a value in the whole log where its messages state that they do not
/// have it, and, unless the log may have one, any other. Returns the torques that are 0 throughout,
/// as drives write them that do not measure any.
fn check_values(
    plan: &Plan,
    survey: &Survey,
    allows_empty: bool,
) -> Result<Option<String>, LogError> {
    let (mut zeros, mut drives) = (Vec::new(), false);
    for (channel, found) in plan.channels.iter().zip(&survey.channels) {
        let columns = channel.columns.len().max(1);
        for (reading, formula) in &channel.readings {
            let values = found.cells.chunks(columns).map(|row| formula.value(row));
            let name = reading.name();
            if let Some(first) = values.clone().flatten().next() {
                drives |= is_wheel_angle(name)
                    && values.clone().flatten().any(|v| (v - first).abs() > TURNS);
                let is_zero = |value: f64| value.abs() <= 0.0;
                let is_torque = name.ends_with("_motor_torque");
                if is_torque && is_zero(first) && values.flatten().all(is_zero) {
                    zeros.push(name);
                }
                continue;
            }
            let is_topic = matches!(channel.rows, Rows::Topic(..));
            let rows = format!(
                "{name} has no value in {} {}",
                found.times.len(),
                if is_topic { "messages" } else { "rows" }
            );
            let remedy = match formula.source {
                Source::Inclination(Upward::Orientation(..), _) if is_topic => {
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

/// Refuses a truth of which no row is compared with. Returns what the user should know of the other
/// rows.
fn check_truth(
    plan: &Plan,
    survey: &Survey,
    compare_from: f64,
) -> Result<Option<String>, LogError> {
    let mut channels = plan.channels.iter().enumerate();
    let of_truth = channels.find(|(_, channel)| channel.truth.is_some());
    let Some(((index, channel), truth)) = of_truth.zip(survey.truth.as_ref()) else {
        return Ok(None);
    };
    let table = "the table of --truth";
    let refused = |message: String| Err(LogError::place(&channel.path, table, message));
    let lacks = truth.lacks(&channel.columns);
    let Some((first, last)) = truth.span else {
        return refused(format!(
            "no row can be compared with: {lacks}; allowed: N and T of each wheel in a row, or no --truth"
        ));
    };
    let [first, last] = [first, last].map(|stamp| plan.time(index, stamp, survey.origin));
    let end = survey.duration;
    if last < compare_from || first > end {
        return refused(format!(
            "no row can be compared with: it has N and T of each wheel from {first:.3} to {last:.3} s \
             after the start of the log, and errors count from record.compare_from = {compare_from} s to \
             the end at {end:.3} s; set record.compare_from, or the `offset` of the channel truth if its \
             clock differs"
        ));
    }
    let is_whole = truth.whole == truth.rows;
    let notice = format!("the truth is compared with where it has N and T of each wheel: {lacks}");
    Ok((!is_whole).then_some(notice))
}

/// Says where only some of the frames can be compared with the truth.
fn few_compared(frames: &Frames, compare_from: f64) -> Option<String> {
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
fn check_both(plan: &Plan, choice: &mut LogChoice, options: &LogOptions) -> Result<(), LogError> {
    let refused = |message: String| Err(LogError::whole(&plan.source, message));
    if choice.states_sides && choice.sides != LogSides::Both {
        return refused(format!(
            "has readings of both sides, and the description states sides = \"{}\"; allowed: \"both\", or readings of one side",
            choice.sides.name()
        ));
    }
    let rover = own_names::rover(&plan.source, choice)?;
    choice.sides = LogSides::Both;
    let needed = Reading::of_both(rover.coupling).filter(|r| !r.is_optional() && !plan.has(*r));
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
    choice
        .keep_one_of_both(options.named_estimators)
        .map_err(|error| LogError::whole(&plan.source, error))
}

/// The columns of tables that have the names of readings that a log may lack, and are not mapped.
fn unmapped(plan: &Plan) -> Result<Option<String>, LogError> {
    let mut names = Vec::new();
    for channel in &plan.channels {
        if !matches!(channel.rows, Rows::Table(..)) {
            continue;
        }
        for column in channel.found()? {
            let is_it = |r: &Reading| {
                r.is_optional() && r.is_of_both() == plan.is_of_both() && r.name() == column.name
            };
            if Reading::all().any(|r| is_it(&r) && !plan.has(r)) {
                names.push(column.name);
            }
        }
    }
    let notice = format!(
        "{} of the table are not mapped, so they do not count",
        names.join(", ")
    );
    Ok((!names.is_empty()).then_some(notice))
}

/// Leaves out contact angles, or the estimators that need them. Returns what the user should know.
fn use_contact_angles(
    plan: &mut Plan,
    choice: &mut LogChoice,
    options: &LogOptions,
) -> Result<Option<String>, LogError> {
    let refused = |message: String| Err(LogError::whole(&plan.source, message));
    let absent = plan.absent().into_iter();
    let (absent, others): (Vec<_>, Vec<_>) = absent.partition(|r| r.is_contact_angle());
    if let Some(reading) = others.first() {
        return refused(format!(
            "has no {}: every estimator needs it; allowed to be missing: contact angles",
            reading.name()
        ));
    }
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
    plan.drop_contact_angles();
    let could = |e: &&EstimatorChoice| {
        matches!(e.settings.method, Method::Kalman(method) if method.rolling)
            && e.settings.needs_contact_angles()
    };
    let could = choice.estimators.iter().filter(could);
    let could: Vec<String> = could.map(|e| format!("--estimator {}", e.name)).collect();
    let left_out = choice.without_contact_angles(options.named_estimators);
    let left_out = left_out.map_err(|error| LogError::whole(&plan.source, error))?;
    let names = left_out.join(", ");
    let mut notice = format!("no contact angles: {names} take them from the log and are left out");
    if !could.is_empty() {
        notice += &format!("; {} runs without them", could.join(" or "));
    }
    Ok((!left_out.is_empty()).then_some(notice))
}

fn record(survey: &Survey, choice: &LogChoice, warnings: &mut Vec<String>) -> RecordChoice {
    let mut compare_from = choice.compare_from;
    if compare_from >= survey.duration {
        warnings.push(format!(
            "the log lasts {:.3} s, less than record.compare_from = {compare_from} s: all of it counts",
            survey.duration
        ));
        compare_from = 0.0;
    }
    let rate = 1.0 / survey.channels[0].report.period;
    RecordChoice {
        duration: survey.duration,
        // To six digits: steps between time stamps are rounded.
        rate: format!("{rate:.5e}").parse().unwrap_or(rate),
        compare_from,
    }
}

/// Hash of the files and of the description.
fn fingerprint(files: &[PathBuf], choice: &LogChoice) -> Result<u64, LogError> {
    let mut hash = FnvHasher::default();
    let mut buffer = vec![0; 1 << 18];
    for path in files {
        let mut file = File::open(path).map_err(LogError::io(path))?;
        loop {
            match file.read(&mut buffer).map_err(LogError::io(path))? {
                0 => break,
                n => hash.write(&buffer[..n]),
            }
        }
    }
    hash.write(format!("{choice:?}").as_bytes());
    Ok(hash.finish())
}
