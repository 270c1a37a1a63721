//! Ranges and notes of panels.

use crate::drawn::{svg, values};
use plotters::style::BLACK;
use robhaz_record::figures::style::truth_line;
use robhaz_record::figures::{Axis, Estimated, Layer, Panel, Scale, Trace};

/// Share of the values on each side that may be cut, as in a figure.
const TAIL: f64 = 0.005;

fn trace(values: impl Fn(f64) -> f64) -> Trace {
    let mut trace = Trace::new(201);
    for k in 0..=200 {
        let time = f64::from(k) / 100.0;
        trace.add(time, Some(values(time)));
    }
    trace
}

fn panel(layers: Vec<Layer>) -> Panel {
    Panel::new("", "N (N)", (2.0, 100.0), layers)
}

/// Closed form: truth 10 N at all times, estimate 12 N that starts at 900 N. From 0.5 s on 10 to 12
/// N are shown; with the margin of 6 % of 2 N, the range is 9.88 to 12.12 N. If the start counts it
/// reaches further.
#[test]
fn samples_before_the_filter_has_settled_do_not_set_the_range() {
    let truth = trace(|_| 10.0);
    let mut estimate = Estimated::new(201);
    estimate.line = trace(|t| if t < 0.4 { 900.0 } else { 12.0 });
    let panels = [panel(vec![
        Layer::peaks(&truth, truth_line()),
        Layer::estimate(&estimate, BLACK),
    ])];
    let axis = |compare_from: f64| Axis {
        label: "time (s)",
        range: 0.0..2.0,
        compare_from,
    };
    let range = Panel::shared_range(&panels, &axis(0.5), TAIL);
    assert!((range.start - 9.88).abs() < 1e-9 && (range.end - 12.12).abs() < 1e-9);
    assert!(Panel::shared_range(&panels, &axis(0.0), TAIL).end > 100.0);
    // Nothing is compared in a run of 2 s: all counts.
    assert!(Panel::shared_range(&panels, &axis(3.0), TAIL).end > 100.0);
}

/// Closed form: 1 at 400 places, and -0.26 at one. The common range cuts the peak and says to
/// where, with the digits of its axis; the whole range holds it, with the margin of 6 % of 1.26.
#[test]
fn a_cut_peak_is_named_with_the_digits_of_its_axis() {
    let at = (0..400).map(|k| if k == 7 { -0.26 } else { 1.0 });
    let panel = || Panel {
        least_span: 0.1,
        ..panel(vec![values(at.clone(), BLACK)])
    };
    let axis = Axis::of_places("x (m)", 0.0..400.0);
    let cut = svg(panel(), &axis, Scale::Own);
    assert!(cut.contains("\ncut: down to -0.26\n"));
    let whole = Panel::shared_range(&[panel()], &axis, 0.0);
    assert!((whole.start + 0.26 + 0.06 * 1.26).abs() < 1e-9);
    assert!(!svg(panel(), &axis, Scale::Whole).contains("cut:"));
}
