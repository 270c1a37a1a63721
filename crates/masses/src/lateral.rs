//! The lateral centre of mass of a rover with both sides from six scales.
//!
//! With both sides in one posture on level plates, left and right differ in load only by what lies
//! off the middle plane: the body's centre of mass. The nine rows of
//! [`robhaz_estimator::whole`] give the difference of each pair of wheels, which is proportional to
//! it.

use crate::blocks::{Blocks, simulate};
use crate::error::{Result, WeighError};
use crate::fit::{Misfit, misfit, of_wheel};
use crate::measurements::{Accuracy, Measurements, Reading};
use nalgebra::{Matrix3, SMatrix, Vector2, Vector3};
use robhaz_estimator::whole::{
    Joints, ROWS, Rows, WholeEquilibrium, WholeError, WholeMotion, WholePosture,
};
use robhaz_model::{GRAVITY, Suspension, WholeRover};

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
) -> Result<Lateral> {
    let mut used = Vec::new();
    let (mut information, mut right) = (0.0, 0.0);
    let mut by_scales = [Vector2::zeros(); 3];
    for reading in differences {
        let [Some(a), Some(b), Some(c)] = reading.forces else {
            continue;
        };
        let found = Vector3::new(a, b, c);
        let predicted = predict(rover, reading.inclinations, accuracy)?;
        let by_place = predicted.by_place;
        let weight = predicted.covariance.cholesky();
        let weight = weight.ok_or_else(WeighError::undetermined)?.inverse();
        let weighted = weight * by_place;
        information += weighted.dot(&by_place);
        right += weighted.dot(&found);
        // A scale keeps its gain and zero.
        for i in 0..3 {
            by_scales[i] += weighted[i] * Vector2::new(predicted.forces[i], 1.0);
        }
        used.push((reading.line, found, predicted));
    }
    if !(information > 0.0 && information.is_finite()) {
        let message = "no posture has readings of six scales; allowed: left and right wheels all on scales in at least one";
        return Err(WeighError::new(message));
    }
    let place = right / information;
    let (mut sum, mut residuals) = (0.0, Vec::new());
    for (line, found, predicted) in &used {
        let residual = found - predicted.by_place * place;
        let scales = |i: usize, _| 2.0 * accuracy.of_constant(predicted.forces[i]);
        let of_scales = Vector3::from_fn(scales);
        let covariance = predicted.covariance + Matrix3::from_diagonal(&of_scales);
        let weight = covariance.cholesky();
        let weight = weight.ok_or_else(WeighError::undetermined)?.inverse();
        sum += residual.dot(&(weight * residual));
        residuals
            .extend((0..3).map(|i| (of_wheel(i, *line), residual[i], covariance[(i, i)].sqrt())));
    }
    // The place takes one of them.
    let misfit = misfit(residuals.len() - 1, sum, &residuals)
        .map_err(|error| WeighError::new(format!("left less right: {error}")))?;
    let scales = by_scales.map(|by| {
        let [gain, zero] = [accuracy.scale_gain * by.x, accuracy.scale_zero * by.y];
        2.0 * (gain * gain + zero * zero)
    });
    let scales = scales.iter().sum::<f64>() / (information * information);
    let deviation = (information.recip() + scales).sqrt();
    let mass = &rover.side.mass;
    let share = mass.body / mass.total();
    Ok(Lateral {
        body_place: (place, deviation),
        rover_place: (share * place, share * deviation),
        misfit,
    })
}

/// Readings of `rover` with both sides on equal blocks ([`simulate`]): the mean of left and right,
/// and their differences.
///
/// # Errors
/// [`WeighError`]
pub fn simulate_both(
    rover: &WholeRover,
    postures: &[Blocks],
    accuracy: &Accuracy,
    mut normal: impl FnMut() -> f64,
) -> Result<Measurements> {
    // The mean of two independent errors.
    let half = std::f64::consts::FRAC_1_SQRT_2;
    let of_mean = Accuracy {
        scale: half * accuracy.scale,
        scale_gain: half * accuracy.scale_gain,
        scale_zero: half * accuracy.scale_zero,
        horizontal_force: half * accuracy.horizontal_force,
        ..*accuracy
    };
    let mut measurements = simulate(&rover.side, postures, &of_mean, &mut normal)?;
    let scales = [0, 1, 2].map(|_| of_mean.draw_scale(&mut normal));
    for reading in &measurements.readings {
        let predicted = predict(rover, reading.inclinations, accuracy)?;
        let factor = predicted.covariance.cholesky();
        let factor = factor.ok_or_else(WeighError::undetermined)?.l();
        let drawn = factor * Vector3::from_fn(|_, _| normal());
        let difference = |i: usize| {
            // Twice that of the mean, as one scale errs up and the other down.
            let force = predicted.forces[i];
            let constant = 2.0 * (of_mean.shown(force, scales[i]) - force);
            predicted.by_place[i] * rover.body_place + constant + drawn[i]
        };
        measurements.differences.push(Reading {
            forces: [0, 1, 2].map(|i| Some(difference(i))),
            ..*reading
        });
    }
    Ok(measurements)
}

/// What six scales show of a rover in one posture.
struct Predicted {
    /// Left less right forces by the body's place, N/m.
    by_place: Vector3<f64>,
    /// Covariance of their readings without gains and zeros of the scales, N^2.
    covariance: Matrix3<f64>,
    /// Mean force of left and right, N.
    forces: Vector3<f64>,
}

fn predict(rover: &WholeRover, inclinations: [f64; 2], accuracy: &Accuracy) -> Result<Predicted> {
    // Of one metre to the side: the loads are linear in it.
    let aside = WholeRover {
        body_place: 1.0,
        ..rover.clone()
    };
    let aside = equilibrium(&aside, inclinations)?;
    let columns = SMatrix::<f64, ROWS, 6>::from_columns(&aside.h_n);
    let normal = (columns.transpose() * columns).cholesky();
    let normal = normal.ok_or_else(WeighError::undetermined)?;
    let solve = |of: &Rows| normal.solve(&(columns.transpose() * of));
    let difference = |of: &Rows| {
        let n = solve(of);
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
    let n = solve(&aside.f);
    // The statics are at the robot's gravity, and the scales at 9.81 m/s^2.
    let share = GRAVITY / rover.side.gravity;
    Ok(Predicted {
        by_place: difference(&aside.f) * share,
        covariance,
        forces: Vector3::from_fn(|i, _| 0.5 * share * (n[i] + n[i + 3])),
    })
}

/// The nine rows at rest on level plates, both sides with links 1 and 2 at these inclinations, rad.
fn equilibrium(rover: &WholeRover, inclinations: [f64; 2]) -> Result<WholeEquilibrium> {
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
