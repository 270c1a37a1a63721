//! Lines and arrows of several times, any number at each, that are not logged yet.

use crate::ViewerError;
use crate::colours::Colour;
use crate::convert::flat;
use crate::writer::Writer;
use rerun::archetypes::{Arrows2D, LineStrips2D};
use robhaz_model::Vec2;

/// Polylines, m.
#[derive(Default)]
pub(crate) struct Strips {
    times: Vec<f64>,
    counts: Vec<usize>,
    strips: Vec<Vec<[f32; 2]>>,
}

impl Strips {
    /// Adds the polylines of a time (s).
    pub(crate) fn push<S>(&mut self, time: f64, strips: impl IntoIterator<Item = S>)
    where
        S: IntoIterator<Item = Vec2>,
    {
        let before = self.strips.len();
        let points = |strip: S| strip.into_iter().map(flat).collect();
        self.strips.extend(strips.into_iter().map(points));
        self.times.push(time);
        self.counts.push(self.strips.len() - before);
    }

    /// Whether there is no polyline.
    pub(crate) fn is_empty(&self) -> bool {
        self.strips.is_empty()
    }

    /// What was added since the last call of [`Strips::flush`].
    #[cfg(test)]
    pub(crate) fn strips(&self) -> &[Vec<[f32; 2]>] {
        &self.strips
    }

    /// Logs what was added since the last call.
    pub(crate) fn flush(&mut self, out: &mut Writer, entity: &str) -> Result<(), ViewerError> {
        std::mem::take(self).log(out, entity)
    }

    /// Logs all of it.
    pub(crate) fn log(self, out: &mut Writer, entity: &str) -> Result<(), ViewerError> {
        let columns = LineStrips2D::update_fields().with_strips(self.strips);
        out.columns(entity, &self.times, columns.columns(self.counts))
    }
}

/// An arrow: colour, origin and vector (m).
pub(crate) type Arrow = (Colour, Vec2, Vec2);

/// Arrows.
#[derive(Default)]
pub(crate) struct Arrows {
    counts: Vec<usize>,
    arrows: Vec<Arrow>,
}

impl Arrows {
    /// Adds the arrows of the next time.
    pub(crate) fn push(&mut self, arrows: Vec<Arrow>) {
        self.counts.push(arrows.len());
        self.arrows.extend(arrows);
    }

    /// Logs all of them, at their times (s).
    pub(crate) fn log(
        self,
        out: &mut Writer,
        entity: &str,
        times: &[f64],
    ) -> Result<(), ViewerError> {
        let arrows = self.arrows.iter();
        let columns = Arrows2D::update_fields()
            .with_colors(arrows.clone().map(|(colour, ..)| *colour))
            .with_origins(arrows.clone().map(|(_, origin, _)| flat(*origin)))
            .with_vectors(arrows.map(|(.., vector)| flat(*vector)));
        out.columns(entity, times, columns.columns(self.counts))
    }
}
