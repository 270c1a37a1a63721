//! What tractions and normal forces depend on of that which nobody reads: the columns that carry the filter's covariance into theirs.

use crate::equilibrium::{Equilibrium, Loads};
use crate::motion::{SENSITIVE, state};
use crate::told::{Statics, Told};
use nalgebra::Vector4;
use robhaz_model::Vec2;

/// Traction of one wheel as it follows from torque and speed, and what it depends on.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Traction {
    /// With the errors found taken off, N.
    pub value: f64,
    /// Standard deviation of the observer's part, N.
    pub sigma: f64,
    /// Change with the offset, 1/m.
    pub by_offset: f64,
    /// Change with the common gear friction, 1/m.
    pub by_friction: f64,
    /// Change with the gain, N.
    pub by_gain: f64,
}

/// How the right side `y = F' - H_T T` and the contact angles' part of `H_N N` change with the states that they depend on: a
/// column a state, N.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sensitivity {
    pub columns: [Vector4<f64>; SENSITIVE],
}

impl Sensitivity {
    pub const ACCELERATION: usize = 0;
    pub const CONTACT_ANGLE: usize = state::CONTACT_ANGLE - state::ACCELERATION;
    pub const TORQUE_OFFSET: usize = state::TORQUE_OFFSET - state::ACCELERATION;
    pub const GEAR_FRICTION: usize = state::GEAR_FRICTION - state::ACCELERATION;
    pub const TORQUE_GAIN: usize = state::TORQUE_GAIN - state::ACCELERATION;

    /// At one instant, for the tractions as they are believed.
    pub fn new(told: &Told, statics: &Statics, tractions: &[Traction; 3]) -> Self {
        let geometry = &told.robot.geometry;
        let (settings, equilibrium, arms) = (&told.settings, &statics.equilibrium, &statics.arms);
        let mut columns = [Vector4::zeros(); SENSITIVE];
        if settings.inertia {
            for (axis, unit) in [Vec2::x(), Vec2::y()].into_iter().enumerate() {
                let pushed = Loads::uniform(&told.masses, unit);
                columns[Sensitivity::ACCELERATION + axis] =
                    Equilibrium::right_of(arms, &geometry.carriers, &pushed, settings.moment_lever)
                        .0;
            }
        }
        // Normal forces as the uncorrected equations give them.
        let normal = statics
            .inverse
            .solve(&equilibrium.right_side(&tractions.map(|t| t.value)));
        for i in 0..3 {
            let t = &tractions[i];
            columns[Sensitivity::CONTACT_ANGLE + i] = equilibrium.by_contact_angle(
                i,
                geometry.carriers[i],
                geometry.wheel_radius,
                normal[i],
                t.value,
            );
            let h = equilibrium.h_t[i];
            columns[Sensitivity::TORQUE_OFFSET + i] = h * -t.by_offset;
            columns[Sensitivity::GEAR_FRICTION] += h * -t.by_friction;
            columns[Sensitivity::TORQUE_GAIN + i] = h * -t.by_gain;
        }
        Self { columns }
    }

    /// `w' A`.
    pub fn along(&self, w: &Vector4<f64>) -> [f64; SENSITIVE] {
        self.columns.map(|column| w.dot(&column))
    }
}
