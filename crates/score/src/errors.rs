//! Errors of one force on the three wheels.

use crate::rule::Compared;
use crate::sum::{Sum, means};
use robhaz_estimator::Estimate;
use serde::{Deserialize, Serialize};

/// Errors of one force over the samples of a run.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ForceErrors {
    /// Root mean square error of each wheel, N.
    pub rmse: [f64; 3],
    /// Root mean square error over the three wheels, N.
    pub rmse_all: f64,
    /// `rmse_all` over the mean true normal force of the three wheels, -; `None` when no wheel ever
    /// carried load.
    pub nrmse: Option<f64>,
    /// Mean error of each wheel, estimate minus truth, N; `None` in results of earlier versions.
    pub bias: Option<[f64; 3]>,
    /// Largest absolute error of any wheel, N.
    pub max_abs: f64,
    /// Time of that error, s; `None` in results of earlier versions.
    pub max_abs_time_s: Option<f64>,
}

/// Root mean square error of N over the three wheels at one sample, N.
pub fn rms_over_wheels(estimate: &Estimate, compared: &Compared) -> f64 {
    let wheels = compared.wheels.iter().zip(estimate.normal_force);
    let squares: f64 = wheels
        .map(|(wheel, n)| (n - wheel.normal_force).powi(2))
        .sum();
    (squares / 3.0).sqrt()
}

/// Running sums of the errors of one force.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct ErrorSums {
    errors: [Sum; 3],
    squares: [Sum; 3],
    largest: f64,
    largest_at: f64,
}

impl ErrorSums {
    /// Adds the errors of the three wheels (N) at the sample of a time (s).
    pub(crate) fn add(&mut self, time: f64, errors: [f64; 3]) {
        for (i, error) in errors.into_iter().enumerate() {
            self.errors[i].add(error);
            self.squares[i].add(error * error);
            if error.abs() > self.largest {
                (self.largest, self.largest_at) = (error.abs(), time);
            }
        }
    }

    /// The errors over `samples`, for a mean load in N; `None` without samples.
    pub(crate) fn errors(&self, samples: u64, mean_load: Option<f64>) -> Option<ForceErrors> {
        let mean_squares = means(&self.squares, samples)?;
        let rmse_all = (mean_squares.iter().sum::<f64>() / 3.0).sqrt();
        Some(ForceErrors {
            rmse: mean_squares.map(f64::sqrt),
            rmse_all,
            nrmse: mean_load.map(|load| rmse_all / load),
            bias: means(&self.errors, samples),
            max_abs: self.largest,
            max_abs_time_s: Some(self.largest_at),
        })
    }
}
