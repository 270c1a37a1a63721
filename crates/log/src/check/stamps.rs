//! Errors of the time stamps, measured by the wheels, and their resolution.

use crate::check::report::Finding;
use crate::jitter::Jitter;
use robhaz_estimator::SensorFrame;

/// Largest deviation of a step from a whole number of units of the stamps, as a share of the unit.
const WHOLE: f64 = 0.01;
/// Least unit of stamps that matters, s.
const LEAST_UNIT: f64 = 1e-5;
/// Errors of the stamps that are no fault, s: of stamps with four decimals. `estimate` counts them by itself.
const ROUNDED: f64 = 2e-4;

const TEST: &str = "jitter";
const CHANNEL: &str = "time stamps";

/// The finding of the errors that the frames show against a stated one (s), and the one that counts, s.
pub fn finding(frames: &[SensorFrame], counts: f64, stated: f64) -> (f64, Finding) {
    let jitter = Jitter::of(frames, counts);
    let [measured, budget] = [jitter.sigma, stated].map(|time| 1e3 * time);
    let unit = resolution(frames);
    let of_unit = unit.map_or(String::new(), |unit| {
        format!("; the stamps are whole numbers of {:.3} ms", 1e3 * unit)
    });
    let figure =
        format!("the stamps err by {measured:.2} ms by the wheels, budget {budget:.2} ms{of_unit}");
    let mut finding = Finding::ok(TEST, CHANNEL, figure);
    if !jitter.is_shown {
        finding.figure =
            format!("the wheels do not turn steadily, or by too much between readings{of_unit}");
        finding = finding.cannot_tell("record a drive at a steady speed, at a higher rate");
    } else if jitter.exceeds(stated.max(ROUNDED)) {
        let finer = if unit.is_some() {
            ", with more digits"
        } else {
            ""
        };
        finding = finding.fault(format!(
            "budget.jitter = \"{measured:.1} ms\" (estimate takes it by itself); better: stamp readings when they are taken{finer}"
        ));
    }
    let finding = finding.with("jitter", jitter.sigma, "s");
    (jitter.counted(stated), finding)
}

/// The unit of the stamps, s, if all steps are whole numbers of it and differ: the least step or the
/// least difference of two.
fn resolution(frames: &[SensorFrame]) -> Option<f64> {
    let mut steps: Vec<f64> = frames.windows(2).map(|w| w[1].time - w[0].time).collect();
    steps.sort_by(f64::total_cmp);
    let least = *steps.first()?;
    let differences = steps.windows(2).map(|w| w[1] - w[0]);
    let unit = differences
        .filter(|by| *by > LEAST_UNIT)
        .fold(f64::INFINITY, f64::min)
        .min(least);
    let whole = |step: &f64| (step / unit - (step / unit).round()).abs() < WHOLE;
    let differ = steps.last().is_some_and(|last| last - least > 0.5 * unit);
    (unit > LEAST_UNIT && differ && steps.iter().all(whole)).then_some(unit)
}
