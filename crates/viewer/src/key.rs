//! The key to the plots: a sample of each line. It is a view of its own, so that no legend covers data.

use crate::ViewerError;
use crate::colours::{Colour, WHEELS, by_index};
use crate::convert::narrow;
use crate::plot::Line;
use crate::writer::Writer;
use rerun::archetypes::LineStrips2D;
use rerun::components::Radius;
use robhaz_run::RunDescription;

/// Width and height of one entry, in units of the view.
pub(crate) const PLACE: [f64; 2] = [1.0, 0.3];
/// Length of a sample, in units of the view.
const SAMPLE: f64 = 0.5;
/// Distance between the samples of an entry, in units of the view.
const SPACING: f64 = 0.045;
/// Distance of the lowest sample from the top, in units of the view.
const LOWEST: f64 = 0.13;

/// Samples of lines with one label.
pub(crate) struct Entry {
    label: String,
    /// Colours of the samples, from top to bottom.
    colours: Vec<Colour>,
    /// Width, points.
    width: f32,
}

impl Entry {
    /// Wide lines in the colours of the wheels.
    pub(crate) fn of_wheels(label: &str) -> Self {
        Self {
            label: label.to_owned(),
            colours: WHEELS.to_vec(),
            width: Line::WIDE,
        }
    }

    /// A narrow line in the colour of an estimator or run, by its index.
    pub(crate) fn of_index(label: &str, index: usize) -> Self {
        Self {
            label: label.to_owned(),
            colours: vec![by_index(index)],
            width: Line::NARROW,
        }
    }
}

/// The key to the plots of a run. Recorded readings have no true lines.
pub(crate) fn of_run(run: &RunDescription) -> Vec<Entry> {
    let names = run.estimators.iter().enumerate();
    let estimators = names.map(|(k, e)| Entry::of_index(&e.label, k));
    let truth = || Entry::of_wheels("true");
    let truth = run.has_truth.then(truth).into_iter();
    truth.chain(estimators).collect()
}

/// Logs a key under an entity: its entries side by side.
pub(crate) fn log(out: &mut Writer, entity: &str, entries: &[Entry]) -> Result<(), ViewerError> {
    let mut left = 0.5 * (PLACE[0] - SAMPLE);
    for (k, entry) in entries.iter().enumerate() {
        let mut y = LOWEST;
        for (i, colour) in entry.colours.iter().rev().enumerate() {
            let ends = [left, left + SAMPLE].map(|x| [narrow(x), narrow(y)]);
            // The viewer puts a label below its line: the lowest line has it.
            let label = (i == 0).then_some(entry.label.as_str());
            out.constant(
                format!("{entity}/{k}/{i}"),
                &LineStrips2D::new([ends])
                    .with_colors([*colour])
                    .with_radii([Radius::new_ui_points(0.5 * entry.width)])
                    .with_labels(label)
                    .with_show_labels(true),
            )?;
            y -= SPACING;
        }
        left += PLACE[0];
    }
    Ok(())
}
