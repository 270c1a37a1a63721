//! Several lines over time in one entity. Scalars need the least memory and time in this form.

use crate::ViewerError;
use crate::colours::Colour;
use crate::writer::Writer;
use rerun::archetypes::{Scalars, SeriesLines};

/// Name, colour and width of a line.
#[derive(Clone, Debug)]
pub(crate) struct Line {
    /// Name with unit.
    pub(crate) name: String,
    /// Colour.
    pub(crate) colour: Colour,
    /// Width, points.
    pub(crate) width: f32,
}

impl Line {
    /// Width of a true line, points.
    pub(crate) const WIDE: f32 = 5.0;
    /// Width of an estimated line, points.
    pub(crate) const NARROW: f32 = 1.5;
    /// Width of the edge of a band, points.
    const EDGE: f32 = 0.75;

    /// A line of the truth.
    pub(crate) fn truth(name: impl Into<String>, colour: Colour) -> Self {
        Self::of_width(name, colour, Self::WIDE)
    }

    /// A line of an estimate.
    pub(crate) fn estimate(name: impl Into<String>, colour: Colour) -> Self {
        Self::of_width(name, colour, Self::NARROW)
    }

    /// The edge of a band.
    pub(crate) fn edge(name: impl Into<String>, colour: Colour) -> Self {
        Self::of_width(name, colour, Self::EDGE)
    }

    /// A line of a width, points.
    pub(crate) fn of_width(name: impl Into<String>, colour: Colour, width: f32) -> Self {
        Self {
            name: name.into(),
            colour,
            width,
        }
    }
}

/// An entity with one value of each of its lines at each time.
#[derive(Debug)]
pub(crate) struct Plot {
    entity: String,
    lines: Vec<Line>,
    /// Times that are not logged yet, s.
    times: Vec<f64>,
    /// Values at those times, line by line at each.
    values: Vec<f64>,
    /// The style of the lines is logged.
    declared: bool,
}

impl Plot {
    /// A plot without values.
    pub(crate) fn new(entity: impl Into<String>, lines: Vec<Line>) -> Self {
        Self {
            entity: entity.into(),
            lines,
            times: Vec::new(),
            values: Vec::new(),
            declared: false,
        }
    }

    /// Adds the values of all lines at one time (s), in the order of the lines. NaN makes a gap.
    pub(crate) fn push(&mut self, time: f64, values: impl IntoIterator<Item = f64>) {
        self.times.push(time);
        self.values.extend(values);
        debug_assert_eq!(self.values.len(), self.times.len() * self.lines.len());
    }

    /// Logs the values that were added since the last call. The style of the lines is logged before
    /// the first values, so that a plot without values is not in the recording.
    pub(crate) fn flush(&mut self, out: &mut Writer) -> Result<(), ViewerError> {
        if self.times.is_empty() || self.lines.is_empty() {
            self.times.clear();
            return Ok(());
        }
        if !self.declared {
            self.declared = true;
            out.constant(
                self.entity.as_str(),
                &SeriesLines::new()
                    .with_names(self.lines.iter().map(|l| l.name.as_str()))
                    .with_colors(self.lines.iter().map(|l| l.colour))
                    .with_widths(self.lines.iter().map(|l| l.width)),
            )?;
        }
        let times = std::mem::take(&mut self.times);
        let rows = std::iter::repeat_n(self.lines.len(), times.len());
        out.columns(
            self.entity.as_str(),
            &times,
            Scalars::new(self.values.drain(..)).columns(rows),
        )
    }
}
