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

/// Range of a panel with these values, least first or not: all of them, unless a share `tail` on each side is far beyond
/// the bulk. At least `least_span` high, so that noise does not fill a panel.
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

/// A value with two digits of the height of its axis, at most with units: 4.26 on an axis of 0.5 is not rounded to 4.
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

#[cfg(test)]
mod tests {
    use super::*;

    fn ramp(n: u32) -> Vec<f64> {
        (0..n).map(f64::from).collect()
    }

    /// Ordinary data are shown whole, with a margin.
    #[test]
    fn the_range_holds_all_ordinary_values() {
        let range = range(ramp(1000), 1.0, TAIL);
        assert!(range.start < 0.0 && range.end > 999.0);
        assert!(range.start > -100.0 && range.end < 1100.0);
    }

    /// An impact of a wheel on an edge does not flatten the rest, except where no value may be cut.
    #[test]
    fn a_single_peak_does_not_rule_the_range() {
        let values = [ramp(1000), vec![1e6]].concat();
        let cut = range(values.clone(), 1.0, TAIL);
        assert!(cut.end > 999.0 && cut.end < 2500.0, "{cut:?}");
        let whole = range(values, 1.0, 0.0);
        assert!(whole.start < 0.0 && whole.end > 1e6, "{whole:?}");
    }

    /// Constant data, or none, still give a range with a height.
    #[test]
    fn the_range_has_a_least_height() {
        let range_of_constant = range(vec![5.0, 5.0], 2.0, TAIL);
        assert!(range_of_constant.start < 4.0 && range_of_constant.end > 6.0);
        assert_eq!(range(Vec::new(), 2.0, TAIL), 0.0..2.0);
    }

    /// A line that leaves the range runs along its edge, and the note says how far it goes.
    #[test]
    fn lines_are_cut_at_the_edge() {
        let line = [(0.0, 0.0), (1.0, 2.0), (2.0, -3.0)];
        let shown = [(0.0, 0.0), (1.0, 1.0), (2.0, -1.0)];
        assert_eq!(clamp(&line, &(-1.0..1.0)), shown);
        let note = cut(line.iter().map(|p| p.1), &(-1.0..1.0));
        assert_eq!(note.as_deref(), Some("cut: -3 to 2"));
        assert_eq!(cut([0.5].into_iter(), &(-1.0..1.0)), None);
    }
}
