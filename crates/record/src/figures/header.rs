//! Title, subtitle and key over the panels of a figure.

use super::style::{Area, Drawn, line, path, text, units, write};
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, VPos};

/// Margin of every figure, px.
pub const MARGIN: f64 = 14.0;
/// Width of every figure, px.
pub const WIDTH: u32 = 880;

const TITLE: f64 = 24.0;
const SUBTITLE: f64 = 19.0;
const KEY: f64 = 20.0;
const KEY_TOP: f64 = MARGIN + TITLE + SUBTITLE;
const LETTERS: f64 = 12.5;
/// Width of a letter of a sans-serif font, in sizes of the font: a little more than the mean of
/// English text.
const LETTER: f64 = 0.56;
/// Length of a sample, px.
const SAMPLE: f64 = 26.0;
const SAMPLE_GAP: f64 = 6.0;
const ENTRY_GAP: f64 = 20.0;

/// A sample in the key: a line, and whether it is dashed.
#[derive(Clone, Copy)]
pub struct Mark(ShapeStyle, bool);

impl Mark {
    /// A line.
    pub fn line(style: ShapeStyle) -> Self {
        Self(style, false)
    }

    /// A dashed line.
    pub fn dashed(style: ShapeStyle) -> Self {
        Self(style, true)
    }

    /// An area.
    pub fn area(color: RGBColor) -> Self {
        Self::line(line(color, 12.0))
    }
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
        // Some marks and letters.
        let [marks, letters] = [self.marks.len(), self.label.chars().count()].map(|n| n as f64);
        marks * (SAMPLE + SAMPLE_GAP) + letters * LETTER * LETTERS
    }
}

/// Title, subtitle and key.
pub struct Header {
    /// Title.
    pub title: String,
    /// Subtitle.
    pub subtitle: String,
    /// The key to the lines.
    pub key: Vec<Entry>,
}

impl Header {
    /// Where the panels below it begin, px.
    pub fn bottom(&self) -> f64 {
        // A few rows.
        let rows = self.rows().len() as f64;
        KEY_TOP + rows * KEY + 6.0
    }

    /// The entries of each row of the key.
    fn rows(&self) -> Vec<Vec<&Entry>> {
        let room = f64::from(WIDTH) - 2.0 * MARGIN;
        let mut rows: Vec<Vec<&Entry>> = Vec::new();
        let mut x = 0.0;
        for entry in &self.key {
            match rows.last_mut() {
                Some(row) if x + entry.width() <= room => row.push(entry),
                _ => {
                    rows.push(vec![entry]);
                    x = 0.0;
                }
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
        let at = (MARGIN, MARGIN + TITLE + 0.4 * SUBTITLE);
        write(page, &self.subtitle, at, plain())?;
        let mut y = KEY_TOP + 0.5 * KEY;
        for row in self.rows() {
            let mut x = MARGIN;
            for entry in row {
                let end = x + entry.width() + ENTRY_GAP;
                for Mark(style, is_dashed) in &entry.marks {
                    let ends = [x, x + SAMPLE].map(|x| (units(x), units(y)));
                    page.draw(&path(ends.to_vec(), *style, *is_dashed))?;
                    x += SAMPLE + SAMPLE_GAP;
                }
                write(page, &entry.label, (x, y), plain())?;
                x = end;
            }
            y += KEY;
        }
        Ok(())
    }
}
