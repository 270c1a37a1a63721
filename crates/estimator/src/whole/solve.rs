//! Weighted least squares of the nine rows for the six normal forces.
//!
//! Axial forces are six more unknowns that no reading shows. They are not solved for: their mean is
//! proportional to N, as far as the row of the force y asks, and the rest is covariance. So is
//! every other error: each row counts for what it knows.

use super::{ROWS, Rows, WholeEquilibrium, WholeError};
use nalgebra::{Matrix6, SMatrix, Vector6};

/// What errs in the equations, in the order of their covariance.
pub mod input {
    /// First of the specific force x, y, z, m/s^2.
    pub const SPECIFIC_FORCE: usize = 0;
    /// First of the six contact angles, rad.
    pub const CONTACT_ANGLE: usize = 3;
    /// First of the six tractions, N.
    pub const TRACTION: usize = 9;
}

/// Number of the uncertain inputs.
pub const INPUTS: usize = 15;

/// Covariance of the errors of the inputs in the order of [`input`], SI.
pub type InputCovariance = SMatrix<f64, INPUTS, INPUTS>;

/// What no input accounts for, in mean loads of a wheel.
///
/// Axial forces beyond the part that is proportional to N: half of what a friction of 0.6 carries.
/// Chosen.
const AXIAL: f64 = 0.3;
/// Drilling moment of a wheel over its radius: friction of 0.7 over a contact as wide as half a
/// radius. Chosen.
const DRILLING: f64 = 0.2;
/// Error of each row: places, masses, penetration. Chosen.
const ROW: f64 = 0.005;
/// Axial over normal force: no ground holds more. Guard.
const STEEPEST: f64 = 1.0;

/// Normal forces of the six wheels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WholeForces {
    /// In the planes of the wheels, N: the ground's tilt across them is not seen.
    pub normal: [f64; 6],
    /// Their covariance, N^2.
    pub covariance: Matrix6<f64>,
    /// Covariance of the errors of N and of the inputs, in the order of [`input`].
    pub with_inputs: SMatrix<f64, 6, INPUTS>,
    /// Axial force over N, by which the force y is carried.
    pub axial: f64,
    /// Squared distance of the rows from what their covariance allows: chi-square with three
    /// degrees of freedom if all that is stated holds.
    pub misfit: f64,
}

impl WholeForces {
    /// Standard deviation of N of wheel `i`, N.
    pub fn sigma_normal(&self, i: usize) -> f64 {
        robhaz_model::sqrt(self.covariance[(i, i)].max(0.0))
    }
}

/// Lower root of a positive definite matrix (Cholesky). `None` where a pivot is lost in rounding.
fn root<const N: usize>(matrix: &SMatrix<f64, N, N>) -> Option<[[f64; N]; N]> {
    let mut l = [[0.0; N]; N];
    for j in 0..N {
        for i in j..N {
            let mut sum = matrix[(i, j)];
            for k in 0..j {
                sum -= l[i][k] * l[j][k];
            }
            if i > j {
                l[i][j] = sum / l[j][j];
            } else if sum > 1e-13 * matrix[(j, j)] && sum < f64::INFINITY {
                // Written so that a NaN fails too.
                l[j][j] = robhaz_model::sqrt(sum);
            } else {
                return None;
            }
        }
    }
    Some(l)
}

/// `L^-1 x`.
fn forward<const N: usize>(l: &[[f64; N]; N], x: &SMatrix<f64, N, 1>) -> SMatrix<f64, N, 1> {
    let mut y = *x;
    for i in 0..N {
        for k in 0..i {
            y[i] -= l[i][k] * y[k];
        }
        y[i] /= l[i][i];
    }
    y
}

/// `L'^-1 x`.
fn backward<const N: usize>(l: &[[f64; N]; N], x: &SMatrix<f64, N, 1>) -> SMatrix<f64, N, 1> {
    let mut y = *x;
    for i in (0..N).rev() {
        for k in i + 1..N {
            y[i] -= l[k][i] * y[k];
        }
        y[i] /= l[i][i];
    }
    y
}

impl WholeEquilibrium {
    /// The six normal forces for tractions in N and the covariance of the inputs' errors.
    ///
    /// # Errors
    /// [`WholeError::Singular`].
    pub fn solve(
        &self,
        traction: &[f64; 6],
        inputs: &InputCovariance,
    ) -> Result<WholeForces, WholeError> {
        let y = self.right_side(traction);
        // Equal loads that carry the force z: on a plane, however tilted, their axial forces are exact.
        let carried: f64 = self.h_n.iter().map(|column| column[2]).sum();
        let about = self.fit(&y, traction, &[y[2] / carried; 6], inputs)?.normal;
        let fit = self.fit(&y, traction, &about, inputs)?;
        fit.forces().ok_or(WholeError::Singular)
    }

    /// Axial force over N, from the row of the force y.
    fn axial_share(&self, y: &Rows, normal: &[f64; 6]) -> f64 {
        let (mut left, mut across) = (y[1], 0.0);
        for i in 0..6 {
            left -= self.h_n[i][1] * normal[i];
            across += self.h_a[i][1] * normal[i].max(0.0);
        }
        (left / across).clamp(-STEEPEST, STEEPEST)
    }

    /// Weighted least squares, linearised at the forces `normal`, N.
    #[inline(always)]
    fn fit(
        &self,
        y: &Rows,
        traction: &[f64; 6],
        normal: &[f64; 6],
        inputs: &InputCovariance,
    ) -> Result<Fit, WholeError> {
        let axial = self.axial_share(y, normal);
        // What an error of each input does to `f - H_T T - H_N N`.
        let mut effects = [Rows::zeros(); INPUTS];
        for (k, effect) in effects.iter_mut().enumerate() {
            *effect = match k {
                0..input::CONTACT_ANGLE => self.by_specific_force[k],
                input::CONTACT_ANGLE..input::TRACTION => {
                    let i = k - input::CONTACT_ANGLE;
                    -self.by_contact_angle(i, normal[i], traction[i])
                }
                _ => -self.h_t[k - input::TRACTION],
            };
        }
        // Covariances of the rows with the inputs, and of the rows.
        let mut with = [Rows::zeros(); INPUTS];
        let variance = |share: f64| (share * self.mean_load) * (share * self.mean_load);
        let mut c = SMatrix::<f64, ROWS, ROWS>::from_diagonal_element(variance(ROW));
        // The lever is twice the radius.
        c[(Self::YAW, Self::YAW)] += 6.0 * variance(0.5 * DRILLING);
        for (j, with) in with.iter_mut().enumerate() {
            for (i, effect) in effects.iter().enumerate() {
                with.axpy(inputs[(i, j)], effect, 1.0);
            }
            c.ger(1.0, with, &effects[j], 1.0);
        }
        for column in &self.h_a {
            c.ger(variance(AXIAL), column, column, 1.0);
        }
        let root_rows = root(&c).ok_or(WholeError::Singular)?;
        let columns =
            core::array::from_fn(|i| forward(&root_rows, &(self.h_n[i] + self.h_a[i] * axial)));
        let right = forward(&root_rows, y);
        let information = Matrix6::from_fn(|i, j| columns[i].dot(&columns[j]));
        let mut fit = Fit {
            axial,
            normal: [0.0; 6],
            root_normal: root(&information).ok_or(WholeError::Singular)?,
            right,
            columns,
            root_rows,
            with,
        };
        fit.normal = fit.solve(&right);
        Ok(fit)
    }
}

/// A weighted least squares. Rows over their root are white.
struct Fit {
    axial: f64,
    /// N.
    normal: [f64; 6],
    /// Root of the information of N.
    root_normal: [[f64; 6]; 6],
    /// White right-hand side and columns.
    right: Rows,
    columns: [Rows; 6],
    /// Root of the covariance of the rows.
    root_rows: [[f64; ROWS]; ROWS],
    /// Covariance of the rows with each input.
    with: [Rows; INPUTS],
}

impl Fit {
    /// N for white rows.
    fn solve(&self, white: &Rows) -> [f64; 6] {
        self.by_information(self.columns.map(|column| column.dot(white)))
    }

    /// The covariance of N times a vector.
    fn by_information(&self, vector: [f64; 6]) -> [f64; 6] {
        let half = forward(&self.root_normal, &Vector6::from(vector));
        backward(&self.root_normal, &half).into()
    }

    /// N with its covariances. `None` where a number is not finite.
    fn forces(&self) -> Option<WholeForces> {
        let mut left = self.right;
        for (column, n) in self.columns.iter().zip(self.normal) {
            left -= column * n;
        }
        let misfit = left.norm_squared();
        // Written so that a NaN fails too.
        if !(misfit < f64::INFINITY) {
            return None;
        }
        let unit = |k: usize| core::array::from_fn(|i| f64::from(u8::from(i == k)));
        let covariance = core::array::from_fn::<_, 6, _>(|k| self.by_information(unit(k)));
        let with = self
            .with
            .map(|column| self.solve(&forward(&self.root_rows, &column)));
        Some(WholeForces {
            normal: self.normal,
            covariance: covariance.into(),
            with_inputs: with.into(),
            axial: self.axial,
            misfit,
        })
    }
}
