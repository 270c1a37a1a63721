//! Eq. (8) at one instant, ready to be solved.

use super::arms::Arms;
use super::equilibrium::{Equilibrium, LeastSquaresInverse};
use super::loads::Loads;
use nalgebra::Vector4;
use robhaz_model::Geometry;

/// Eq. (8) at one instant, with its least-squares inverse and its redundancy.
pub(crate) struct Equations {
    /// Positions on the linkage.
    pub arms: Arms,
    /// Angles of links 1 and 2, rad.
    pub link_angles: [f64; 2],
    /// Gravity, and inertial loads where they are known.
    pub loads: Loads,
    /// H and F'.
    pub equilibrium: Equilibrium,
    /// Left inverse of H_N.
    pub inverse: LeastSquaresInverse,
    /// Unit vector `w` with `w' H_N = 0`; `None` where the contacts leave it undefined.
    pub parity_direction: Option<Vector4<f64>>,
}

impl Equations {
    /// Eq. (8) for the posture `arms` of the links' angles (rad), loads, contact angles (rad) and
    /// the lever of the moment rows (m). `None` where the statics are singular.
    #[inline(always)]
    pub fn new(
        geometry: &Geometry,
        arms: Arms,
        link_angles: [f64; 2],
        loads: Loads,
        contact_angle: &[f64; 3],
        lever: f64,
    ) -> Option<Self> {
        let (carriers, radius) = (&geometry.carriers, geometry.wheel_radius);
        let equilibrium = Equilibrium::new(&arms, carriers, radius, &loads, contact_angle, lever)?;
        Some(Self {
            arms,
            link_angles,
            loads,
            inverse: equilibrium.least_squares()?,
            parity_direction: equilibrium.parity_direction(),
            equilibrium,
        })
    }
}
