//! The mass parameters that the static loads of eq. (8) depend on, and their covariance.
//!
//! Seven combinations of masses, centres of mass and pins determine the weight's part of eq. (8) in
//! every posture. With positions as complex numbers (x + iy, nominal pose), w_i the axles on link
//! k, u = S - P and kappa = (link3's centre of mass - R)/(S - R), where link 3 is replaced by
//! masses at R, at P and on the body (its loop closes):
//!
//! ```text
//! total mass      M  = sum of all masses
//! moment of link1 a1 = m1 (c1 - Q) + mw sum(w_i - Q) + mb (P - Q) + m3 kappa (P - Q)
//! moment of link2 a2 = m2 (c2 - Q) + mw sum(w_i - Q) + m3 (1 - kappa) (R - Q)
//! moment of body  ab = mb (cb - P) + m3 kappa u
//! ```
//!
//! The potential energy over g is M y_Q + Im(a1 e^(i theta_1) + a2 e^(i theta_2) + ab e^(i
//! theta_body)); its derivatives by y_Q, theta_1 and theta_2 are the rows of eq. (8). They are the
//! base parameters of the mechanism (Gautier and Khalil, "Direct calculation of minimum set of
//! inertial parameters of serial robots", IEEE Trans. Robotics and Automation 6, 1990): scales
//! under the wheels measure these, and not the single masses.

use super::arms::Arms;
use nalgebra::{Matrix4, SMatrix, SVector, Vector4};
use robhaz_model::{Bar, GRAVITY, Robot, Vec2};

/// Number of load parameters.
pub const LOAD_PARAMETERS: usize = 7;

/// Names and units of the load parameters, in their order.
pub const LOAD_PARAMETER_NAMES: [(&str, &str); LOAD_PARAMETERS] = [
    ("total mass", "kg"),
    ("moment of link1, x", "kg m"),
    ("moment of link1, y", "kg m"),
    ("moment of link2, x", "kg m"),
    ("moment of link2, y", "kg m"),
    ("moment of body, x", "kg m"),
    ("moment of body, y", "kg m"),
];

/// The load parameters of a robot, kg and kg m: `[M, a1.x, a1.y, a2.x, a2.y, ab.x, ab.y]`.
pub fn load_parameters(robot: &Robot) -> [f64; LOAD_PARAMETERS] {
    let (geometry, mass) = (&robot.geometry, &robot.mass);
    let pins = &geometry.pins;
    let (p, r) = (pins.p - pins.q, pins.r - pins.q);
    let (u, v) = (pins.s - pins.p, pins.s - pins.r);
    let product = |a: Vec2, b: Vec2| Vec2::new(a.x * b.x - a.y * b.y, a.x * b.y + a.y * b.x);
    let at3 = geometry.link_cg[2] - pins.r;
    let kappa = product(at3, Vec2::new(v.x, -v.y)) / v.norm_squared();
    let [m1, m2, m3] = mass.links;
    let mut links = [
        (geometry.link_cg[0] - pins.q) * m1 + p * mass.body + product(kappa, p) * m3,
        (geometry.link_cg[1] - pins.q) * m2 + (r - product(kappa, r)) * m3,
    ];
    let body = (geometry.body_cg - pins.p) * mass.body + product(kappa, u) * m3;
    for (axle, carrier) in geometry.axles.iter().zip(&geometry.carriers) {
        links[carrier.index()] += (axle - pins.q) * mass.wheel;
    }
    let [link1, link2] = links;
    [
        mass.total(),
        link1.x,
        link1.y,
        link2.x,
        link2.y,
        body.x,
        body.y,
    ]
}

/// Derivatives of the weight's part of eq. (8), `F'` (N), by the load parameters, for links at
/// `arms` and moment rows divided by `lever` (m): one column a parameter, N/kg and N/(kg m).
pub fn by_load_parameters(arms: &Arms, lever: f64) -> [Vector4<f64>; LOAD_PARAMETERS] {
    let [body, link1, link2, _] = arms.axes;
    // Rates of the body's angle by those of links 1 and 2.
    let of_body = |rates| arms.turning(rates, [0.0; 2]).rates[Bar::Body as usize];
    let (by1, by2) = (of_body([1.0, 0.0]), of_body([0.0, 1.0]));
    let g = GRAVITY / lever;
    let moments = |of1: f64, of2: f64| Vector4::new(0.0, 0.0, g * of1, g * of2);
    [
        Vector4::new(0.0, GRAVITY, 0.0, 0.0),
        moments(link1.x, 0.0),
        moments(-link1.y, 0.0),
        moments(0.0, link2.x),
        moments(0.0, -link2.y),
        moments(by1 * body.x, by2 * body.x),
        moments(-by1 * body.y, -by2 * body.y),
    ]
}

/// Covariance of the errors of the load parameters of a robot that was weighed, kg^2, kg^2 m, kg^2
/// m^2.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LoadCovariance(SMatrix<f64, LOAD_PARAMETERS, LOAD_PARAMETERS>);

/// Why numbers are no covariance.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LoadCovarianceError {
    /// A number is not finite, or a variance is negative. Numbers of row and column, from 1.
    Entry(usize, usize),
    /// The matrix is not symmetric. Numbers of row and column, from 1.
    Asymmetric(usize, usize),
    /// A combination of the parameters would have a negative variance.
    Indefinite,
}

impl core::fmt::Display for LoadCovarianceError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Entry(i, j) => write!(
                f,
                "row {i}, column {j} is not a finite number, or a variance below 0"
            ),
            Self::Asymmetric(i, j) => {
                write!(f, "row {i}, column {j} differs from row {j}, column {i}")
            }
            Self::Indefinite => write!(f, "a combination of rows has a variance below 0"),
        }
    }
}

impl core::error::Error for LoadCovarianceError {}

/// Largest relative rounding error of a written covariance.
/// Definition.
const ROUNDING: f64 = 1e-9;

impl LoadCovariance {
    /// Takes rows of numbers for a covariance.
    ///
    /// # Errors
    /// [`LoadCovarianceError`] where they are none: not finite, not symmetric, not positive
    /// semidefinite; each within rounding.
    pub fn new(
        rows: &[[f64; LOAD_PARAMETERS]; LOAD_PARAMETERS],
    ) -> Result<Self, LoadCovarianceError> {
        let matrix = SMatrix::from_fn(|i, j| rows[i][j]);
        // Of parameters in units of their own standard deviations.
        let mut scaled = SMatrix::<f64, LOAD_PARAMETERS, LOAD_PARAMETERS>::identity();
        for i in 0..LOAD_PARAMETERS {
            for j in 0..LOAD_PARAMETERS {
                let (entry, scale) = (matrix[(i, j)], matrix[(i, i)] * matrix[(j, j)]);
                if !(entry.is_finite() && matrix[(i, i)] >= 0.0) {
                    return Err(LoadCovarianceError::Entry(i + 1, j + 1));
                }
                let size = robhaz_model::sqrt(scale.max(0.0));
                if !(libm::fabs(entry - matrix[(j, i)]) <= ROUNDING * size) {
                    return Err(LoadCovarianceError::Asymmetric(i + 1, j + 1));
                }
                if size > 0.0 {
                    scaled[(i, j)] = entry / size;
                } else if entry != 0.0 {
                    return Err(LoadCovarianceError::Indefinite);
                }
            }
            scaled[(i, i)] += ROUNDING;
        }
        if scaled.cholesky().is_none() {
            return Err(LoadCovarianceError::Indefinite);
        }
        Ok(Self(matrix))
    }

    /// The covariance, row by row, in the order of [`LOAD_PARAMETER_NAMES`].
    pub fn rows(&self) -> [[f64; LOAD_PARAMETERS]; LOAD_PARAMETERS] {
        core::array::from_fn(|i| core::array::from_fn(|j| self.0[(i, j)]))
    }

    /// The same covariance of parameters in these units (kg, kg m) in place of SI.
    pub(crate) fn in_units(&self, units: &[f64; LOAD_PARAMETERS]) -> Self {
        Self(SMatrix::from_fn(|i, j| {
            self.0[(i, j)] / (units[i] * units[j])
        }))
    }

    /// Covariance of the loads in the rows of eq. (8), N^2, for links at `arms` and moment rows
    /// divided by `lever`, m.
    pub fn of_loads(&self, arms: &Arms, lever: f64) -> Matrix4<f64> {
        self.of_columns(&by_load_parameters(arms, lever))
    }

    /// Covariance of values with these derivatives by the load parameters.
    pub(crate) fn of_columns<const N: usize>(
        &self,
        columns: &[SVector<f64, N>; LOAD_PARAMETERS],
    ) -> SMatrix<f64, N, N> {
        let j = SMatrix::<f64, N, LOAD_PARAMETERS>::from_columns(columns);
        let covariance = j * self.0 * j.transpose();
        // Symmetric to the last bit.
        (covariance + covariance.transpose()) * 0.5
    }

    /// Variance of the moment of a side's weight along the way about Q, over gravity, kg^2 m^2: of a
    /// linkage in its nominal pose.
    pub(crate) fn of_moment_along(&self) -> f64 {
        let along = SVector::from([0.0, 1.0, 0.0, 1.0, 0.0, 1.0, 0.0]);
        along.dot(&(self.0 * along)).max(0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::statics::{Equilibrium, Loads};
    use crate::testing::{arms, geometry};
    use proptest::prelude::*;

    proptest! {
        /// Equivalence: the columns times the parameters are the weight's part of eq. (8), for any
        /// posture, masses and centres of mass. So the seven parameters determine the loads, and
        /// their derivatives are the columns.
        #[test]
        fn seven_parameters_determine_the_loads(
            theta2 in -0.4_f64..0.4, opening in -0.6_f64..0.5, is_b in any::<bool>(),
            masses in prop::array::uniform5(0.1_f64..8.0), moved in prop::array::uniform8(-0.1_f64..0.1),
        ) {
            let mut robot = Robot { geometry: geometry(is_b), ..Robot::default_a() };
            let [body, m1, m2, m3, wheel] = masses;
            (robot.mass.body, robot.mass.links, robot.mass.wheel) = (body, [m1, m2, m3], wheel);
            let [x, y, x1, y1, x2, y2, x3, y3] = moved;
            robot.geometry.body_cg += Vec2::new(x, y);
            for (cg, by) in robot.geometry.link_cg.iter_mut().zip([(x1, y1), (x2, y2), (x3, y3)]) {
                *cg += Vec2::new(by.0, by.1);
            }
            let arms = arms(&robot.geometry, [theta2 + opening, theta2]);
            let loads = Loads::at_rest(&robot.mass.true_points());
            let (expected, _) = Equilibrium::load_side(&arms, &robot.geometry.carriers, &loads, 0.2);
            let columns = by_load_parameters(&arms, 0.2);
            let parameters = load_parameters(&robot);
            let found: Vector4<f64> = columns.iter().zip(parameters).map(|(c, p)| c * p).sum();
            // Rounding of forces of 200 N.
            prop_assert!((found - expected).norm() < 1e-9, "{found} {expected}");
        }
    }

    #[test]
    fn what_is_no_covariance_is_refused() {
        let mut rows = [[0.0; LOAD_PARAMETERS]; LOAD_PARAMETERS];
        assert!(LoadCovariance::new(&rows).is_ok());
        for (i, row) in rows.iter_mut().enumerate() {
            row[i] = 1e-4;
        }
        let sound = LoadCovariance::new(&rows).expect("diagonal");
        assert_eq!(sound.rows(), rows);
        let changed = |i: usize, j: usize, value: f64| {
            let mut rows = rows;
            rows[i][j] = value;
            LoadCovariance::new(&rows)
        };
        use LoadCovarianceError::{Asymmetric, Entry, Indefinite};
        assert_eq!(changed(2, 2, -1.0), Err(Entry(3, 1)));
        assert_eq!(changed(2, 3, f64::NAN), Err(Entry(3, 4)));
        assert_eq!(changed(0, 3, 1e-5), Err(Asymmetric(1, 4)));
        (rows[0][1], rows[1][0]) = (2e-4, 2e-4);
        assert_eq!(LoadCovariance::new(&rows), Err(Indefinite));
    }
}
