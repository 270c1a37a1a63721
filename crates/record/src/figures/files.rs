//! A figure as the bytes of an SVG file.

use super::style::SCALE;
use plotters::coord::Shift;
use plotters::drawing::IntoDrawingArea;
use plotters::prelude::{DrawingArea, DrawingBackend, SVGBackend, WHITE};
use std::error::Error;

/// The result of drawing a part of a figure.
pub type Drawn = Result<(), Box<dyn Error>>;

/// A figure that can be drawn on any backend.
pub trait Picture {
    /// Width and height, px.
    fn size(&self) -> (u32, u32);

    /// Draws it on a white page of its size; a px has [`SCALE`] units.
    ///
    /// # Errors
    /// The error of the backend.
    fn draw<DB>(&self, page: &DrawingArea<DB, Shift>) -> Drawn
    where
        DB: DrawingBackend,
        DB::ErrorType: 'static;
}

/// The figure as an SVG file; the reason when it cannot be drawn.
pub fn svg(picture: &impl Picture) -> Result<Vec<u8>, String> {
    let (width, height) = picture.size();
    let drawn = (SCALE * width, SCALE * height);
    let mut inner = String::new();
    draw_on(SVGBackend::with_string(&mut inner, drawn), picture)?;
    // The drawing is larger by the scale: an outer element gives it its nominal size and what its lines inherit.
    let outer = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" \
         viewBox=\"0 0 {} {}\" stroke-linejoin=\"round\">\n{inner}</svg>\n",
        drawn.0, drawn.1
    );
    Ok(outer.into_bytes())
}

fn draw_on<DB>(backend: DB, picture: &impl Picture) -> Result<(), String>
where
    DB: DrawingBackend,
    DB::ErrorType: 'static,
{
    let page = backend.into_drawing_area();
    page.fill(&WHITE).map_err(|e| e.to_string())?;
    picture.draw(&page).map_err(|e| e.to_string())?;
    page.present().map_err(|e| e.to_string())
}
