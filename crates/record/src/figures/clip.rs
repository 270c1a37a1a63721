//! The range that a panel shows, and values outside of it.

use super::trace::Point;
use crate::quantile::extremes;
use std::ops::Range;

/// Share of the values on each side that may lie outside of the bulk.
pub const TAIL: f64 = 0.005;
/// Largest distance of the range from the bulk, in heights of the bulk.
const REACH: f64 = 0.5;
/// Margin above and below, as a share of the range.
const MARGIN: f64 = 0.06;

/// Range of a panel with these values, least first or not: all of them, unless a share `tail` on
/// each side is far beyond the bulk. At least `least_span` high, so that noise does not fill a
/// panel.
pub fn range(mut values: Vec<f64>, least_span: f64, tail: f64) -> Range<f64> {
    values.sort_by(f64::total_cmp);
    let (Some(first), Some(last)) = (values.first().copied(), values.last().copied()) else {
        return 0.0..least_span;
    };
    // An index into some thousand values.
    let tail = (values.len() as f64 * tail) as usize;
    let (low, high) = (values[tail], values[values.len() - 1 - tail]);
    let bulk = (high - low).max(least_span);
    let low = first.max(low - REACH * bulk);
    let high = last.min(high + REACH * bulk);
    let middle = 0.5 * (low + high);
    let half = (0.5 + MARGIN) * (high - low).max(least_span);
    middle - half..middle + half
}

/// A note where a panel does not show all values.
pub fn cut(values: impl Iterator<Item = f64>, range: &Range<f64>) -> Option<String> {
    let (low, high) = extremes(values);
    let below = low < range.start;
    let above = high > range.end;
    let height = range.end - range.start;
    let (low, high) = (rounded(low, height), rounded(high, height));
    match (below, above) {
        (true, true) => Some(format!("cut: {low} to {high}")),
        (true, false) => Some(format!("cut: down to {low}")),
        (false, true) => Some(format!("cut: up to {high}")),
        (false, false) => None,
    }
}

/// A value with two digits of the height of its axis, at most with units: 4.26 on an axis of 0.5 is
/// not rounded to 4.
fn rounded(value: f64, height: f64) -> f64 {
    let unit = 10f64.powf((height.log10().floor() - 1.0).min(0.0));
    tidy((value / unit).round() * unit)
}

/// A value without the rounding error of binary fractions.
pub fn tidy(value: f64) -> f64 {
    // Adding 0 turns -0 into 0.
    (value * 1e6).round() / 1e6 + 0.0
}

/// The points of a line or corners of an area, with those outside of the range moved to its edge.
pub fn clamp(corners: &[Point], range: &Range<f64>) -> Vec<Point> {
    let inside = |p: &Point| (p.0, p.1.clamp(range.start, range.end));
    corners.iter().map(inside).collect()
}
