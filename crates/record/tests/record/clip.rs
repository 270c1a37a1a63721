//! Lines within the range of a panel.

use robhaz_record::figures::{Axis, Layer, Panel, Point, Trace, clip};
use std::ops::Range;

/// The range of a panel with these values.
fn range(points: &[Point], least_span: f64) -> Range<f64> {
    let mut trace = Trace::new(points.len() as u64);
    for (x, y) in points {
        trace.add(*x, Some(*y));
    }
    let panel = Panel::new("", "N (N)", (least_span, 100.0), vec![Layer::Truth(&trace)]);
    Panel::shared_range(&[panel], &Axis::of_places("x (m)", 0.0..2000.0))
}

fn ramp(n: u32) -> Vec<Point> {
    (0..n).map(|k| (f64::from(k), f64::from(k))).collect()
}

/// Ordinary data are shown whole, with a margin.
#[test]
fn the_range_holds_all_ordinary_values() {
    let range = range(&ramp(1000), 1.0);
    assert!(range.start < 0.0 && range.end > 999.0);
    assert!(range.start > -100.0 && range.end < 1100.0);
}

/// An impact of a wheel on an edge does not flatten the rest.
#[test]
fn a_single_peak_does_not_rule_the_range() {
    let mut points = ramp(1000);
    points.push((1000.0, 1e6));
    let range = range(&points, 1.0);
    assert!(range.end > 999.0 && range.end < 2500.0, "{range:?}");
}

/// Constant data, or none, still give a range with a height.
#[test]
fn the_range_has_a_least_height() {
    let constant = [(0.0, 5.0), (1.0, 5.0)];
    let range_of_constant = range(&constant, 2.0);
    assert!(range_of_constant.start < 4.0 && range_of_constant.end > 6.0);
    assert_eq!(range(&[], 2.0), 0.0..2.0);
}

/// A line that leaves the range ends at its edge and begins again at its edge.
#[test]
fn lines_are_cut_at_the_edge() {
    let line = [(0.0, 0.0), (1.0, 2.0), (2.0, 0.0), (3.0, -2.0), (4.0, 4.0)];
    let parts = clip(&line, &(-1.0..1.0));
    assert_eq!(
        parts,
        [
            vec![(0.0, 0.0), (0.5, 1.0)],
            vec![(1.5, 1.0), (2.0, 0.0), (2.5, -1.0)],
            vec![(3.0 + 1.0 / 6.0, -1.0), (3.5, 1.0)],
        ]
    );
    assert!(clip(&[(0.0, 5.0), (1.0, 6.0)], &(-1.0..1.0)).is_empty());
    assert_eq!(clip(&line, &(-9.0..9.0)), [line.to_vec()]);
}
