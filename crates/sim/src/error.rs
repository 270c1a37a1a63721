//! Reasons why a simulation cannot start or stops.
//!
//! The messages state physical facts. `robhaz-scene` adds the keys of the scene file that a user
//! can change.

use robhaz_model::StanceError;

/// Reason why a simulation cannot start or stops.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum PlantError {
    /// There is no valid truth any more.
    #[error("at t = {time:.4} s {why}")]
    NoTruth {
        /// Time, s.
        time: f64,
        /// The reason.
        why: NoTruth,
    },
    /// The ground under a raw start is not level: a wheel would be too deep in the ground, or above
    /// it.
    #[error(
        "at a raw start the ground under the wheels must be level at y = 0, but wheel {wheel} is {}",
        position(*depth, *rest)
    )]
    RawStart {
        /// 1 front, 2 middle, 3 rear.
        wheel: usize,
        /// Penetration, m; negative above the ground.
        depth: f64,
        /// Penetration under the mean wheel load, m.
        rest: f64,
    },
    /// The settled start finds no static equilibrium.
    #[error("the robot finds no rest at its start: {why}")]
    NoRest {
        /// The reason.
        why: NoRest,
    },
    /// The robot cannot stand, not even on level ground.
    #[error(transparent)]
    Stance(#[from] StanceError),
}

/// Reason why the forces at a state are unknown or would be wrong.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum NoTruth {
    /// A wheel's centre is below the ground, where the contact laws do not apply.
    #[error("the centre of wheel {wheel} is below the ground (x = {x:.3} m)")]
    WheelBelowGround {
        /// 1 front, 2 middle, 3 rear.
        wheel: usize,
        /// Position of the wheel's centre, m.
        x: f64,
    },
    /// The state contains NaN or infinity: the step is too long for the contact, or the forces are
    /// too large.
    #[error(
        "the state of {part} is not finite: the forces are too large for the step, or the ground threw the robot"
    )]
    NotFinite {
        /// Name of the bar.
        part: &'static str,
    },
    /// A bar has turned by more than a right angle. Only wheels have contact with the ground, so
    /// the forces would be wrong.
    #[error("{part} has turned over")]
    Overturned {
        /// Name of the bar.
        part: &'static str,
    },
    /// A wheel is more than 1 m above the ground.
    #[error("wheel {wheel} has left the ground by more than 1 m (x = {x:.1} m)")]
    OffTheGround {
        /// 1 front, 2 middle, 3 rear.
        wheel: usize,
        /// Position of the wheel's centre, m.
        x: f64,
    },
    /// The angles of links 1 and 2 are outside of the range in which the four-bar closes.
    #[error("links 1 and 2 have turned farther than the four-bar can close")]
    LoopRange,
    /// The solver of `direct` finds no step within its tolerance, or no forces.
    #[error("the solver finds no step that is accurate enough")]
    NoStep,
    /// Kinetic, potential and elastic energy minus the work of the motors exceeds its minimum so
    /// far by more than the tolerance: the integration is wrong.
    #[error("energy is made from nothing: {made:.1e} J since its minimum")]
    EnergyMade {
        /// Rise of the energy since its minimum, J.
        made: f64,
    },
    /// The gap of a pin is too large: the pin forces would be wrong.
    #[error(
        "the pins of the four-bar are {distance:.1e} m apart: the forces are too large for the step"
    )]
    LoopOpen {
        /// Largest gap, m.
        distance: f64,
    },
}

impl NoTruth {
    /// The reason with its time, s.
    pub(crate) fn at(self, time: f64) -> PlantError {
        PlantError::NoTruth { time, why: self }
    }
}

/// Reason why there is no static equilibrium at the start.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum NoRest {
    /// No pose near the nominal one has all three wheels on the ground.
    #[error("no pose near the nominal one has all three wheels on the ground")]
    Pose,
    /// The equations of equilibrium have no solution near that pose.
    #[error("with all three wheels on the ground, neither friction nor the linkage holds it there")]
    Equilibrium,
    /// A motor is too weak to hold its wheel.
    #[error(
        "the motor of wheel {wheel} would have to hold {torque:.3e} N m, and gives {limit:.3e} N m at most"
    )]
    Motor {
        /// 1 front, 2 middle, 3 rear.
        wheel: usize,
        /// Torque in equilibrium, N m.
        torque: f64,
        /// Largest torque of motor and control, N m.
        limit: f64,
    },
    /// A wheel is in the air, or has more than one contact.
    #[error("wheel {wheel} would touch the ground at {contacts} places instead of one")]
    Contacts {
        /// 1 front, 2 middle, 3 rear.
        wheel: usize,
        /// Number of contacts.
        contacts: u32,
    },
}

/// Position of a wheel relative to the ground, in words. `depth` is its penetration (m), `rest`
/// that under the mean load (m).
fn position(depth: f64, rest: f64) -> String {
    if depth > 0.0 {
        format!("{depth:.4} m deep in the ground, where its weight takes it {rest:.4} m deep")
    } else {
        format!("{:.4} m above the ground", -depth)
    }
}
