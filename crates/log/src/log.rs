//! A log that is ready to be estimated.

use crate::bag::is_mcap;
use crate::check::{
    Consistency, Level, StatedBoth, certain, contradiction, signs_are_lost, torque_spikes,
};
use crate::place::no_table;
use crate::survey::survey;
use crate::{
    Channel, Channels, Frames, Jitter, LogError, LogOptions, LogPlace, bursts, content, held,
    integral, mapped, measured, merged, own_names, wrap,
};
use fnv::FnvHasher;
use robhaz_estimator::EstimatorSettings;
use robhaz_estimator::whole::WholeEstimator;
use robhaz_model::BodyMount;
use robhaz_run::{
    BothDescription, ChannelReport, EstimatorDescription, Run, RunDescription, Source as Samples,
};
use robhaz_scene::{ChannelChoice, LogChoice, LogSides, RecordChoice};
use std::fs::File;
use std::hash::Hasher as _;
use std::io::Read as _;
use std::path::PathBuf;

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
        let mut channels = Channels {
            all: channels(&place)?,
            source: place.path,
        };
        let (mut choice, mut warnings) = (place.choice, place.warnings);
        let mut files = channels.files();
        warnings.extend(content::unmapped(&channels)?);
        if channels.is_of_both() || choice.sides == LogSides::Both {
            content::check_both(&channels, &mut choice, options)?;
        } else {
            let notice = content::use_contact_angles(&mut channels, &mut choice, options)?;
            warnings.extend(notice);
        }
        if let Some(truth) = &options.truth {
            let mut stated = choice.mapping.iter().flat_map(|m| &m.channels);
            let clock = stated.find(|c| c.name == ChannelChoice::TRUTH);
            let truth_channel = own_names::truth(truth, clock, channels.is_of_both())?;
            channels.all.push(truth_channel);
            files.push(truth.clone());
        }
        let (origin, duration) = survey(&mut channels)?;
        if content::drop_empty_angles(&mut channels.all) {
            let notice = content::use_contact_angles(&mut channels, &mut choice, options)?;
            warnings.extend(notice);
        }
        warnings.extend(mend(&mut channels.all, &mut choice, options)?);
        warnings.extend(measure(&channels.all, &mut choice, options));
        let mount = mount(&channels, &mut choice, options);
        let rate = 1.0 / channels.all[0].report.period;
        let from = &mut choice.compare_from;
        let record = record(duration, rate, from, &mut warnings);
        let from = record.compare_from;
        warnings.extend(content::check_truth(&channels, duration, from)?);
        let mut frames = Frames::new(channels, origin, mount);
        warnings.extend(content::few_compared(&frames, from));
        let fingerprint = fingerprint(&files, &choice)?;
        let jitter = jitter(&mut frames, &choice, options)?;
        if jitter.exceeds(choice.budget.jitter) {
            let [measured, stated] = [jitter.sigma, choice.budget.jitter].map(|s| 1e3 * s);
            warnings.push(format!(
                "the time stamps err by {measured:.2} ms, measured by the wheels; budget.jitter is {stated} ms: the measured one counts"
            ));
        }
        if !options.allows_empty {
            warnings.extend(level(&frames, &choice).warning());
        }
        Ok(Self {
            fingerprint,
            name: place.name,
            choice,
            record,
            warnings,
            frames,
            jitter,
        })
    }

    /// Robot, noise budget and estimators, with the errors of the time stamps that count.
    pub fn counted(&self) -> LogChoice {
        let mut choice = self.choice.clone();
        choice.budget.jitter = self.jitter.counted(choice.budget.jitter);
        choice
    }

    /// Whether the readings of both sides agree; `None` of a log of one.
    ///
    /// # Errors
    /// [`LogError`] of a rover that cannot be estimated.
    pub fn consistency(&self) -> Result<Option<Consistency>, LogError> {
        let choice = self.counted();
        let (LogSides::Both, [one]) = (choice.sides, &choice.estimators[..]) else {
            return Ok(None);
        };
        let stated = StatedBoth {
            rover: &own_names::rover(self.frames.source(), &choice)?,
            settings: choice.settings(one),
            joint: choice.pin,
            compare_from: self.record.compare_from,
        };
        Ok(Some(contradiction(&self.frames.all_of_both(), &stated)))
    }

    /// The run of its estimators, with the log's [`Log::consistency`].
    ///
    /// # Errors
    /// [`LogError`] of a rover that cannot be estimated.
    pub fn into_run(self, consistency: Option<Consistency>) -> Result<Run, LogError> {
        let choice = self.counted();
        let mut description =
            RunDescription::of_log(&self.name, self.fingerprint, self.record, &choice);
        description.has_truth = self.frames.has_truth();
        let sides = self.frames.of_sides();
        description.certain = certain(&sides[0], &choice.robot.robot);
        let (Some(found), [one]) = (consistency, &description.estimators[..]) else {
            return Ok(Run::of(description, self.into_source()));
        };
        let source = self.frames.source();
        let rover = own_names::rover(source, &choice)?;
        let estimator = WholeEstimator::new(&rover, one.settings, choice.pin);
        let estimator = estimator.map_err(|e| LogError::whole(source, e))?;
        let side = |side: &str| EstimatorDescription {
            label: format!("{}-{side}", one.label),
            ..one.clone()
        };
        description.both = Some(BothDescription {
            label: one.label.clone(),
            coupling: rover.coupling,
            contradiction: found.contradiction,
            unconfirmed: found.unconfirmed,
        });
        description.estimators = ["left", "right"].map(side).into();
        Ok(Run::of_both(description, self.into_source(), estimator))
    }

    /// Its readings alone.
    pub fn into_source(self) -> Box<dyn Samples + Send> {
        Box::new(self.frames)
    }
}

/// The channels of a log, whose rows are not read yet.
fn channels(place: &LogPlace) -> Result<Vec<Channel>, LogError> {
    let choice = &place.choice;
    match (&choice.mapping, place.files.first()) {
        (Some(mapping), _) => mapped::channels(&place.path, &place.files, mapping),
        (None, Some(table)) if is_mcap(table) => Ok(vec![own_names::topic(table, choice)?]),
        (None, Some(table)) => Ok(vec![own_names::readings(table, choice)?]),
        (None, None) => Err(no_table(&place.path)),
    }
}

/// Makes the rows readings: angles that start anew go on, bursts are spread, repeated values left out, speeds integrated.
/// Returns what the user should know.
fn mend(
    all: &mut Vec<Channel>,
    choice: &mut LogChoice,
    options: &LogOptions,
) -> Result<Vec<String>, LogError> {
    all.iter_mut().for_each(wrap::go_on);
    all.iter_mut().for_each(wrap::take_directions);
    let other = all.iter().find(|channel| channel.report.is_of_other_unit());
    if let Some(channel) = other.filter(|_| !options.allows_empty) {
        return Err(channel.problem(of_other_unit(&channel.report)));
    }
    let mut warnings: Vec<String> = all.iter_mut().filter_map(bursts::spread).collect();
    warnings.extend(held::leave_out(all));
    warnings.extend(merged::split(all));
    let counts = &mut choice.budget.encoder_counts;
    warnings.extend(integral::of_speeds(all, counts));
    warnings.extend(content::check_values(all, options.allows_empty)?);
    Ok(warnings)
}

/// Takes what the readings show of counts and noise, where nothing is stated. Returns what the user should know.
fn measure(all: &[Channel], choice: &mut LogChoice, options: &LogOptions) -> Vec<String> {
    let budget = &mut choice.budget;
    let mut warnings = Vec::new();
    warnings.extend(measured::take_counts(all, &mut budget.encoder_counts));
    if !choice.stated.contains("budget.torque_noise") {
        let noise = &mut budget.torque_noise;
        *noise = measured::noise_of_torques(all, *noise, options.allows_empty);
    }
    if !options.allows_empty {
        let noise = &mut budget.torque_noise;
        warnings.extend(measured::take_rounding_of_torques(all, noise));
        warnings.extend(measured::take_noise_of_pins(all, &mut choice.pin[0]));
    }
    warnings
}

/// What makes readings of the links of those of a body, and the budget of these; `None` of another log.
fn mount(channels: &Channels, choice: &mut LogChoice, options: &LogOptions) -> Option<BodyMount> {
    if !channels.is_of_body() {
        return None;
    }
    let robot = &choice.robot.robot;
    let mount = BodyMount::new(&robot.geometry, choice.pin[0]);
    let budget = &choice.budget;
    choice.body = Some([budget.inclination_noise, budget.rate_noise]);
    choice.budget = budget.of_body_sensors(robot, choice.pin);
    // A check looks for what an estimate leaves out.
    Some(match options.allows_empty {
        true => mount.keeping_jumps(),
        false => mount,
    })
}

/// Errors of the time stamps; gaps that are none are left out. Refuses torques whose signs are lost.
fn jitter(
    frames: &mut Frames,
    choice: &LogChoice,
    options: &LogOptions,
) -> Result<Jitter, LogError> {
    let sides = frames.of_sides();
    let jitter = Jitter::of(&sides[0], choice.budget.encoder_counts);
    frames.leave_out_gaps(&jitter);
    let robot = &choice.robot.robot;
    let noise = choice.budget.torque_noise;
    let lost = |side: &Vec<_>| signs_are_lost(&torque_spikes::of_side(side, robot, noise).1, robot);
    let lost = sides.iter().any(lost);
    if !options.allows_empty && lost {
        return Err(LogError::whole(
            frames.source(),
            "all torques touch zero and never pass it, so their signs are lost, and no forces follow from them; allowed: signed currents or torques: log them, or the drivers' direction with them",
        ));
    }
    Ok(jitter)
}

/// What is wrong with a rate that no robot is recorded at.
fn of_other_unit(report: &ChannelReport) -> String {
    let rate = 1.0 / report.period;
    let other = report.other_unit();
    let other = other.map_or(String::new(), |(unit, rate)| {
        format!("; with time_unit = \"{unit}\" it is {rate:.1} Hz")
    });
    format!(
        "has a row every {:.3e} s, {rate:.3e} Hz, and no robot is recorded at such a rate; allowed: the time_unit of its times in a description{other}",
        report.period
    )
}

/// The zero that all inclinometers have in common.
fn level(frames: &Frames, choice: &LogChoice) -> Level {
    let robot = &choice.robot.robot;
    let settings = choice.stated(EstimatorSettings::kalman());
    let noise = settings.budget.torque_noise;
    match choice.sides {
        LogSides::Both => {
            let frames = frames.all_of_both();
            let (_, frames) = torque_spikes::of_both(&frames, robot, noise);
            let rover = choice.robot.whole_rover();
            rover.map_or_else(Level::default, |r| Level::of_both(&frames, &r, &settings))
        }
        _ => {
            let frames = frames.all_of_links();
            let (_, frames) = torque_spikes::of_side(&frames, robot, noise);
            Level::of_side(&frames, robot, &settings)
        }
    }
}

/// Duration (s) and rate (Hz), and the time from which means count (s), which lies within the log.
fn record(
    duration: f64,
    rate: f64,
    compare_from: &mut f64,
    warnings: &mut Vec<String>,
) -> RecordChoice {
    if *compare_from >= duration {
        warnings.push(format!(
            "the log lasts {duration:.3} s, less than record.compare_from = {compare_from} s: all of it counts"
        ));
        *compare_from = 0.0;
    }
    RecordChoice {
        duration,
        // To six digits: steps between time stamps are rounded.
        rate: format!("{rate:.5e}").parse().unwrap_or(rate),
        compare_from: *compare_from,
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
