//! Delays between channels, and when they are a fault.

use crate::fit::{Fit, fit};
use crate::report::Verdict;
use crate::signal::delayed;

/// Delays that channels may have, s: of the later one, from `-early` to `late`.
#[derive(Clone, Copy, Debug)]
pub struct Allowed {
    /// How much earlier.
    pub early: f64,
    /// How much later.
    pub late: f64,
}

/// Standard deviations beyond what is allowed. They are large: residuals count as correlated over half a second.
const GATE: f64 = 2.0;
/// Least improvement of the fit over the best allowed delay: the square of two standard deviations. The deviation of a delay
/// holds near it only; the fit tells whether it is much better than without.
const IMPROVEMENT: f64 = 4.0;
/// Share that a delayed signal explains. With less, other errors than a delay make the difference, such as accelerations of
/// the robot.
const EXPLAINED: f64 = 0.95;
/// Least number of independent residuals: with fewer the deviation itself is known to a sixth only, 1/sqrt(2 n).
const LEAST_INDEPENDENT: f64 = 20.0;

impl Allowed {
    /// With half the period of the slower channel (s): its readings show no shorter delay.
    pub fn at_period(self, period: f64) -> Self {
        Self {
            early: self.early + 0.5 * period,
            late: self.late + 0.5 * period,
        }
    }

    /// A fault is beyond the allowed delays by its deviation, and fits significantly better than they do. A delay that is
    /// neither a fault nor allowed cannot be told.
    pub fn judge(&self, delay: &Delay) -> Verdict {
        let beyond = (delay.seconds - self.late).max(-self.early - delay.seconds);
        let is_certain = delay.improvement > IMPROVEMENT
            && delay.explained > EXPLAINED
            && delay.independent >= LEAST_INDEPENDENT;
        if beyond <= 0.0 {
            Verdict::Ok
        } else if is_certain && beyond > GATE * delay.sigma {
            Verdict::Fault
        } else {
            Verdict::CannotTell
        }
    }
}

/// A delay between two signals.
#[derive(Clone, Copy, Debug)]
pub struct Delay {
    /// By how much `y` is later than its regressors, s.
    pub seconds: f64,
    /// Standard deviation, s.
    pub sigma: f64,
    /// Share of the mean square of `y` that the fit at this delay explains.
    pub explained: f64,
    /// How much better than at the best of the allowed delays: difference of the residuals' sums of squares over their
    /// variance, chi-square with one degree of freedom if there is no delay.
    pub improvement: f64,
    /// Number of independent residuals.
    pub independent: f64,
}

/// The delay, within `longest` steps of `dt` (s), at which the regressors explain `y` best; between steps by a parabola.
/// `memory` is the number of samples over which residuals are correlated. `None` where the best is at an end, or where there
/// are too few samples to tell.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_precision_loss,
    clippy::cast_possible_wrap,
    reason = "the number of samples of a log"
)]
pub fn delay<const K: usize>(
    y: &[f64],
    x: &[&[f64]; K],
    longest: usize,
    memory: usize,
    dt: f64,
    allowed: Allowed,
) -> Option<Delay> {
    let left = |lag: isize| {
        let late = x.map(|x| delayed(x, lag));
        let refs: [&[f64]; K] = core::array::from_fn(|k| late[k].as_slice());
        fit(y, &refs)
    };
    let longest = longest as isize;
    // Coarse first: the explained share is smooth over the width of the filters.
    let coarse = (longest / 25).max(1);
    let best = |lags: &mut dyn Iterator<Item = isize>| {
        let explained = |lag: isize| left(lag).map_or(f64::NEG_INFINITY, |f| f.explained);
        lags.map(|lag| (lag, explained(lag)))
            .max_by(|a, b| a.1.total_cmp(&b.1))
            .map(|(lag, _)| lag)
    };
    let near = best(&mut (-25..=25).map(|k| k * coarse))?;
    let lag = best(&mut (near - coarse..=near + coarse))?;
    if lag.abs() >= longest {
        return None;
    }
    let (before, here, after) = (left(lag - 1)?, left(lag)?, left(lag + 1)?);
    let cost = |f: &Fit<K>| 1.0 - f.explained;
    let curvature = cost(&before) - 2.0 * cost(&here) + cost(&after);
    if curvature <= 0.0 {
        return None;
    }
    let shift = 0.5 * (cost(&before) - cost(&after)) / curvature;
    let independent = here.count as f64 / memory as f64 - K as f64;
    if independent <= 0.0 {
        return None;
    }
    let lags = |time: f64| (time / dt).floor() as isize;
    let mut of_allowed = (-lags(allowed.early)..=lags(allowed.late)).filter_map(left);
    let first = of_allowed.next().map_or(1.0, |f| cost(&f));
    let least = of_allowed.fold(first, |least, f| least.min(cost(&f)));
    Some(Delay {
        seconds: (lag as f64 + shift) * dt,
        sigma: (2.0 * cost(&here) / (curvature * independent)).sqrt() * dt,
        explained: here.explained,
        independent,
        improvement: (independent * (least / cost(&here) - 1.0)).max(0.0),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wave(n: usize, shift: f64) -> Vec<f64> {
        let at = |i: usize| {
            let t = i as f64 - shift;
            (0.05 * t).sin() + 0.5 * (0.013 * t).cos()
        };
        (0..n).map(at).collect()
    }

    /// A delay that is allowed, one that is beyond, and two that only look so.
    #[test]
    fn a_fault_is_beyond_its_deviation_and_fits_better() {
        let allowed = Allowed {
            early: 0.005,
            late: 0.025,
        };
        let judge_at = |seconds: f64, sigma: f64, improvement: f64, explained: f64| {
            let delay = Delay {
                seconds,
                sigma,
                improvement,
                independent: 40.0,
                explained,
            };
            allowed.judge(&delay)
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
    }

    /// Closed form: a delay of 7.4 steps is found to a hundredth of a step.
    #[test]
    fn a_delay_between_steps_is_found() -> Result<(), &'static str> {
        let (x, y) = (wave(2000, 0.0), wave(2000, 7.4));
        let allowed = Allowed {
            early: 0.0,
            late: 2e-3,
        };
        let found = delay(&y, &[&x], 50, 1, 1e-3, allowed).ok_or("delay")?;
        assert!((found.seconds - 7.4e-3).abs() < 1e-5, "{found:?}");
        assert!(found.improvement > 1e3, "{found:?}");
        let late = delay(&wave(2000, 80.0), &[&x], 50, 1, 1e-3, allowed);
        assert!(late.is_none_or(|d| d.explained < 0.9));
        Ok(())
    }
}
