//! All estimators in one figure: errors of N over time, RMSE in the key.

use super::header::{Entry, Mark};
use super::page::{Column, Page, Scale};
use super::panel::{Layer, Panel};
use super::paper::{page, start_entry, wheel_panel};
use super::run::{EstimatorTraces, RunTraces};
use super::style::{estimator as look_of, line};

/// Errors of N of every estimator: RMS over the wheels, and each wheel's own.
pub fn comparison(run: &RunTraces) -> Page<'_> {
    let rms = Panel {
        logarithmic: true,
        ..Panel::new(
            "RMS over the three wheels",
            "error of N (N)",
            (0.0, 210.0),
            layers(run, |e| &e.rms_error).collect(),
        )
    };
    let wheels = (0..3).map(|i| {
        let errors = layers(run, |e| &e.error[i].line).chain([Layer::Level(0.0)]);
        wheel_panel(i, "error of N (N)", 0.2, errors.collect())
    });
    let mut key: Vec<Entry> = run
        .estimators
        .iter()
        .enumerate()
        .map(|(place, estimator)| entry(place, estimator))
        .collect();
    key.extend(start_entry(run));
    let subtitle = format!(
        "estimated minus true; means over {:.0} ms",
        1e3 * run.interval
    );
    page(
        run,
        "Errors of the normal forces, all estimators",
        subtitle,
        key,
        vec![Column::new(Scale::Own, std::iter::once(rms).chain(wheels))],
    )
}

fn layers<'a>(
    run: &'a RunTraces,
    trace: impl Fn(&'a EstimatorTraces) -> &'a super::trace::Trace,
) -> impl Iterator<Item = Layer<'a>> {
    run.estimators.iter().enumerate().map(move |(place, e)| {
        let (color, dashes) = look_of(place);
        Layer::Mean(trace(e), color, dashes)
    })
}

fn entry(place: usize, estimator: &EstimatorTraces) -> Entry {
    let (color, dashes) = look_of(place);
    let style = line(color, 1.8);
    let mark = if dashes {
        Mark::Dashed(style)
    } else {
        Mark::Line(style)
    };
    let rmse = match estimator.summary().normal_force {
        Some(errors) => format!("RMSE {:.2} N", errors.rmse_all),
        None => "nothing to compare".to_owned(),
    };
    Entry::new(mark, format!("{}: {rmse}", estimator.name))
}
