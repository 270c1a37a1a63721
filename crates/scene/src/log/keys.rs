//! The keys of a log description that set numbers and words.

use super::choice::LogChoice;
use crate::key::{Key, Words};
use crate::range::at_least;
use crate::units::{ANGLE, ANGULAR_RATE, LENGTH, NONE, RATE_WALK, ROTARY_DAMPING, TIME, TORQUE};

/// A section whose keys set fields of the description.
pub(super) struct Section {
    pub name: &'static str,
    pub meaning: &'static str,
    pub keys: &'static [Key<LogChoice>],
}

/// What inclinometers measure: [`robhaz_estimator::NoiseBudget::specific_force`] off and on.
const MEASURED: Words = &["gravity", "specific-force"];

/// All these sections, in the order of a resolved description.
pub(super) const SECTIONS: &[Section] = &[
    Section {
        name: "drive",
        meaning: "eq. (2)",
        keys: DRIVE,
    },
    Section {
        name: "contact",
        meaning: "wheel and ground",
        keys: CONTACT,
    },
    Section {
        name: "budget",
        meaning: "standard deviations of all sensor errors, from data sheets",
        keys: BUDGET,
    },
    Section {
        name: "record",
        meaning: "what counts",
        keys: RECORD,
    },
];

const DRIVE: &[Key<LogChoice>] = &[Key::number(
    "viscous_damping",
    ROTARY_DAMPING,
    at_least(0.0).at_most(1e3),
    |l| &mut l.viscous_damping,
    "nominal damping B of the wheel module, at the wheel",
)];

const CONTACT: &[Key<LogChoice>] = &[Key::number(
    "compression",
    LENGTH,
    at_least(0.0).at_most(0.1),
    |l| &mut l.compression,
    "compression of wheel and ground at the mean wheel load: a wheel rolls with its radius less this",
)];

const RECORD: &[Key<LogChoice>] = &[Key::number(
    "compare_from",
    TIME,
    at_least(0.0).at_most(1e6),
    |l| &mut l.compare_from,
    "errors and means count from this time on, after rest and start; 0 for a log that is shorter",
)];

const BUDGET: &[Key<LogChoice>] = &[
    Key::number(
        "encoder_counts",
        NONE,
        at_least(0.0).at_most(1e12),
        |l| &mut l.budget.encoder_counts,
        "counts of the encoder in a turn of the wheel; 0 for an exact angle",
    ),
    Key::number(
        "jitter",
        TIME,
        at_least(0.0).at_most(1.0),
        |l| &mut l.budget.jitter,
        "error of the time stamps",
    ),
    Key::number(
        "torque_noise",
        TORQUE,
        at_least(0.0).at_most(1e3),
        |l| &mut l.budget.torque_noise,
        "white noise of the torque, of a sample",
    ),
    Key::number(
        "torque_offset",
        TORQUE,
        at_least(0.0).at_most(1e3),
        |l| &mut l.budget.torque_offset,
        "constant offset of the torque",
    ),
    Key::number(
        "torque_gain",
        NONE,
        at_least(0.0).at_most(1.0),
        |l| &mut l.budget.torque_gain,
        "relative error of the torque's scale",
    ),
    Key::number(
        "gear_friction",
        TORQUE,
        at_least(0.0).at_most(1e3),
        |l| &mut l.budget.gear_friction,
        "dry friction in the gears that the motor torque does not show, at the wheel",
    ),
    Key::number(
        "rolling_resistance",
        NONE,
        at_least(0.0).at_most(1.0),
        |l| &mut l.budget.rolling_resistance,
        "coefficient of the rolling resistance: its standard deviation about 0",
    ),
    Key::number(
        "inclination_noise",
        ANGLE,
        at_least(0.0).at_most(1.0),
        |l| &mut l.budget.inclination_noise,
        "white noise of the inclinometers, of a sample",
    ),
    Key::number(
        "inclination_bias",
        ANGLE,
        at_least(0.0).at_most(1.0),
        |l| &mut l.budget.inclination_bias,
        "constant error of the inclinometers",
    ),
    Key::word(
        "inclination_feels",
        MEASURED,
        |l| usize::from(l.budget.specific_force),
        |l, i| l.budget.specific_force = i == 1,
        "what the inclinometers measure: the direction of gravity, or of the specific force, which includes the link's acceleration",
    ),
    Key::number(
        "inclination_lag",
        TIME,
        at_least(0.0).at_most(1e3),
        |l| &mut l.budget.inclination_lag,
        "time constant of the inclinometers' low pass, 1/(2 pi bandwidth)",
    ),
    Key::number(
        "inclination_place",
        LENGTH,
        at_least(0.0).at_most(10.0),
        |l| &mut l.budget.inclination_place,
        "distance of an inclinometer from the centre of mass of its link",
    ),
    Key::number(
        "rate_noise",
        ANGULAR_RATE,
        at_least(0.0).at_most(1e2),
        |l| &mut l.budget.rate_noise,
        "white noise of the gyros, of a sample",
    ),
    Key::number(
        "rate_bias",
        ANGULAR_RATE,
        at_least(0.0).at_most(1e2),
        |l| &mut l.budget.rate_bias,
        "bias of the gyros at the start",
    ),
    Key::number(
        "rate_walk",
        RATE_WALK,
        at_least(0.0).at_most(1e2),
        |l| &mut l.budget.rate_walk,
        "random walk of the gyros' bias: its standard deviation after one second",
    ),
    Key::number(
        "contact_angle_error",
        ANGLE,
        at_least(0.0).at_most(1.0),
        |l| &mut l.budget.contact_angle,
        "error of the contact angles in the log",
    ),
    Key::number(
        "contact_angle_time",
        TIME,
        at_least(0.0).at_most(1e6),
        |l| &mut l.budget.contact_angle_time,
        "correlation time of that error; 0 for white noise",
    ),
    Key::number(
        "body_cg",
        LENGTH,
        at_least(0.0).at_most(1.0),
        |l| &mut l.budget.body_cg,
        "error of the position of the body's centre of mass in the drawings",
    ),
    Key::number(
        "link_masses",
        NONE,
        at_least(0.0).at_most(1.0),
        |l| &mut l.budget.link_mass,
        "relative error of the masses of links 1 to 3",
    ),
    Key::load_covariance(
        "load_covariance",
        |l| &mut l.budget.load_covariance,
        "covariance of masses, centres of mass and pins of a robot that was weighed, as `robhaz weigh` writes it (weighing.md); body_cg and link_masses are 0 then",
    ),
];
