//! Is the stated standard deviation right? The error against it, and the share of errors within two of them.

use super::caption::caption;
use super::chart::{Chart, Point, Shape, Sheet};
use super::histogram::{Intervals, count_scale};
use super::request::{PlotError, PlotRequest};
use super::scale::{Scale, Spacing, extremes};
use super::selection::Selection;
use crate::figures::header::{Entry, Header, Mark};
use crate::figures::style::{LINKAGE, TRUTH, estimator as color_of, line, spread_color};

/// Share of a normal distribution within two standard deviations.
const WITHIN_TWO: f64 = 0.9545;
const HEIGHT: f64 = 320.0;
const STATED: &str = "stated";
const COVERAGE: &str = "coverage";

/// The figure. The error is `nrmse`: `stated` is relative to the same mean.
///
/// # Errors
/// [`PlotError`]
pub fn calibration(selection: &Selection<'_>, request: &PlotRequest) -> Result<Sheet, PlotError> {
    let stated = selection.dataset.numbers(STATED);
    let points = |estimator: usize| -> Vec<Point> {
        let rows = selection.rows.iter().filter(|r| r.estimator == estimator);
        let point = |r: &super::selection::Row| {
            let sigma = stated.get(r.row).copied().flatten()?;
            (sigma.is_finite() && sigma > 0.0).then_some((sigma, r.value))
        };
        rows.filter_map(point).collect()
    };
    let all: Vec<Vec<Point>> = (0..selection.estimators.len()).map(points).collect();
    let names = selection.estimators.iter().zip(&all);
    let without: Vec<&str> = names
        .clone()
        .filter(|(_, points)| points.is_empty())
        .map(|((_, name), _)| *name)
        .collect();
    if all.iter().all(Vec::is_empty) {
        return Err(PlotError::Nothing {
            name: STATED.to_owned(),
            reason: format!("{} state no standard deviation", without.join(", ")),
        });
    }
    let key = names.filter(|(_, points)| !points.is_empty());
    let key = key
        .map(|((number, name), _)| Entry::new(Mark::Area(color_of(*number).0), (*name).to_owned()));
    let mut key: Vec<Entry> = key.collect();
    key.push(Entry::new(
        Mark::Line(line(TRUTH, 3.2)),
        "error as large as stated",
    ));
    let mut drawn = format!(
        "Left: each point is a run, nrmse against the stated standard deviation, both over the mean of N; on the line they are \
         equal. Right: share of errors within two stated standard deviations in each run; the line is at {WITHIN_TWO}, that of \
         a normal distribution."
    );
    if !without.is_empty() {
        drawn.push_str(&format!(
            " No standard deviation is stated by: {}.",
            without.join(", ")
        ));
    }
    let mut row = vec![scatter(selection, request, &all)];
    row.extend(coverage(selection));
    Ok(Sheet {
        header: Header {
            title: "Calibration: error and stated standard deviation".to_owned(),
            subtitle: String::new(),
            key,
        },
        rows: vec![row],
        caption: caption(selection, drawn),
    })
}

/// Error against stated standard deviation, with one scale on both axes.
fn scatter(selection: &Selection<'_>, request: &PlotRequest, all: &[Vec<Point>]) -> Chart {
    let values = || all.iter().flatten().flat_map(|p| [p.0, p.1]);
    let positive = values().all(|v| v > 0.0);
    let wish = request.x_spacing.or(request.y_spacing).filter(|_| positive);
    let spacing = wish.unwrap_or_else(|| match extremes(values()) {
        // Errors and deviations are compared as ratios, unless they are nearly the same.
        Some((low, high)) if low > 0.0 && high > 4.0 * low => Spacing::Logarithmic,
        _ => Spacing::Linear,
    });
    let scale = Scale::around_errors(values().collect::<Vec<_>>(), spacing);
    let (low, high) = scale.ends();
    let mut shapes = vec![Shape::Line(vec![(low, low), (high, high)], TRUTH, 3.2)];
    for ((number, _), points) in selection.estimators.iter().zip(all) {
        let color = color_of(*number).0;
        shapes.extend(points.iter().map(|p| Shape::Dot(*p, color, 2.2)));
    }
    Chart {
        title: "Error and stated standard deviation".to_owned(),
        x_label: "stated standard deviation of N over mean N".to_owned(),
        y_label: "nrmse".to_owned(),
        x: scale.clone(),
        y: scale,
        width: 1.0,
        height: HEIGHT,
        grid: true,
        shapes,
    }
}

/// Distribution of the coverage; `None` where no row has any.
fn coverage(selection: &Selection<'_>) -> Option<Chart> {
    let values = selection.dataset.numbers(COVERAGE);
    let of = |estimator: usize| {
        let rows = selection
            .rows
            .iter()
            .filter(move |r| r.estimator == estimator);
        rows.filter_map(|r| values.get(r.row).copied().flatten())
    };
    let estimators = 0..selection.estimators.len();
    let all: Vec<f64> = estimators.clone().flat_map(of).collect();
    extremes(all.iter().copied())?;
    let with_nominal = all.into_iter().chain([WITHIN_TWO]);
    let intervals = Intervals::of(with_nominal, Spacing::Linear);
    let counts: Vec<Vec<u64>> = estimators.map(|k| intervals.counts(of(k))).collect();
    let y = count_scale(&counts.concat());
    let top = y.ends().1;
    let mut shapes = Vec::new();
    for ((number, _), counts) in selection.estimators.iter().zip(&counts) {
        if counts.iter().all(|count| *count == 0) {
            continue;
        }
        let color = color_of(*number).0;
        // Bars of the first, outlines of all: those behind stay visible.
        if shapes.is_empty() {
            shapes.extend(intervals.bars(counts, spread_color(color)));
        }
        shapes.push(Shape::Line(intervals.outline(counts), color, 1.6));
    }
    shapes.push(Shape::Dashed(
        vec![(WITHIN_TWO, 0.0), (WITHIN_TWO, top)],
        LINKAGE,
        1.2,
    ));
    Some(Chart {
        title: "Coverage".to_owned(),
        x_label: "share of errors within two standard deviations".to_owned(),
        y_label: "runs".to_owned(),
        x: intervals.scale(),
        y,
        width: 1.0,
        height: HEIGHT,
        grid: true,
        shapes,
    })
}
