//! What explains a recording: how many records of the run it keeps, the page on its views, and the
//! key to its plots, a sample of each line.

use crate::colours::{WHEELS, by_index};
use crate::draw::{lines, narrow};
use crate::error::Result;
use crate::forces::newtons_per_metre;
use crate::series::{NARROW, WIDE};
use crate::writer::Writer;
use re_sdk_types::components::Color;
use robhaz_run::RunDescription;

/// Rate of the animation, Hz of simulated time.
const FRAME_RATE: f64 = 60.0;
/// Rate of the time series, Hz of simulated time: every eighth record at 1 kHz.
const SERIES_RATE: f64 = 125.0;
/// Longest planned duration of a run that is recorded at these rates, s: some 30 MB. A longer run
/// keeps as many frames and rows.
const FULL_RATE_TIME: f64 = 120.0;

/// Factor by which the recording of a run is thinned in time: 1 up to 120 s, in proportion to the
/// planned duration beyond.
pub(crate) fn thinning(run: &RunDescription) -> f64 {
    (run.record.duration / FULL_RATE_TIME).max(1.0)
}

/// Rates of the time series and of the animation with a thinning, Hz of simulated time.
pub(crate) fn rates(thinning: f64) -> [f64; 2] {
    [SERIES_RATE / thinning, FRAME_RATE / thinning]
}

/// The page as Markdown. `chosen` is the index of the estimator whose forces are drawn; all rates
/// are divided by `thinning`.
pub(crate) fn page(run: &RunDescription, chosen: Option<usize>, thinning: f64) -> String {
    let robot = &run.robot;
    let source = match &run.world {
        Some(world) => format!("terrain {}", world.terrain.kind),
        None if run.has_truth => {
            "recorded readings, compared with a table of true forces".to_owned()
        }
        None => "recorded readings without truth".to_owned(),
    };
    let arrows = chosen.map_or(String::new(), |k| {
        format!(
            "- Thick arrows are true; thin arrows beside them are from the estimator {}. The bar across the end of an \
             arrow is two standard deviations to both sides, if the estimator states them.\n",
            run.estimators[k].label
        )
    });
    let [series, frames] = rates(thinning).map(|rate| (10.0 * rate).round() / 10.0);
    format!(
        include_str!("about.md"),
        name = run.name,
        geometry = robot.geometry_name,
        masses = robot.mass_name,
        source = source,
        duration = run.record.duration,
        rate = run.record.rate,
        newtons = newtons_per_metre(&robot.robot),
        arrows = arrows,
        series = series,
        frames = frames,
    )
}

/// Width of an entry, in units of the view.
const WIDTH: f64 = 1.0;
/// Height of the key, in units of the view.
pub(crate) const KEY_HEIGHT: f64 = 0.3;
/// Length of a sample, in units of the view.
const SAMPLE: f64 = 0.5;
/// Distance between the samples of an entry, in units of the view.
const SPACING: f64 = 0.045;
/// Distance of the lowest sample from the top, in units of the view.
const LOWEST: f64 = 0.13;

/// Width of the key to the plots of a run, in units of the view.
pub(crate) fn key_width(run: &RunDescription) -> f64 {
    WIDTH * entries(run).len() as f64
}

/// Label, colours of the samples from top to bottom, and their width (points) of each entry.
/// Recorded readings have no true lines.
fn entries(run: &RunDescription) -> Vec<(&str, Vec<Color>, f32)> {
    let truth = run.has_truth.then(|| ("true", WHEELS.to_vec(), WIDE));
    let estimators = run.estimators.iter().enumerate();
    let estimators = estimators.map(|(k, e)| (&*e.label, vec![by_index(k)], NARROW));
    truth.into_iter().chain(estimators).collect()
}

/// Logs the key to the plots of a run: its entries side by side. It is a view of its own, so that
/// no legend covers data.
pub(crate) fn log_key(out: &mut Writer, run: &RunDescription) -> Result {
    let mut left = 0.5 * (WIDTH - SAMPLE);
    for (k, (label, colours, width)) in entries(run).into_iter().enumerate() {
        let mut y = LOWEST;
        for (i, colour) in colours.into_iter().rev().enumerate() {
            let ends = [left, left + SAMPLE].map(|x| [narrow(x), narrow(y)]);
            // The viewer puts a label below its line: the lowest line has it.
            let label = (i == 0).then_some(label);
            let line = lines(colour, 0.5 * width).with_strips([ends]);
            let line = line.with_labels(label).with_show_labels(true);
            out.constant(format!("key/{k}/{i}"), &line)?;
            y -= SPACING;
        }
        left += WIDTH;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use robhaz_scene::Scene;

    /// Closed form: a run of any length keeps at most the rows and frames of one of two minutes.
    #[test]
    fn long_runs_have_recordings_of_a_bounded_size() {
        let mut run = RunDescription::of(&Scene::default()).expect("a robot");
        for (duration, expected) in [
            (20.0, 1.0),
            (120.0, 1.0),
            (3600.0, 30.0),
            (1e6, 1e6 / 120.0),
        ] {
            run.record.duration = duration;
            let factor = thinning(&run);
            assert!((factor - expected).abs() < 1e-9, "{duration} s: {factor}");
            for (rate, most) in rates(factor).into_iter().zip([15_000.0, 7_200.0]) {
                assert!(rate * duration <= most + 1e-6, "{duration} s: {rate} Hz");
            }
        }
    }
}
