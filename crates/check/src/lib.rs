//! Is a recorded log what the estimators take it for? Signs, units, wiring, delays, zeros, ranges and noise, from the
//! readings alone.
//!
//! | module | question | from |
//! |---|---|---|
//! | `still` | Is a channel stuck or saturated? | repeated values |
//! | `rest` | Are zeros and noise those of the budget? | the rest before the first motion |
//! | `links` | Signs, units, exchange and delay of gyroscopes and inclinometers | integral of the rate |
//! | `wheels` | Signs and counts of the encoders | the wheels against each other |
//! | `balance` | Signs of torques and inclinometers, delay of the torques | weight and inertia |
//! | `ground` | Scale of the encoders, signs and exchange of the links' sensors | each wheel passes the same ground |
//! | `drive` | Exchanged wheels, delay of the torques | answer of a speed control |
//! | `torque_scale` | Do the torques fit the robot's mass? | work of the torques, and height, in `best` |
//! | `agreement` | Does `best` agree with all? | innovations of all its filters |
//!
//! Each finding has a verdict, the figure behind it, and what to do. A test that a log cannot answer says so.

mod agreement;
mod balance;
mod course;
mod drive;
mod fit;
mod ground;
mod links;
mod motion;
mod recording;
mod report;
mod rest;
mod signal;
mod still;
mod torque_scale;
mod wheels;

pub use report::{Finding, Report, Verdict};

use course::Course;
use motion::Motion;
use recording::Recording;
use robhaz_estimator::{EstimatorSettings, NoiseBudget, SensorFrame};
use robhaz_model::Robot;

/// What is stated of the robot and its sensors.
#[derive(Clone, Copy, Debug)]
pub struct Stated<'a> {
    /// The nominal robot.
    pub robot: &'a Robot,
    /// Standard deviations of all sensor errors.
    pub budget: NoiseBudget,
    /// Nominal damping B of the wheel module, N m s.
    pub viscous_damping: f64,
    /// Nominal compression of wheel and ground, m.
    pub compression: f64,
}

impl Stated<'_> {
    /// `best` with what is stated; with contact angles if each wheel has some.
    fn settings(&self, frames: &[SensorFrame]) -> EstimatorSettings {
        let has_angle = |i: usize| frames.iter().any(|f| f.contact_angle[i].is_some());
        let best = if (0..3).all(has_angle) {
            EstimatorSettings::best()
        } else {
            EstimatorSettings::best_without_angles()
        };
        EstimatorSettings {
            viscous_damping: self.viscous_damping,
            compression: self.compression,
            budget: self.budget,
            ..best
        }
    }
}

/// Checks the frames of a log, in order of time, against what is stated.
pub fn check(frames: &[SensorFrame], stated: &Stated<'_>) -> Report {
    let (robot, budget) = (stated.robot, &stated.budget);
    let Some(recording) = Recording::new(frames) else {
        let remedy = "record some seconds";
        let finding = Finding::cannot_tell("log", "all", "less than three frames", remedy);
        return Report::new(vec![finding]);
    };
    let motion = Motion::of(&recording, robot);
    let course = Course::new(&motion, robot, &recording.inclination);
    let mut findings = still::findings(frames, budget);
    findings.extend(rest::findings(&recording, budget));
    findings.extend(links::findings(&recording, &motion, robot, budget));
    findings.extend(wheels::findings(&motion, robot));
    findings.extend(ground::findings(course.as_ref(), robot));
    let damping = stated.viscous_damping;
    findings.extend(balance::findings(&recording, &motion, robot, damping));
    findings.extend(drive::findings(&recording, &motion));
    let (agreement, scale) = agreement::finding(frames, robot, &stated.settings(frames));
    findings.push(torque_scale::finding(scale, robot));
    findings.push(agreement);
    Report::new(findings)
}
