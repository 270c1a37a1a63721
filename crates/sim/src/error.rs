//! Reasons why a simulation cannot start or stops.
//!
//! The messages state physical facts. `robhaz-scene` adds the keys of the scene file that a user
//! can change.

use robhaz_model::StanceError;

/// Reason why a simulation cannot start or stops.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum PlantError {
    /// A wheel's centre is below the ground.
    #[error("at t = {time:.4} s the centre of wheel {wheel} is below the ground (x = {x:.3} m)")]
    WheelBelowGround {
        /// Time, s.
        time: f64,
        /// 1 front, 2 middle, 3 rear.
        wheel: usize,
        /// Position of the wheel's centre, m.
        x: f64,
    },
    /// The state contains NaN or infinity: the step is too long for the contact, or the forces are
    /// too large.
    #[error(
        "at t = {time:.4} s the state of {part} is not finite: the forces are too large for the step, or the ground threw the robot"
    )]
    NotFinite {
        /// Time, s.
        time: f64,
        /// Name of the bar.
        part: &'static str,
    },
    /// A bar has turned by more than a right angle. Only wheels have contact with the ground, so
    /// the forces would be wrong.
    #[error("at t = {time:.4} s {part} has turned over")]
    Overturned {
        /// Time, s.
        time: f64,
        /// Name of the bar.
        part: &'static str,
    },
    /// A wheel is more than 1 m above the ground.
    #[error("at t = {time:.4} s wheel {wheel} has left the ground by more than 1 m (x = {x:.1} m)")]
    OffTheGround {
        /// Time, s.
        time: f64,
        /// 1 front, 2 middle, 3 rear.
        wheel: usize,
        /// Position of the wheel's centre, m.
        x: f64,
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
    /// The angles of links 1 and 2 are outside of the range in which the four-bar closes.
    #[error("at t = {time:.4} s links 1 and 2 have turned farther than the four-bar can close")]
    LoopRange {
        /// Time, s.
        time: f64,
    },
    /// The solver of `direct` finds no step within its tolerance.
    #[error("at t = {time:.4} s the solver finds no step that is accurate enough")]
    NoStep {
        /// Time, s.
        time: f64,
    },
    /// Kinetic, potential and elastic energy minus the work of the motors exceeds its minimum so
    /// far by more than the tolerance: the integration is wrong.
    #[error("at t = {time:.4} s energy is made from nothing: {made:.1e} J since its minimum")]
    EnergyMade {
        /// Time, s.
        time: f64,
        /// Rise of the energy since its minimum, J.
        made: f64,
    },
    /// The gap of a pin is too large: the pin forces would be wrong.
    #[error(
        "at t = {time:.4} s the pins of the four-bar are {distance:.1e} m apart: the forces are too large for the step"
    )]
    LoopOpen {
        /// Time, s.
        time: f64,
        /// Largest gap, m.
        distance: f64,
    },
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

/// Reason why the forces at a state cannot be evaluated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum NoForces {
    /// The four-bar cannot close.
    Loop,
    /// A wheel's centre is below the ground.
    BelowGround {
        /// Index of the wheel, 0 front.
        wheel: usize,
        /// The place.
        source: BelowGround,
    },
    /// The mass matrix is not positive definite.
    Singular,
}

/// The centre of a wheel is below the ground, where the contact laws do not apply.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct BelowGround {
    /// Position of the wheel's centre, m.
    pub x: f64,
}

impl BelowGround {
    /// The same fact with its time (s) and the index of the wheel (0 front).
    pub fn at(self, time: f64, wheel: usize) -> PlantError {
        let (wheel, x) = (wheel + 1, self.x);
        PlantError::WheelBelowGround { time, wheel, x }
    }
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
