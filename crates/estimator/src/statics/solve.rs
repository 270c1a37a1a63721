//! Sensitivity of the right-hand side of eq. (8) to the uncertain inputs: inputs that no sensor
//! measures, or that sensors measure with correlated errors. It carries the covariance of the
//! inputs into that of the forces. And least squares for the normal forces, with the covariance of
//! all forces.

use super::equilibrium::{Equations, Equilibrium, LeastSquaresInverse};
use super::forces::Forces;
use super::loads::Loads;
use crate::state;
use nalgebra::{Matrix4, Vector4};
use robhaz_model::{Geometry, PointMasses, Vec2};

/// Traction of one wheel from motor torque and speed, with its derivatives by the uncertain inputs.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Traction {
    /// Corrected by the estimated errors, N.
    pub value: f64,
    /// Standard deviation of the observer's error, N.
    pub observed: f64,
    /// Correlation time of that error, s.
    pub lasts: f64,
    /// Standard deviation of the resistance that is in no state, N.
    pub resisted: f64,
    /// Derivative by the torque offset, 1/m.
    pub by_offset: f64,
    /// Derivative by the wheels' resistance at the mean load, 1/m.
    pub by_resistance: f64,
    /// Derivative by the torque gain, N.
    pub by_gain: f64,
}

impl Traction {
    /// Variance by what is no input, N^2.
    pub fn noise(&self) -> f64 {
        self.observed * self.observed + self.resisted * self.resisted
    }

    /// The derivatives of the traction of wheel `i`, each with its input.
    pub fn gradient(&self, i: usize) -> [(usize, f64); 3] {
        [
            (state::TORQUE_OFFSET.of(i), self.by_offset),
            (state::RESISTANCE.of(0), self.by_resistance),
            (state::TORQUE_GAIN.of(i), self.by_gain),
        ]
    }
}

/// Derivatives of `y - H_N N`, with `y = F' - H_T T` and N held, by the uncertain inputs: a column
/// an input, in the order of [`state`]; N over the input's unit.
pub(crate) type Sensitivity = [Vector4<f64>; state::INPUTS];

/// The sensitivity at one instant, linearised at these normal forces and tractions, N. A resistance of
/// 1 N m moves each N `ahead`, m; `inertial` holds the masses if the loads include inertia, else `None`;
/// `lever` is that of the moment rows, m.
pub(crate) fn sensitivity(
    geometry: &Geometry,
    equations: &Equations,
    tractions: &[Traction; 3],
    (normal_force, traction): (&[f64; 3], &[f64; 3]),
    ahead: &[f64; 3],
    inertial: Option<&PointMasses>,
    lever: f64,
) -> Sensitivity {
    let (equilibrium, arms) = (&equations.equilibrium, &equations.arms);
    let mut columns = [Vector4::zeros(); state::INPUTS];
    if let Some(masses) = inertial {
        for (axis, unit) in [Vec2::x(), Vec2::y()].into_iter().enumerate() {
            let unit_load = Loads::uniform(masses, unit);
            columns[state::ACCELERATION.of(axis)] =
                Equilibrium::load_side(arms, &geometry.carriers, &unit_load, lever).0;
        }
    }
    for i in 0..3 {
        columns[state::CONTACT_ANGLE.of(i)] =
            equilibrium.by_contact_angle(i, geometry, [normal_force[i], traction[i]]);
        columns[state::RESISTANCE.of(0)] -=
            equilibrium.by_shift(ahead[i] * normal_force[i], geometry.carriers[i]);
        for (k, derivative) in tractions[i].gradient(i) {
            columns[k] += equilibrium.h_t[i] * -derivative;
        }
    }
    columns
}

/// Right-hand side of eq. (8): value, sensitivity, noise covariance.
pub(crate) struct RightSide {
    /// `y = F' - H_T T`, N.
    pub value: Vector4<f64>,
    /// A: derivatives of `y - H_N N` with respect to the uncertain inputs, at fixed N.
    pub sensitivity: Sensitivity,
    /// T.
    pub tractions: [Traction; 3],
    /// Covariance of loads, stop torque and unmodelled load, N^2.
    pub loads: Matrix4<f64>,
}

impl RightSide {
    /// Variance of the combination `w` of the rows from everything but the inputs: loads and torque
    /// observers, N^2.
    pub fn noise_along(&self, equilibrium: &Equilibrium, w: &Vector4<f64>) -> f64 {
        let mut variance = w.dot(&(self.loads * w));
        for (column, traction) in equilibrium.h_t.iter().zip(&self.tractions) {
            let along = column.dot(w);
            variance += along * along * traction.noise();
        }
        variance
    }
}

/// Generalised least squares for N, with `R = A P A' + noise` as the covariance of the equation
/// error.
///
/// `parity` is the unit vector w with `w' H_N = 0`: exact equations satisfy `w' y = 0`. With it, y
/// and T are first replaced by their means given `w' y = 0`; for y that is
/// `y - R w (w' y)/(w' R w)`. The result is consistent, so any left inverse of H_N gives the same
/// N: that of weighted least squares with the weight `R^-1`.
///
/// `inputs` gives the covariance of two uncertain inputs by their indices in [`state`], SI.
pub(crate) fn solve(
    equations: &Equations,
    parity: Option<&Vector4<f64>>,
    right: &RightSide,
    inputs: impl Fn(usize, usize) -> f64,
) -> Forces {
    let mut joint = Joint::new(&equations.equilibrium, right, &inputs);
    if let Some(w) = parity {
        joint.impose(w);
    }
    joint.forces(&equations.inverse)
}

/// Right-hand side y and tractions T as jointly Gaussian.
struct Joint {
    y: Vector4<f64>,
    traction: [f64; 3],
    /// R: covariance of the equation error, N^2.
    yy: Matrix4<f64>,
    /// Covariance of each traction with the equation error, N^2.
    ty: [Vector4<f64>; 3],
    /// Covariance of the tractions, N^2.
    tt: [[f64; 3]; 3],
}

impl Joint {
    /// From the covariance of the inputs and the noise.
    fn new(
        equilibrium: &Equilibrium,
        right: &RightSide,
        inputs: &impl Fn(usize, usize) -> f64,
    ) -> Self {
        let causes = causes(&right.tractions, inputs);
        let [t1, t2, t3] = equilibrium.h_t.map(|column| -column);
        let [x, y, angle1, angle2, angle3, mut resistance, ..] = right.sensitivity;
        // Less what it does through the tractions.
        for (column, traction) in equilibrium.h_t.iter().zip(&right.tractions) {
            resistance += column * traction.by_resistance;
        }
        let columns = [x, y, angle1, angle2, angle3, resistance, t1, t2, t3];
        // Covariance of each cause with the equation error.
        let mut effects = [Vector4::zeros(); CAUSES];
        for (effect, row) in effects.iter_mut().zip(&causes) {
            for (column, covariance) in columns.iter().zip(row) {
                *effect += column * *covariance;
            }
        }
        let mut yy = right.loads;
        for (column, effect) in columns.iter().zip(&effects) {
            yy += column * effect.transpose();
        }
        Self {
            y: right.value,
            traction: right.tractions.map(|t| t.value),
            yy,
            ty: [0, 1, 2].map(|i| effects[DIRECT + i]),
            tt: [0, 1, 2].map(|i| [0, 1, 2].map(|j| causes[DIRECT + i][DIRECT + j])),
        }
    }

    /// The conditional distribution given `w' y = 0`.
    fn impose(&mut self, w: &Vector4<f64>) {
        let rw = self.yy * w;
        let variance = w.dot(&rw);
        // Written so that a NaN fails too. Exact inputs satisfy the parity already.
        if !(variance > 0.0) {
            return;
        }
        let tw = self.ty.map(|c| c.dot(w));
        let step = w.dot(&self.y) / variance;
        self.y -= rw * step;
        for (traction, tw) in self.traction.iter_mut().zip(tw) {
            *traction -= tw * step;
        }
        for i in 0..3 {
            self.ty[i] -= rw * (tw[i] / variance);
            for j in 0..3 {
                self.tt[i][j] -= tw[i] * tw[j] / variance;
            }
        }
        self.yy -= rw * rw.transpose() / variance;
    }

    /// N by a left inverse, and the covariance of all forces.
    fn forces(&self, inverse: &LeastSquaresInverse) -> Forces {
        let mut covariance = [[0.0; 6]; 6];
        for i in 0..3 {
            let ri = self.yy * inverse.rows[i];
            for j in 0..3 {
                covariance[2 * i][2 * j] = self.tt[i][j];
                covariance[2 * i + 1][2 * j + 1] = inverse.rows[j].dot(&ri);
                let n_t = inverse.rows[i].dot(&self.ty[j]);
                covariance[2 * i + 1][2 * j] = n_t;
                covariance[2 * j][2 * i + 1] = n_t;
            }
        }
        Forces {
            normal: inverse.solve(&self.y),
            traction: self.traction,
            covariance,
        }
    }
}

/// Inputs that act on the equations directly: accelerations, contact angles and the wheels' resistance.
/// The others act through the tractions alone.
pub(crate) const DIRECT: usize = state::RESISTANCE.end();
/// What errs in the equations: direct inputs and the three tractions.
pub(crate) const CAUSES: usize = DIRECT + 3;

/// Covariance of direct inputs and tractions, SI: the inputs' part, and the observers' noise of the
/// tractions.
pub(crate) fn causes(
    tractions: &[Traction; 3],
    inputs: &impl Fn(usize, usize) -> f64,
) -> [[f64; CAUSES]; CAUSES] {
    let mut covariance = [[0.0; CAUSES]; CAUSES];
    for a in 0..DIRECT {
        for b in 0..DIRECT {
            covariance[a][b] = inputs(a, b);
        }
    }
    for (i, ti) in tractions.iter().enumerate() {
        let [offset, resistance, gain] = ti.gradient(i);
        let with = |a: usize| {
            let by = |(k, derivative): (usize, f64)| derivative * inputs(a, k);
            by(offset) + by(resistance) + by(gain)
        };
        for a in 0..DIRECT {
            covariance[a][DIRECT + i] = with(a);
            covariance[DIRECT + i][a] = covariance[a][DIRECT + i];
        }
        for (j, tj) in tractions.iter().enumerate().take(i + 1) {
            let mut sum = if i == j { ti.noise() } else { 0.0 };
            for (k, derivative) in tj.gradient(j) {
                sum += derivative * with(k);
            }
            covariance[DIRECT + i][DIRECT + j] = sum;
            covariance[DIRECT + j][DIRECT + i] = sum;
        }
    }
    covariance
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::nominal::Nominal;
    use crate::settings::EstimatorSettings;
    use crate::statics::{Arms, Loads};
    use crate::testing::positive;
    use nalgebra::{Matrix3, SMatrix, Vector3};
    use proptest::prelude::*;
    use robhaz_model::Robot;

    const INPUTS: usize = state::INPUTS;
    type Normals = SMatrix<f64, 4, 3>;

    /// Eq. (8) at rest, for angles of links 1 and 2 and contact angles, rad.
    fn equations(robot: &Robot, theta: [f64; 2], slopes: &[f64; 3]) -> Equations {
        let nominal = Nominal::new(robot, EstimatorSettings::kalman());
        let arms = Arms::new(&robot.geometry, theta[0], theta[1]).expect("inside the stops");
        let loads = Loads::at_rest(&nominal.masses);
        let equations = nominal.equations(arms, theta, loads, slopes, &[0.0; 3]);
        equations.expect("regular")
    }

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
                |(value, sigma, [by_offset, by_resistance, by_gain])| Traction {
                    value,
                    observed: sigma,
                    lasts: 0.0,
                    resisted: 0.0,
                    by_offset,
                    by_resistance,
                    by_gain,
                },
            )
    }

    proptest! {
        /// Equivalence: moving the right-hand side to where the parity holds and taking any left
        /// inverse is weighted least squares with the weight R^-1, here solved as such, with
        /// matrices of full size: N, T and the whole covariance. Conditions are about 1e4: 1e-8 of
        /// the forces leaves four digits.
        #[test]
        fn whitened_is_weighted_least_squares(
            theta1 in -0.3_f64..0.3, theta2 in -0.3_f64..0.3, slopes in prop::array::uniform3(-0.4_f64..0.4),
            direct in prop::collection::vec(vector(), DIRECT),
            tractions in (traction(), traction(), traction()), root in prop::collection::vec(-0.5_f64..0.5, state::INPUTS * state::INPUTS),
        ) {
            let robot = Robot::default_a();
            let equations = equations(&robot, [theta1, theta2], &slopes);
            let e = &equations.equilibrium;
            let tractions = [tractions.0, tractions.1, tractions.2];
            let mut sensitivity = [Vector4::zeros(); INPUTS];
            sensitivity[..DIRECT].copy_from_slice(&direct);
            for (i, t) in tractions.iter().enumerate() {
                for (k, derivative) in t.gradient(i) {
                    sensitivity[k] -= e.h_t[i] * derivative;
                }
            }
            let p: SMatrix<f64, INPUTS, INPUTS> = positive(&root);
            let inputs = |i, j| p[(i, j)];
            let right = RightSide {
                value: e.right_side(&tractions.map(|t| t.value)),
                sensitivity,
                tractions,
                loads: Matrix4::identity() * 0.1,
            };
            let found = solve(&equations, equations.parity_direction.as_ref(), &right, inputs);

            // Right-hand side and tractions as one Gaussian.
            let h = Normals::from_columns(&e.h_n);
            let h_t = Normals::from_columns(&e.h_t);
            let a = SMatrix::<f64, 4, INPUTS>::from_columns(&sensitivity);
            let mut g = SMatrix::<f64, 3, INPUTS>::zeros();
            for (i, t) in tractions.iter().enumerate() {
                g[(i, state::TORQUE_OFFSET.of(i))] = t.by_offset;
                g[(i, state::RESISTANCE.of(0))] = t.by_resistance;
                g[(i, state::TORQUE_GAIN.of(i))] = t.by_gain;
            }
            let d = Matrix3::from_diagonal(&Vector3::from(tractions.map(|t| t.noise())));
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

        /// Without the parity the forces are the unweighted least squares', and their covariance is
        /// that of a linear map of the right-hand side.
        #[test]
        fn without_parity_the_covariance_is_mapped(y in vector(), sigma in 0.1_f64..3.0) {
            let equations = equations(&Robot::default_a(), [0.1, -0.1], &[0.1, 0.0, 0.2]);
            let inverse = &equations.inverse;
            let none = Traction { value: 0.0, observed: 0.0, lasts: 0.0, resisted: 0.0, by_offset: 0.0, by_resistance: 0.0, by_gain: 0.0 };
            let right = RightSide {
                value: y,
                sensitivity: [Vector4::zeros(); INPUTS],
                tractions: [none; 3],
                loads: Matrix4::identity() * (sigma * sigma),
            };
            let found = solve(&equations, None, &right, |_, _| 0.0);
            let expected = inverse.solve(&y);
            prop_assert!((0..3).all(|i| found.normal[i].to_bits() == expected[i].to_bits()));
            for i in 0..3 {
                let expected = inverse.rows[i].norm_squared() * sigma * sigma;
                prop_assert!((found.covariance[2 * i + 1][2 * i + 1] - expected).abs() < 1e-9 * expected);
            }
        }
    }
}
