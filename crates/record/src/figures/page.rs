//! A figure: title, subtitle and key, and below them columns of panels over a common axis.

use super::panel::{Axis, PANEL_TITLE, Panel, TAIL, X_LABELS};
use super::style::{Area, Drawn, SCALE, line, path, text, units, write};
use crate::error::{Result, io_error};
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, VPos};
use std::error::Error;
use std::ops::Range;
use std::path::Path;
use std::slice::from_ref;

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
/// Distance between columns, px.
const GAP: f64 = 12.0;

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

/// The vertical ranges of panels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scale {
    /// One range in a column, so that their heights can be compared.
    Common,
    /// Each has a range of its own.
    Own,
    /// Each has a range of its own, which holds every value: for panels whose extremes decide.
    Whole,
}

/// A figure.
pub struct Page {
    /// Title.
    pub title: String,
    /// Subtitle.
    pub subtitle: String,
    /// The key to the lines.
    pub key: Vec<Entry>,
    /// The horizontal axis of all panels.
    pub axis: Axis,
    /// The vertical ranges.
    pub scale: Scale,
    /// The columns below, from left to right, each from top to bottom.
    pub columns: Vec<Vec<Panel>>,
}

impl Page {
    /// Where the panels begin, below title and key, px.
    fn top(&self) -> f64 {
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

    /// The range of each panel of a column, in the unit of the data.
    fn ranges(&self, column: &[Panel]) -> Vec<Range<f64>> {
        let range = |panel: &Panel| {
            let (with, tail) = match self.scale {
                Scale::Common => (column, TAIL),
                Scale::Own => (from_ref(panel), TAIL),
                Scale::Whole => (from_ref(panel), 0.0),
            };
            let own = || Panel::shared_range(with, &self.axis, tail);
            panel.range.clone().unwrap_or_else(own)
        };
        column.iter().map(range).collect()
    }

    /// Draws title, subtitle and key at the top of a page.
    fn draw_header(&self, page: &Area<'_>) -> Drawn {
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

    /// Width and height, px.
    fn size(&self) -> (u32, u32) {
        let height = |panel: &Panel| PANEL_TITLE + panel.height;
        let heights = self.columns.iter().map(|c| c.iter().map(height).sum());
        let panels = heights.fold(0.0, f64::max) + X_LABELS;
        let height = self.top() + panels + 0.5 * MARGIN;
        // The height of a picture.
        (WIDTH, height.ceil() as u32)
    }

    /// Draws it on a white page of its size.
    fn draw(&self, page: &Area<'_>) -> Drawn {
        self.draw_header(page)?;
        let part = |left: f64, top: f64, width: f64, height: f64| {
            let corner = (units(left), units(top));
            page.clone().shrink(corner, (units(width), units(height)))
        };
        let full = f64::from(WIDTH) - 2.0 * MARGIN;
        let first = self.top();
        // A few columns.
        let count = self.columns.len() as f64;
        let width = (full - (count - 1.0) * GAP) / count;
        let mut left = MARGIN;
        for column in &self.columns {
            let mut top = first;
            let panels = column.iter().zip(self.ranges(column));
            for (r, (panel, range)) in panels.enumerate() {
                let last = r + 1 == column.len();
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
/// [`RecordError`](crate::RecordError) of the file system and of the drawing library.
pub fn write_figure(folder: &Path, stem: &str, page: &Page) -> Result {
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
