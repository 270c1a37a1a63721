//! What is shown over time: forces, errors, contact angles, needed friction.

use crate::ViewerError;
use crate::colours::{NEUTRAL, WHEELS};
use crate::plot::{Line, Plot};
use crate::rrd::RrdWriter;
use robhaz_estimator::{Estimate, EstimateError};
use robhaz_run::Frame;
use robhaz_scene::Scene;
use robhaz_sim::WheelTruth;

/// Names of the wheels, front to rear.
pub(crate) const WHEEL_NAMES: [&str; 3] = ["front", "middle", "rear"];
/// Below this load T/N says nothing, N: a fiftieth of a wheel's static load.
const LEAST_LOAD: f64 = 1.0;

/// All time series of a run.
pub(crate) struct Series {
    times: Vec<f64>,
    normal_force: [Plot; 3],
    traction: [Plot; 3],
    error: [Plot; 3],
    rms_error: Plot,
    contact_angle: Plot,
    friction: Plot,
}

impl Series {
    /// The series of a scene. `chosen` is the estimator whose friction is shown.
    pub(crate) fn new(scene: &Scene, chosen: Option<usize>) -> Self {
        let names: Vec<&str> = scene.estimators.iter().map(|e| e.name.as_str()).collect();
        let per_wheel = |quantity: &str, truth: bool| {
            [0, 1, 2].map(|i| {
                let estimates = names
                    .iter()
                    .enumerate()
                    .map(|(k, name)| Line::estimate(format!("{name} [N]"), WHEELS[i].estimator(k)));
                let lines = truth
                    .then(|| Line::truth("true [N]", WHEELS[i]))
                    .into_iter()
                    .chain(estimates)
                    .collect();
                Plot::new(format!("series/{quantity}/wheel{}", i + 1), lines)
            })
        };
        let rms_lines = names
            .iter()
            .enumerate()
            .map(|(k, name)| Line::estimate(format!("{name} [N]"), NEUTRAL.estimator(k)))
            .collect();
        Self {
            times: Vec::new(),
            normal_force: per_wheel("normal_force", true),
            traction: per_wheel("traction", true),
            error: per_wheel("error_of_normal_force", false),
            rms_error: Plot::new("series/error_of_normal_force/rms", rms_lines),
            contact_angle: Plot::new(
                "series/contact_angle",
                of_all_wheels("true", Some("given"), "deg"),
            ),
            friction: Plot::new(
                "series/friction",
                of_all_wheels("true", chosen.map(|k| names[k]), "-"),
            ),
        }
    }

    /// Logs how all lines look.
    pub(crate) fn declare(&self, out: &mut RrdWriter) -> Result<(), ViewerError> {
        self.plots().try_for_each(|plot| plot.declare(out))
    }

    /// Adds one record. `chosen` is the estimator whose friction is shown.
    pub(crate) fn push(&mut self, frame: &Frame<'_>, chosen: Option<usize>) {
        let wheels = &frame.truth.wheels;
        let estimated = |value: fn(&Estimate, usize) -> f64, i: usize| {
            frame
                .estimates
                .iter()
                .map(move |e| or_gap(e, |e| value(e, i)))
        };
        self.times.push(frame.truth.time);
        for (i, wheel) in wheels.iter().enumerate() {
            let normal = wheel.normal_force;
            self.normal_force[i].push([normal]);
            self.normal_force[i].push(estimated(|e, i| e.normal_force[i], i));
            self.traction[i].push([wheel.traction]);
            self.traction[i].push(estimated(|e, i| e.traction[i], i));
            self.error[i].push(estimated(|e, i| e.normal_force[i], i).map(|n| n - normal));
        }
        self.rms_error.push(
            frame
                .estimates
                .iter()
                .map(|e| or_gap(e, |e| rms_error(e, wheels))),
        );
        self.contact_angle
            .push(wheels.map(|w| w.contact_angle.to_degrees()));
        self.contact_angle.push(
            frame
                .sensors
                .contact_angle
                .map(|g| g.map_or(f64::NAN, f64::to_degrees)),
        );
        self.friction
            .push(wheels.map(|w| needed_friction(w.traction, w.normal_force)));
        if let Some(estimate) = chosen.map(|k| &frame.estimates[k]) {
            self.friction.push([0, 1, 2].map(|i| {
                or_gap(estimate, |e| {
                    needed_friction(e.traction[i], e.normal_force[i])
                })
            }));
        }
    }

    /// Logs what has come since the last time.
    pub(crate) fn flush(&mut self, out: &mut RrdWriter) -> Result<(), ViewerError> {
        let times = std::mem::take(&mut self.times);
        self.plots_mut()
            .try_for_each(|plot| plot.flush(out, &times))
    }

    fn plots(&self) -> impl Iterator<Item = &Plot> {
        let whole = [&self.rms_error, &self.contact_angle, &self.friction];
        self.normal_force
            .iter()
            .chain(&self.traction)
            .chain(&self.error)
            .chain(whole)
    }

    fn plots_mut(&mut self) -> impl Iterator<Item = &mut Plot> {
        let whole = [
            &mut self.rms_error,
            &mut self.contact_angle,
            &mut self.friction,
        ];
        self.normal_force
            .iter_mut()
            .chain(&mut self.traction)
            .chain(&mut self.error)
            .chain(whole)
    }
}

/// One wide line a wheel and, where there is a second source, one narrow line a wheel.
fn of_all_wheels(first: &str, second: Option<&str>, unit: &str) -> Vec<Line> {
    let name = |i: usize, source: &str| format!("{} {source} [{unit}]", WHEEL_NAMES[i]);
    let wide = (0..3).map(|i| Line::truth(name(i, first), WHEELS[i]));
    let narrow = second.into_iter().flat_map(|source| {
        (0..3).map(move |i| Line::estimate(name(i, source), WHEELS[i].estimator(0)))
    });
    wide.chain(narrow).collect()
}

/// A value of an estimate; a gap in the line where there is none.
fn or_gap(estimate: &Result<Estimate, EstimateError>, value: impl Fn(&Estimate) -> f64) -> f64 {
    estimate.as_ref().map_or(f64::NAN, value)
}

/// Root mean square over the wheels of the error of N, N.
fn rms_error(estimate: &Estimate, wheels: &[WheelTruth; 3]) -> f64 {
    let sum: f64 = wheels
        .iter()
        .zip(estimate.normal_force)
        .map(|(wheel, n)| (n - wheel.normal_force).powi(2))
        .sum();
    (sum / 3.0).sqrt()
}

/// mu_n = T/N, -; a gap where the wheel carries next to nothing.
fn needed_friction(traction: f64, normal_force: f64) -> f64 {
    if normal_force < LEAST_LOAD {
        f64::NAN
    } else {
        traction / normal_force
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn friction_of_an_unloaded_wheel_is_a_gap() {
        assert!((needed_friction(10.0, 40.0) - 0.25).abs() < 1e-15);
        assert!(needed_friction(10.0, 0.0).is_nan());
    }
}
