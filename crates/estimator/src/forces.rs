//! Normal forces from eq. (8), with their covariance: least squares, the parity residual put back where it belongs, N >= 0.

use crate::best::{Sensitivity, Traction};
use crate::equilibrium::{Equilibrium, LeastSquaresInverse};
use crate::motion::{MotionFilter, SENSITIVE, state};
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
    /// Ground does not pull: while a normal force is negative, the most negative one is set to zero and the others follow by
    /// their covariance with it.
    pub fn without_pull(&mut self) {
        for _ in 0..3 {
            let (mut worst, mut least) = (0, 0.0);
            for i in 0..3 {
                if self.normal[i] < least {
                    (worst, least) = (i, self.normal[i]);
                }
            }
            let variance = self.covariance[2 * worst + 1][2 * worst + 1];
            if !(least < 0.0 && variance > 0.0) {
                break;
            }
            let column = self.covariance.map(|row| row[2 * worst + 1]);
            let step = least / variance;
            for i in 0..3 {
                self.traction[i] -= column[2 * i] * step;
                self.normal[i] -= column[2 * i + 1] * step;
            }
            self.normal[worst] = 0.0;
            for i in 0..6 {
                for j in 0..6 {
                    self.covariance[i][j] -= column[i] * column[j] / variance;
                }
            }
        }
        // The last of three may be left by a hair.
        self.normal = self.normal.map(|n| n.max(0.0));
    }
}
