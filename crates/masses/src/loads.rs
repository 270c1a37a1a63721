//! The covariance of a weighing in the seven load parameters, and what it means for the normal
//! forces.
//!
//! Masses and centres of mass act through the load parameters alone. Pins also act through the
//! body's angle and through the arms of the wheels about Q; their effect on the balance of eq. (8),
//! `F' - H_N N`, is projected on the load parameters by least squares over the postures of a drive
//! at rest.

use crate::error::{Result, WeighError};
use crate::measurements::Accuracy;
use crate::parameters::{
    CENTRES, Covariance, PARAMETERS, Tolerances, Values, WHEEL, values, with_values,
};
use crate::prior::{Prior, derivatives};
use crate::statics::{imbalance, plate_forces};
use nalgebra::{SMatrix, SVector};
use robhaz_estimator::statics::{
    Arms, LOAD_PARAMETER_NAMES, LOAD_PARAMETERS, LoadCovariance, by_load_parameters,
    load_parameters,
};
use robhaz_model::{GRAVITY, Robot};

/// A value before and after weighing.
#[derive(Clone, Debug, PartialEq)]
pub struct WeighedValue {
    /// In words.
    pub name: String,
    /// `kg`, `m` or `kg m`.
    pub unit: &'static str,
    /// Nominal, in its unit.
    pub drawn: f64,
    /// Now: the most probable one for nominal values and scales together.
    pub found: f64,
    /// Standard deviation by the tolerances alone.
    pub prior: f64,
    /// Standard deviation now.
    pub deviation: f64,
}

/// Standard deviation of a normal force by errors of masses, centres of mass and pins: RMS over
/// wheels and over the postures of a drive, N, at the robot's gravity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ForceDeviation {
    /// By the tolerances alone.
    pub before: f64,
    /// After weighing.
    pub after: f64,
}

/// Moment rows over this length count as forces, m.
const LEVER: f64 = 0.2;
/// Singular values below this part of the largest one are 0: those of a four-bar are 1e-4 of it and
/// more, rounding leaves 1e-16.
const RANK: f64 = 1e-10;
/// Step of the differences, in prior standard deviations.
const DIFFERENCE: f64 = 1e-3;

/// Angles of links 1 and 2 on a driven ground, rad: theta_2 within 0.2 rad, theta_1 - theta_2
/// within 0.3 rad or within 0.8 of the way to the stops.
pub(crate) fn drive_postures(robot: &Robot) -> Vec<[f64; 2]> {
    let stop = &robot.geometry.stop;
    let (lower, upper) = ((0.8 * stop.lower).max(-0.3), (0.8 * stop.upper).min(0.3));
    let openings = [lower, 0.5 * lower, 0.0, 0.5 * upper, upper];
    let postures = |theta2: f64| openings.map(|opening| [theta2 + opening, theta2]);
    [-0.2, 0.0, 0.2].map(postures).concat()
}

type ByParameters<const ROWS: usize> = SMatrix<f64, ROWS, PARAMETERS>;

/// Standard deviations for a covariance of the unknowns over their prior deviations.
pub(crate) struct Deviations {
    pub covariance: LoadCovariance,
    /// Of the load parameters themselves. In [`Self::covariance`] they also stand for what pins
    /// change beside them.
    parameters: [f64; LOAD_PARAMETERS],
    /// See [`ForceDeviation`].
    pub force: f64,
}

impl Deviations {
    pub fn new(prior: &Prior<'_>, robot: &Robot, covariance: &Covariance) -> Result<Self> {
        let projection = projection(prior, robot).map_err(WeighError::of_nominal)?;
        let by_unknowns = forces_by_unknowns(prior, robot).map_err(WeighError::of_nominal)?;
        let of_loads = projection * covariance * projection.transpose();
        let of_loads = (of_loads + of_loads.transpose()) * 0.5;
        let rows = std::array::from_fn(|i| std::array::from_fn(|j| of_loads[(i, j)]));
        let by = by_parameters(prior, robot, |robot| Ok(load_parameters(robot).into()));
        let by = by.map_err(WeighError::of_nominal)?;
        let own: SMatrix<f64, LOAD_PARAMETERS, LOAD_PARAMETERS> = by * covariance * by.transpose();
        Ok(Self {
            parameters: std::array::from_fn(|i| own[(i, i)].sqrt()),
            // A product A P A' is a covariance.
            covariance: LoadCovariance::new(&rows).map_err(|_| WeighError::not_converged())?,
            force: mean_variance(&by_unknowns, covariance).sqrt(),
        })
    }
}

impl Tolerances {
    /// Covariance of the loads of a robot that errs from its nominal values by these tolerances and
    /// was put on scales as a whole: its mass is known to [`Self::TOTAL`], where it is from the
    /// parts.
    ///
    /// # Errors
    /// [`WeighError`] where a tolerance is not above 0, or the robot cannot stand in the postures
    /// of a drive.
    pub fn loads(&self, nominal: &Robot) -> Result<LoadCovariance> {
        let prior = Prior::new(nominal, self, &Accuracy::TYPICAL)?;
        let mut covariance = Covariance::identity();
        // The sum of the masses' errors, as a combination of the unknowns.
        let mut sum = Values::zeros();
        for i in 0..CENTRES {
            let count = if i == WHEEL { 3.0 } else { 1.0 };
            sum[i] = count * prior.deviations[i];
        }
        let (known, parts) = (Self::TOTAL * nominal.mass.total(), sum.norm_squared());
        if parts > known * known {
            covariance += sum * sum.transpose() * ((known * known - parts) / (parts * parts));
        }
        Ok(Deviations::new(&prior, nominal, &covariance)?.covariance)
    }
}

/// Derivatives of a function of the robot by the unknowns over their prior deviations, about
/// `robot`.
fn by_parameters<const ROWS: usize>(
    prior: &Prior<'_>,
    robot: &Robot,
    of: impl Fn(&Robot) -> Result<SVector<f64, ROWS>>,
) -> Result<ByParameters<ROWS>> {
    let values = values(robot);
    derivatives(DIFFERENCE, |change: &Values| {
        let there = values + change.component_mul(&prior.deviations);
        of(&with_values(robot, &there))
    })
}

/// The load parameters' change for a change of each unknown: exact for masses and centres of mass,
/// for pins the least squares over the drive's postures.
fn projection(prior: &Prior<'_>, robot: &Robot) -> Result<ByParameters<LOAD_PARAMETERS>> {
    let mut normal = SMatrix::<f64, LOAD_PARAMETERS, LOAD_PARAMETERS>::zeros();
    let mut right = ByParameters::<LOAD_PARAMETERS>::zeros();
    for angles in drive_postures(robot) {
        let arms = Arms::new(&robot.geometry, angles[0], angles[1])?;
        let columns = by_load_parameters(&arms, LEVER);
        let by_loads = SMatrix::<f64, 4, LOAD_PARAMETERS>::from_columns(&columns);
        let forces = plate_forces(robot, angles, [0.0; 3])?;
        let of = |robot: &Robot| imbalance(robot, angles, &forces, LEVER);
        let by_unknowns = by_parameters(prior, robot, of)?;
        normal += by_loads.transpose() * by_loads;
        right += by_loads.transpose() * by_unknowns;
    }
    // Body and links that turn alike have the same columns: of a bogie, or of a link in line with
    // Q.
    let svd = normal.svd(true, true);
    let least = RANK * svd.singular_values[0];
    let found = svd.solve(&right, least);
    found.map_err(|_| WeighError::undetermined())
}

/// Derivatives of the normal forces in the drive's postures by the unknowns over their prior
/// deviations, at the robot's gravity.
pub(crate) fn forces_by_unknowns(prior: &Prior<'_>, robot: &Robot) -> Result<Vec<ByParameters<3>>> {
    // The statics are those of the place of weighing, with 9.81 m/s^2.
    let share = robot.gravity / GRAVITY;
    let of = |angles| {
        move |robot: &Robot| {
            let forces = plate_forces(robot, angles, [0.0; 3])?;
            Ok(forces.map(|force| share * force).into())
        }
    };
    let at = |angles| by_parameters(prior, robot, of(angles));
    drive_postures(robot).into_iter().map(at).collect()
}

/// The mean over wheels and postures of the variances that a covariance of the unknowns causes.
pub(crate) fn mean_variance(forces: &[ByParameters<3>], covariance: &Covariance) -> f64 {
    let variance = |by: &ByParameters<3>| (by * covariance * by.transpose()).trace();
    let variances = forces.iter().map(variance);
    variances.sum::<f64>() / (3 * forces.len()) as f64
}

/// The load parameters before and after.
pub(crate) fn compare(
    nominal: &Robot,
    robot: &Robot,
    before: &Deviations,
    after: &Deviations,
) -> Vec<WeighedValue> {
    let (drawn, found) = (load_parameters(nominal), load_parameters(robot));
    let names = LOAD_PARAMETER_NAMES.iter().enumerate();
    names
        .map(|(i, (name, unit))| WeighedValue {
            name: (*name).to_owned(),
            unit,
            drawn: drawn[i],
            found: found[i],
            prior: before.parameters[i],
            deviation: after.parameters[i],
        })
        .collect()
}
