//! Normal forces from eq. (8), with their covariance: least squares, the parity residual put back where it belongs, N >= 0.

use crate::equilibrium::{Equilibrium, LeastSquaresInverse};
use crate::motion::{MotionFilter, SENSITIVE, state};
use crate::sensitivity::{Sensitivity, Traction};
use nalgebra::{Matrix4, Vector4};

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

/// What the right side of eq. (8) does not know: its value, what it depends on, and the noise that no state covers.
pub(crate) struct RightSide<'a> {
    /// `F' - H_T T`, N.
    pub value: Vector4<f64>,
    pub sensitivity: &'a Sensitivity,
    pub tractions: &'a [Traction; 3],
    /// Covariance of loads and stop torque, N^2.
    pub loads: Matrix4<f64>,
}

impl RightSide<'_> {
    /// Noise that no state covers: loads, and the torque observers.
    pub fn noise(&self, equilibrium: &Equilibrium) -> Matrix4<f64> {
        let mut r = self.loads;
        for i in 0..3 {
            let column = equilibrium.h_t[i] * self.tractions[i].sigma;
            r += column * column.transpose();
        }
        r
    }
}

/// Least squares on a right side whose covariance is known.
///
/// The equations hold one combination without normal forces, `w' y = 0`. With `whitening` the right side is first moved, in the
/// metric of its covariance R, to where that holds: `y - R w (w' y)/(w' R w)`. What is left is consistent, so that any left
/// inverse of H_N gives the same N: that of weighted least squares with weight `R^-1`.
pub(crate) fn solve(
    equilibrium: &Equilibrium,
    inverse: &LeastSquaresInverse,
    parity: Option<Vector4<f64>>,
    right: &RightSide<'_>,
    motion: &MotionFilter,
) -> Forces {
    let p = &motion.filter.p;
    let columns = &right.sensitivity.columns;
    // P A', the covariance of states and right side.
    let mut states = [Vector4::zeros(); SENSITIVE];
    for (a, row) in states.iter_mut().enumerate() {
        for (b, column) in columns.iter().enumerate() {
            *row += column * p[state::ACCELERATION + a][state::ACCELERATION + b];
        }
    }
    let mut r = right.noise(equilibrium);
    for (column, row) in columns.iter().zip(&states) {
        r += column * row.transpose();
    }
    // Covariances of the tractions with the right side, and with each other.
    let by = |i: usize, row: &dyn Fn(usize) -> Vector4<f64>| {
        let t = &right.tractions[i];
        row(Sensitivity::TORQUE_OFFSET + i) * (t.by_offset)
            + row(Sensitivity::GEAR_FRICTION) * t.by_friction
            + row(Sensitivity::TORQUE_GAIN + i) * t.by_gain
    };
    let mut t_y = [Vector4::zeros(); 3];
    for (i, c) in t_y.iter_mut().enumerate() {
        let sigma = right.tractions[i].sigma;
        *c = by(i, &|k| states[k]) - equilibrium.h_t[i] * (sigma * sigma);
    }
    let mut t_t = [[0.0; 3]; 3];
    for i in 0..3 {
        let ti = &right.tractions[i];
        for j in 0..=i {
            let tj = &right.tractions[j];
            let at = |a: usize, b: usize| p[state::ACCELERATION + a][state::ACCELERATION + b];
            let gi = [
                (Sensitivity::TORQUE_OFFSET + i, ti.by_offset),
                (Sensitivity::GEAR_FRICTION, ti.by_friction),
                (Sensitivity::TORQUE_GAIN + i, ti.by_gain),
            ];
            let gj = [
                (Sensitivity::TORQUE_OFFSET + j, tj.by_offset),
                (Sensitivity::GEAR_FRICTION, tj.by_friction),
                (Sensitivity::TORQUE_GAIN + j, tj.by_gain),
            ];
            let mut sum = if i == j { ti.sigma * ti.sigma } else { 0.0 };
            for (a, u) in gi {
                for (b, v) in gj {
                    sum += u * v * at(a, b);
                }
            }
            t_t[i][j] = sum;
            t_t[j][i] = sum;
        }
    }

    let mut y = right.value;
    let mut traction = right.tractions.map(|t| t.value);
    if let Some(w) = parity {
        let rw = r * w;
        let s = w.dot(&rw);
        if s > 0.0 {
            let step = w.dot(&y) / s;
            y -= rw * step;
            let tw = t_y.map(|c| c.dot(&w));
            for i in 0..3 {
                traction[i] -= tw[i] * step;
                t_y[i] -= rw * (tw[i] / s);
                for j in 0..3 {
                    t_t[i][j] -= tw[i] * tw[j] / s;
                }
            }
            r -= rw * rw.transpose() / s;
        }
    }
    let mut covariance = [[0.0; 6]; 6];
    for i in 0..3 {
        let ri = r * inverse.rows[i];
        for j in 0..3 {
            covariance[2 * i][2 * j] = t_t[i][j];
            covariance[2 * i + 1][2 * j + 1] = inverse.rows[j].dot(&ri);
            let n_t = inverse.rows[i].dot(&t_y[j]);
            covariance[2 * i + 1][2 * j] = n_t;
            covariance[2 * j][2 * i + 1] = n_t;
        }
    }
    Forces {
        normal: inverse.solve(&y),
        traction,
        covariance,
    }
}

impl Forces {
    /// Ground does not pull: the most likely forces, in the metric of their covariance, of which no normal force is negative.
    ///
    /// The optimum holds some wheels at zero and lets the others follow by their covariance with these; of the seven ways to hold
    /// wheels that leave nothing negative it is the nearest one.
    pub fn without_pull(&mut self) {
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
        *self = nearest;
    }

    /// Sets the normal force of wheel `i` to zero and lets all others follow. Returns what that adds to the square of the
    /// distance in standard deviations.
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
        // What is held is known exactly: rounding must not leave a variance.
        self.normal[i] = 0.0;
        self.covariance[k] = [0.0; 6];
        normal * step
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::arms::Arms;
    use crate::equilibrium::Loads;
    use crate::settings::NoiseBudget;
    use crate::testing::positive;
    use nalgebra::{Matrix3, SMatrix, Vector3};
    use proptest::prelude::*;
    use robhaz_model::Robot;

    type Normals = SMatrix<f64, 4, 3>;

    fn vector() -> impl Strategy<Value = Vector4<f64>> {
        prop::array::uniform4(-1.0_f64..1.0).prop_map(Vector4::from)
    }

    fn traction() -> impl Strategy<Value = Traction> {
        (
            -20.0_f64..20.0,
            0.1_f64..2.0,
            prop::array::uniform3(-5.0_f64..5.0),
        )
            .prop_map(
                |(value, sigma, [by_offset, by_friction, by_gain])| Traction {
                    value,
                    sigma,
                    by_offset,
                    by_friction,
                    by_gain,
                },
            )
    }

    proptest! {
        /// Equivalence: moving the right side to where the parity holds and taking any left inverse is weighted least squares
        /// with the weight R^-1, here solved as such, with matrices of full size: N, T and the whole covariance.
        /// Conditions are about 1e4: 1e-8 of the forces leaves four digits.
        #[test]
        fn whitened_is_weighted_least_squares(
            theta1 in -0.3_f64..0.3, theta2 in -0.3_f64..0.3, slopes in prop::array::uniform3(-0.4_f64..0.4),
            columns in prop::collection::vec(vector(), SENSITIVE),
            tractions in (traction(), traction(), traction()), root in prop::collection::vec(-0.5_f64..0.5, SENSITIVE * SENSITIVE),
        ) {
            let robot = Robot::default_a();
            let geometry = &robot.geometry;
            let arms = Arms::new(geometry, theta1, theta2).expect("inside the stops");
            let loads = Loads::at_rest(&robot.mass.true_points());
            let e = Equilibrium::new(&arms, &geometry.carriers, geometry.wheel_radius, &loads, &slopes, 0.2).expect("regular");
            let inverse = e.least_squares().expect("regular");
            let tractions = [tractions.0, tractions.1, tractions.2];
            let sensitivity = Sensitivity { columns: core::array::from_fn(|k| columns[k]) };
            let p: SMatrix<f64, SENSITIVE, SENSITIVE> = positive(&root);
            let mut motion = MotionFilter::new(&NoiseBudget::typical());
            for i in 0..SENSITIVE {
                for j in 0..SENSITIVE {
                    motion.filter.p[state::ACCELERATION + i][state::ACCELERATION + j] = p[(i, j)];
                }
            }
            let right = RightSide {
                value: e.right_side(&tractions.map(|t| t.value)),
                sensitivity: &sensitivity,
                tractions: &tractions,
                loads: Matrix4::identity() * 0.1,
            };
            let found = solve(&e, &inverse, e.parity_direction(), &right, &motion);

            // Right side and tractions as one Gaussian.
            let h = Normals::from_columns(&e.h_n);
            let h_t = Normals::from_columns(&e.h_t);
            let a = SMatrix::<f64, 4, SENSITIVE>::from_columns(&sensitivity.columns);
            let mut g = SMatrix::<f64, 3, SENSITIVE>::zeros();
            for (i, t) in tractions.iter().enumerate() {
                g[(i, Sensitivity::TORQUE_OFFSET + i)] = t.by_offset;
                g[(i, Sensitivity::GEAR_FRICTION)] = t.by_friction;
                g[(i, Sensitivity::TORQUE_GAIN + i)] = t.by_gain;
            }
            let d = Matrix3::from_diagonal(&Vector3::from(tractions.map(|t| t.sigma * t.sigma)));
            let r = a * p * a.transpose() + h_t * d * h_t.transpose() + right.loads;
            let t_y = g * p * a.transpose() - d * h_t.transpose();
            let t_t = g * p * g.transpose() + d;
            let weight = r.cholesky().expect("positive").inverse();
            let of_normal = (h.transpose() * weight * h).cholesky().expect("rank 3").inverse();
            let normal = of_normal * h.transpose() * weight * right.value;
            let left = weight * (right.value - h * normal);
            let traction = Vector3::from(tractions.map(|t| t.value)) - t_y * left;
            let freed = weight - weight * h * of_normal * h.transpose() * weight;
            let of_traction = t_t - t_y * freed * t_y.transpose();
            let between = of_normal * h.transpose() * weight * t_y.transpose();

            let scale = 100.0 + normal.norm();
            let covariance = |i: usize, j: usize| found.covariance[i][j];
            for i in 0..3 {
                prop_assert!((found.normal[i] - normal[i]).abs() < 1e-8 * scale, "{:?} {normal}", found.normal);
                prop_assert!((found.traction[i] - traction[i]).abs() < 1e-8 * scale, "{:?} {traction}", found.traction);
                for j in 0..3 {
                    let scale = 1.0 + of_normal.norm() + t_t.norm();
                    prop_assert!((covariance(2 * i + 1, 2 * j + 1) - of_normal[(i, j)]).abs() < 1e-8 * scale);
                    prop_assert!((covariance(2 * i, 2 * j) - of_traction[(i, j)]).abs() < 1e-8 * scale);
                    prop_assert!((covariance(2 * i + 1, 2 * j) - between[(i, j)]).abs() < 1e-8 * scale);
                    prop_assert!((covariance(2 * j, 2 * i + 1) - between[(i, j)]).abs() < 1e-8 * scale);
                }
            }
        }

        /// Without the parity the forces are the unweighted least squares', and their covariance is that of a linear map of the
        /// right side.
        #[test]
        fn without_parity_the_covariance_is_mapped(y in vector(), sigma in 0.1_f64..3.0) {
            let robot = Robot::default_a();
            let geometry = &robot.geometry;
            let arms = Arms::new(geometry, 0.1, -0.1).expect("inside the stops");
            let loads = Loads::default();
            let e = Equilibrium::new(&arms, &geometry.carriers, geometry.wheel_radius, &loads, &[0.1, 0.0, 0.2], 0.2).expect("regular");
            let inverse = e.least_squares().expect("regular");
            let none = Traction { value: 0.0, sigma: 0.0, by_offset: 0.0, by_friction: 0.0, by_gain: 0.0 };
            let right = RightSide {
                value: y,
                sensitivity: &Sensitivity { columns: [Vector4::zeros(); SENSITIVE] },
                tractions: &[none; 3],
                loads: Matrix4::identity() * (sigma * sigma),
            };
            let motion = MotionFilter::new(&NoiseBudget::typical());
            let found = solve(&e, &inverse, None, &right, &motion);
            let expected = inverse.solve(&y);
            prop_assert!((0..3).all(|i| found.normal[i].to_bits() == expected[i].to_bits()));
            for i in 0..3 {
                let expected = inverse.rows[i].norm_squared() * sigma * sigma;
                prop_assert!((found.covariance[2 * i + 1][2 * i + 1] - expected).abs() < 1e-9 * expected);
            }
        }

        /// Optimality: forces that do not pull are the most likely ones, `min (z - z0)' P^-1 (z - z0)` with N >= 0. The
        /// conditions of Karush, Kuhn and Tucker: `P^-1 (z - z0)` is zero but for wheels held at zero, and there it pushes
        /// (not negative). Checked as `z - z0 = P mu` with mu only there. 1e-9 of 100 N is rounding at a condition of 1e4.
        #[test]
        fn without_pull_is_the_constrained_optimum(
            normal in prop::array::uniform3(-40.0_f64..80.0), traction in prop::array::uniform3(-20.0_f64..20.0),
            root in prop::collection::vec(-1.0_f64..1.0, 36),
        ) {
            let p: SMatrix<f64, 6, 6> = positive(&root);
            let mut forces = Forces {
                normal,
                traction,
                covariance: core::array::from_fn(|i| core::array::from_fn(|j| p[(i, j)])),
            };
            forces.without_pull();
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
                    // Held at zero, and known to be.
                    prop_assert!(forces.normal[i] <= 0.0, "{multipliers} {forces:?}");
                    prop_assert!(forces.covariance[2 * i + 1].iter().all(|c| c.abs() < 1e-9));
                }
            }
        }
    }
}
