//! `[sensors]` and `[model_error]`: errors of the readings and of the nominal robot.
//!
//! A grade sets every key of the sensors and the error of the nominal damping. The keys override
//! single values.

use crate::form::{Word, word};
use crate::key::{keys, names};
use crate::quantity::{
    ANGLE, ANGULAR_RATE, FORCE, FREQUENCY, LENGTH, NONE, RATE_WALK, TIME, TORQUE, above, at_least,
    number,
};
use crate::scene::Scene;
use crate::source::Node;
use robhaz_sim::sensors::{Grade, ImuPlace};

/// What inclinometers measure: [`SensorSpec::specific_force`](robhaz_sim::sensors::SensorSpec) off
/// and on.
pub(crate) const MEASURED: Word<bool> =
    word(&[false, true], |specific_force| match specific_force {
        false => "gravity",
        true => "specific-force",
    });

keys! {
    /// The keys of `[sensors]`.
    pub(crate) KEYS: Scene;

    /// preset of all sensor errors; each key below, except rate, overrides one of them
    grade: word(&Grade::ALL, Grade::name) => sensors.grade;

    /// samples a second, a whole multiple of record.rate
    rate: number(FREQUENCY, above(0.0).at_most(1e6)) => sensors.rate;

    /// counts of the encoder in a turn of the wheel; 0 for an exact angle
    encoder_counts: number(NONE, at_least(0.0).at_most(1e12)) => sensors.spec.encoder_counts;

    /// relative error of the torque's scale, standard deviation, drawn once a run and wheel
    torque_gain: number(NONE, at_least(0.0).at_most(1.0)) => sensors.spec.torque_gain;

    /// offset of the torque, standard deviation, drawn once a run and wheel
    torque_offset: number(TORQUE, at_least(0.0).at_most(1e3)) => sensors.spec.torque_offset;

    /// white noise of the torque, standard deviation of a sample
    torque_noise: number(TORQUE, at_least(0.0).at_most(1e3)) => sensors.spec.torque_noise;

    /// step in which the motor current is read, as a torque at the wheel; 0 for none
    torque_step: number(TORQUE, at_least(0.0).at_most(1e3)) => sensors.spec.torque_step;

    /// Coulomb friction in the reading alone, which shows torque + F sign(speed); it does not act
    /// on the robot
    torque_friction: number(TORQUE, at_least(0.0).at_most(1e3)) => sensors.spec.torque_friction;

    /// where inclinometers and gyros sit: on both links, or in the body, with an angle sensor in pin
    /// Q; each reading of a link is then one of the body less angles of the linkage
    imu: word(&ImuPlace::ALL, ImuPlace::name) => sensors.spec.imu;

    /// with imu = "body": white noise of the angle of pin Q, standard deviation of a sample
    pin_noise: number(ANGLE, at_least(0.0).at_most(1.0)) => sensors.spec.pin_noise;

    /// with imu = "body": bias of the angle of pin Q, standard deviation, drawn once a run
    pin_bias: number(ANGLE, at_least(0.0).at_most(1.0)) => sensors.spec.pin_bias;

    /// white noise of the inclinometers, standard deviation of a sample
    inclination_noise: number(ANGLE, at_least(0.0).at_most(1.0)) => sensors.spec.inclination_noise;

    /// bias of the inclinometers, standard deviation, drawn once a run and link
    inclination_bias: number(ANGLE, at_least(0.0).at_most(1.0)) => sensors.spec.inclination_bias;

    /// time constant of the inclinometers' low pass
    inclination_lag: number(TIME, at_least(0.0).at_most(1e3)) => sensors.spec.inclination_lag;

    /// what the inclinometers measure: the direction of gravity, or of the specific force, which
    /// includes the link's acceleration
    inclination_feels: MEASURED => sensors.spec.specific_force;

    /// white noise of the gyros, standard deviation of a sample
    rate_noise: number(ANGULAR_RATE, at_least(0.0).at_most(1e2)) => sensors.spec.rate_noise;

    /// bias of the gyros at the start, standard deviation, drawn once a run and link
    rate_bias: number(ANGULAR_RATE, at_least(0.0).at_most(1e2)) => sensors.spec.rate_bias;

    /// random walk of the gyros' bias: its standard deviation after one second
    rate_walk: number(RATE_WALK, at_least(0.0).at_most(1e2)) => sensors.spec.rate_walk;

    /// relative error of the gyros' scale, standard deviation, drawn once a run and link
    rate_scale: number(NONE, at_least(0.0).at_most(1.0)) => sensors.spec.rate_scale;

    /// RMS error of the contact angles given to the estimators
    contact_angle_error: number(ANGLE, at_least(0.0).at_most(1.0))
        => sensors.spec.contact_angle_error;

    /// correlation time of that error; 0 for white noise
    contact_angle_time: number(TIME, at_least(0.0).at_most(1e6)) => sensors.spec.contact_angle_time;

    /// standard deviation of the sampling time about its time stamp; at most 0.3 of the sampling
    /// period
    jitter: number(TIME, at_least(0.0).at_most(1.0)) => sensors.spec.jitter;

    /// share of the readings of each channel that are lost
    dropped: number(NONE, at_least(0.0).below(1.0)) => sensors.spec.dropped;
}

keys! {
    /// The keys of `[model_error]`.
    pub(crate) MODEL_ERROR: Scene;

    /// distance by which the body's centre of mass is moved in a random direction
    body_cg: number(LENGTH, at_least(0.0).at_most(1.0)) => model_error.body_cg;

    /// relative error of the masses of links 1 to 3, standard deviation; their inertias change in
    /// proportion
    link_masses: number(NONE, at_least(0.0).at_most(1.0)) => model_error.link_masses;

    /// distance by which each pin is moved, each in its own random direction
    pins: number(LENGTH, at_least(0.0).at_most(1.0)) => model_error.pins;

    /// relative error of the nominal damping B: with 0.1 it is 10 % too high; 0.1 with
    /// sensors.grade typical and poor
    viscous_damping: number(NONE, at_least(-1.0).at_most(10.0)) => model_error.viscous_damping;

    /// relative error of J_wheel
    wheel_inertia: number(NONE, above(-1.0).at_most(10.0)) => model_error.wheel_inertia;

    /// relative error of J_rotor
    rotor_inertia: number(NONE, above(-1.0).at_most(10.0)) => model_error.rotor_inertia;

    /// relative error of the wheels' radius
    wheel_radius: number(NONE, above(-1.0).at_most(10.0)) => model_error.wheel_radius;

    /// standard deviation of scales on which the simulated robot is weighed in six postures, which
    /// corrects the nominal one (weighing.md); 0: not weighed
    scales: number(FORCE, at_least(0.0).at_most(1e3)) => model_error.scales;
}

/// The chosen grade. It is needed before all other keys, which override its values. An unknown word
/// is refused when the section is read.
pub(crate) fn chosen_grade(root: &Node) -> Grade {
    let name = root.find("sensors.grade").and_then(Node::as_text);
    let grade = Grade::ALL.into_iter().find(|g| Some(g.name()) == name);
    grade.unwrap_or(Grade::Ideal)
}

/// Removes the file's values of keys that a grade sets, where an override chooses the grade.
pub(crate) fn drop_keys_of_other_grades(root: &mut Node) {
    let grade = root.find("sensors.grade");
    if grade.is_some_and(|g| g.origin.is_override()) {
        let is_set = |key: &str| !["grade", "rate"].contains(&key) && names(KEYS).contains(&key);
        root.drop_keys("sensors", is_set);
        root.drop_keys("model_error", |key| key == "viscous_damping");
    }
}
