//! Impulse and work on the robot, integrated by the engines beside the motion.

use crate::ground::{GroundForces, WheelMotion};
use robhaz_model::Vec2;

/// Impulse and work since time zero, integrated at the engine's own steps.
///
/// An impact lasts less than a millisecond, and sums over records miss it; these integrals do not. The motion does not depend
/// on them. Two balances follow:
///
/// - momentum gained = sum of `impulse` + weight times time,
/// - mechanical energy gained = `motor_work` - `gear_loss` + `ground_work` + `stop_work`.
///
/// `direct` integrates by the quadrature of its solver, of the same order as the motion. `rapier` multiplies the force that it
/// holds over a step by the mean of the speeds at the step's ends: of first order in the step, as the motion.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Balance {
    /// Impulse of the ground on each wheel, N s.
    pub impulse: [Vec2; 3],
    /// Work of the motors, J.
    pub motor_work: f64,
    /// Energy that damping and friction in the gears take, J.
    pub gear_loss: f64,
    /// Work of the ground on the wheels, J: negative where friction and damping take energy and the contacts' springs store it.
    pub ground_work: f64,
    /// Work of the end stops on the links, J.
    pub stop_work: f64,
}

/// What acts on one wheel at one instant, without its motor.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct WheelLoad {
    /// Force of the ground, N.
    force: Vec2,
    /// Torque of the ground that resists the forward spin, N m.
    ground_torque: f64,
    /// Torque that damping and friction in the gear take, N m.
    gear_torque: f64,
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
    /// Adds what a wheel's load does in `time` (s) at a constant motion and a constant spin `omega` relative to the link (rad/s).
    pub(crate) fn add_wheel(
        &mut self,
        wheel: usize,
        load: &WheelLoad,
        motion: &WheelMotion,
        omega: f64,
        time: f64,
    ) {
        self.impulse[wheel] += load.force * time;
        self.gear_loss += load.gear_torque * omega * time;
        self.ground_work +=
            (load.force.dot(&motion.velocity) - load.ground_torque * motion.spin) * time;
    }
}
