//! All estimators in one figure: errors of N over time, RMSE in the key.

use super::header::{Entry, Mark};
use super::page::{Column, Page, Scale};
use super::panel::{Layer, Panel};
use super::paper::{page, start_entry, wheel_panel};
use super::run::{EstimatorTraces, RunTraces};
use super::style::{estimator as look_of, line};
use super::trace::Trace;

/// Errors of N of every estimator: RMS over the wheels, and each wheel's own.
pub fn comparison(run: &RunTraces) -> Page {
    let rms = layers(run, |e| &e.rms_error).collect();
    let rms = Panel {
        logarithmic: true,
        ..Panel::new(
            "RMS over the three wheels",
            "error of N (N)",
            (0.0, 210.0),
            rms,
        )
    };
    let wheels = (0..3).map(|i| {
        let mut errors = vec![Layer::level(0.0, &(0.0..run.end))];
        errors.extend(layers(run, |e| &e.error[i].line));
        wheel_panel(i, "error of N (N)", 0.2, errors)
    });
    let estimators = run.estimators.iter().enumerate();
    let key = estimators.map(|(place, estimator)| {
        let (color, is_dashed) = look_of(place);
        let mark = if is_dashed { Mark::dashed } else { Mark::line };
        let rmse = match estimator.score.normal_force() {
            Some(errors) => format!("RMSE {:.2} N", errors.rmse_all),
            None => "no true forces".to_owned(),
        };
        Entry::new(
            mark(line(color, 1.8)),
            format!("{}: {rmse}", estimator.name),
        )
    });
    page(
        run,
        "Errors of the normal forces, all estimators",
        format!(
            "estimated minus true; means over {:.0} ms",
            1e3 * run.interval
        ),
        key.chain(start_entry(run)).collect(),
        vec![Column::new(Scale::Own, std::iter::once(rms).chain(wheels))],
    )
}

fn layers(
    run: &RunTraces,
    trace: impl Fn(&EstimatorTraces) -> &Trace,
) -> impl Iterator<Item = Layer> {
    run.estimators.iter().enumerate().map(move |(place, e)| {
        let (color, is_dashed) = look_of(place);
        Layer::mean(trace(e), color, is_dashed)
    })
}
