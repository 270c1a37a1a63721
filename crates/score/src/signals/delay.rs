//! Delays of one signal behind others.

use super::{Fit, delayed, fit, residuals};

/// Delays that channels may have, s: of the later one, from `-early` to `late`. Readings show no
/// delay below half the period of the slower channel.
#[derive(Clone, Copy, Debug)]
pub struct Allowed {
    /// How much earlier.
    pub early: f64,
    /// How much later.
    pub late: f64,
    /// Share that the delayed signal must explain. With less, other errors than a delay make the
    /// difference, such as accelerations of the robot.
    pub explained: f64,
    /// Share that errors of the regressors leave. Another delay may seem to explain as much more,
    /// with coefficients that pass on less of them.
    pub errors: f64,
}

/// A delay between two signals.
#[derive(Clone, Copy, Debug)]
pub struct Delay {
    /// By how much `y` is later than its regressors, s.
    pub seconds: f64,
    /// Standard deviation, s; infinite at the longest delay that is looked for: the delay is that or more.
    pub sigma: f64,
    /// Share of the mean square of `y` that the fit at this delay explains.
    pub explained: f64,
    /// How much more it explains than the best of the allowed delays.
    pub gained: f64,
    /// How much better than at the best of the allowed delays: difference of the residuals' sums of
    /// squares over their variance, chi-square with one degree of freedom if there is no delay.
    pub improvement: f64,
    /// Length of the signals in times over which residuals may be correlated, less the
    /// coefficients.
    pub length: f64,
}

/// The delay, within `longest` steps of `dt` (s), at which the regressors explain `y` best; between
/// steps by a parabola. `memory` is the largest number of samples over which residuals are
/// correlated. `None` where there are too few samples to tell.
pub fn delay(
    y: &[f64],
    x: &[&[f64]],
    longest: usize,
    memory: usize,
    dt: f64,
    allowed: Allowed,
) -> Option<Delay> {
    let late = |lag: isize| -> Vec<Vec<f64>> { x.iter().map(|x| delayed(x, lag)).collect() };
    let left = |lag: isize| fit(y, &slices(&late(lag)));
    let longest = longest as isize;
    // Coarse first: the explained share is smooth over the width of the filters.
    let coarse = (longest / 25).max(1);
    let best = |lags: &mut dyn Iterator<Item = isize>| {
        let explained = |lag: isize| left(lag).map_or(f64::NEG_INFINITY, |f| f.explained);
        let shares = lags.map(|lag| (lag, explained(lag)));
        Some(shares.max_by(|a, b| a.1.total_cmp(&b.1))?.0)
    };
    let near = best(&mut (-25..=25).map(|k| k * coarse))?;
    let lag = best(&mut (near - coarse..=near + coarse))?;
    let cost = |f: &Fit| 1.0 - f.explained;
    let lags = |time: f64| (time / dt).floor() as isize;
    let mut of_allowed = (-lags(allowed.early)..=lags(allowed.late)).filter_map(left);
    let first = of_allowed.next().map_or(1.0, |f| cost(&f));
    let least = of_allowed.fold(first, |least, f| least.min(cost(&f)));
    if lag.abs() >= longest {
        let here = left(lag)?;
        return Some(Delay {
            seconds: (lag.signum() * longest) as f64 * dt,
            sigma: f64::INFINITY,
            explained: here.explained,
            gained: least - cost(&here),
            improvement: 0.0,
            length: 0.0,
        });
    }
    let (before, here, after) = (left(lag - 1)?, left(lag)?, left(lag + 1)?);
    let curvature = cost(&before) - 2.0 * cost(&here) + cost(&after);
    if curvature <= 0.0 {
        return None;
    }
    let shift = 0.5 * (cost(&before) - cost(&after)) / curvature;
    let shifted = late(lag);
    // Change of the prediction with the delay, a step, of which the regressors explain nothing.
    let mut slope = vec![0.0; y.len()];
    let (before_all, after_all) = (late(lag - 1), late(lag + 1));
    for (k, coefficient) in here.coefficients.iter().enumerate() {
        let changes = before_all[k].iter().zip(&after_all[k]);
        for (sum, (a, b)) in slope.iter_mut().zip(changes) {
            *sum += 0.5 * coefficient * (b - a);
        }
    }
    let shifted = slices(&shifted);
    let slope = residuals(&slope, &shifted, &fit(&slope, &shifted)?);
    let products = residuals(y, &shifted, &here);
    let products = products.iter().zip(&slope).map(|(r, s)| r * s);
    let correlated = correlated(&products.collect::<Vec<_>>(), memory);
    let independent = here.count as f64 / correlated - x.len() as f64;
    if independent <= 0.0 {
        return None;
    }
    Some(Delay {
        seconds: (lag as f64 + shift) * dt,
        sigma: (2.0 * cost(&here) / (curvature * independent)).sqrt() * dt,
        explained: here.explained,
        gained: least - cost(&here),
        length: here.count as f64 / memory.max(1) as f64 - x.len() as f64,
        improvement: (independent * (least / cost(&here) - 1.0)).max(0.0),
    })
}

fn slices(x: &[Vec<f64>]) -> Vec<&[f64]> {
    x.iter().map(Vec::as_slice).collect()
}

/// Number of samples over which errors are correlated: the sum of their autocorrelation with Bartlett's
/// weights (Newey and West, Econometrica 55, 1987), from 1 to `longest`. One that is missing counts as 0.
pub fn correlated(errors: &[f64], longest: usize) -> f64 {
    let at = |lag: usize| -> f64 {
        let pairs = errors.iter().zip(errors.iter().skip(lag));
        let products = pairs.map(|(a, b)| a * b);
        products.filter(|product| product.is_finite()).sum()
    };
    let longest = longest.max(1);
    let weighted = |lag: usize| (1.0 - lag as f64 / longest as f64) * at(lag);
    let sum = 1.0 + 2.0 * (1..longest).map(weighted).sum::<f64>() / at(0);
    // `min` takes the other one for a NaN.
    sum.min(longest as f64).max(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::signals::fit::tests::wave;

    /// Closed form: a delay of 7.4 steps is found to a hundredth of a step.
    #[test]
    fn a_delay_between_steps_is_found() -> Result<(), &'static str> {
        let (x, y) = (wave(2000, 0.0), wave(2000, 7.4));
        let allowed = Allowed {
            early: 0.0,
            late: 2e-3,
            explained: 0.95,
            errors: 0.0,
        };
        let found = delay(&y, &[&x], 50, 1, 1e-3, allowed).ok_or("delay")?;
        assert!((found.seconds - 7.4e-3).abs() < 1e-5, "{found:?}");
        assert!(found.improvement > 1e3, "{found:?}");
        let late = delay(&wave(2000, 80.0), &[&x], 50, 1, 1e-3, allowed);
        assert!(late.is_none_or(|d| d.explained < 0.9));
        Ok(())
    }

    /// Closed form: values of random sign that are each held for `m` samples have the
    /// autocorrelation 1 - l/m, whose sum with Bartlett's weights to `longest` is m - (m^2 - 1)/(3
    /// longest): 9.67 of 10. 2 000 independent signs leave 2 sqrt(longest/20 000), 0.14 of it.
    #[test]
    fn correlation_of_held_values() {
        let mut state = 1_u64;
        let mut sign = || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1);
            if state >> 63 == 0 { 1.0 } else { -1.0 }
        };
        let held: Vec<f64> = (0..2000).flat_map(|_| [sign(); 10]).collect();
        let found = correlated(&held, 100);
        assert!((found / 9.67 - 1.0).abs() < 3.0 * 0.14, "{found}");
    }
}
