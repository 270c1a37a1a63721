//! A figure: a header, and below it columns of panels over a common axis.

use super::header::{Header, MARGIN, WIDTH};
use super::panel::{Axis, PANEL_TITLE, Panel, TAIL, X_LABELS};
use super::style::{Area, Drawn, SCALE, units};
use crate::error::{RecordError, io_error};
use plotters::drawing::IntoDrawingArea;
use plotters::prelude::{SVGBackend, WHITE};
use std::error::Error;
use std::ops::Range;
use std::path::Path;
use std::slice::from_ref;

/// Distance between columns, px.
const GAP: f64 = 12.0;

/// The vertical ranges of the panels of a column.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scale {
    /// One range, so that their heights can be compared.
    Common,
    /// Each has a range of its own.
    Own,
    /// Each has a range of its own, which holds every value: for panels whose extremes decide.
    Whole,
}

/// Panels from top to bottom.
pub struct Column {
    /// The panels.
    pub panels: Vec<Panel>,
    /// Their ranges.
    pub scale: Scale,
}

impl Column {
    /// A column of panels.
    pub fn new(scale: Scale, panels: impl IntoIterator<Item = Panel>) -> Self {
        let panels = panels.into_iter().collect();
        Self { panels, scale }
    }

    /// The range of each panel, in the unit of the data.
    fn ranges(&self, axis: &Axis) -> Vec<Range<f64>> {
        let range = |panel: &Panel| {
            let (with, tail) = match self.scale {
                Scale::Common => (&self.panels[..], TAIL),
                Scale::Own => (from_ref(panel), TAIL),
                Scale::Whole => (from_ref(panel), 0.0),
            };
            let own = || Panel::shared_range(with, axis, tail);
            panel.range.clone().unwrap_or_else(own)
        };
        self.panels.iter().map(range).collect()
    }

    fn height(&self) -> f64 {
        let panels: f64 = self.panels.iter().map(|p| PANEL_TITLE + p.height).sum();
        panels + X_LABELS
    }
}

/// A figure.
pub struct Page {
    /// Title and key.
    pub header: Header,
    /// The horizontal axis of all panels.
    pub axis: Axis,
    /// The columns below, from left to right.
    pub columns: Vec<Column>,
}

impl Page {
    /// Width and height, px.
    fn size(&self) -> (u32, u32) {
        let panels = self.columns.iter().map(Column::height).fold(0.0, f64::max);
        let height = self.header.bottom() + panels + 0.5 * MARGIN;
        // The height of a picture.
        (WIDTH, height.ceil() as u32)
    }

    /// Draws it on a white page of its size.
    fn draw(&self, page: &Area<'_>) -> Drawn {
        self.header.draw(page)?;
        let part = |left: f64, top: f64, width: f64, height: f64| {
            let corner = (units(left), units(top));
            page.clone().shrink(corner, (units(width), units(height)))
        };
        let full = f64::from(WIDTH) - 2.0 * MARGIN;
        let first = self.header.bottom();
        // A few columns.
        let count = self.columns.len() as f64;
        let width = (full - (count - 1.0) * GAP) / count;
        let mut left = MARGIN;
        for column in &self.columns {
            let mut top = first;
            let panels = column.panels.iter().zip(column.ranges(&self.axis));
            for (r, (panel, range)) in panels.enumerate() {
                let last = r + 1 == column.panels.len();
                let height = PANEL_TITLE + panel.height;
                let labels = if last { X_LABELS } else { 0.0 };
                let area = part(left, top, width, height + labels);
                panel.draw(&area, &self.axis, &range, last)?;
                top += height;
            }
            left += width + GAP;
        }
        Ok(())
    }
}

/// Writes a figure into a folder as `stem.svg`.
///
/// # Errors
/// [`RecordError`] of the file system and of the drawing library.
pub fn write_figure(folder: &Path, stem: &str, page: &Page) -> Result<(), RecordError> {
    let path = folder.join(format!("{stem}.svg"));
    let text = svg(page).map_err(|error| io_error("draw", &path)(error.to_string()))?;
    std::fs::write(&path, text).map_err(io_error("write", &path))
}

fn svg(figure: &Page) -> Result<String, Box<dyn Error>> {
    let (width, height) = figure.size();
    let drawn = (SCALE * width, SCALE * height);
    let mut inner = String::new();
    let page = SVGBackend::with_string(&mut inner, drawn).into_drawing_area();
    page.fill(&WHITE)?;
    figure.draw(&page)?;
    page.present()?;
    drop(page);
    // The drawing is larger by the scale: an outer element gives it its nominal size and what its
    // lines inherit.
    Ok(format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" \
         viewBox=\"0 0 {} {}\" stroke-linejoin=\"round\">\n{inner}</svg>\n",
        drawn.0, drawn.1
    ))
}
