//! The range of a panel, and values outside of it.

use crate::drawn::{svg, values};
use plotters::style::{BLACK, RED};
use robhaz_record::figures::{Axis, Layer, Panel, Scale};
use std::ops::Range;

/// Share of the values on each side that may be cut, as in a figure.
const TAIL: f64 = 0.005;

fn panel(of: impl IntoIterator<Item = f64>, least_span: f64) -> Panel {
    Panel::new("", "N (N)", (least_span, 100.0), vec![values(of, BLACK)])
}

fn axis() -> Axis {
    Axis::of_places("x (m)", 0.0..2000.0)
}

/// The range of a panel with these values.
fn range(of: Vec<f64>, least_span: f64, tail: f64) -> Range<f64> {
    Panel::shared_range(&[panel(of, least_span)], &axis(), tail)
}

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

/// A line that leaves the range runs along its edge; so does the border of an area.
#[test]
fn lines_are_cut_at_the_edge() {
    let drawn = |at: [f64; 3]| {
        let corners = at
            .into_iter()
            .enumerate()
            .map(|(k, y)| (f64::from(k as u32), y));
        let layers = vec![values(at, BLACK), Layer::area(corners.collect(), RED)];
        let panel = Panel {
            range: Some(-1.0..1.0),
            ..Panel::new("", "N (N)", (1.0, 100.0), layers)
        };
        svg(panel, &Axis::of_places("x (m)", 0.0..2.0), Scale::Own)
    };
    assert_eq!(drawn([0.0, 2.0, -3.0]), drawn([0.0, 1.0, -1.0]));
    assert_ne!(drawn([0.0, 2.0, -3.0]), drawn([0.0, 0.5, -1.0]));
}

/// A note says how far the values go that are cut, with the digits of the axis, where there are
/// any.
#[test]
fn what_is_cut_is_named() {
    let note = |of: Vec<f64>, scale| {
        let svg = svg(panel(of, 1.0), &axis(), scale);
        let note = svg.lines().find(|line| line.contains("cut:"));
        note.map(str::to_owned)
    };
    let wave = |low: f64, high: f64| -> Vec<f64> {
        let middle = 0.5 * (low + high);
        let at = |k: u32| middle + 0.5 * (high - low) * f64::from(k).sin();
        (0..1000).map(at).collect()
    };
    let with = |base: &[f64], peaks: &[f64]| [base, peaks].concat();
    let (level, high) = (wave(-1.0, 1.0), wave(100.0, 190.0));
    for (values, expected) in [
        (with(&level, &[5.0, -6.0]), Some("cut: -6 to 5")),
        (with(&high, &[-0.3]), Some("cut: down to 0")),
        (with(&high, &[304.7]), Some("cut: up to 305")),
        (with(&level, &[1.5]), None),
    ] {
        assert_eq!(note(values.clone(), Scale::Own).as_deref(), expected);
        assert_eq!(note(values, Scale::Whole), None);
    }
}
