//! What is stated of a log: the robot, its sensors, and where these are.

use robhaz_estimator::EstimatorSettings;
use robhaz_estimator::whole::WholeEstimator;
use robhaz_model::{Posture, Robot, Suspension, WholeRover};

/// White noise of an inertial sensor in the body and of the angle of pin Q, a sample.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BodyNoise {
    /// Of the inclination of the body, rad.
    pub inclination: f64,
    /// Of its rate, rad/s.
    pub rate: f64,
    /// Of the angle of pin Q, rad.
    pub pin: f64,
}

/// What is stated of the robot and its sensors.
#[derive(Clone, Copy, Debug)]
pub struct Stated<'a> {
    /// The nominal robot.
    pub robot: &'a Robot,
    /// Settings of `kalman`, which runs on the log; with or without contact angles as the log has them.
    pub settings: EstimatorSettings,
    /// Time after the first frame from which on forces count, s.
    pub compare_from: f64,
    /// The sensors of body and pin Q of which the readings of the links are made; `None` of sensors
    /// on the links.
    pub body: Option<BodyNoise>,
}

impl Stated<'_> {
    /// The link that the body is fixed to, from 0, if the readings of the links are made of those
    /// of the body; `None` of a four-bar.
    pub(super) fn body_link(&self) -> Option<usize> {
        match self.robot.geometry.suspension {
            Suspension::Bogie { body } if self.body.is_some() => Some(body.index()),
            _ => None,
        }
    }
}

/// Inclination and rate of the body by those of the links, NaN where the linkage cannot close.
pub fn of_body(stated: &Stated<'_>, angles: [f64; 2], rates: [f64; 2]) -> [f64; 2] {
    // Without a reading of the pin this link keeps its own.
    if let Some(fixed) = stated.body_link() {
        return [angles[fixed], rates[fixed]];
    }
    let geometry = &stated.robot.geometry;
    let Ok(posture) = Posture::close(geometry, angles[0] - angles[1], 0.0) else {
        return [f64::NAN; 2];
    };
    let [body, ..] = posture.rates(geometry, rates[0] - rates[1], 0.0);
    [angles[1] + posture.body, rates[1] + body]
}

/// What is stated of a log of both sides.
#[derive(Clone, Copy, Debug)]
pub struct StatedBoth<'a> {
    /// The nominal rover.
    pub rover: &'a WholeRover,
    /// Settings of its estimator.
    pub settings: EstimatorSettings,
    /// White noise and constant error of the angles of the joints, rad.
    pub joint: [f64; 2],
    /// Time after the first frame from which on forces count, s.
    pub compare_from: f64,
}

impl StatedBoth<'_> {
    /// Its estimator, for one log; `None` of a rover that cannot be estimated.
    pub(super) fn estimator(&self) -> Option<WholeEstimator> {
        let estimator = WholeEstimator::new(self.rover, self.settings, self.joint);
        Some(estimator.ok()?.untied())
    }
}
