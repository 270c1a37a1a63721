//! Extremes and quantiles of a sample.

/// Least and largest of some values; infinite and the wrong way round of none.
pub fn extremes(values: impl IntoIterator<Item = f64>) -> (f64, f64) {
    let none = (f64::INFINITY, f64::NEG_INFINITY);
    let wider = |(low, high): (f64, f64), value: f64| (low.min(value), high.max(value));
    values.into_iter().fold(none, wider)
}

/// The `share`-quantile (0 to 1) of ascending values, linear between neighbours: type 7 of Hyndman and Fan (1996), as R
/// and NumPy have it by default. `None` of no values.
pub fn quantile(ascending: &[f64], share: f64) -> Option<f64> {
    let last = ascending.len().checked_sub(1)?;
    let place = share.clamp(0.0, 1.0) * last as f64;
    let below = place.floor() as usize;
    let (low, high) = (ascending.get(below)?, ascending.get((below + 1).min(last))?);
    Some(low + (place - place.floor()) * (high - low))
}

/// Quantiles of values in any order, at each of the `shares`; `None` of no values.
pub fn quantiles<const N: usize>(
    values: impl IntoIterator<Item = f64>,
    shares: [f64; N],
) -> Option<[f64; N]> {
    let mut sorted: Vec<f64> = values.into_iter().collect();
    sorted.sort_by(f64::total_cmp);
    (!sorted.is_empty()).then(|| shares.map(|share| quantile(&sorted, share).unwrap_or(f64::NAN)))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Closed form: of 0, 1 ... 20 the quantile of a share is 20 times the share; between two values it is linear.
    #[test]
    fn quantiles_of_evenly_spaced_values_are_linear() {
        let values = (0..=20).rev().map(f64::from);
        let found = quantiles(values, [0.0, 0.05, 0.25, 0.33, 0.5, 0.95, 1.0]);
        let expected = [0.0, 1.0, 5.0, 6.6, 10.0, 19.0, 20.0];
        let found = found.expect("21 values");
        // Rounding of a few products.
        assert!(
            found
                .iter()
                .zip(expected)
                .all(|(f, e)| (f - e).abs() < 1e-12),
            "{found:?}"
        );
    }

    /// Closed form: one value is each of its quantiles; the median of two is their mean; none has no quantile.
    #[test]
    fn small_samples_have_quantiles() {
        assert_eq!(quantiles([3.0], [0.05, 0.5, 0.95]), Some([3.0; 3]));
        assert_eq!(quantiles([4.0, 1.0], [0.5]), Some([2.5]));
        assert_eq!(quantiles([], [0.5]), None);
    }
}
