//! Title, subtitle and key over the panels of a figure.

use super::area::{Area, Drawn, write};
use super::style::{grid_line, text, units};
use plotters::element::DashedPathElement;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, VPos};

/// Margin of every figure, px.
pub const MARGIN: f64 = 14.0;
/// Width of every figure, px.
pub const WIDTH: u32 = 880;

const TITLE: f64 = 24.0;
const SUBTITLE: f64 = 19.0;
const KEY: f64 = 20.0;
const LETTERS: f64 = 12.5;
/// Width of a letter of a sans-serif font, in sizes of the font: a little more than the mean of English text.
const LETTER: f64 = 0.56;
/// Length of a line's sample and of an area's, px.
const LINE_SAMPLE: f64 = 26.0;
const AREA_SAMPLE: f64 = 20.0;
const SAMPLE_GAP: f64 = 6.0;
const ENTRY_GAP: f64 = 20.0;

/// A sample in the key.
#[derive(Clone, Copy)]
pub enum Mark {
    /// A line.
    Line(ShapeStyle),
    /// A dashed line.
    Dashed(ShapeStyle),
    /// An area.
    Area(RGBColor),
    /// An arrow that points right, of a length in px.
    Arrow(ShapeStyle, f64),
}

impl Mark {
    fn width(self) -> f64 {
        match self {
            Self::Line(_) | Self::Dashed(_) => LINE_SAMPLE,
            Self::Area(_) => AREA_SAMPLE,
            Self::Arrow(_, length) => length,
        }
    }

    fn draw(self, page: &Area<'_>, (x, y): (f64, f64)) -> Drawn {
        let ends = [(units(x), units(y)), (units(x + self.width()), units(y))];
        match self {
            Self::Line(style) => page.draw(&PathElement::new(ends, style))?,
            Self::Dashed(style) => page.draw(&dashed(ends.to_vec(), style))?,
            Self::Area(color) => {
                let corners = [
                    (units(x), units(y - 6.0)),
                    (units(x + AREA_SAMPLE), units(y + 6.0)),
                ];
                page.draw(&Rectangle::new(corners, color.filled()))?;
                page.draw(&Rectangle::new(corners, grid_line()))?;
            }
            Self::Arrow(style, length) => {
                page.draw(&PathElement::new(ends, style))?;
                let tip = x + length;
                let head = [(tip, y), (tip - 7.0, y - 3.5), (tip - 7.0, y + 3.5)];
                let head = head.map(|(x, y)| (units(x), units(y))).to_vec();
                page.draw(&Polygon::new(head, style.color.filled()))?;
            }
        }
        Ok(())
    }
}

/// A dashed line, by the drawing library's own element.
pub fn dashed<Coord: Clone>(
    points: Vec<Coord>,
    style: ShapeStyle,
) -> DashedPathElement<std::vec::IntoIter<Coord>, i32> {
    DashedPathElement::new(points, units(7.0), units(4.0), style)
}

/// Samples with one label.
pub struct Entry {
    /// From left to right.
    pub marks: Vec<Mark>,
    /// Their meaning.
    pub label: String,
}

impl Entry {
    /// An entry with one sample.
    pub fn new(mark: Mark, label: impl Into<String>) -> Self {
        Self {
            marks: vec![mark],
            label: label.into(),
        }
    }

    fn width(&self) -> f64 {
        let marks: f64 = self.marks.iter().map(|m| m.width() + SAMPLE_GAP).sum();
        #[expect(clippy::cast_precision_loss, reason = "some ten letters")]
        let letters = self.label.chars().count() as f64;
        marks + LETTER * LETTERS * letters
    }
}

/// Title, subtitle and key.
pub struct Header {
    /// Title.
    pub title: String,
    /// Subtitle; can be empty.
    pub subtitle: String,
    /// The key to the lines.
    pub key: Vec<Entry>,
}

impl Header {
    /// Where the panels below it begin, px.
    pub fn bottom(&self) -> f64 {
        #[expect(clippy::cast_precision_loss, reason = "a few rows")]
        let rows = self.rows().len() as f64;
        self.key_top() + rows * KEY + 6.0
    }

    fn key_top(&self) -> f64 {
        let subtitle = if self.subtitle.is_empty() {
            0.0
        } else {
            SUBTITLE
        };
        MARGIN + TITLE + subtitle
    }

    /// The entries of each row of the key.
    fn rows(&self) -> Vec<Vec<&Entry>> {
        let room = f64::from(WIDTH) - 2.0 * MARGIN;
        let mut rows: Vec<Vec<&Entry>> = Vec::new();
        let mut x = f64::INFINITY;
        for entry in &self.key {
            if x + entry.width() > room {
                rows.push(Vec::new());
                x = 0.0;
            }
            if let Some(row) = rows.last_mut() {
                row.push(entry);
            }
            x += entry.width() + ENTRY_GAP;
        }
        rows
    }

    /// Draws it at the top of a page.
    ///
    /// # Errors
    /// The error of the drawing library.
    pub fn draw(&self, page: &Area<'_>) -> Drawn {
        let title = text(16.0, FontStyle::Bold, HPos::Left, VPos::Top);
        write(page, &self.title, (MARGIN, MARGIN), title)?;
        let plain = || text(LETTERS, FontStyle::Normal, HPos::Left, VPos::Center);
        if !self.subtitle.is_empty() {
            let at = (MARGIN, MARGIN + TITLE + 0.4 * SUBTITLE);
            write(page, &self.subtitle, at, plain())?;
        }
        let mut y = self.key_top() + 0.5 * KEY;
        for row in self.rows() {
            let mut x = MARGIN;
            for entry in row {
                let end = x + entry.width() + ENTRY_GAP;
                for mark in &entry.marks {
                    mark.draw(page, (x, y))?;
                    x += mark.width() + SAMPLE_GAP;
                }
                write(page, &entry.label, (x, y), plain())?;
                x = end;
            }
            y += KEY;
        }
        Ok(())
    }
}
