//! Quantiles of a sample.

/// Quantiles of values in any order, at each of the `shares` (0 to 1), linear between neighbours:
/// type 7 of Hyndman and Fan (1996), as R and NumPy have it by default. `None` of no values.
pub fn quantiles<const N: usize>(
    values: impl IntoIterator<Item = f64>,
    shares: [f64; N],
) -> Option<[f64; N]> {
    let mut sorted: Vec<f64> = values.into_iter().collect();
    sorted.sort_by(f64::total_cmp);
    let last = sorted.len().checked_sub(1)?;
    Some(shares.map(|share| {
        let place = share.clamp(0.0, 1.0) * last as f64;
        let below = place.floor() as usize;
        let (low, high) = (sorted[below], sorted[(below + 1).min(last)]);
        low + (place - place.floor()) * (high - low)
    }))
}
