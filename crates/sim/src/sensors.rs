//! What the robot's sensors read of the truth.

use crate::truth::Truth;

/// Readings of one instant, as exact as the truth: no noise, no bias, no quantisation, no specific-force error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Readings {
    /// Time of the sample, s.
    pub time: f64,
    /// Turn of each wheel relative to its link since the start, rad (motor-side encoder over gear ratio).
    pub wheel_angle: [f64; 3],
    /// Motor torque at each wheel, N m (from the motor's current).
    pub motor_torque: [f64; 3],
    /// Inclinometers on link 1 and link 2: turn from the nominal pose, rad.
    pub inclination: [f64; 2],
    /// Rate gyroscopes on link 1 and link 2, rad/s.
    pub rate: [f64; 2],
    /// Contact angles, rad. No sensor reads them: the paper assumes that they are known.
    pub contact_angle: [f64; 3],
}

/// Ideal sensors (grade `ideal`): every reading is the truth.
pub fn ideal(truth: &Truth) -> Readings {
    Readings {
        time: truth.time,
        wheel_angle: truth.wheels.map(|w| w.angle),
        motor_torque: truth.wheels.map(|w| w.torque),
        inclination: [truth.links[0].angle, truth.links[1].angle],
        rate: [truth.links[0].rate, truth.links[1].rate],
        contact_angle: truth.wheels.map(|w| w.contact_angle),
    }
}
