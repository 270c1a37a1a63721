//! Least squares for the unknowns, with the nominal values as prior: Gauss and Newton.
//!
//! Unknowns x are errors of the nominal values, of the two inclination offsets, and of gain and zero
//! of three scales, each over its prior standard deviation. With residuals r of the readings of covariance R and J = dh/dx the sum
//! r' R^-1 r + x' x is minimised; the covariance of x is (I + sum J' R^-1 J)^-1. A reading's
//! covariance R holds the scale's error, and the errors of inclinations and horizontal forces
//! carried through the statics.

use crate::error::{Result, WeighError};
use crate::loads::{self, ForceDeviation, WeighedValue};
use crate::measurements::{Accuracy, Measurements, Reading};
use crate::parameters::{CENTRES, Covariance, PARAMETERS, Tolerances, names, values};
use crate::prior::{Predicted, Prior, UNKNOWNS, Unknowns};
use nalgebra::{Cholesky, Const, SMatrix, Vector3};
use robhaz_estimator::statics::LoadCovariance;
use robhaz_model::{GRAVITY, Robot};

/// Most steps of Gauss and Newton; a few are enough for errors of nominal values.
const MOST_STEPS: usize = 30;
/// A step below this, in prior standard deviations, ends the iteration.
const CONVERGED: f64 = 1e-6;
/// The misfit is refused beyond this many standard deviations of its chi-squared distribution.
const MISFIT_LIMIT: f64 = 4.0;

pub(crate) type Information = SMatrix<f64, UNKNOWNS, UNKNOWNS>;

/// The part of a covariance of all unknowns that is of the robot.
pub(crate) fn of_robot(covariance: &Information) -> Covariance {
    covariance.fixed_view::<PARAMETERS, PARAMETERS>(0, 0).into()
}

fn cholesky(information: Information) -> Result<Cholesky<f64, Const<UNKNOWNS>>> {
    information.cholesky().ok_or_else(WeighError::not_converged)
}

/// A robot that was weighed.
#[derive(Clone, Debug, PartialEq)]
pub struct Weighed {
    /// Its masses, centres of mass and pins: the most probable ones for nominal values and scales
    /// together.
    pub robot: Robot,
    /// These one by one: five masses, four centres of mass, four pins.
    pub values: Vec<WeighedValue>,
    /// Offsets of the inclinations of links 1 and 2 and their standard deviation, rad.
    pub inclination_offsets: [(f64, f64); 2],
    /// The seven parameters that forces depend on.
    pub loads: Vec<WeighedValue>,
    /// Covariance of their errors, for the estimators' budget.
    pub covariance: LoadCovariance,
    /// Error of the normal forces that masses, centres of mass and pins cause on a driven ground.
    pub forces: ForceDeviation,
    /// How the readings fit the robot.
    pub misfit: Misfit,
}

/// Weighted squares of what the readings and the nominal values were changed by.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Misfit {
    /// The sum; distributed as chi-squared with `readings` degrees of freedom if the stated errors
    /// hold.
    pub sum: f64,
    /// Number of readings of scales.
    pub readings: usize,
}

/// Normal equations of Gauss and Newton: the information of the readings about the unknowns.
pub(crate) struct Normal {
    pub information: Information,
    right: Unknowns,
    sum: f64,
}

impl Normal {
    /// The prior alone.
    pub fn prior(unknowns: &Unknowns) -> Self {
        Self {
            information: Information::identity(),
            right: -unknowns,
            sum: unknowns.norm_squared(),
        }
    }

    /// Adds the readings of a posture, N. Wheels without a scale do not count. `None` if the
    /// covariance is singular.
    pub fn add(
        &mut self,
        predicted: &Predicted,
        forces: &[Option<f64>; 3],
    ) -> Option<Vector3<f64>> {
        let (mut covariance, mut by) = (predicted.covariance, predicted.by_unknowns);
        let mut residual = Vector3::zeros();
        for i in 0..3 {
            match forces[i] {
                Some(force) => residual[i] = force - predicted.forces[i],
                None => {
                    covariance.fill_row(i, 0.0);
                    covariance.fill_column(i, 0.0);
                    covariance[(i, i)] = 1.0;
                    by.fill_row(i, 0.0);
                }
            }
        }
        let weight = covariance.cholesky()?.inverse();
        self.information += by.transpose() * weight * by;
        self.right += by.transpose() * (weight * residual);
        self.sum += residual.dot(&(weight * residual));
        Some(residual)
    }
}

/// Masses, centres of mass and pins from readings of scales, with the nominal values as prior.
///
/// # Errors
/// [`WeighError`]: impossible postures, readings that do not fit, impossible results. It says what the scales show and
/// what they would of the nominal robot.
pub fn weigh(
    nominal: &Robot,
    measurements: &Measurements,
    tolerances: &Tolerances,
    accuracy: &Accuracy,
) -> Result<Weighed> {
    if measurements.count() == 0 {
        let message = "there is no reading of a scale; allowed: at least one";
        return Err(WeighError::new(message));
    }
    check_stops(nominal, &measurements.readings)?;
    let prior = Prior::new(nominal, tolerances, accuracy)?;
    fitted(&prior, measurements).map_err(|error| match expected(&prior, measurements) {
        Some(expected) => WeighError::new(format!("{error}; {expected}")),
        None => error,
    })
}

/// What the scales show in the mean, against what they would of the nominal robot; `None` without readings.
fn expected(prior: &Prior<'_>, measurements: &Measurements) -> Option<String> {
    let of_side = prior.nominal.mass.total() * GRAVITY;
    if let Some(weight) = measurements
        .weight
        .filter(|weight| is_other_mass(weight / of_side))
    {
        return Some(format!(
            "weight is {weight:.1} N, {:.2} times the {of_side:.1} N of one side by the robot file: state that of one side, with its unit",
            weight / of_side
        ));
    }
    let mut sums = [[0.0; 3]; 3];
    for reading in &measurements.readings {
        let predicted = prior.predict(&Unknowns::zeros(), reading.inclinations);
        let predicted = predicted.ok()?.forces;
        for (i, force) in reading.forces.iter().enumerate() {
            let Some(force) = force else { continue };
            sums[i] = [
                sums[i][0] + force,
                sums[i][1] + predicted[i],
                sums[i][2] + 1.0,
            ];
        }
    }
    // Each wheel has the mean over its own readings.
    let mean = |k: usize| {
        let wheels = sums.iter().filter(|sums| sums[2] > 0.0);
        wheels.map(|sums| sums[k] / sums[2]).collect::<Vec<f64>>()
    };
    let (found, nominal) = (mean(0), mean(1));
    let ratio = found.iter().sum::<f64>() / nominal.iter().sum::<f64>();
    let words = |forces: &[f64]| {
        let forces: Vec<String> = forces.iter().map(|force| format!("{force:.1}")).collect();
        forces.join(", ")
    };
    let check = match is_other_mass(ratio) {
        true => CHECK_UNITS,
        false => ": check the order of the wheels, and each reading",
    };
    ratio.is_finite().then(|| {
        format!(
            "the wheels' scales show {} N in the mean, {ratio:.2} times the {} N of the robot file{check}",
            words(&found),
            words(&nominal)
        )
    })
}

/// What to do about forces that show another mass.
pub const CHECK_UNITS: &str =
    ": check the unit of the forces, and, of sums of both sides, that they are halved";

/// Whether a ratio of masses is beyond what a payload or a missing battery explains.
pub fn is_other_mass(ratio: f64) -> bool {
    !(2.0 / 3.0..1.5).contains(&ratio)
}

fn fitted(prior: &Prior<'_>, measurements: &Measurements) -> Result<Weighed> {
    let mut unknowns = Unknowns::zeros();
    for _ in 0..MOST_STEPS {
        let (normal, _) = normal_equations(prior, measurements, &unknowns)?;
        let step = cholesky(normal.information)?.solve(&normal.right);
        unknowns += step;
        if !unknowns.iter().all(|x| x.is_finite()) {
            return Err(WeighError::not_converged());
        }
        if step.amax() < CONVERGED {
            let (normal, residuals) = normal_equations(prior, measurements, &unknowns)?;
            return finish(prior, measurements, &unknowns, &normal, &residuals);
        }
    }
    Err(WeighError::not_converged())
}

fn check_stops(nominal: &Robot, readings: &[Reading]) -> Result<()> {
    /// The stops are elastic, and inclinations have errors, rad.
    const SLACK: f64 = 0.01;
    let stop = &nominal.geometry.stop;
    for reading in readings {
        let opening = reading.inclinations[0] - reading.inclinations[1];
        if !(opening > stop.lower - SLACK && opening < stop.upper + SLACK) {
            let [found, lower, upper] = [opening, stop.lower, stop.upper].map(f64::to_degrees);
            return Err(WeighError::new(format!(
                "line {}: theta_1 - theta_2 is {found:.1} deg, beyond the end stops of pin Q; allowed: {lower:.1} to {upper:.1} deg; \
                 check signs and units",
                reading.line
            )));
        }
    }
    Ok(())
}

/// A reading of a scale: its name, its residual (measured minus fitted, N) and the standard deviation of that, N.
pub(crate) type Residual = (String, f64, f64);

/// The name of a wheel's reading (from 0).
pub(crate) fn of_wheel(i: usize, line: u64) -> String {
    format!("wheel{} in line {line}", i + 1)
}

/// The normal equations at `unknowns`, and the residuals.
fn normal_equations(
    prior: &Prior<'_>,
    measurements: &Measurements,
    unknowns: &Unknowns,
) -> Result<(Normal, Vec<Residual>)> {
    let mut normal = Normal::prior(unknowns);
    let mut residuals = Vec::new();
    for reading in &measurements.readings {
        let predicted = prior.predict(unknowns, reading.inclinations);
        let line = reading.line;
        let predicted = predicted.map_err(|error| {
            WeighError::new(format!(
                "line {line}: {error}; check the inclinations and the robot's pins"
            ))
        })?;
        let residual = normal.add(&predicted, &reading.forces);
        let residual = residual.ok_or_else(WeighError::not_converged)?;
        for i in (0..3).filter(|i| reading.forces[*i].is_some()) {
            let sigma = predicted.covariance[(i, i)].sqrt();
            residuals.push((of_wheel(i, line), residual[i], sigma));
        }
    }
    if let Some(weight) = measurements.weight {
        let mut by = Unknowns::zeros();
        for (i, parts) in [1.0, 1.0, 1.0, 1.0, 3.0].into_iter().enumerate() {
            by[i] = GRAVITY * parts * prior.deviations[i];
        }
        let residual = weight - prior.robot(unknowns).mass.total() * GRAVITY;
        // It has a scale of its own.
        let accuracy = &prior.accuracy;
        let variance = accuracy.scale.powi(2) + accuracy.of_constant(weight);
        residuals.push(("weight".to_owned(), residual, variance.sqrt()));
        let weight = variance.recip();
        normal.information += by * by.transpose() * weight;
        normal.right += by * (residual * weight);
        normal.sum += residual * residual * weight;
    }
    Ok((normal, residuals))
}

fn finish(
    prior: &Prior<'_>,
    measurements: &Measurements,
    unknowns: &Unknowns,
    normal: &Normal,
    residuals: &[Residual],
) -> Result<Weighed> {
    let misfit = misfit(measurements.count(), normal.sum, residuals)?;
    let robot = prior.robot(unknowns);
    check_robot(&robot).map_err(|reason| {
        WeighError::new(format!(
            "the readings lead to an impossible robot: {reason}"
        ))
    })?;
    let covariance = cholesky(normal.information)?.inverse();
    let part = of_robot(&covariance);
    let after = loads::Deviations::new(prior, &robot, &part)?;
    let before = loads::Deviations::new(prior, &robot, &SMatrix::identity())?;
    let found = values(&robot);
    let value = |(i, name): (usize, String)| WeighedValue {
        name,
        unit: if i < CENTRES { "kg" } else { "m" },
        drawn: prior.values[i],
        found: found[i],
        prior: prior.deviations[i],
        deviation: prior.deviations[i] * part[(i, i)].sqrt(),
    };
    let offset = prior.accuracy.inclination_offset;
    Ok(Weighed {
        // Without those that the robot has not.
        values: (names().enumerate().map(value))
            .filter(|value| value.prior > 0.0)
            .collect(),
        inclination_offsets: [PARAMETERS, PARAMETERS + 1]
            .map(|i| (offset * unknowns[i], offset * covariance[(i, i)].sqrt())),
        loads: loads::compare(prior.nominal, &robot, &before, &after),
        covariance: after.covariance,
        forces: ForceDeviation {
            before: before.force,
            after: after.force,
        },
        misfit,
        robot,
    })
}

/// Whether the robot can exist and stand; else why not.
fn check_robot(robot: &Robot) -> Result<(), String> {
    robot.geometry.check().map_err(|e| e.to_string())?;
    robot.mass.check().map_err(|e| e.to_string())?;
    robot.check_stance().map_err(|e| e.to_string())
}

/// Whether the readings fit.
pub(crate) fn misfit(readings: usize, sum: f64, residuals: &[Residual]) -> Result<Misfit> {
    // Wilson and Hilferty: the cube root of chi-squared over its degrees of freedom is nearly
    // Gaussian.
    let n = readings as f64;
    let variance = 2.0 / (9.0 * n);
    let most = n * (1.0 - variance + MISFIT_LIMIT * variance.sqrt()).powi(3);
    if sum > most {
        // The first of equal ones.
        let size = |(_, residual, sigma): &Residual| (residual / sigma).abs();
        let worst = residuals.iter().min_by(|a, b| size(b).total_cmp(&size(a)));
        let worst = worst.map_or(String::new(), |(name, residual, sigma)| {
            format!(
                "; the worst reading is that of {name}: {residual:+.2} N beside the fit, its error is stated as \
                 {sigma:.2} N; check this scale, and the order of wheels, signs and units"
            )
        });
        return Err(WeighError::new(format!(
            "the readings do not fit a robot within the stated errors: the weighted sum of squares is {sum:.1}, allowed: at most \
             {most:.1} for {readings} readings{worst}"
        )));
    }
    Ok(Misfit { sum, readings })
}
