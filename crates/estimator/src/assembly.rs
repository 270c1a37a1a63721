//! An estimate from the forces and equations of one instant.

use crate::estimate::Estimate;
use crate::flags::Flags;
use crate::nominal::Nominal;
use crate::statics::{Equations, Forces};
use nalgebra::Vector4;
use robhaz_model::Vec2;

/// The estimate at `time` (s): forces and posture, for the contact angles (rad) and the right-hand
/// side `F' - H_T T` (N) of the least squares. Without what only some filters state. Inlined, so
/// that it is made where it is returned: it has more than a kilobyte.
#[inline(always)]
pub(crate) fn assemble(
    nominal: &Nominal,
    time: f64,
    equations: &Equations,
    forces: &Forces,
    right_side: &Vector4<f64>,
    contact_angle: [f64; 3],
    flags: Flags,
) -> Estimate {
    let carriers = &nominal.robot.geometry.carriers;
    let (arms, [theta1, theta2]) = (&equations.arms, equations.link_angles);
    let equilibrium = &equations.equilibrium;
    let [p, r, s] = equilibrium.pins;
    let q = equilibrium.force_in_q(&equations.loads, carriers, &forces.normal, &forces.traction);
    let mut residual = *right_side;
    for i in 0..3 {
        residual -= equilibrium.h_n[i] * forces.normal[i];
    }
    let lever = nominal.settings.moment_lever;
    Estimate {
        time,
        normal_force: forces.normal,
        traction: forces.traction,
        covariance: None,
        contact_angle,
        contact_angle_sigma: None,
        posture: arms.posture(theta1, theta2),
        angle_sigma: None,
        pin_from_q: [arms.p, Vec2::zeros(), arms.r, arms.s],
        pin_force: [p, q, r, s],
        residual: [
            residual.x,
            residual.y,
            residual.z * lever,
            residual.w * lever,
        ],
        parity: None,
        reading_errors: None,
        contact: None,
        friction: None,
        health: None,
        torque_scale: None,
        flags,
    }
}
