//! The interface of the engines; impulse and work, which they integrate together with the motion.

use crate::error::PlantError;
use crate::ground::{GroundForces, WheelMotion};
use crate::truth::Truth;
use robhaz_model::{Vec2, WheelCommand};

/// An engine: it integrates the motion and evaluates the truth once per period.
pub(crate) trait Engine: Send {
    /// Mean integration step since the start, s.
    fn mean_step(&self) -> f64;

    /// Sets the commands of the wheels from the next instant on.
    fn command(&mut self, commands: [WheelCommand; 3]);

    /// Writes the truth at the current time to `instant`. The simulation then advances by one
    /// period. A return value would be copied several times, and it has 1.1 kB.
    fn next_instant(&mut self, instant: &mut Instant) -> Result<(), PlantError>;
}

/// The truth at one instant, with the energies that [`Truth`] does not contain.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Instant {
    pub truth: Truth,
    /// Elastic energy of all contacts, J.
    pub contact_energy: f64,
    /// Work of the motors since the start. The other integrals are zero unless
    /// [`PlantSetup::balance`](crate::PlantSetup::balance) is set.
    pub balance: Balance,
}

/// Impulse and work since time zero, integrated at the engine's own steps.
///
/// An impact lasts less than a millisecond. Sums over records miss it; these integrals do not. The
/// motion does not depend on them. Two balances hold:
///
/// - change of momentum = sum of `impulse` + weight times time,
/// - change of mechanical energy = `motor_work` - `gear_loss` + `ground_work` + `stop_work`.
///
/// `direct` integrates with the quadrature of its solver, of the same order as the motion. `rapier`
/// multiplies the constant force of a step by the mean of the speeds at both ends of the step,
/// which is of first order in the step, like the motion.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Balance {
    /// Impulse of the ground on each wheel, N s.
    pub impulse: [Vec2; 3],
    /// Work of the motors, J.
    pub motor_work: f64,
    /// Energy that damping and friction in the gears dissipate, J.
    pub gear_loss: f64,
    /// Work of the ground on the wheels, J. It is negative when friction and damping dissipate
    /// energy or contacts store it.
    pub ground_work: f64,
    /// Work of the end stops on the links, J.
    pub stop_work: f64,
}

/// Forces and torques on one wheel at one instant, without its motor torque.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct WheelLoad {
    /// Force of the ground, N.
    pub force: Vec2,
    /// Torque of the ground that resists the forward spin, N m.
    pub ground_torque: f64,
    /// Torque of damping and friction in the gear, N m.
    pub gear_torque: f64,
}

impl WheelLoad {
    /// From the ground's forces and the gear's torque (N m).
    pub fn new(ground: &GroundForces, gear_torque: f64) -> Self {
        Self {
            force: ground.force,
            ground_torque: ground.torque,
            gear_torque,
        }
    }
}

impl Balance {
    /// Adds impulse and work of a wheel's load over `time` (s), at a constant motion and a constant
    /// spin `omega` relative to the link (rad/s).
    pub(crate) fn add_wheel(
        &mut self,
        load: &WheelLoad,
        motion: &WheelMotion,
        omega: f64,
        time: f64,
    ) {
        self.impulse[motion.wheel] += load.force * time;
        self.gear_loss += load.gear_torque * omega * time;
        self.ground_work +=
            (load.force.dot(&motion.velocity) - load.ground_torque * motion.spin) * time;
    }
}
