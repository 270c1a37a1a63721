//! What is known before the readings, and the forces that it predicts.

use crate::error::{Result, WeighError};
use crate::measurements::Accuracy;
use crate::parameters::{PARAMETERS, Tolerances, Values, values, with_values};
use crate::statics::plate_forces;
use nalgebra::{Matrix3, SMatrix, SVector, Vector2, Vector3};
use robhaz_model::Robot;

/// Number of unknowns with the two offsets of inclinations, and gain and zero of three scales.
pub(crate) const UNKNOWNS: usize = SCALES + 6;
const SCALES: usize = PARAMETERS + 2;
/// Step of the differences, in prior standard deviations: at most 0.1 mm.
const DIFFERENCE: f64 = 1e-2;

/// Errors of nominal values, inclination offsets and scales, over their prior standard deviations.
pub(crate) type Unknowns = SVector<f64, UNKNOWNS>;

/// Forces of one posture and their derivatives by the unknowns, over the wheels.
pub(crate) struct Predicted {
    /// Normal forces as the scales show them, N.
    pub forces: Vector3<f64>,
    /// By the unknowns, N a prior standard deviation.
    pub by_unknowns: SMatrix<f64, 3, UNKNOWNS>,
    /// Covariance of the readings of three scales, N^2.
    pub covariance: Matrix3<f64>,
}

/// Derivatives at 0 of a function of several changes, by differences of two steps.
pub(crate) fn derivatives<const OF: usize, const BY: usize>(
    step: f64,
    of: impl Fn(&SVector<f64, BY>) -> Result<SVector<f64, OF>>,
) -> Result<SMatrix<f64, OF, BY>> {
    let mut found = SMatrix::<f64, OF, BY>::zeros();
    for i in 0..BY {
        let mut change = SVector::zeros();
        change[i] = step;
        found.set_column(i, &((of(&change)? - of(&-change)?) / (2.0 * step)));
    }
    Ok(found)
}

/// Drawings, tolerances and accuracy: what is known before the readings.
pub(crate) struct Prior<'a> {
    pub nominal: &'a Robot,
    pub values: Values,
    pub deviations: Values,
    pub accuracy: Accuracy,
}

impl<'a> Prior<'a> {
    pub fn new(nominal: &'a Robot, tolerances: &Tolerances, accuracy: &Accuracy) -> Result<Self> {
        let check = |name: &str, found: f64, allowed: &str, is_allowed: bool| match is_allowed {
            true => Ok(()),
            false => Err(WeighError::new(format!(
                "the {name} is {found}; allowed: {allowed}"
            ))),
        };
        let Tolerances { mass, centre, pin } = *tolerances;
        for (name, found, most, allowed) in [
            ("tolerance of masses", mass, 1.0, "1"),
            ("tolerance of centres of mass", centre, 1.0, "1"),
            ("tolerance of pins", pin, 1.0, "1"),
            ("error of scales", accuracy.scale, 1e3, "1000 N"),
        ] {
            let allowed = format!("above 0 and at most {allowed}");
            check(name, found, &allowed, found > 0.0 && found <= most)?;
        }
        for (name, found) in [
            ("offset of inclinations", accuracy.inclination_offset),
            ("error of inclinations", accuracy.inclination),
            ("horizontal force", accuracy.horizontal_force),
            ("zero error of scales", accuracy.scale_zero),
        ] {
            let allowed = "at least 0 and at most 1000";
            check(name, found, allowed, (0.0..=1e3).contains(&found))?;
        }
        let (gain, allowed) = (accuracy.scale_gain, "at least 0 and at most 0.5");
        check(
            "relative error of scales",
            gain,
            allowed,
            (0.0..=0.5).contains(&gain),
        )?;
        Ok(Self {
            nominal,
            values: values(nominal),
            deviations: tolerances.deviations(nominal),
            accuracy: *accuracy,
        })
    }

    /// The robot for values of the unknowns.
    pub fn robot(&self, unknowns: &Unknowns) -> Robot {
        let errors = unknowns.fixed_rows::<PARAMETERS>(0);
        let values = self.values + errors.component_mul(&self.deviations);
        with_values(self.nominal, &values)
    }

    fn forces(&self, unknowns: &Unknowns, inclinations: [f64; 2]) -> Result<Vector3<f64>> {
        let offset = self.accuracy.inclination_offset;
        let angles = [0, 1].map(|i| inclinations[i] - offset * unknowns[PARAMETERS + i]);
        let forces = plate_forces(&self.robot(unknowns), angles, [0.0; 3])?;
        let shown = |i: usize| {
            let errors = [0, 1].map(|k| unknowns[SCALES + 2 * i + k]);
            self.accuracy.shown(forces[i], errors)
        };
        Ok(Vector3::from_fn(|i, _| shown(i)))
    }

    /// Forces of a posture that the inclinometers read as `inclinations`, rad.
    pub fn predict(&self, unknowns: &Unknowns, inclinations: [f64; 2]) -> Result<Predicted> {
        let by_unknowns = derivatives(DIFFERENCE, |change: &Unknowns| {
            self.forces(&(unknowns + change), inclinations)
        })?;
        let forces = self.forces(unknowns, inclinations)?;
        let accuracy = &self.accuracy;
        let mut covariance = Matrix3::from_diagonal_element(accuracy.scale * accuracy.scale);
        let mut add =
            |by: Vector3<f64>, sigma: f64| covariance += by * by.transpose() * (sigma * sigma);
        let by_inclinations = derivatives(1e-5, |change: &Vector2<f64>| {
            self.forces(unknowns, (Vector2::from(inclinations) + change).into())
        })?;
        for by in by_inclinations.column_iter() {
            add(by.into(), accuracy.inclination);
        }
        let robot = self.robot(unknowns);
        let on_plates = |horizontal| plate_forces(&robot, inclinations, horizontal);
        for i in 0..3 {
            // The part of a wheel's horizontal force that the others balance.
            let mut balanced = [-1.0 / 3.0; 3];
            balanced[i] += 1.0;
            let [with, without] = [on_plates(balanced)?, on_plates([0.0; 3])?].map(Vector3::from);
            add(with - without, accuracy.horizontal_force);
        }
        Ok(Predicted {
            forces,
            by_unknowns,
            covariance,
        })
    }
}
