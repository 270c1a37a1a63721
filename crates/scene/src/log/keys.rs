//! The keys of a log description.

use super::choice::LogChoice;
use super::imu::IMUS;
use super::mapping::{CHANNELS, Missing};
use super::reading::READING;
use crate::estimators::Estimators;
use crate::form::{KeyReference, Maybe};
use crate::key::{self, keys, section};
use crate::quantity::{
    ANGLE, ANGULAR_RATE, LENGTH, NONE, RATE_WALK, ROTARY_DAMPING, TIME, TORQUE, at_least, number,
};
use crate::robot::ROBOT;
use crate::sensors::MEASURED;
use crate::values::{Covariance, NAME, text};

keys! {
    /// All keys, in the order of a resolved description.
    pub(crate) LOG: LogChoice;

    /// name of the log
    name: Maybe(NAME) => name;

    /// geometry and masses
    robot: ROBOT => robot;

    /// eq. (2)
    drive: section(DRIVE) => self;

    /// wheel and ground
    contact: section(CONTACT) => self;

    /// standard deviations of all sensor errors, from data sheets
    budget: section(BUDGET) => self;

    /// what counts
    record: section(RECORD) => self;

    /// the estimators
    estimator: Estimators => estimators;

    /// name of the channel whose rows are the frames
    time_base ("the first"): Maybe(text("a text")) => (|l| &mut l.mapped().time_base);

    /// readings that the log does not have
    missing: Missing => (|l| &mut l.mapped().missing);

    /// tables or topics with a clock of their own
    channel: CHANNELS => (|l| &mut l.mapped().channels);

    /// columns of single readings
    reading: READING => (|l| &mut l.mapped().readings);

    /// columns of inertial measurement units
    imu: IMUS => (|l| &mut l.mapped().imus);
}

keys! {
    /// The keys of `[drive]`.
    pub(crate) DRIVE: LogChoice;

    /// nominal damping B of the wheel module, at the wheel
    viscous_damping: number(ROTARY_DAMPING, at_least(0.0).at_most(1e3)) => viscous_damping;
}

keys! {
    CONTACT: LogChoice;

    /// compression of wheel and ground at the mean wheel load: a wheel rolls with its radius less
    /// this
    compression: number(LENGTH, at_least(0.0).at_most(0.1)) => compression;
}

keys! {
    RECORD: LogChoice;

    /// errors and means count from this time on, after rest and start; 0 for a log that is shorter
    compare_from: number(TIME, at_least(0.0).at_most(1e6)) => compare_from;
}

keys! {
    pub(super) BUDGET: LogChoice;

    /// counts of the encoder in a turn of the wheel; 0 for an exact angle
    encoder_counts: number(NONE, at_least(0.0).at_most(1e12)) => budget.encoder_counts;

    /// error of the time stamps
    jitter: number(TIME, at_least(0.0).at_most(1.0)) => budget.jitter;

    /// white noise of the torque, of a sample
    torque_noise: number(TORQUE, at_least(0.0).at_most(1e3)) => budget.torque_noise;

    /// constant offset of the torque
    torque_offset: number(TORQUE, at_least(0.0).at_most(1e3)) => budget.torque_offset;

    /// relative error of the torque's scale
    torque_gain: number(NONE, at_least(0.0).at_most(1.0)) => budget.torque_gain;

    /// white noise of the angle of pin Q, of logs with pin_angle
    pin_noise: number(ANGLE, at_least(0.0).at_most(1.0)) => (|l| &mut l.pin[0]);

    /// constant error of that angle
    pin_bias: number(ANGLE, at_least(0.0).at_most(1.0)) => (|l| &mut l.pin[1]);

    /// dry friction in the gears that the motor torque does not show, at the wheel
    gear_friction ("0.3 of robot A, else in proportion to weight and wheel radius"):
        number(TORQUE, at_least(0.0).at_most(1e3)) => budget.gear_friction;

    /// coefficient of the rolling resistance: its standard deviation about 0
    rolling_resistance: number(NONE, at_least(0.0).at_most(1.0)) => budget.rolling_resistance;

    /// white noise of the inclinometers, of a sample
    inclination_noise: number(ANGLE, at_least(0.0).at_most(1.0)) => budget.inclination_noise;

    /// constant error of the inclinometers
    inclination_bias: number(ANGLE, at_least(0.0).at_most(1.0)) => budget.inclination_bias;

    /// what the inclinometers measure: the direction of gravity, or of the specific force, which
    /// includes the link's acceleration
    inclination_feels: MEASURED => budget.specific_force;

    /// time constant of the inclinometers' low pass, 1/(2 pi bandwidth)
    inclination_lag: number(TIME, at_least(0.0).at_most(1e3)) => budget.inclination_lag;

    /// distance of an inclinometer from the centre of mass of its link
    inclination_place: number(LENGTH, at_least(0.0).at_most(10.0)) => budget.inclination_place;

    /// white noise of the gyros, of a sample
    rate_noise: number(ANGULAR_RATE, at_least(0.0).at_most(1e2)) => budget.rate_noise;

    /// bias of the gyros at the start
    rate_bias: number(ANGULAR_RATE, at_least(0.0).at_most(1e2)) => budget.rate_bias;

    /// random walk of the gyros' bias: its standard deviation after one second
    rate_walk: number(RATE_WALK, at_least(0.0).at_most(1e2)) => budget.rate_walk;

    /// error of the contact angles in the log
    contact_angle_error: number(ANGLE, at_least(0.0).at_most(1.0)) => budget.contact_angle;

    /// correlation time of that error; 0 for white noise
    contact_angle_time: number(TIME, at_least(0.0).at_most(1e6)) => budget.contact_angle_time;

    /// error of the position of the body's nominal centre of mass
    body_cg: number(LENGTH, at_least(0.0).at_most(1.0)) => budget.body_cg;

    /// relative error of the masses of links 1 to 3
    link_masses: number(NONE, at_least(0.0).at_most(1.0)) => budget.link_mass;

    /// covariance of masses, centres of mass and pins of a robot that was weighed, as
    /// `robhaz weigh` writes it (weighing.md); body_cg and link_masses are 0 then
    load_covariance: Covariance => budget.load_covariance;

    /// payload that the robot may carry and [robot] does not have, over the robot's mass: it widens
    /// what is stated until the torques show the weight
    payload: number(NONE, at_least(0.0).at_most(1.0)) => budget.payload;
}

/// The rows of the tables of keys in `docs/logs.md`. The text explains the keys above all tables;
/// those of `[robot]` and `[[estimator]]` are as in a scene.
pub fn log_reference() -> Vec<KeyReference> {
    let mut rows = Vec::new();
    key::rows(&mut rows, LOG, "", &mut LogChoice::default());
    let as_in_a_scene = |key: &str| key.starts_with("robot.") || key.starts_with("estimator");
    rows.retain(|row| row.key.contains('.') && !as_in_a_scene(&row.key));
    rows
}
