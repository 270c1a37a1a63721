//! Sensitivity of the right-hand side of eq. (8) to the uncertain inputs: inputs that no sensor
//! measures, or that sensors measure with correlated errors. It carries the covariance of the
//! inputs into that of the forces.

use super::equilibrium::{Equations, Equilibrium};
use super::loads::Loads;
use nalgebra::Vector4;
use robhaz_model::{Geometry, PointMasses, Vec2};

/// Order of the uncertain inputs.
pub(crate) mod input {
    /// Acceleration of Q, m/s^2: x, y.
    pub const ACCELERATION: usize = 0;
    /// Errors of the given contact angles, rad.
    pub const CONTACT_ANGLE: usize = 2;
    /// Offsets of the torque readings, N m.
    pub const TORQUE_OFFSET: usize = 5;
    /// Dry friction in the gears, common to all wheels, N m against the spin.
    pub const GEAR_FRICTION: usize = 8;
    /// Relative errors of the torque readings.
    pub const TORQUE_GAIN: usize = 9;
    /// How many.
    pub const COUNT: usize = 12;
}

/// Traction of one wheel from motor torque and speed, with its derivatives by the uncertain inputs.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Traction {
    /// Corrected by the estimated errors, N.
    pub value: f64,
    /// Standard deviation of the observer's part, N.
    pub sigma: f64,
    /// Derivative by the torque offset, 1/m.
    pub by_offset: f64,
    /// Derivative by the gear friction, 1/m.
    pub by_friction: f64,
    /// Derivative by the torque gain, N.
    pub by_gain: f64,
}

impl Traction {
    /// The derivatives of the traction of wheel `i`, each with its input.
    pub fn gradient(&self, i: usize) -> [(usize, f64); 3] {
        [
            (input::TORQUE_OFFSET + i, self.by_offset),
            (input::GEAR_FRICTION, self.by_friction),
            (input::TORQUE_GAIN + i, self.by_gain),
        ]
    }
}

/// Derivatives of `y - H_N N`, with `y = F' - H_T T` and N held, by the uncertain inputs: a column an
/// input, in the order of [`input`]; N over the input's unit.
pub(crate) type Sensitivity = [Vector4<f64>; input::COUNT];

/// The sensitivity at one instant, linearised at the normal forces and tractions `forces`, N. `inertial` holds
/// the masses if the loads include inertia, else `None`; `lever` is that of the moment rows, m.
pub(crate) fn sensitivity(
    geometry: &Geometry,
    equations: &Equations,
    tractions: &[Traction; 3],
    (normal_force, traction): (&[f64; 3], &[f64; 3]),
    inertial: Option<&PointMasses>,
    lever: f64,
) -> Sensitivity {
    let (equilibrium, arms) = (&equations.equilibrium, &equations.arms);
    let mut columns = [Vector4::zeros(); input::COUNT];
    if let Some(masses) = inertial {
        for (axis, unit) in [Vec2::x(), Vec2::y()].into_iter().enumerate() {
            let unit_load = Loads::uniform(masses, unit);
            columns[input::ACCELERATION + axis] =
                Equilibrium::load_side(arms, &geometry.carriers, &unit_load, lever).0;
        }
    }
    for i in 0..3 {
        let t = &tractions[i];
        columns[input::CONTACT_ANGLE + i] = equilibrium.by_contact_angle(
            i,
            geometry.carriers[i],
            geometry.wheel_radius,
            normal_force[i],
            traction[i],
        );
        for (k, derivative) in t.gradient(i) {
            columns[k] += equilibrium.h_t[i] * -derivative;
        }
    }
    columns
}
