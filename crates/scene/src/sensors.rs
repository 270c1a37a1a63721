//! `[sensors]` and `[model_error]`: what the estimators see, and what they are told of the robot.
//!
//! A grade stands for a value of every key of the sensors and of the damping that is told; the keys change single ones.

use crate::key::{Key, Words};
use crate::range::{above, at_least};
use crate::scene::Scene;
use crate::source::{Entry, Node, Value};
use crate::units::{ANGLE, ANGULAR_RATE, FREQUENCY, LENGTH, NONE, RATE_WALK, TIME, TORQUE};
use robhaz_sim::sensors::Grade;

/// Name of the section of the sensors.
pub(crate) const PATH: &str = "sensors";
/// Name of the section of what is told.
pub(crate) const MODEL_ERROR_PATH: &str = "model_error";

/// Keys of the sensors that a grade does not stand for.
const NOT_OF_THE_GRADE: [&str; 2] = ["grade", "rate"];
/// Keys of the model error that a grade stands for.
const TOLD_BY_THE_GRADE: [&str; 1] = ["viscous_damping"];

/// What inclinometers feel: [`SensorSpec::specific_force`](robhaz_sim::sensors::SensorSpec) off and on.
const FELT: Words = &["gravity", "specific-force"];

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
        "which errors the sensors have; each key below but rate changes one of them",
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
        "Coulomb friction in the reading alone: it shows torque + F sign(speed), the robot feels nothing of it",
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
        FELT,
        |s| usize::from(s.sensors.spec.specific_force),
        |s, i| s.sensors.spec.specific_force = i == 1,
        "what the inclinometers take for the vertical: gravity alone, or gravity and the link's acceleration",
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
        "random walk of that bias: its standard deviation after a second",
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
        "error of the contact angles that are given, RMS",
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
        "standard deviation of the instant of sampling about its time stamp; at most 0.3 of the time between samples",
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
        "how far the body's centre of mass is moved in a random direction",
    ),
    Key::number(
        "link_masses",
        NONE,
        at_least(0.0).at_most(1.0),
        |s| &mut s.model_error.link_masses,
        "relative error of the masses of links 1 to 3, standard deviation; their inertias go with them",
    ),
    Key::number(
        "pins",
        LENGTH,
        at_least(0.0).at_most(1.0),
        |s| &mut s.model_error.pins,
        "how far each pin is moved in a random direction of its own",
    ),
    Key::number(
        "viscous_damping",
        NONE,
        at_least(-1.0).at_most(10.0),
        |s| &mut s.model_error.viscous_damping,
        "relative error of the damping B: 0.1 is told 10 % too high; 0.1 with sensors.grade typical and poor",
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
];

/// The grade that is chosen, before all other keys, which change what it stands for. What is no grade is refused with its
/// section.
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

/// A grade that an override chooses leaves behind what the file says of what a grade stands for.
pub(crate) fn forget_old_grade(root: &mut Node) {
    let grade = root.get(PATH).and_then(|s| s.get("grade"));
    if !grade.is_some_and(|g| g.origin.is_override()) {
        return;
    }
    let of_sensors =
        |key: &str| !NOT_OF_THE_GRADE.contains(&key) && KEYS.iter().any(|k| k.name == key);
    forget(root, PATH, of_sensors);
    forget(root, MODEL_ERROR_PATH, |key| {
        TOLD_BY_THE_GRADE.contains(&key)
    });
}

/// Takes keys of a section out where they come from the file.
fn forget(root: &mut Node, section: &str, which: impl Fn(&str) -> bool) {
    let Value::Table(sections) = &mut root.value else {
        return;
    };
    for entry in sections.iter_mut().filter(|e| e.key == section) {
        if let Value::Table(entries) = &mut entry.node.value {
            entries.retain(|e: &Entry| e.origin.is_override() || !which(&e.key));
        }
    }
}
