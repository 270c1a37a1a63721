//! Forces of the wheels with their covariance; bounded by N >= 0.

use super::equilibrium::LeastSquaresInverse;
use nalgebra::Vector4;

/// Normal forces and tractions of the three wheels.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Forces {
    /// N.
    pub normal: [f64; 3],
    /// N.
    pub traction: [f64; 3],
    /// Covariance of `[T1 N1 T2 N2 T3 N3]`, N^2.
    pub covariance: [[f64; 6]; 6],
}

impl Forces {
    /// Adds an error of the rows of eq. (8) with the deviation `constant`, N, to the covariance of
    /// N. It changes no estimate: an error that lasts, or that no equation shows, is not the white
    /// noise by which the rows are weighted.
    pub fn consider(&mut self, inverse: &LeastSquaresInverse, constant: &Vector4<f64>) {
        let moved = inverse.solve(constant);
        for (i, a) in moved.iter().enumerate() {
            for (j, b) in moved.iter().enumerate() {
                self.covariance[2 * i + 1][2 * j + 1] += a * b;
            }
        }
    }

    /// Multiplies all forces by a factor.
    pub fn scale(&mut self, factor: f64) {
        let forces = self.normal.iter_mut().chain(&mut self.traction);
        forces.for_each(|force| *force *= factor);
        let entries = self.covariance.iter_mut().flatten();
        entries.for_each(|entry| *entry *= factor * factor);
    }

    /// Standard deviation of N of wheel `i`, N.
    pub fn sigma_normal(&self, i: usize) -> f64 {
        let k = 2 * i + 1;
        robhaz_model::sqrt(self.covariance[k][k].clamp(0.0, f64::INFINITY))
    }

    /// If any N < 0, replaces the forces by those conditioned on N = 0 for some wheels: the set of
    /// wheels with the smallest Mahalanobis distance for which all N >= 0. This is the most likely
    /// point without a negative normal force.
    ///
    /// The covariance stays that without the bound. That a wheel carries no load is not known: its
    /// N is only less than nothing within its error, and the other forces err with it. A covariance
    /// conditioned on N = 0 would state N exactly.
    ///
    /// It tries all seven non-empty sets of wheels.
    pub fn bound(&mut self) {
        if self.normal.iter().all(|n| *n >= 0.0) {
            return;
        }
        let (mut nearest, mut least) = (*self, f64::INFINITY);
        for held in 1_u8..8 {
            let mut tried = *self;
            let mut distance = 0.0;
            for i in 0..3 {
                if held & (1 << i) != 0 {
                    distance += tried.hold(i);
                }
            }
            if distance < least && tried.normal.iter().all(|n| *n >= 0.0) {
                (nearest, least) = (tried, distance);
            }
        }
        (self.normal, self.traction) = (nearest.normal, nearest.traction);
    }

    /// Inflates the variance of each force beyond `limit` (N) by its square, so that no force at
    /// all is within its deviation. Returns whether there is one.
    pub fn inflate_beyond(&mut self, limit: f64) -> bool {
        let mut found = false;
        let forces = self.traction.iter().zip(&self.normal);
        let forces = forces.flat_map(|(traction, normal)| [traction, normal]);
        for ((k, row), force) in self.covariance.iter_mut().enumerate().zip(forces) {
            if force.abs() > limit
                && let Some(variance) = row.get_mut(k)
            {
                *variance += force * force;
                found = true;
            }
        }
        found
    }

    /// Drops all covariances where one is beyond what its variances allow: of absurd readings
    /// nothing but rounding is left.
    pub fn keep_proper(&mut self) {
        let p = self.covariance;
        let variance = [0, 1, 2, 3, 4, 5].map(|k: usize| if p[k][k] < 0.0 { 0.0 } else { p[k][k] });
        let is_proper = |i: usize, j: usize| {
            let (a, b) = (p[i][j], p[j][i]);
            (a * a).max(b * b) <= variance[i] * variance[j] * (1.0 + 1e-9) + 1e-12
        };
        if (0..6).all(|i| (0..i).all(|j| is_proper(i, j))) {
            return;
        }
        self.covariance = [[0.0; 6]; 6];
        for k in 0..6 {
            self.covariance[k][k] = variance[k];
        }
    }

    /// Conditions on N = 0 of wheel `i`. Returns the squared Mahalanobis distance of that step,
    /// dimensionless.
    fn hold(&mut self, i: usize) -> f64 {
        let k = 2 * i + 1;
        let column = self.covariance.map(|row| row[k]);
        let (normal, variance) = (self.normal[i], column[k]);
        let step = normal / variance;
        for j in 0..3 {
            self.traction[j] -= column[2 * j] * step;
            self.normal[j] -= column[2 * j + 1] * step;
        }
        for (row, a) in self.covariance.iter_mut().zip(column) {
            for (entry, b) in row.iter_mut().zip(column) {
                *entry -= a * b / variance;
            }
            row[k] = 0.0;
        }
        // N of that wheel is now exact: rounding must not leave a variance.
        self.normal[i] = 0.0;
        self.covariance[k] = [0.0; 6];
        normal * step
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::positive;
    use nalgebra::SMatrix;
    use proptest::prelude::*;

    /// Closed form: an error e of the rows moves N by the left inverse times e. Considered, it adds
    /// the square of that to the covariance, and leaves N, T and their other covariances as they
    /// are.
    #[test]
    fn a_considered_error_moves_only_the_covariance_of_n() {
        let row = |k: f64| Vector4::new(0.3 * k, -0.2, 0.1 + k, 0.5);
        let inverse = LeastSquaresInverse {
            rows: [row(1.0), row(-2.0), row(0.5)],
        };
        let before = Forces {
            normal: [40.0, 50.0, 45.0],
            traction: [1.0, -2.0, 0.5],
            covariance: core::array::from_fn(|i| core::array::from_fn(|j| (i + j) as f64)),
        };
        let error = Vector4::new(0.1, -0.4, 0.2, 0.3);
        let mut after = before;
        after.consider(&inverse, &error);
        let moved = inverse.solve(&error);
        for i in 0..6 {
            for j in 0..6 {
                let of_normal = i % 2 == 1 && j % 2 == 1;
                let added = if of_normal {
                    moved[i / 2] * moved[j / 2]
                } else {
                    0.0
                };
                let found = after.covariance[i][j] - before.covariance[i][j];
                assert!((found - added).abs() < 1e-12, "{i} {j}");
            }
        }
        assert_eq!(
            (after.normal, after.traction),
            (before.normal, before.traction)
        );
    }

    /// A force beyond the limit has a deviation of at least itself; the others keep theirs.
    #[test]
    fn a_force_beyond_the_limit_has_a_large_deviation() {
        let mut forces = Forces {
            normal: [0.0, 0.0, 14_733.0],
            traction: [3.0, -900.0, 0.0],
            covariance: [[1.0; 6]; 6],
        };
        assert!(forces.inflate_beyond(700.0));
        let variances: [f64; 6] = core::array::from_fn(|k| forces.covariance[k][k]);
        assert_eq!(
            variances.map(|v| v > 1.0),
            [false, false, true, false, false, true]
        );
        assert!(variances[5] > 14_733.0_f64.powi(2) && variances[2] > 900.0_f64.powi(2));
        assert!(!forces.inflate_beyond(20_000.0));
    }

    /// Covariances beyond their variances are dropped, others stay.
    #[test]
    fn improper_covariances_are_dropped() {
        let mut forces = Forces {
            normal: [1.0; 3],
            traction: [1.0; 3],
            covariance: [[1.0; 6]; 6],
        };
        forces.keep_proper();
        assert_eq!(forces.covariance, [[1.0; 6]; 6]);
        forces.covariance[1][5] = 3.2e32;
        forces.keep_proper();
        let unit = core::array::from_fn(|i| core::array::from_fn(|j| f64::from(u8::from(i == j))));
        assert_eq!(forces.covariance, unit);
    }

    proptest! {
        /// Optimality: bounded forces are the most likely ones, `min (z - z0)' P^-1 (z - z0)` with
        /// N >= 0. The conditions of Karush, Kuhn and Tucker: `P^-1 (z - z0)` is zero but for
        /// wheels held at zero, and there it pushes (not negative). Checked as `z - z0 = P mu` with
        /// mu only there. 1e-9 of 100 N is rounding at a condition of 1e4.
        #[test]
        fn bounded_is_the_constrained_optimum(
            normal in prop::array::uniform3(-40.0_f64..80.0), traction in prop::array::uniform3(-20.0_f64..20.0),
            root in prop::collection::vec(-1.0_f64..1.0, 36),
        ) {
            let p: SMatrix<f64, 6, 6> = positive(&root);
            let mut forces = Forces {
                normal,
                traction,
                covariance: core::array::from_fn(|i| core::array::from_fn(|j| p[(i, j)])),
            };
            forces.bound();
            let stack = |t: [f64; 3], n: [f64; 3]| nalgebra::SVector::<f64, 6>::from([t[0], n[0], t[1], n[1], t[2], n[2]]);
            let change = stack(forces.traction, forces.normal) - stack(traction, normal);
            let multipliers = p.cholesky().expect("positive").solve(&change);
            let scale = 1.0 + multipliers.norm();
            for i in 0..3 {
                prop_assert!(forces.normal[i] >= 0.0);
                prop_assert!(multipliers[2 * i].abs() < 1e-9 * scale, "{multipliers}");
                let m = multipliers[2 * i + 1];
                prop_assert!(m > -1e-9 * scale, "{multipliers} {forces:?}");
                if m > 1e-9 * scale {
                    // Held at zero.
                    prop_assert!(forces.normal[i] <= 0.0, "{multipliers} {forces:?}");
                }
                // A bound measures nothing: no variance falls.
                for j in 0..6 {
                    prop_assert!((forces.covariance[i][j] - p[(i, j)]).abs() <= 0.0);
                    prop_assert!((forces.covariance[i + 3][j] - p[(i + 3, j)]).abs() <= 0.0);
                }
            }
        }
    }
}
