//! The range that a panel shows, and the parts of a line inside it.

use super::trace::Point;
use crate::quantile::extremes;
use std::ops::Range;

/// Share of the values on each side that may lie outside of the bulk.
const TAIL: f64 = 0.005;
/// Largest distance of the range from the bulk, in heights of the bulk.
const REACH: f64 = 0.5;
/// Margin above and below, as a share of the range.
const MARGIN: f64 = 0.06;

/// Range of a panel with these lines: all values, unless single peaks are far beyond the bulk of the values.
///
/// At least `least_span` high, so that noise does not fill a panel.
pub fn range<'a>(lines: impl Iterator<Item = &'a Point>, least_span: f64) -> Range<f64> {
    let mut values: Vec<f64> = lines.map(|p| p.1).collect();
    values.sort_by(f64::total_cmp);
    let (Some(first), Some(last)) = (values.first().copied(), values.last().copied()) else {
        return 0.0..least_span;
    };
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        clippy::cast_precision_loss,
        reason = "an index into some thousand values"
    )]
    let tail = (values.len() as f64 * TAIL) as usize;
    let (low, high) = (values[tail], values[values.len() - 1 - tail]);
    let bulk = (high - low).max(least_span);
    let low = first.max(low - REACH * bulk);
    let high = last.min(high + REACH * bulk);
    with_margin(low, high, least_span)
}

/// Range of a panel with all values of these lines, at least `least_span` high.
pub fn whole<'a>(lines: impl Iterator<Item = &'a Point>, least_span: f64) -> Range<f64> {
    let (low, high) = extremes(lines.map(|p| p.1));
    if low > high {
        return 0.0..least_span;
    }
    with_margin(low, high, least_span)
}

fn with_margin(low: f64, high: f64, least_span: f64) -> Range<f64> {
    let middle = 0.5 * (low + high);
    let half = (0.5 + MARGIN) * (high - low).max(least_span);
    middle - half..middle + half
}

/// A note where a panel does not show all values.
pub fn cut(points: impl Iterator<Item = Point>, range: &Range<f64>) -> Option<String> {
    let (low, high) = extremes(points.map(|p| p.1));
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

/// The parts of a line that lie in the range.
pub fn clip(line: &[Point], range: &Range<f64>) -> Vec<Vec<Point>> {
    let inside = |p: &Point| range.contains(&p.1);
    let mut parts = vec![Vec::new()];
    for (i, point) in line.iter().enumerate() {
        if i > 0 {
            for crossing in crossings(line[i - 1], *point, range) {
                // A crossing ends a part or begins one.
                let ends = parts.last().is_some_and(|part| !part.is_empty());
                push(&mut parts, crossing);
                if ends {
                    parts.push(Vec::new());
                }
            }
        }
        if inside(point) {
            push(&mut parts, *point);
        }
    }
    parts.retain(|part| part.len() > 1);
    parts
}

/// The corners of an area, with those outside of the range moved to its edge.
pub fn clamp(corners: &[Point], range: &Range<f64>) -> Vec<Point> {
    let inside = |p: &Point| (p.0, p.1.clamp(range.start, range.end));
    corners.iter().map(inside).collect()
}

fn push(parts: &mut [Vec<Point>], point: Point) {
    if let Some(part) = parts.last_mut() {
        part.push(point);
    }
}

/// Where the straight line from `a` to `b` crosses the bounds, in order.
fn crossings(a: Point, b: Point, range: &Range<f64>) -> impl Iterator<Item = Point> {
    let (low, high) = (range.start, range.end);
    let bounds = if a.1 < b.1 { [low, high] } else { [high, low] };
    bounds.into_iter().filter_map(move |bound| {
        let crosses = (a.1 < bound) != (b.1 < bound);
        crosses.then(|| {
            let share = (bound - a.1) / (b.1 - a.1);
            (a.0 + share * (b.0 - a.0), bound)
        })
    })
}
