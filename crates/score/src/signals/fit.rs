//! Least squares with few coefficients.

use super::median;
use nalgebra::{DMatrix, DVector};

/// Coefficients of a least-squares fit.
#[derive(Clone, Debug)]
pub struct Fit {
    /// In the order of the regressors.
    pub coefficients: Vec<f64>,
    /// Standard deviations of the coefficients where residuals are independent from sample to
    /// sample.
    pub deviations: Vec<f64>,
    /// Share of the mean square of `y` that the fit explains: 0 to 1.
    pub explained: f64,
    /// Number of samples.
    pub count: usize,
}

/// Sums of the products of each two of the signals, over the samples where all are there, and the
/// number of these. The matrix is symmetric.
pub fn products(signals: &[&[f64]]) -> (DMatrix<f64>, usize) {
    let n = signals.len();
    let (mut sums, mut row, mut count) = (vec![0.0; n * n], vec![0.0; n], 0);
    let samples = signals.iter().map(|signal| signal.len()).min().unwrap_or(0);
    for i in 0..samples {
        for (value, signal) in row.iter_mut().zip(signals) {
            *value = signal[i];
        }
        if row.iter().all(|v| v.is_finite()) {
            for (sums, a) in sums.chunks_exact_mut(n).zip(&row) {
                for (sum, b) in sums.iter_mut().zip(&row) {
                    *sum += a * b;
                }
            }
            count += 1;
        }
    }
    (DMatrix::from_vec(n, n, sums), count)
}

/// Fits `y` by a sum of the regressors `x`, over the samples where all are there. `None` where they
/// do not determine the coefficients.
pub fn fit(y: &[f64], x: &[&[f64]]) -> Option<Fit> {
    let (k, signals) = (x.len(), [x, &[y]].concat());
    let (sums, count) = products(&signals);
    let (normal, right, square) = (
        sums.view((0, 0), (k, k)),
        sums.view((0, k), (k, 1)),
        sums[(k, k)],
    );
    if count <= k || square <= 0.0 {
        return None;
    }
    // Scaled to ones on the diagonal, so that the limit does not depend on units.
    let scale = DVector::from_fn(k, |i, _| 1.0 / normal[(i, i)].sqrt());
    let scaled = DMatrix::from_fn(k, k, |i, j| normal[(i, j)] * scale[i] * scale[j]);
    let inverse = scaled.cholesky()?.inverse();
    if !inverse.iter().all(|v| v.is_finite() && v.abs() < 1e8) {
        return None;
    }
    let coefficients = (&inverse * right.component_mul(&scale)).component_mul(&scale);
    let left = (square - coefficients.dot(&right)).max(0.0);
    let deviation = |i: usize| scale[i] * (inverse[(i, i)] * left / count as f64).sqrt();
    Some(Fit {
        deviations: (0..k).map(deviation).collect(),
        coefficients: coefficients.iter().copied().collect(),
        explained: 1.0 - left / square,
        count,
    })
}

/// As [`fit`], without the samples whose residuals are beyond five standard deviations of the
/// middle ones: impacts.
pub fn robust_fit(y: &[f64], x: &[&[f64]]) -> Option<Fit> {
    let mut kept = y.to_vec();
    let mut found = fit(&kept, x)?;
    for _ in 0..3 {
        let residuals = residuals(y, x, &found);
        // 1.48 times the median of the magnitudes is the standard deviation of normal errors.
        let sigma = 1.48 * median(residuals.iter().map(|r| r.abs()).collect())?;
        for ((kept, y), r) in kept.iter_mut().zip(y).zip(&residuals) {
            *kept = if r.abs() <= 5.0 * sigma { *y } else { f64::NAN };
        }
        found = fit(&kept, x)?;
    }
    Some(found)
}

/// What the fit leaves of `y`.
pub fn residuals(y: &[f64], x: &[&[f64]], fit: &Fit) -> Vec<f64> {
    let part = |k: usize, i: usize| fit.coefficients[k] * x[k][i];
    let predicted = |i: usize| -> f64 { (0..x.len()).map(|k| part(k, i)).sum() };
    let numbered = y.iter().enumerate();
    numbered.map(|(i, y)| y - predicted(i)).collect()
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// Two waves, `shift` samples late.
    pub fn wave(n: usize, shift: f64) -> Vec<f64> {
        let at = |i: usize| {
            let t = i as f64 - shift;
            (0.05 * t).sin() + 0.5 * (0.013 * t).cos()
        };
        (0..n).map(at).collect()
    }

    /// Closed form: exact coefficients of an exact sum; an outlier does not count; a constant twice
    /// determines nothing.
    #[test]
    fn coefficients_of_a_sum() -> Result<(), &'static str> {
        let (a, b) = (wave(500, 0.0), vec![1.0; 500]);
        let mut y: Vec<f64> = a.iter().map(|a| 3.0 * a - 2.0).collect();
        let found = fit(&y, &[&a, &b]).ok_or("fit")?;
        assert!((found.coefficients[0] - 3.0).abs() < 1e-10);
        assert!((found.coefficients[1] + 2.0).abs() < 1e-10 && found.explained > 1.0 - 1e-12);
        assert!(fit(&y, &[&b, &b]).is_none());
        y[100] = 1e6;
        for (i, y) in y.iter_mut().enumerate() {
            *y += 1e-3 * (1.7 * i as f64).sin();
        }
        let found = robust_fit(&y, &[&a, &b]).ok_or("fit")?;
        assert!((found.coefficients[0] - 3.0).abs() < 1e-3 && found.count == 499);
        Ok(())
    }
}
