//! How far an estimator is off, summed up record by record.

use crate::summary::{EstimatorSummary, ForceErrors};
use robhaz_estimator::{Estimate, EstimateError};
use robhaz_scene::is_compared;
use robhaz_sim::Truth;

/// A sum that keeps what rounding would lose (Neumaier), so that an hour at 1 kHz is summed as exactly as a second.
#[derive(Clone, Copy, Debug, Default)]
struct Sum {
    total: f64,
    lost: f64,
}

impl Sum {
    fn add(&mut self, value: f64) {
        let total = self.total + value;
        self.lost += if self.total.abs() >= value.abs() {
            (self.total - total) + value
        } else {
            (value - total) + self.total
        };
        self.total = total;
    }

    fn value(&self) -> f64 {
        self.total + self.lost
    }
}

/// A root mean square.
#[derive(Clone, Copy, Debug, Default)]
pub struct Rms {
    squares: Sum,
    samples: u32,
}

impl Rms {
    /// One more value.
    pub fn add(&mut self, value: f64) {
        self.squares.add(value * value);
        self.samples += 1;
    }

    /// The root mean square so far; `None` before the first value.
    pub fn value(&self) -> Option<f64> {
        (self.samples > 0).then(|| (self.squares.value() / f64::from(self.samples)).sqrt())
    }
}

/// Errors of one force on the three wheels.
#[derive(Clone, Copy, Debug, Default)]
struct Errors {
    squares: [Sum; 3],
    largest: f64,
}

impl Errors {
    fn add(&mut self, errors: [f64; 3]) {
        for (sum, error) in self.squares.iter_mut().zip(errors) {
            sum.add(error * error);
            self.largest = self.largest.max(error.abs());
        }
    }

    /// `samples` must not be 0.
    fn summary(&self, samples: f64, mean_load: f64) -> ForceErrors {
        let mean_squares = self.squares.map(|sum| sum.value() / samples);
        let rmse_all = (mean_squares.iter().sum::<f64>() / 3.0).sqrt();
        ForceErrors {
            rmse: mean_squares.map(f64::sqrt),
            rmse_all,
            nrmse: (mean_load > 0.0).then(|| rmse_all / mean_load),
            max_abs: self.largest,
        }
    }
}

/// Errors of one estimator over a run.
#[derive(Clone, Debug)]
pub struct Accuracy {
    name: String,
    compare_from: f64,
    samples: u32,
    missing: u32,
    load: [Sum; 3],
    normal_force: Errors,
    traction: Errors,
}

impl Accuracy {
    /// Nothing compared yet; records before `compare_from` (s) will not count.
    pub fn new(name: &str, compare_from: f64) -> Self {
        Self {
            name: name.to_owned(),
            compare_from,
            samples: 0,
            missing: 0,
            load: Default::default(),
            normal_force: Errors::default(),
            traction: Errors::default(),
        }
    }

    /// Compares one estimate with the truth.
    pub fn add(&mut self, truth: &Truth, estimate: Option<&Result<Estimate, EstimateError>>) {
        if !is_compared(truth.time, self.compare_from) {
            return;
        }
        let Some(estimate) = usable(estimate) else {
            self.missing += 1;
            return;
        };
        self.samples += 1;
        let (mut normal_force, mut traction) = ([0.0; 3], [0.0; 3]);
        for (i, wheel) in truth.wheels.iter().enumerate() {
            self.load[i].add(wheel.normal_force);
            normal_force[i] = estimate.normal_force[i] - wheel.normal_force;
            traction[i] = estimate.traction[i] - wheel.traction;
        }
        self.normal_force.add(normal_force);
        self.traction.add(traction);
    }

    /// The result so far; without a sample there are no errors to tell.
    pub fn summary(&self) -> EstimatorSummary {
        let samples = f64::from(self.samples);
        let load = (self.samples > 0).then(|| self.load.map(|sum| sum.value() / samples));
        let errors = |e: &Errors| load.map(|l| e.summary(samples, l.iter().sum::<f64>() / 3.0));
        EstimatorSummary {
            name: self.name.clone(),
            normal_force: errors(&self.normal_force),
            traction: errors(&self.traction),
            mean_normal_force: load,
            samples: self.samples,
            missing: self.missing,
        }
    }
}

/// An estimate with forces that can be compared.
fn usable(estimate: Option<&Result<Estimate, EstimateError>>) -> Option<&Estimate> {
    let estimate = estimate?.as_ref().ok()?;
    let mut forces = estimate.normal_force.iter().chain(&estimate.traction);
    forces.all(|f| f.is_finite()).then_some(estimate)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A plain sum would lose every one of the small values.
    #[test]
    fn small_values_are_not_lost_in_a_large_sum() {
        let mut sum = Sum::default();
        sum.add(1e16);
        for _ in 0..1000 {
            sum.add(1.0);
        }
        sum.add(-1e16);
        assert!((sum.value() - 1000.0).abs() < 1e-9);
    }
}
