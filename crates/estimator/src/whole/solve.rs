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
/// The weights need N, and N the weights. Guard.
const PASSES: usize = 2;

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
        // On a plane, however it is tilted, the axial forces that equal loads give are exact.
        let mut normal = [self.mean_load; 6];
        let mut found = Err(WholeError::Singular);
        for _ in 0..PASSES {
            let forces = self.pass(&y, traction, &normal, inputs)?;
            normal = forces.normal;
            found = Ok(forces);
        }
        found
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

    /// One weighted least squares, linearised at the forces `normal`, N.
    fn pass(
        &self,
        y: &Rows,
        traction: &[f64; 6],
        normal: &[f64; 6],
        inputs: &InputCovariance,
    ) -> Result<WholeForces, WholeError> {
        let axial = self.axial_share(y, normal);
        // What an error of each input does to `f - H_T T - H_N N`.
        let mut effects = [Rows::zeros(); INPUTS];
        let (forces, others) = effects.split_at_mut(input::CONTACT_ANGLE);
        forces.copy_from_slice(&self.by_specific_force);
        for (i, effect) in others.iter_mut().enumerate() {
            *effect = if i < 6 {
                -self.by_contact_angle(i, normal[i], traction[i])
            } else {
                -self.h_t[i - 6]
            };
        }
        // Covariances of the rows with the inputs.
        let mut with = [Rows::zeros(); INPUTS];
        let variance = |share: f64| (share * self.mean_load) * (share * self.mean_load);
        let mut c = SMatrix::<f64, ROWS, ROWS>::identity() * variance(ROW);
        for (j, with) in with.iter_mut().enumerate() {
            for (i, effect) in effects.iter().enumerate() {
                *with += effect * inputs[(i, j)];
            }
            c += *with * effects[j].transpose();
        }
        for column in &self.h_a {
            c += column * column.transpose() * variance(AXIAL);
        }
        // The lever is twice the radius.
        c[(Self::YAW, Self::YAW)] += 6.0 * variance(0.5 * DRILLING);

        let l = root(&c).ok_or(WholeError::Singular)?;
        let white: [Rows; 6] =
            core::array::from_fn(|i| forward(&l, &(self.h_n[i] + self.h_a[i] * axial)));
        let white_y = forward(&l, y);
        let information = Matrix6::from_fn(|i, j| white[i].dot(&white[j]));
        let l_n = root(&information).ok_or(WholeError::Singular)?;
        let solved = |right: [f64; 6]| backward(&l_n, &forward(&l_n, &Vector6::from(right)));
        let covariance = Matrix6::from_columns(&core::array::from_fn::<_, 6, _>(|j| {
            let mut unit = [0.0; 6];
            unit[j] = 1.0;
            solved(unit)
        }));
        let found = solved(white.map(|column| column.dot(&white_y)));
        let mut left = white_y;
        for (column, n) in white.iter().zip(found.iter()) {
            left -= column * *n;
        }
        let with_inputs = SMatrix::from_columns(&with.map(|column| {
            let column = forward(&l, &column);
            solved(white.map(|of| of.dot(&column)))
        }));
        if !left.norm_squared().is_finite() {
            return Err(WholeError::Singular);
        }
        Ok(WholeForces {
            normal: found.into(),
            covariance,
            with_inputs,
            axial,
            misfit: left.norm_squared(),
        })
    }
}
