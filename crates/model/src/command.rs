//! What a control asks of the drive of a wheel.

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
