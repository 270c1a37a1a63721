//! Differences between two runs of one scene.

use super::balance::greater;
use robhaz_sim::{Balance, Truth};

/// Differences between two runs of one scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Agreement {
    /// RMS difference of N over wheels and records, relative to the mean of N, -.
    pub normal_force: f64,
    /// Distance between the bodies at the end, m.
    pub apart: f64,
}

/// Compares two runs, record by record.
pub fn agreement(a: &[Truth], b: &[Truth]) -> Agreement {
    let (mut square, mut sum, mut count) = (0.0, 0.0, 0.0);
    for (a, b) in a.iter().zip(b) {
        for (a, b) in a.wheels.iter().zip(&b.wheels) {
            square += (a.normal_force - b.normal_force).powi(2);
            sum += b.normal_force;
            count += 1.0;
        }
    }
    let apart = match (a.last(), b.last()) {
        (Some(a), Some(b)) => (a.body.position - b.body.position).norm(),
        _ => f64::NAN,
    };
    Agreement {
        normal_force: f64::sqrt(square / count) / (sum / count),
        apart,
    }
}

/// Largest relative difference, over the wheels, of the ground's impulse on a wheel in two runs of
/// equal length, -.
///
/// The impulses are those that the engines integrate, so impacts between records are included.
pub fn impulse_difference(a: &Balance, b: &Balance) -> f64 {
    a.impulse
        .iter()
        .zip(&b.impulse)
        .map(|(a, b)| (a - b).norm() / b.norm())
        .fold(0.0, greater)
}
