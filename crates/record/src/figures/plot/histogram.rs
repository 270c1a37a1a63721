//! How often a score has which value: a chart for each estimator, with the same intervals.

use super::caption::caption;
use super::chart::{Chart, Shape, Sheet};
use super::request::{PlotError, PlotRequest};
use super::scale::{Scale, Spacing, extremes, label};
use super::selection::Selection;
use crate::figures::header::Header;
use crate::figures::style::{LINKAGE, estimator as color_of, spread_color};
use crate::quantile::quantiles;
use plotters::style::RGBColor;

/// Least and largest number of intervals.
const INTERVALS: (f64, f64) = (20.0, 40.0);
const HEIGHT: f64 = 120.0;

/// Equal intervals along an axis.
pub struct Intervals {
    spacing: Spacing,
    low: f64,
    width: f64,
    count: usize,
}

impl Intervals {
    /// Intervals that hold all values, as wide as Freedman and Diaconis (1981) have it: 2 IQR n^(-1/3).
    pub fn of(values: impl Iterator<Item = f64>, spacing: Spacing) -> Self {
        let values: Vec<f64> = values.map(|v| spacing.coordinate(v)).collect();
        let (low, high) = extremes(values.iter().copied()).unwrap_or((0.0, 1.0));
        let n = values.len().max(1) as f64;
        let [first, third] = quantiles(values, [0.25, 0.75]).unwrap_or([low, high]);
        let wide = 2.0 * (third - first) / n.cbrt();
        let count = ((high - low) / wide).ceil();
        // Equal quartiles: no width.
        let count = if count.is_finite() {
            count
        } else {
            INTERVALS.0
        };
        let count = count.clamp(INTERVALS.0, INTERVALS.1);
        let width = match high - low {
            span if span > 0.0 => span / count,
            _ => (0.01 * high.abs()).max(1e-9),
        };
        Self {
            spacing,
            low,
            width,
            count: count as usize,
        }
    }

    /// Numbers of values in each interval.
    pub fn counts(&self, values: impl Iterator<Item = f64>) -> Vec<u64> {
        let mut counts = vec![0; self.count];
        for value in values {
            let place = (self.spacing.coordinate(value) - self.low) / self.width;
            let place = (place.floor().max(0.0) as usize).min(self.count - 1);
            if let Some(count) = counts.get_mut(place) {
                *count += 1;
            }
        }
        counts
    }

    /// Bars of these counts.
    pub fn bars(&self, counts: &[u64], color: RGBColor) -> Vec<Shape> {
        let at = |k: usize| self.spacing.value(self.low + k as f64 * self.width);
        let bars = counts.iter().enumerate().filter(|(_, count)| **count > 0);
        let bar = |(k, count): (usize, &u64)| {
            let top = *count as f64;
            Shape::Cell([(at(k), top), (at(k + 1), 0.0)], color)
        };
        bars.map(bar).collect()
    }

    /// Steps along the tops of these counts, from zero to zero.
    pub fn outline(&self, counts: &[u64]) -> Vec<(f64, f64)> {
        let at = |k: usize| self.spacing.value(self.low + k as f64 * self.width);
        let steps = counts.iter().enumerate().flat_map(|(k, count)| {
            let top = *count as f64;
            [(at(k), top), (at(k + 1), top)]
        });
        let (first, last) = ((at(0), 0.0), (at(counts.len()), 0.0));
        std::iter::once(first).chain(steps).chain([last]).collect()
    }

    /// The axis.
    pub fn scale(&self) -> Scale {
        let room = 0.5 * self.width;
        let high = self.low + self.count as f64 * self.width;
        Scale::between(self.low - room, high + room, self.spacing)
    }
}

/// The axis of counts, from zero on.
pub fn count_scale(counts: &[u64]) -> Scale {
    let most = counts.iter().max().copied().unwrap_or(0).max(1);
    Scale::between(0.0, 1.08 * most as f64, Spacing::Linear)
}

/// The figure.
///
/// # Errors
/// [`PlotError`]
pub fn histogram(selection: &Selection<'_>, request: &PlotRequest) -> Result<Sheet, PlotError> {
    // The horizontal axis is that of the score: either wish holds for it.
    let wish = request.y_spacing.or(request.x_spacing);
    let spacing = selection.score_spacing(wish)?;
    let intervals = Intervals::of(selection.rows.iter().map(|r| r.value), spacing);
    let counts: Vec<Vec<u64>> = (0..selection.estimators.len())
        .map(|k| intervals.counts(selection.scores(k)))
        .collect();
    let y = count_scale(&counts.concat());
    let charts = counts.iter().enumerate().zip(&selection.estimators);
    let charts = charts.map(|((k, counts), (number, name))| {
        let color = color_of(*number).0;
        let mut shapes = intervals.bars(counts, spread_color(color));
        let ends = quantiles(selection.scores(k), [0.05, 0.5, 0.95]);
        let [low, median, high] = ends.unwrap_or([f64::NAN; 3]);
        let level = |value: f64| vec![(value, 0.0), (value, y.ends().1)];
        shapes.push(Shape::Line(level(median), LINKAGE, 1.6));
        shapes.push(Shape::Dashed(level(low), LINKAGE, 1.0));
        shapes.push(Shape::Dashed(level(high), LINKAGE, 1.0));
        let number = |v: f64| label(v, 0.0);
        vec![Chart {
            title: format!(
                "{name}: median {}, 5 to 95 %: {} to {}",
                number(median),
                number(low),
                number(high)
            ),
            x_label: selection.score_label(),
            y_label: "runs".to_owned(),
            x: intervals.scale(),
            y: y.clone(),
            width: 1.0,
            height: HEIGHT,
            grid: true,
            shapes,
        }]
    });
    let drawn = "Number of runs in each interval; line: median, dashed: 5 and 95 %.".to_owned();
    Ok(Sheet {
        rows: charts.collect(),
        header: Header {
            title: format!("Distribution of {}", selection.score.name),
            subtitle: String::new(),
            key: Vec::new(),
        },
        caption: caption(selection, drawn),
    })
}
