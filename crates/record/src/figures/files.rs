//! A figure as an SVG file.

use super::page::Page;
use super::style::SCALE;
use crate::error::{RecordError, io_error};
use plotters::drawing::IntoDrawingArea;
use plotters::prelude::{SVGBackend, WHITE};
use std::error::Error;
use std::path::Path;

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
