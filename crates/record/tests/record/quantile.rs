//! Quantiles.

use robhaz_record::figures::quantiles;

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
