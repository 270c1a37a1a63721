//! Signals: samples at equal steps, where a NaN is a missing one. Filters without delay, least
//! squares, delays of one signal behind another.
//!
//! No function here has type parameters: it would be compiled again, and not for speed, in the
//! crates that read logs.

mod delay;
mod fit;

pub use delay::{Allowed, Delay, correlated, delay};
pub use fit::{Fit, fit, products, residuals, robust_fit};

/// Mean over the `2 half + 1` samples around each; a NaN near the ends, and where more than half of
/// them are missing.
pub fn smooth(x: &[f64], half: usize) -> Vec<f64> {
    let mut sums = vec![(0.0, 0)];
    for value in x {
        let (sum, count) = sums[sums.len() - 1];
        sums.push(match value.is_finite() {
            true => (sum + value, count + 1),
            false => (sum, count),
        });
    }
    let mean = |i: usize| {
        let (from, to) = (sums[i.checked_sub(half)?], sums.get(i + half + 1)?);
        let count = to.1 - from.1;
        (2 * count > 2 * half + 1).then(|| (to.0 - from.0) / count as f64)
    };
    (0..x.len()).map(|i| mean(i).unwrap_or(f64::NAN)).collect()
}

/// The samples less their mean over the `2 half + 1` samples around each.
pub fn high_pass(x: &[f64], half: usize) -> Vec<f64> {
    subtract(x, &smooth(x, half))
}

/// Difference over `2 half` samples around each.
pub fn difference(x: &[f64], half: usize) -> Vec<f64> {
    let at = |i: usize| Some(x.get(i + half)? - x.get(i.checked_sub(half)?)?);
    (0..x.len()).map(|i| at(i).unwrap_or(f64::NAN)).collect()
}

/// Derivative of smoothed samples: difference of the means of `2 half + 1` samples before and
/// after, over the time between (`dt` is the step, s).
pub fn derivative(x: &[f64], half: usize, dt: f64) -> Vec<f64> {
    let time = 2.0 * half as f64 * dt;
    let change = difference(&smooth(x, half), half);
    change.iter().map(|change| change / time).collect()
}

/// Integral by the trapezoidal rule. A missing sample counts as 0, and is missing in the result.
pub fn integral(x: &[f64], dt: f64) -> Vec<f64> {
    let (mut sum, mut last) = (0.0, 0.0);
    let mut of = |value: &f64| {
        if !value.is_finite() {
            last = 0.0;
            return f64::NAN;
        }
        sum += 0.5 * dt * (last + value);
        last = *value;
        sum
    };
    x.iter().map(&mut of).collect()
}

/// The samples `lag` steps later (positive) or earlier: element i is `x[i - lag]`.
pub fn delayed(x: &[f64], lag: isize) -> Vec<f64> {
    let at = |i: usize| x.get(i.checked_add_signed(-lag)?).copied();
    (0..x.len()).map(|i| at(i).unwrap_or(f64::NAN)).collect()
}

/// `a` less `b`, sample by sample.
pub fn subtract(a: &[f64], b: &[f64]) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a - b).collect()
}

/// Mean of the samples that are there.
pub fn mean(x: &[f64]) -> Option<f64> {
    mean_of(x, |v| v)
}

fn mean_of(x: &[f64], of: impl Fn(f64) -> f64) -> Option<f64> {
    let finite = || x.iter().filter(|v| v.is_finite());
    let count = finite().count();
    (count > 0).then(|| finite().map(|v| of(*v)).sum::<f64>() / count as f64)
}

/// Root of the mean square of the samples that are there; 0 without any.
pub fn rms(x: &[f64]) -> f64 {
    mean_of(x, |v| v * v).map_or(0.0, f64::sqrt)
}

/// Root of the mean square of the deviations from the mean; 0 without any sample.
pub fn deviation(x: &[f64]) -> f64 {
    let mean = mean(x).unwrap_or(0.0);
    mean_of(x, |v| (v - mean) * (v - mean)).map_or(0.0, f64::sqrt)
}

/// Standard deviation of the white noise of samples of a smooth signal: what three differ by from a
/// straight line, by the median, which neither corners nor spikes change. `None` of fewer than 50.
///
/// Noise bends steps of two samples as much as steps of one, a smooth signal four times as much.
pub fn white_noise(x: &[f64]) -> Option<f64> {
    /// Standard deviation of normal errors over the median of their amounts.
    const OF_MEDIAN: f64 = 1.4826;
    const LEAST: usize = 50;
    let bend = |step: usize| {
        let of = |i: usize| (x[i + 2 * step] - 2.0 * x[i + step] + x[i]).abs();
        let all: Vec<f64> = (0..x.len().saturating_sub(2 * step)).map(of).collect();
        let is_enough = all.iter().filter(|bend| bend.is_finite()).count() >= LEAST;
        let bend = OF_MEDIAN * median(all).filter(|_| is_enough)?;
        Some(bend * bend)
    };
    // (1 + 4 + 1) sigma^2, and that of the signal, b^2 and (4 b)^2.
    let noise = (16.0 * bend(1)? - bend(2)?) / (15.0 * 6.0);
    Some(noise.max(0.0).sqrt())
}

/// Median of the samples that are there.
pub fn median(mut values: Vec<f64>) -> Option<f64> {
    values.retain(|v| v.is_finite());
    let middle = values.len() / 2;
    if values.is_empty() {
        return None;
    }
    let (_, median, _) = values.select_nth_unstable_by(middle, f64::total_cmp);
    Some(*median)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(n: usize) -> Vec<f64> {
        (0..n).map(|i| 2.0 * i as f64).collect()
    }

    /// Closed form: on a straight line the mean is the line, the derivative its slope, and nothing
    /// passes the high pass.
    #[test]
    fn filters_keep_a_straight_line() {
        let x = line(50);
        for (i, mean) in smooth(&x, 4).iter().enumerate() {
            assert_eq!(mean.is_nan(), !(4..46).contains(&i));
            assert!(mean.is_nan() || (mean - x[i]).abs() < 1e-12);
        }
        let slopes = derivative(&x, 3, 0.5);
        assert!((slopes[25] - 4.0).abs() < 1e-12 && slopes[0].is_nan());
        assert!(high_pass(&x, 5)[20].abs() < 1e-12);
        assert!((delayed(&x, 3)[10] - x[7]).abs() < 1e-12);
        assert!((delayed(&x, -3)[10] - x[13]).abs() < 1e-12);
    }

    /// Closed form: noise that alternates by +-1 bends by 4 and, over two steps, not at all; a parabola
    /// bends by its second difference and four times that, and is no noise; spikes do not count.
    #[test]
    fn white_noise_is_no_curvature() {
        let expected = 1.4826 * 16.0 / 90f64.sqrt();
        let alternating = |i: usize| if i.is_multiple_of(2) { 1.0 } else { -1.0 };
        let mut x: Vec<f64> = (0..200).map(alternating).collect();
        x[100] = 1e6;
        assert!((white_noise(&x).unwrap_or(0.0) - expected).abs() < 1e-12);
        let parabola: Vec<f64> = (0..200).map(|i| 0.1 * (i * i) as f64).collect();
        // The root of what rounding leaves of equal squares.
        assert!(white_noise(&parabola).is_some_and(|noise| noise < 1e-6));
        assert_eq!(white_noise(&x[..50]), None);
    }

    /// A missing sample is bridged by a mean; its integral goes on behind it.
    #[test]
    fn missing_samples_are_left_out() {
        let mut x = vec![1.0; 20];
        x[10] = f64::NAN;
        assert!((smooth(&x, 2)[10] - 1.0).abs() < 1e-12);
        let sum = integral(&x, 1.0);
        assert!(sum[10].is_nan() && (sum[19] - 18.0).abs() < 1.1);
        assert_eq!(median(x.clone()), Some(1.0));
        assert_eq!(median(vec![]), None);
        assert!((rms(&[3.0, -3.0, f64::NAN]) - 3.0).abs() < 1e-12);
    }
}
