//! Figs. 5 to 8 of the paper, and figures of the same form for any estimator.

use super::header::{Entry, Header, Mark};
use super::page::{Column, Page};
use super::panel::{Axis, Layer, Panel};
use super::run::{EstimatorTraces, PINS, RunTraces};
use super::style::{LINKAGE, START, WHEELS, band_color, estimate_line, spread_color, truth_line};
use super::trace::{Band, Trace};
use crate::summary::EstimatorSummary;
use plotters::style::RGBColor;

/// Titles of the panels of the wheels.
pub const WHEEL_TITLES: [&str; 3] = ["Wheel 1 (front)", "Wheel 2 (middle)", "Wheel 3 (rear)"];
/// Height of a panel, px.
const HEIGHT: f64 = 138.0;

/// Time from 0 to the end of the run.
pub fn time_axis(run: &RunTraces) -> Axis {
    Axis {
        label: "time (s)",
        range: 0.0..run.end,
        compare_from: run.rule.compare_from,
    }
}

/// The entry of the key that explains the shaded time before errors count, if there is any.
pub fn start_entry(run: &RunTraces) -> Option<Entry> {
    let from = run.rule.compare_from;
    let label = format!("start, not compared (before {from} s)");
    (from > 0.0).then(|| Entry::new(Mark::Area(START), label))
}

/// Fig. 5: the pins' positions.
pub fn linkage(run: &RunTraces) -> Page<'_> {
    let column = |axis: usize, y_label: &'static str| {
        Column::of_own_scales(PINS.iter().enumerate().map(move |(k, (_, title))| {
            let estimate = run.shown.as_ref().map(|s| &s.pins[k][axis]);
            let error = run
                .shown
                .as_ref()
                .and_then(|s| s.pin_errors[k][axis].value());
            Panel {
                title: (*title).to_owned(),
                note: error.map_or(String::new(), pin_note),
                y_label,
                least_span: 2.0,
                logarithmic: false,
                height: HEIGHT,
                layers: layers(&run.pins[k][axis], estimate, None, LINKAGE),
            }
        }))
    };
    Page {
        header: Header {
            title: "Position of the linkage's pins (the paper's Fig. 5)".to_owned(),
            subtitle: "in world axes, measured from pin Q".to_owned(),
            key: key(run, shown(run), &[LINKAGE], false),
        },
        axis: time_axis(run),
        columns: vec![column(0, "x from Q (mm)"), column(1, "y from Q (mm)")],
    }
}

/// Fig. 6: N and T of every wheel.
pub fn forces(run: &RunTraces) -> Page<'_> {
    let summary = shown(run).map(|e| e.summary());
    let errors = summary.and_then(|s| s.normal_force.zip(s.traction));
    let normal = (0..3).map(|i| {
        let estimate = shown(run);
        force_panel(i, "normal force N (N)").with(
            errors.map(|(n, _)| n.rmse[i]),
            layers(
                &run.normal_force[i],
                estimate.map(|e| &e.normal_force[i]),
                estimate.map(|e| &e.band[i]),
                WHEELS[i],
            ),
        )
    });
    let traction = (0..3).map(|i| {
        let estimate = run.shown.as_ref();
        force_panel(i, "traction T (N)").with(
            errors.map(|(_, t)| t.rmse[i]),
            layers(
                &run.traction[i],
                estimate.map(|s| &s.traction[i]),
                estimate.map(|s| &s.traction_band[i]),
                WHEELS[i],
            ),
        )
    });
    let banded = shown(run).is_some_and(has_band);
    Page {
        header: Header {
            title: "Force distribution over the wheels (the paper's Fig. 6)".to_owned(),
            subtitle: String::new(),
            key: key(run, shown(run), &WHEELS, banded),
        },
        axis: time_axis(run),
        columns: vec![Column::of_one_scale(normal), Column::of_one_scale(traction)],
    }
}

/// Figs. 7 and 8, and figures of the same form: N of every wheel; with a covariance also its error, each with two
/// standard deviations.
pub fn normal_forces<'a>(run: &'a RunTraces, estimator: &'a EstimatorTraces) -> Page<'a> {
    let summary = estimator.summary();
    let errors = summary.normal_force;
    let normal = (0..3).map(|i| {
        let (truth, band) = (&run.normal_force[i], &estimator.band[i]);
        let estimate = Some(&estimator.normal_force[i]);
        force_panel(i, "normal force N (N)").with(
            errors.map(|e| e.rmse[i]),
            layers(truth, estimate, Some(band), WHEELS[i]),
        )
    });
    let mut columns = vec![Column::of_one_scale(normal)];
    let banded = has_band(estimator);
    if banded && run.has_truth() {
        let error = (0..3).map(|i| Panel {
            least_span: 0.2,
            ..force_panel(i, "error of N (N)").with(
                None,
                vec![
                    Layer::Band(&estimator.error_band[i], WHEELS[i]),
                    Layer::Estimate(&estimator.error[i], WHEELS[i]),
                    Layer::Level(0.0),
                ],
            )
        });
        columns.push(Column::of_one_scale(error));
    }
    Page {
        header: Header {
            title: estimator.kind.names(&estimator.name).1,
            subtitle: overall(&summary),
            key: key(run, Some(estimator), &WHEELS, banded),
        },
        axis: time_axis(run),
        columns,
    }
}

/// Needed friction of every wheel with two standard deviations, of an estimator that states them.
pub fn needed_friction<'a>(run: &'a RunTraces, estimator: &'a EstimatorTraces) -> Page<'a> {
    let panel = |i: usize| Panel {
        least_span: 0.02,
        ..force_panel(i, "needed friction T/N").with(
            None,
            layers(
                &run.needed[i],
                Some(&estimator.needed[i]),
                Some(&estimator.needed_band[i]),
                WHEELS[i],
            ),
        )
    };
    Page {
        header: Header {
            title: format!("Needed friction by {}", estimator.name),
            subtitle: String::new(),
            key: key(run, Some(estimator), &WHEELS, true),
        },
        axis: time_axis(run),
        columns: vec![Column::of_one_scale((0..3).map(panel))],
    }
}

/// The estimator that Figs. 5 and 6 show.
fn shown(run: &RunTraces) -> Option<&EstimatorTraces> {
    run.shown.as_ref().map(|s| &run.estimators[s.index])
}

fn has_band(estimator: &EstimatorTraces) -> bool {
    estimator.band.iter().any(|band| !band.is_empty())
}

/// A panel of a force on a wheel without content.
fn force_panel<'a>(wheel: usize, y_label: &'static str) -> Panel<'a> {
    Panel {
        title: WHEEL_TITLES[wheel].to_owned(),
        note: String::new(),
        y_label,
        least_span: 2.0,
        logarithmic: false,
        height: HEIGHT,
        layers: Vec::new(),
    }
}

impl<'a> Panel<'a> {
    /// The panel with its layers, and with an RMSE (N) as its note.
    fn with(self, rmse: Option<f64>, layers: Vec<Layer<'a>>) -> Self {
        Self {
            note: rmse.map_or(String::new(), |r| format!("RMSE {r:.2} N")),
            layers,
            ..self
        }
    }
}

/// Truth, estimate and its band.
fn layers<'a>(
    truth: &'a Trace,
    estimate: Option<&'a Trace>,
    band: Option<&'a Band>,
    color: RGBColor,
) -> Vec<Layer<'a>> {
    let band = band.map(|band| Layer::Band(band, color));
    let estimate = estimate.map(|trace| Layer::Estimate(trace, color));
    let truth = Layer::Truth(truth);
    band.into_iter().chain([truth]).chain(estimate).collect()
}

/// The key to panels of truth and one estimator.
fn key(
    run: &RunTraces,
    estimator: Option<&EstimatorTraces>,
    colors: &[RGBColor],
    banded: bool,
) -> Vec<Entry> {
    let truth = || Entry::new(Mark::Line(truth_line()), "true");
    let mut key: Vec<Entry> = run.has_truth().then(truth).into_iter().collect();
    let marks = |mark: &dyn Fn(RGBColor) -> Mark| colors.iter().map(|c| mark(*c)).collect();
    if let Some(estimator) = estimator {
        let thinned = estimator.rms_error.stride() > 1;
        let mean = if thinned { ", mean" } else { "" };
        key.push(Entry {
            marks: marks(&|c| Mark::Line(estimate_line(c))),
            label: format!("estimated ({}){mean}", estimator.name),
        });
        if thinned {
            key.push(Entry {
                marks: marks(&|c| Mark::Area(spread_color(c))),
                label: format!("its range within {:.0} ms", 1e3 * run.interval),
            });
        }
        if banded {
            key.push(Entry {
                marks: marks(&|c| Mark::Area(band_color(c))),
                label: "two standard deviations".to_owned(),
            });
        }
    }
    key.extend(start_entry(run));
    key
}

/// The error of a pin's position as text; `rms` in mm.
fn pin_note(rms: f64) -> String {
    if rms < 0.01 {
        "RMSE below 0.01 mm".to_owned()
    } else {
        format!("RMSE {rms:.2} mm")
    }
}

/// The error over all wheels as text.
fn overall(summary: &EstimatorSummary) -> String {
    let Some(errors) = summary.normal_force else {
        return "nothing to compare".to_owned();
    };
    let rmse = format!("RMSE over the three wheels {:.2} N", errors.rmse_all);
    match errors.nrmse {
        Some(nrmse) => format!("{rmse} = {:.1} % of the mean normal force", 100.0 * nrmse),
        None => rmse,
    }
}
