//! What is read at one instant, and what a control asks of the drive of a wheel.

use crate::LinkReading;

/// All readings of one instant, SI; `None` where a reading is missing.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SensorFrame {
    /// Time of the sample, s; must increase from frame to frame.
    pub time: f64,
    /// Turn of each wheel relative to its link, rad, forward positive: encoder counts times 2 pi /
    /// counts a turn.
    pub wheel_angle: [Option<f64>; 3],
    /// Motor torque at each wheel after the gear, N m, forward positive.
    pub motor_torque: [Option<f64>; 3],
    /// Sensors on link 1.
    pub link1: LinkReading,
    /// Sensors on link 2.
    pub link2: LinkReading,
    /// Contact angles, rad: given, as the paper assumes, not read by a sensor. An estimator that
    /// finds them itself ignores them.
    pub contact_angle: [Option<f64>; 3],
}

/// Command of one wheel, held from one sample to the next.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum WheelCommand {
    /// The set speed that the drive plans for this wheel, tracked by the PI control of the drive.
    #[default]
    Planned,
    /// A set speed relative to the link, rad/s, forward positive, tracked by the PI control of the
    /// drive.
    Speed(f64),
    /// A motor torque at the wheel, N m, forward positive, within the torque limit of the drive.
    /// The integral of the PI control follows it, so that a later set speed begins at this torque.
    Torque(f64),
}
