//! Figs. 5 to 8 of the paper, and figures of the same form for any estimator.

use super::page::{Entry, Mark, Page, Scale};
use super::panel::{Axis, Layer, Panel};
use super::run::{EstimatorTraces, PINS, RunTraces};
use super::style::{LINKAGE, START, WHEELS, band_color, estimate_line, truth_line};
use super::trace::{Estimated, Trace};
use plotters::style::RGBColor;
use robhaz_score::ForceErrors;

/// Titles of the panels of the wheels.
const WHEEL_TITLES: [&str; 3] = ["Wheel 1 (front)", "Wheel 2 (middle)", "Wheel 3 (rear)"];
/// Height of a panel, px.
const HEIGHT: f64 = 138.0;

/// A quantity of a wheel: name of the vertical axis, and least height of its range.
type Quantity = (&'static str, f64);
const NORMAL_FORCE: Quantity = ("normal force N (N)", 2.0);
const TRACTION: Quantity = ("traction T (N)", 2.0);
const ERROR: Quantity = ("error of N (N)", 0.2);

/// A figure over time.
fn page(
    run: &RunTraces,
    title: &str,
    subtitle: String,
    key: Vec<Entry>,
    scale: Scale,
    columns: Vec<Vec<Panel>>,
) -> Page {
    Page {
        title: title.to_owned(),
        subtitle,
        key,
        axis: Axis {
            label: "time (s)",
            range: 0.0..run.end,
            compare_from: run.rule.compare_from,
        },
        scale,
        columns,
    }
}

/// The entry of the key that explains the shaded time before errors count, if there is any.
fn start_entry(run: &RunTraces) -> Option<Entry> {
    let from = run.rule.compare_from;
    let label = format!("start, not compared (before {from} s)");
    (from > 0.0).then(|| Entry::new(Mark::area(START), label))
}

/// Fig. 5: the pins' positions.
pub fn linkage(run: &RunTraces) -> Page {
    let shown = shown(run).next();
    let column = |axis: usize, y_label: &'static str| {
        let panel = |(k, (_, title)): (usize, &(_, &str))| {
            let estimate = shown.map(|s| &s.pins[k][axis]);
            let layers = layers(&run.pins[k][axis], estimate, LINKAGE);
            let error = shown.and_then(|s| s.pin_errors[k][axis].value());
            Panel {
                note: error.map_or(String::new(), |rms| format!("RMSE {rms:.2} mm")),
                ..Panel::new(title, y_label, (2.0, HEIGHT), layers)
            }
        };
        PINS.iter().enumerate().map(panel).collect()
    };
    page(
        run,
        "Position of the linkage's pins (as the paper's Fig. 5)",
        "in world axes, measured from pin Q".to_owned(),
        key(run, &names(run), &[LINKAGE], false),
        Scale::Own,
        vec![column(0, "x from Q (mm)"), column(1, "y from Q (mm)")],
    )
}

/// Fig. 6: N and T of every wheel.
pub fn forces(run: &RunTraces) -> Page {
    let shown: Vec<_> = shown(run).map(Some).collect();
    // Without estimators the truth alone.
    let all = if shown.is_empty() { vec![None] } else { shown };
    let titles = |of: Option<&EstimatorTraces>| match (all.len(), of) {
        (2, Some(of)) => format!("{}: ", of.name),
        _ => String::new(),
    };
    let mut columns = [Vec::new(), Vec::new()];
    for of in &all {
        let (truth, title) = (run.truth_of(*of), titles(*of));
        let (normal, traction) = (of.map(|e| &e.normal_force), of.map(|e| &e.traction));
        let errors = of.map(|e| (e.score.normal_force(), e.score.traction()));
        let (of_normal, of_traction) = errors.unwrap_or_default();
        let normal = wheels(&title, &truth.normal_force, normal, NORMAL_FORCE, of_normal);
        let traction = wheels(&title, &truth.traction, traction, TRACTION, of_traction);
        columns[0].extend(normal);
        columns[1].extend(traction);
    }
    let banded = all.iter().flatten().any(|e| has_band(e));
    page(
        run,
        "Force distribution over the wheels (as the paper's Fig. 6)",
        "normal forces and tractions".to_owned(),
        key(run, &names(run), &WHEELS, banded),
        Scale::Common,
        columns.into(),
    )
}

/// Figs. 7 and 8, and figures of the same form: N of every wheel; with a covariance also its error,
/// each with two standard deviations.
pub fn normal_forces(run: &RunTraces, estimator: &EstimatorTraces) -> Page {
    let errors = estimator.score.normal_force();
    let normal = Some(&estimator.normal_force);
    let truth = &run.truth_of(Some(estimator)).normal_force;
    let panels = wheels("", truth, normal, NORMAL_FORCE, errors);
    let mut columns = vec![panels.into()];
    let banded = has_band(estimator);
    if banded && run.has_truth {
        let error = (0..3).map(|i| {
            let error = Layer::estimate(&estimator.error[i], WHEELS[i]);
            let zero = Layer::level(0.0, &(0.0..run.end));
            wheel_panel("", i, ERROR, vec![zero, error])
        });
        columns.push(error.collect());
    }
    page(
        run,
        &estimator.figure.1,
        overall(errors),
        key(run, &estimator.name, &WHEELS, banded),
        Scale::Common,
        columns,
    )
}

/// The estimators that Figs. 5 and 6 show.
fn shown(run: &RunTraces) -> impl Iterator<Item = &EstimatorTraces> {
    run.estimators.iter().filter(|e| e.is_shown)
}

fn has_band(estimator: &EstimatorTraces) -> bool {
    estimator.normal_force.iter().any(Estimated::has_band)
}

/// A panel of a wheel; its title begins with `of`.
fn wheel_panel(of: &str, wheel: usize, (y_label, span): Quantity, layers: Vec<Layer>) -> Panel {
    let title = format!("{of}{}", WHEEL_TITLES[wheel]);
    Panel::new(&title, y_label, (span, HEIGHT), layers)
}

/// A quantity of every wheel, true and estimated, with its RMSE (N) as note.
fn wheels(
    of: &str,
    truth: &[Trace; 3],
    estimates: Option<&[Estimated; 3]>,
    quantity: Quantity,
    errors: Option<ForceErrors>,
) -> [Panel; 3] {
    [0, 1, 2].map(|i| {
        let layers = layers(&truth[i], estimates.map(|e| &e[i]), WHEELS[i]);
        Panel {
            note: errors.map_or(String::new(), |e| format!("RMSE {:.2} N", e.rmse[i])),
            ..wheel_panel(of, i, quantity, layers)
        }
    })
}

/// Truth and estimate.
fn layers(truth: &Trace, estimate: Option<&Estimated>, color: RGBColor) -> Vec<Layer> {
    let estimate = estimate.map(|estimate| Layer::estimate(estimate, color));
    [Layer::peaks(truth, truth_line())]
        .into_iter()
        .chain(estimate)
        .collect()
}

/// The names of the estimators that Figs. 5 and 6 show.
fn names(run: &RunTraces) -> String {
    let names: Vec<&str> = shown(run).map(|e| e.name.as_str()).collect();
    names.join(", ")
}

/// The key to panels of truth and of the estimators of these names, if any.
fn key(run: &RunTraces, names: &str, colors: &[RGBColor], banded: bool) -> Vec<Entry> {
    let truth = || Entry::new(Mark::line(truth_line()), "true");
    let mut key: Vec<Entry> = run.has_truth.then(truth).into_iter().collect();
    let entry = |mark: fn(RGBColor) -> Mark, label: String| Entry {
        marks: colors.iter().map(|color| mark(*color)).collect(),
        label,
    };
    if !names.is_empty() {
        let label = format!("estimated ({names})");
        key.push(entry(|color| Mark::line(estimate_line(color)), label));
    }
    if banded {
        let label = "two standard deviations".to_owned();
        key.push(entry(|color| Mark::area(band_color(color)), label));
    }
    key.extend(start_entry(run));
    key
}

/// The error over all wheels as text.
fn overall(errors: Option<ForceErrors>) -> String {
    let Some(errors) = errors else {
        return "no true forces".to_owned();
    };
    let rmse = format!("RMSE over the three wheels {:.2} N", errors.rmse_all);
    match errors.nrmse {
        Some(nrmse) => format!("{rmse} = {:.1} % of the mean normal force", 100.0 * nrmse),
        None => rmse,
    }
}
