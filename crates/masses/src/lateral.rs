//! The lateral centre of mass of a rover with both sides from six scales.
//!
//! With both sides in one posture on level plates, left and right differ in load only by what lies
//! off the middle plane: the body's centre of mass. The nine rows of
//! [`robhaz_estimator::whole`] give the difference of each pair of wheels, which is proportional to
//! it.

use crate::error::WeighError;
use crate::fit::{Misfit, misfit};
use crate::measurements::{Accuracy, Reading};
use nalgebra::{Matrix3, SMatrix, Vector3};
use robhaz_estimator::whole::{
    Joints, ROWS, Rows, WholeEquilibrium, WholeError, WholeMotion, WholePosture,
};
use robhaz_model::{Suspension, WholeRover};

/// What six scales say beside three.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lateral {
    /// Lateral place of the body's centre of mass and its standard deviation, m, left positive.
    pub body_place: (f64, f64),
    /// The same of the whole rover's centre of mass.
    pub rover_place: (f64, f64),
    /// How the differences between left and right fit it.
    pub misfit: Misfit,
}

/// The lateral centre of mass from `differences` ([`crate::Measurements::differences`]).
/// [`WholeRover::body_place`] does not count.
///
/// # Errors
/// [`WeighError`]: no reading, a posture without determined forces, readings that do not fit.
pub fn lateral(
    rover: &WholeRover,
    differences: &[Reading],
    accuracy: &Accuracy,
) -> Result<Lateral, WeighError> {
    let mut used = Vec::new();
    let (mut information, mut right) = (0.0, 0.0);
    for reading in differences {
        let [Some(a), Some(b), Some(c)] = reading.forces else {
            continue;
        };
        let found = Vector3::new(a, b, c);
        let (by_place, covariance) = predict(rover, reading.inclinations, accuracy)?;
        let weight = covariance
            .cholesky()
            .ok_or_else(WeighError::undetermined)?
            .inverse();
        information += by_place.dot(&(weight * by_place));
        right += by_place.dot(&(weight * found));
        used.push((reading.line, found, by_place, covariance, weight));
    }
    if !(information > 0.0 && information.is_finite()) {
        let message = "no posture has readings of six scales; allowed: left and right wheels all on scales in at least one";
        return Err(WeighError::new(message));
    }
    let place = right / information;
    let (mut sum, mut residuals) = (0.0, Vec::new());
    for (line, found, by_place, covariance, weight) in &used {
        let residual = found - by_place * place;
        sum += residual.dot(&(weight * residual));
        residuals.extend((0..3).map(|i| (*line, i + 1, residual[i], covariance[(i, i)].sqrt())));
    }
    // The place takes one of them.
    let misfit = misfit(residuals.len() - 1, sum, &residuals)
        .map_err(|error| WeighError::new(format!("left less right: {error}")))?;
    let deviation = information.sqrt().recip();
    let mass = &rover.side.mass;
    let share = mass.body / mass.total();
    Ok(Lateral {
        body_place: (place, deviation),
        rover_place: (share * place, share * deviation),
        misfit,
    })
}

/// Left less right forces by the body's place, N/m, and the covariance of their readings, N^2.
fn predict(
    rover: &WholeRover,
    inclinations: [f64; 2],
    accuracy: &Accuracy,
) -> Result<(Vector3<f64>, Matrix3<f64>), WeighError> {
    // Of one metre to the side: the loads are linear in it.
    let aside = WholeRover {
        body_place: 1.0,
        ..rover.clone()
    };
    let aside = equilibrium(&aside, inclinations)?;
    let columns = SMatrix::<f64, ROWS, 6>::from_columns(&aside.h_n);
    let normal = (columns.transpose() * columns).cholesky();
    let normal = normal.ok_or_else(WeighError::undetermined)?;
    let difference = |of: &Rows| {
        let n = normal.solve(&(columns.transpose() * of));
        Vector3::from_fn(|i, _| n[i] - n[i + 3])
    };
    let mut covariance = Matrix3::from_diagonal_element(2.0 * accuracy.scale * accuracy.scale);
    for i in 0..6 {
        // The part of a wheel's horizontal force that the others of its side balance.
        let side = 3 * (i / 3);
        let mean = (side..side + 3).map(|j| aside.h_t[j]).sum::<Rows>() / 3.0;
        let by = difference(&(mean - aside.h_t[i])) * accuracy.horizontal_force;
        covariance += by * by.transpose();
    }
    Ok((difference(&aside.f), covariance))
}

/// The nine rows at rest on level plates, both sides with links 1 and 2 at these inclinations, rad.
fn equilibrium(rover: &WholeRover, inclinations: [f64; 2]) -> Result<WholeEquilibrium, WeighError> {
    let Suspension::Bogie { body } = rover.side.geometry.suspension else {
        return Err(WeighError::new(WholeError::FourBar));
    };
    let (of_body, of_bogie) = (inclinations[body.index()], inclinations[1 - body.index()]);
    // The differential is level, or the rear bogie: both sides are alike.
    let joints = Joints {
        pins: [of_bogie - of_body; 2],
        ..Joints::default()
    };
    let posture = WholePosture::new(rover, &joints).map_err(WeighError::new)?;
    let motion = WholeMotion::at_rest(rover.side.gravity, of_body, 0.0);
    WholeEquilibrium::new(rover, &posture, &motion, &[-of_body; 6]).map_err(WeighError::new)
}
