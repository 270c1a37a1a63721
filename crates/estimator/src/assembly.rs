//! An estimate from the forces and equations of one instant.

use crate::contact::ContactEstimate;
use crate::estimate::{Estimate, Parity, ReadingErrors};
use crate::flags::Flags;
use crate::friction::WheelFriction;
use crate::health::Health;
use crate::nominal::Nominal;
use crate::statics::{Equations, Forces};
use crate::torque_scale::TorqueScale;
use nalgebra::Vector4;
use robhaz_model::Vec2;

/// Result of the least squares at one instant.
pub(crate) struct Solution<'a> {
    pub forces: &'a Forces,
    /// `F' - H_T T`, N, as the least squares used it.
    pub right_side: &'a Vector4<f64>,
    /// Contact angles, rad.
    pub contact_angle: [f64; 3],
    /// Parity residual before any correction.
    pub parity: Option<Parity>,
    /// `None` from filters that do not estimate it.
    pub contact: Option<[ContactEstimate; 3]>,
    /// The same.
    pub friction: Option<[WheelFriction; 3]>,
    /// `None` from filters that state no covariance.
    pub uncertainty: Option<Uncertainty>,
    pub torque_scale: Option<TorqueScale>,
    pub flags: Flags,
}

/// Uncertainty beside the covariance of the forces.
pub(crate) struct Uncertainty {
    /// Standard deviations of the angles of links 1 and 2, rad.
    pub angle_sigma: [f64; 2],
    /// Standard deviations of the contact angles, rad.
    pub contact_angle_sigma: [f64; 3],
    pub reading_errors: ReadingErrors,
    pub health: Health,
}

/// The estimate at `time` (s). Inlined, so that it is made where it is returned: it has more than a kilobyte.
#[inline(always)]
pub(crate) fn assemble(
    nominal: &Nominal,
    time: f64,
    equations: &Equations,
    solution: &Solution<'_>,
) -> Estimate {
    let Solution {
        forces,
        uncertainty,
        ..
    } = solution;
    let carriers = &nominal.robot.geometry.carriers;
    let (arms, [theta1, theta2]) = (&equations.arms, equations.link_angles);
    let equilibrium = &equations.equilibrium;
    let [p, r, s] = equilibrium.pins;
    let q = equilibrium.force_in_q(&equations.loads, carriers, &forces.normal, &forces.traction);
    let mut residual = *solution.right_side;
    for i in 0..3 {
        residual -= equilibrium.h_n[i] * forces.normal[i];
    }
    let lever = nominal.settings.moment_lever;
    Estimate {
        time,
        normal_force: forces.normal,
        traction: forces.traction,
        covariance: uncertainty.as_ref().map(|_| forces.covariance),
        contact_angle: solution.contact_angle,
        contact_angle_sigma: uncertainty.as_ref().map(|u| u.contact_angle_sigma),
        posture: arms.posture(theta1, theta2),
        angle_sigma: uncertainty.as_ref().map(|u| u.angle_sigma),
        pin_from_q: [arms.p, Vec2::zeros(), arms.r, arms.s],
        pin_force: [p, q, r, s],
        residual: [
            residual.x,
            residual.y,
            residual.z * lever,
            residual.w * lever,
        ],
        parity: solution.parity,
        reading_errors: uncertainty.as_ref().map(|u| u.reading_errors),
        contact: solution.contact,
        friction: solution.friction,
        health: uncertainty.as_ref().map(|u| u.health),
        torque_scale: solution.torque_scale,
        flags: solution.flags,
    }
}
