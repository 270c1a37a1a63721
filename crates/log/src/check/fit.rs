//! Least squares with few coefficients, and delays between signals.

use crate::check::signal::median;
use nalgebra::{SMatrix, SVector};

/// Coefficients of a least-squares fit.
#[derive(Clone, Copy, Debug)]
pub struct Fit<const K: usize> {
    /// In the order of the regressors.
    pub coefficients: [f64; K],
    /// Standard deviations of the coefficients where residuals are independent from sample to
    /// sample.
    pub deviations: [f64; K],
    /// Share of the mean square of `y` that the fit explains: 0 to 1.
    pub explained: f64,
    /// Number of samples.
    pub count: usize,
}

/// Fits `y` by a sum of the regressors `x`, over the samples where all are there. `None` where they
/// do not determine the coefficients.
pub fn fit<const K: usize>(y: &[f64], x: &[impl AsRef<[f64]>; K]) -> Option<Fit<K>> {
    let mut normal = SMatrix::<f64, K, K>::zeros();
    let (mut right, mut square) = (SVector::<f64, K>::zeros(), 0.0);
    let mut count = 0;
    for (i, y) in y.iter().enumerate() {
        let row = SVector::<f64, K>::from_fn(|k, _| *x[k].as_ref().get(i).unwrap_or(&f64::NAN));
        if y.is_finite() && row.iter().all(|v| v.is_finite()) {
            normal += row * row.transpose();
            right += row * *y;
            square += y * y;
            count += 1;
        }
    }
    if count <= K || square <= 0.0 {
        return None;
    }
    // Scaled to ones on the diagonal, so that the limit does not depend on units.
    let scale = SVector::<f64, K>::from_fn(|k, _| 1.0 / normal[(k, k)].sqrt());
    let scaled = SMatrix::<f64, K, K>::from_fn(|i, j| normal[(i, j)] * scale[i] * scale[j]);
    let factor = scaled.cholesky()?;
    let inverse = factor.inverse();
    if !inverse.iter().all(|v| v.is_finite() && v.abs() < 1e8) {
        return None;
    }
    let coefficients = (inverse * right.component_mul(&scale)).component_mul(&scale);
    let left = (square - coefficients.dot(&right)).max(0.0);
    Some(Fit {
        coefficients: core::array::from_fn(|k| coefficients[k]),
        deviations: core::array::from_fn(|k| {
            scale[k] * (inverse[(k, k)] * left / count as f64).sqrt()
        }),
        explained: 1.0 - left / square,
        count,
    })
}

/// As [`fit`], without the samples whose residuals are beyond five standard deviations of the
/// middle ones: impacts.
pub fn robust_fit<const K: usize>(y: &[f64], x: &[impl AsRef<[f64]>; K]) -> Option<Fit<K>> {
    let mut kept = y.to_vec();
    let mut found = fit(&kept, x)?;
    for _ in 0..3 {
        let residuals = residuals(y, x, &found);
        // 1.48 times the median of the magnitudes is the standard deviation of normal errors.
        let sigma = 1.48 * median(residuals.iter().map(|r| r.abs()))?;
        for ((kept, y), r) in kept.iter_mut().zip(y).zip(&residuals) {
            *kept = if r.abs() <= 5.0 * sigma { *y } else { f64::NAN };
        }
        found = fit(&kept, x)?;
    }
    Some(found)
}

/// What the fit leaves of `y`.
pub fn residuals<const K: usize>(y: &[f64], x: &[impl AsRef<[f64]>; K], fit: &Fit<K>) -> Vec<f64> {
    let part = |k: usize, i: usize| fit.coefficients[k] * x[k].as_ref()[i];
    let predicted = |i: usize| -> f64 { (0..K).map(|k| part(k, i)).sum() };
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
