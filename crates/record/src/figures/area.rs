//! A part of a picture, and words on it.

use super::style::units;
use plotters::coord::Shift;
use plotters::prelude::{DrawingArea, SVGBackend, Text};
use plotters::style::TextStyle;
use std::error::Error;

/// The result of drawing a part of a figure.
pub type Drawn = Result<(), Box<dyn Error>>;
/// A part of the page. A px has [`super::style::SCALE`] units.
pub type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;

/// Writes words at a place in px.
pub fn write(area: &Area<'_>, words: &str, (x, y): (f64, f64), style: TextStyle<'static>) -> Drawn {
    area.draw(&Text::new(words.to_owned(), (units(x), units(y)), style))?;
    Ok(())
}
