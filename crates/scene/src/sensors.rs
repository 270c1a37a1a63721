//! `[sensors]` and `[model_error]`: errors of the readings and of the nominal robot.
//!
//! A grade sets every key of the sensors and the error of the nominal damping. The keys override single values.

use crate::key::{Key, Words};
use crate::range::{above, at_least};
use crate::scene::Scene;
use crate::source::{Node, Value};
use crate::units::{ANGLE, ANGULAR_RATE, FORCE, FREQUENCY, LENGTH, NONE, RATE_WALK, TIME, TORQUE};
use robhaz_sim::sensors::Grade;

/// Name of the section of the sensors.
pub(crate) const PATH: &str = "sensors";
/// Name of the section of the model errors.
pub(crate) const MODEL_ERROR_PATH: &str = "model_error";

/// Keys of the sensors that a grade does not set.
const NOT_OF_THE_GRADE: [&str; 2] = ["grade", "rate"];
/// Keys of the model error that a grade sets.
const MODEL_ERRORS_OF_THE_GRADE: [&str; 1] = ["viscous_damping"];

/// What inclinometers measure: [`SensorSpec::specific_force`](robhaz_sim::sensors::SensorSpec) off and on.
const MEASURED: Words = &["gravity", "specific-force"];

/// The keys of `[sensors]`.
pub(crate) const KEYS: &[Key<Scene>] = &[
    Key::word(
        "grade",
        &[
            Grade::Ideal.name(),
            Grade::Typical.name(),
            Grade::Poor.name(),
        ],
        |s| s.sensors.grade as usize,
        |s, i| s.sensors.grade = Grade::ALL[i],
        "preset of all sensor errors; each key below, except rate, overrides one of them",
    ),
    Key::number(
        "rate",
        FREQUENCY,
        above(0.0).at_most(1e6),
        |s| &mut s.sensors.rate,
        "samples a second, a whole multiple of record.rate",
    ),
    Key::number(
        "encoder_counts",
        NONE,
        at_least(0.0).at_most(1e12),
        |s| &mut s.sensors.spec.encoder_counts,
        "counts of the encoder in a turn of the wheel; 0 for an exact angle",
    ),
    Key::number(
        "torque_gain",
        NONE,
        at_least(0.0).at_most(1.0),
        |s| &mut s.sensors.spec.torque_gain,
        "relative error of the torque's scale, standard deviation, drawn once a run and wheel",
    ),
    Key::number(
        "torque_offset",
        TORQUE,
        at_least(0.0).at_most(1e3),
        |s| &mut s.sensors.spec.torque_offset,
        "offset of the torque, standard deviation, drawn once a run and wheel",
    ),
    Key::number(
        "torque_noise",
        TORQUE,
        at_least(0.0).at_most(1e3),
        |s| &mut s.sensors.spec.torque_noise,
        "white noise of the torque, standard deviation of a sample",
    ),
    Key::number(
        "torque_step",
        TORQUE,
        at_least(0.0).at_most(1e3),
        |s| &mut s.sensors.spec.torque_step,
        "step in which the motor current is read, as a torque at the wheel; 0 for none",
    ),
    Key::number(
        "torque_friction",
        TORQUE,
        at_least(0.0).at_most(1e3),
        |s| &mut s.sensors.spec.torque_friction,
        "Coulomb friction in the reading alone, which shows torque + F sign(speed); it does not act on the robot",
    ),
    Key::number(
        "inclination_noise",
        ANGLE,
        at_least(0.0).at_most(1.0),
        |s| &mut s.sensors.spec.inclination_noise,
        "white noise of the inclinometers, standard deviation of a sample",
    ),
    Key::number(
        "inclination_bias",
        ANGLE,
        at_least(0.0).at_most(1.0),
        |s| &mut s.sensors.spec.inclination_bias,
        "bias of the inclinometers, standard deviation, drawn once a run and link",
    ),
    Key::number(
        "inclination_lag",
        TIME,
        at_least(0.0).at_most(1e3),
        |s| &mut s.sensors.spec.inclination_lag,
        "time constant of the inclinometers' low pass",
    ),
    Key::word(
        "inclination_feels",
        MEASURED,
        |s| usize::from(s.sensors.spec.specific_force),
        |s, i| s.sensors.spec.specific_force = i == 1,
        "what the inclinometers measure: the direction of gravity, or of the specific force, which includes the link's acceleration",
    ),
    Key::number(
        "rate_noise",
        ANGULAR_RATE,
        at_least(0.0).at_most(1e2),
        |s| &mut s.sensors.spec.rate_noise,
        "white noise of the gyros, standard deviation of a sample",
    ),
    Key::number(
        "rate_bias",
        ANGULAR_RATE,
        at_least(0.0).at_most(1e2),
        |s| &mut s.sensors.spec.rate_bias,
        "bias of the gyros at the start, standard deviation, drawn once a run and link",
    ),
    Key::number(
        "rate_walk",
        RATE_WALK,
        at_least(0.0).at_most(1e2),
        |s| &mut s.sensors.spec.rate_walk,
        "random walk of the gyros' bias: its standard deviation after one second",
    ),
    Key::number(
        "rate_scale",
        NONE,
        at_least(0.0).at_most(1.0),
        |s| &mut s.sensors.spec.rate_scale,
        "relative error of the gyros' scale, standard deviation, drawn once a run and link",
    ),
    Key::number(
        "contact_angle_error",
        ANGLE,
        at_least(0.0).at_most(1.0),
        |s| &mut s.sensors.spec.contact_angle_error,
        "RMS error of the contact angles given to the estimators",
    ),
    Key::number(
        "contact_angle_time",
        TIME,
        at_least(0.0).at_most(1e6),
        |s| &mut s.sensors.spec.contact_angle_time,
        "correlation time of that error; 0 for white noise",
    ),
    Key::number(
        "jitter",
        TIME,
        at_least(0.0).at_most(1.0),
        |s| &mut s.sensors.spec.jitter,
        "standard deviation of the sampling time about its time stamp; at most 0.3 of the sampling period",
    ),
    Key::number(
        "dropped",
        NONE,
        at_least(0.0).below(1.0),
        |s| &mut s.sensors.spec.dropped,
        "share of the readings of each channel that are lost",
    ),
];

/// The keys of `[model_error]`.
pub(crate) const MODEL_ERROR: &[Key<Scene>] = &[
    Key::number(
        "body_cg",
        LENGTH,
        at_least(0.0).at_most(1.0),
        |s| &mut s.model_error.body_cg,
        "distance by which the body's centre of mass is moved in a random direction",
    ),
    Key::number(
        "link_masses",
        NONE,
        at_least(0.0).at_most(1.0),
        |s| &mut s.model_error.link_masses,
        "relative error of the masses of links 1 to 3, standard deviation; their inertias change in proportion",
    ),
    Key::number(
        "pins",
        LENGTH,
        at_least(0.0).at_most(1.0),
        |s| &mut s.model_error.pins,
        "distance by which each pin is moved, each in its own random direction",
    ),
    Key::number(
        "viscous_damping",
        NONE,
        at_least(-1.0).at_most(10.0),
        |s| &mut s.model_error.viscous_damping,
        "relative error of the nominal damping B: with 0.1 it is 10 % too high; 0.1 with sensors.grade typical and poor",
    ),
    Key::number(
        "wheel_inertia",
        NONE,
        above(-1.0).at_most(10.0),
        |s| &mut s.model_error.wheel_inertia,
        "relative error of J_wheel",
    ),
    Key::number(
        "rotor_inertia",
        NONE,
        above(-1.0).at_most(10.0),
        |s| &mut s.model_error.rotor_inertia,
        "relative error of J_rotor",
    ),
    Key::number(
        "wheel_radius",
        NONE,
        above(-1.0).at_most(10.0),
        |s| &mut s.model_error.wheel_radius,
        "relative error of the wheels' radius",
    ),
    Key::number(
        "scales",
        FORCE,
        at_least(0.0).at_most(1e3),
        |s| &mut s.model_error.scales,
        "standard deviation of scales on which the simulated robot is weighed in six postures, which corrects the nominal one (weighing.md); 0: not weighed",
    ),
];

/// The chosen grade. It is needed before all other keys, which override its values. An unknown word is refused when the
/// section is read.
pub(crate) fn chosen_grade(root: &Node) -> Grade {
    let name = match root
        .get(PATH)
        .and_then(|s| s.get("grade"))
        .map(|n| &n.value)
    {
        Some(Value::Text(name)) => name.as_str(),
        _ => "",
    };
    let of_name = Grade::ALL.into_iter().find(|g| g.name() == name);
    of_name.unwrap_or(Grade::Ideal)
}

/// Removes the file's values of keys that a grade sets, where an override chooses the grade.
pub(crate) fn forget_old_grade(root: &mut Node) {
    let grade = root.get(PATH).and_then(|s| s.get("grade"));
    if !grade.is_some_and(|g| g.origin.is_override()) {
        return;
    }
    let of_sensors =
        |key: &str| !NOT_OF_THE_GRADE.contains(&key) && KEYS.iter().any(|k| k.name == key);
    root.forget(PATH, of_sensors);
    root.forget(MODEL_ERROR_PATH, |key| {
        MODEL_ERRORS_OF_THE_GRADE.contains(&key)
    });
}
