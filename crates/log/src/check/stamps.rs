//! Errors of the time stamps, measured by the wheels, and their resolution.

use crate::check::Finding;
use crate::jitter::Jitter;
use robhaz_estimator::{NoiseBudget, SensorFrame};

/// Errors of the stamps that are no fault, s: of stamps with four decimals. `estimate` counts them by itself.
const ROUNDED: f64 = 2e-4;

const TEST: &str = "jitter";
const CHANNEL: &str = "time stamps";

/// The finding of the errors that the frames show against the stated one; the budget then has the one that counts.
pub fn finding(frames: &[SensorFrame], budget: &mut NoiseBudget) -> Finding {
    let stated = budget.jitter;
    let jitter = Jitter::of(frames, budget.encoder_counts);
    let [measured, allowed] = [jitter.sigma, stated].map(|time| 1e3 * time);
    let of_unit = jitter.unit.map_or(String::new(), |unit| {
        format!("; the stamps are whole numbers of {:.3} ms", 1e3 * unit)
    });
    let figure = format!(
        "the stamps err by {measured:.2} ms by the wheels, budget {allowed:.2} ms{of_unit}"
    );
    let mut finding = Finding::ok(TEST, CHANNEL, figure);
    if !jitter.is_shown {
        finding.figure =
            format!("the wheels do not turn steadily, or by too much between readings{of_unit}");
        finding = finding.cannot_tell("record a drive at a steady speed, at a higher rate");
    } else if jitter.exceeds(stated.max(ROUNDED)) {
        let finer = jitter.unit.map_or("", |_| ", with more digits");
        finding = finding.fault(format!(
            "budget.jitter = \"{measured:.1} ms\" (estimate takes it by itself); better: stamp readings when they are taken{finer}"
        ));
    }
    budget.jitter = jitter.counted(stated);
    finding.with("jitter", jitter.sigma, "s")
}
