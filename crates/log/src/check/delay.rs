//! When a delay between channels is a fault.

use crate::check::{Finding, Verdict};
use robhaz_score::signals::{Allowed, Delay};

/// Standard deviations beyond what is allowed.
const GATE: f64 = 2.0;
/// Least improvement of the fit over the best allowed delay: the square of two standard deviations.
/// The deviation of a delay holds near it only; the fit tells whether it is much better than
/// without.
const IMPROVEMENT: f64 = 4.0;
/// Least length of a log in times over which residuals may be correlated. With fewer the
/// correlation, and with it the deviation, is known to a sixth only, 1/sqrt(2 n).
const LEAST_LENGTH: f64 = 20.0;

/// A fault is beyond the allowed delays by its deviation, and fits significantly better than they
/// do. A delay that is neither a fault nor allowed cannot be judged.
fn judge(allowed: &Allowed, delay: &Delay) -> Verdict {
    let beyond = (delay.seconds - allowed.late).max(-allowed.early - delay.seconds);
    let is_certain =
        delay.improvement > IMPROVEMENT && is_clear(allowed, delay) && delay.length >= LEAST_LENGTH;
    match beyond {
        beyond if beyond <= 0.0 => Verdict::Ok,
        beyond if is_certain && beyond > GATE * delay.sigma => Verdict::Fault,
        _ => Verdict::CannotTell,
    }
}

/// Whether neither other errors nor those of the regressors can make it.
fn is_clear(allowed: &Allowed, delay: &Delay) -> bool {
    delay.explained > allowed.explained && delay.gained > allowed.errors
}

/// Name of the test in findings.
pub const TEST: &str = "delay";

/// The finding of a delay. `none` and `remedy` say why there is none to judge and which log would
/// show it. `fault` says what to do about one; it gets whose readings arrive late, in the words for
/// the `later` channel or for the `other` one, and the offset (s, negative) that they need.
pub fn finding(
    channel: &str,
    delay: Option<Delay>,
    allowed: &Allowed,
    [none, remedy]: [&str; 2],
    [later, other]: [&str; 2],
    fault: impl Fn(&str, f64) -> String,
) -> Finding {
    let is_shown = |d: &Delay| d.sigma.is_finite() || is_clear(allowed, d);
    let Some(delay) = delay.filter(is_shown) else {
        return Finding::ok(TEST, channel, none).cannot_tell(remedy);
    };
    if delay.sigma.is_infinite() {
        let figure = format!(
            "beyond {:.0} ms, the longest that is looked for, {:.1} % explained",
            1e3 * delay.seconds,
            100.0 * delay.explained
        );
        let remedy = "compare the clocks of both, and look for a filter in one of them";
        return Finding::ok(TEST, channel, figure).cannot_tell(remedy);
    }
    let figure = format!(
        "{:.1} +- {:.1} ms, {:.1} % explained",
        1e3 * delay.seconds,
        1e3 * delay.sigma.max(1e-4),
        100.0 * delay.explained,
    );
    let finding = Finding::ok(TEST, channel, figure);
    let finding = match judge(allowed, &delay) {
        Verdict::Ok => finding,
        Verdict::CannotTell => return finding.cannot_tell(remedy),
        Verdict::Fault => {
            let late = if delay.seconds > 0.0 { later } else { other };
            finding.fault(fault(late, -delay.seconds.abs()))
        }
    };
    let finding = finding.with("delay", delay.seconds, "s");
    finding.with("deviation", delay.sigma, "s")
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A delay that is allowed, one that is beyond, and some that only look so.
    #[test]
    fn a_fault_is_beyond_its_deviation_and_fits_better() {
        let allowed = Allowed {
            early: 0.005,
            late: 0.025,
            explained: 0.95,
            errors: 0.01,
        };
        let of = |seconds: f64, sigma: f64, improvement: f64, explained: f64| Delay {
            seconds,
            sigma,
            improvement,
            length: 40.0,
            explained,
            gained: 0.02,
        };
        let judge_at = |seconds: f64, sigma: f64, improvement: f64, explained: f64| {
            super::judge(&allowed, &of(seconds, sigma, improvement, explained))
        };
        let judge = |seconds: f64, sigma: f64, improvement: f64| {
            judge_at(seconds, sigma, improvement, 0.99)
        };
        assert_eq!(judge(0.024, 0.001, 0.0), Verdict::Ok);
        assert_eq!(judge(0.05, 0.002, 100.0), Verdict::Fault);
        assert_eq!(judge(-0.02, 0.002, 100.0), Verdict::Fault);
        // -21.9 +- 4.8 ms was "ok"; 67.8 +- 12.9 ms a fault that did not improve the fit.
        assert_eq!(judge(-0.0219, 0.0048, 0.0), Verdict::CannotTell);
        assert_eq!(judge(0.0678, 0.0129, 1.5), Verdict::CannotTell);
        assert_eq!(judge(0.05, 0.02, 100.0), Verdict::CannotTell);
        // Accelerations of the robot look like a delay, but explain less.
        assert_eq!(judge_at(0.0531, 0.0039, 33.0, 0.81), Verdict::CannotTell);
        // So do counts of encoders, by as much as they leave.
        let delay = Delay {
            gained: 0.009,
            ..of(-0.092, 0.001, 100.0, 0.994)
        };
        assert_eq!(super::judge(&allowed, &delay), Verdict::CannotTell);
    }
}
