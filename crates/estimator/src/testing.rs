//! Random numbers, matrices and linkages for tests.

use crate::statics::{Arms, Equilibrium, Loads};
use proptest::prelude::*;
use robhaz_model::Geometry;

/// Random numbers that are the same in every run: a linear congruential generator (Knuth's MMIX),
/// its high bits.
pub struct Random(u64);

impl Random {
    pub fn new() -> Self {
        Self(1)
    }

    /// Uniform between 0 and 1.
    fn uniform(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        // 32 bits are enough for noise.
        f64::from((self.0 >> 32) as u32) / 4_294_967_296.0
    }

    /// Mean 0, variance 1, nearly normal: the sum of twelve uniform ones.
    pub fn normal(&mut self) -> f64 {
        (0..12).map(|_| self.uniform()).sum::<f64>() - 6.0
    }
}

/// A positive definite matrix from the entries of a root.
pub fn positive<const N: usize>(root: &[f64]) -> nalgebra::SMatrix<f64, N, N> {
    let root = nalgebra::SMatrix::<f64, N, N>::from_row_slice(root);
    root * root.transpose() + nalgebra::SMatrix::identity() * 0.1
}

/// Angles of links 1 and 2 inside the stops, rad.
pub fn angles() -> impl Strategy<Value = [f64; 2]> {
    (-0.4_f64..0.4, -0.6_f64..0.5).prop_map(|(theta2, opening)| [theta2 + opening, theta2])
}

/// Contact angles, rad.
pub fn slopes() -> impl Strategy<Value = [f64; 3]> {
    prop::array::uniform3(-0.5_f64..0.5)
}

/// Geometry B or A.
pub fn geometry(is_b: bool) -> Geometry {
    if is_b { Geometry::b() } else { Geometry::a() }
}

/// The linkage at angles of links 1 and 2 inside the end stops, rad.
pub fn arms(geometry: &Geometry, theta: [f64; 2]) -> Arms {
    Arms::new(geometry, theta[0], theta[1]).expect("inside the stops the four-bar closes")
}

/// Eq. (8) for given contact angles (rad) and a lever of the moment rows (m).
pub fn equations(
    geometry: &Geometry,
    arms: &Arms,
    loads: &Loads,
    contact_angle: &[f64; 3],
    lever: f64,
) -> Equilibrium {
    let (carriers, radius) = (&geometry.carriers, geometry.wheel_radius);
    Equilibrium::new(arms, carriers, radius, loads, contact_angle, lever)
        .expect("C is regular inside the stops")
}
