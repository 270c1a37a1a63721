//! The key to the plots: a sample of each line. It is a view of its own, so that no legend covers
//! data.

use crate::ViewerError;
use crate::colours::{Colour, WHEELS, by_index};
use crate::convert::narrow;
use crate::plot::Line;
use crate::writer::Writer;
use rerun::archetypes::LineStrips2D;
use rerun::components::Radius;
use robhaz_run::RunDescription;

/// Width of an entry, in units of the view.
const WIDTH: f64 = 1.0;
/// Height of the key, in units of the view.
pub(crate) const HEIGHT: f64 = 0.3;
/// Length of a sample, in units of the view.
const SAMPLE: f64 = 0.5;
/// Distance between the samples of an entry, in units of the view.
const SPACING: f64 = 0.045;
/// Distance of the lowest sample from the top, in units of the view.
const LOWEST: f64 = 0.13;

/// Width of the key to the plots of a run, in units of the view.
pub(crate) fn width(run: &RunDescription) -> f64 {
    WIDTH * entries(run).len() as f64
}

/// Label, colours of the samples from top to bottom, and their width (points) of each entry.
/// Recorded readings have no true lines.
fn entries(run: &RunDescription) -> Vec<(&str, Vec<Colour>, f32)> {
    let truth = run.has_truth.then(|| ("true", WHEELS.to_vec(), Line::WIDE));
    let estimators = run.estimators.iter().enumerate();
    let estimators = estimators.map(|(k, e)| (&*e.label, vec![by_index(k)], Line::NARROW));
    truth.into_iter().chain(estimators).collect()
}

/// Logs the key to the plots of a run: its entries side by side.
pub(crate) fn log(out: &mut Writer, run: &RunDescription) -> Result<(), ViewerError> {
    let mut left = 0.5 * (WIDTH - SAMPLE);
    for (k, (label, colours, width)) in entries(run).into_iter().enumerate() {
        let mut y = LOWEST;
        for (i, colour) in colours.into_iter().rev().enumerate() {
            let ends = [left, left + SAMPLE].map(|x| [narrow(x), narrow(y)]);
            // The viewer puts a label below its line: the lowest line has it.
            let label = (i == 0).then_some(label);
            out.constant(
                format!("key/{k}/{i}"),
                &LineStrips2D::new([ends])
                    .with_colors([colour])
                    .with_radii([Radius::new_ui_points(0.5 * width)])
                    .with_labels(label)
                    .with_show_labels(true),
            )?;
            y -= SPACING;
        }
        left += WIDTH;
    }
    Ok(())
}
