//! Several lines over time under one entity: the cheapest way to log scalars.

use crate::ViewerError;
use crate::colours::Colour;
use crate::rrd::RrdWriter;
use re_sdk_types::archetypes::{Scalars, SeriesLines};

/// How a line looks.
#[derive(Clone, Debug)]
pub(crate) struct Line {
    /// Name in the legend, with the unit.
    pub(crate) name: String,
    /// Colour.
    pub(crate) colour: Colour,
    /// Width, points.
    pub(crate) width: f32,
}

impl Line {
    /// A line of the truth: wide.
    pub(crate) fn truth(name: impl Into<String>, colour: Colour) -> Self {
        Self {
            name: name.into(),
            colour,
            width: 5.0,
        }
    }

    /// A line of what is estimated: narrow.
    pub(crate) fn estimate(name: impl Into<String>, colour: Colour) -> Self {
        Self {
            name: name.into(),
            colour,
            width: 1.5,
        }
    }
}

/// An entity with one value for each of its lines at each time.
#[derive(Debug)]
pub(crate) struct Plot {
    entity: String,
    lines: Vec<Line>,
    values: Vec<f64>,
}

impl Plot {
    /// A plot without values.
    pub(crate) fn new(entity: impl Into<String>, lines: Vec<Line>) -> Self {
        Self {
            entity: entity.into(),
            lines,
            values: Vec::new(),
        }
    }

    /// Logs how the lines look.
    pub(crate) fn declare(&self, out: &mut RrdWriter) -> Result<(), ViewerError> {
        out.constant(
            self.entity.as_str(),
            &SeriesLines::new()
                .with_names(self.lines.iter().map(|l| l.name.as_str()))
                .with_colors(self.lines.iter().map(|l| l.colour))
                .with_widths(self.lines.iter().map(|l| l.width)),
        )
    }

    /// Adds the values of one time, in the order of the lines. Not a number: a gap.
    pub(crate) fn push(&mut self, values: impl IntoIterator<Item = f64>) {
        self.values.extend(values);
    }

    /// Logs the values of `times` (s) and forgets them.
    pub(crate) fn flush(&mut self, out: &mut RrdWriter, times: &[f64]) -> Result<(), ViewerError> {
        let rows = std::iter::repeat_n(self.lines.len(), times.len());
        out.columns(
            self.entity.as_str(),
            times,
            Scalars::new(self.values.drain(..)).columns(rows),
        )
    }
}
