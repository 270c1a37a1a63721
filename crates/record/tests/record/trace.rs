//! Lines at the resolution of a figure.

use robhaz_record::figures::{Estimated, Trace};

/// Property: a peak of a single record among a hundred thousand is not lost.
#[test]
fn peaks_survive() {
    let mut trace = Trace::new(100_000);
    for k in 0..100_000 {
        let value = if k == 54_321 { 99.0 } else { f64::from(k % 7) };
        trace.add(f64::from(k), Some(value));
    }
    let pieces = trace.extremes();
    assert_eq!(pieces.len(), 1);
    assert!(pieces[0].len() <= 1200);
    assert!(pieces[0].contains(&(54_321.0, 99.0)));
    assert!(pieces[0].is_sorted_by(|a, b| a.0 < b.0));
    assert!(trace.highs()[0].iter().any(|p| p.1 > 98.0));
}

/// Closed form: means and extremes of a saw-tooth of ten records an interval.
#[test]
fn a_interval_keeps_its_mean_and_its_extremes() {
    let mut trace = Trace::new(6000);
    for k in 0..6000_u32 {
        trace.add(f64::from(k), Some(f64::from(k % 10)));
    }
    assert_eq!(trace.means()[0][0], (4.5, 4.5));
    assert_eq!(trace.lows()[0][1], (14.5, 0.0));
    assert_eq!(trace.highs()[0][1], (14.5, 9.0));
    assert_eq!(trace.means()[0].len(), 600);
}

/// Property: a short run is kept whole, its last record too.
#[test]
fn few_records_are_all_kept() {
    let mut trace = Trace::new(3);
    for k in 0..3 {
        trace.add(f64::from(k), Some(f64::from(k)));
    }
    let whole = [[(0.0, 0.0), (1.0, 1.0), (2.0, 2.0)]];
    assert_eq!(trace.extremes(), whole);
    assert_eq!(trace.means(), whole);
}

/// Property: a line is not drawn across records without a value.
#[test]
fn missing_values_break_the_line() {
    let mut trace = Trace::new(6);
    for (k, value) in [None, Some(1.0), Some(2.0), None, Some(f64::NAN), Some(3.0)]
        .into_iter()
        .enumerate()
    {
        trace.add([0.0, 1.0, 2.0, 3.0, 4.0, 5.0][k], value);
    }
    assert_eq!(
        trace.extremes(),
        [vec![(1.0, 1.0), (2.0, 2.0)], vec![(5.0, 3.0)]]
    );
}

/// Closed form: the outline of a band goes along its lower bound and back along the upper one.
#[test]
fn a_band_is_closed_around_its_centre() {
    let mut estimated = Estimated::new(3);
    assert!(!estimated.has_band());
    for k in 0..3 {
        estimated.add(f64::from(k), Some(10.0), Some(1.0));
    }
    assert_eq!(
        estimated.band(),
        [[
            (0.0, 8.0),
            (1.0, 8.0),
            (2.0, 8.0),
            (2.0, 12.0),
            (1.0, 12.0),
            (0.0, 12.0)
        ]]
    );
}
