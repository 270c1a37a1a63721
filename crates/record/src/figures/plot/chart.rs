//! A chart of shapes between two axes, and the sheet of charts with its caption.

use super::scale::Scale;
use crate::figures::files::{Drawn, Picture};
use crate::figures::header::{Header, MARGIN, WIDTH, dashed, write};
use crate::figures::helvetica;
use crate::figures::page::whole;
use crate::figures::style::{frame_line, grid_line, line, text, units, upward_text};
use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, VPos};

/// Room left of a chart for its labels, px; more where they are longer.
const Y_LABELS: f64 = 62.0;
/// Of it for the name of the axis and the ticks, px.
const Y_NAME: f64 = 26.0;
/// Letters of the labels at the ticks, px.
const TICK_LETTERS: f64 = 11.5;
/// Room below it, px.
const X_LABELS: f64 = 42.0;
/// Room above it, px.
const TITLE: f64 = 22.0;
const GAP: f64 = 14.0;
/// Height and letters of a line of the caption, px.
const CAPTION_LINE: f64 = 16.0;
const CAPTION_LETTERS: f64 = 11.5;

/// A point in the units of the axes.
pub type Point = (f64, f64);

/// What a chart shows, drawn in this order.
pub enum Shape {
    /// A filled polygon.
    Area(Vec<Point>, RGBColor),
    /// A filled rectangle between two corners.
    Cell([Point; 2], RGBColor),
    /// A line of a width in px.
    Line(Vec<Point>, RGBColor, f64),
    /// The same, dashed.
    Dashed(Vec<Point>, RGBColor, f64),
    /// A point of a radius in px.
    Dot(Point, RGBColor, f64),
}

/// A chart.
pub struct Chart {
    /// Over its left corner.
    pub title: String,
    /// Quantity and unit of the horizontal axis.
    pub x_label: String,
    /// Quantity and unit of the vertical axis.
    pub y_label: String,
    /// The axes.
    pub x: Scale,
    /// The vertical axis.
    pub y: Scale,
    /// Width, as a part of the room that the charts beside it share.
    pub width: f64,
    /// Height of the plot, px.
    pub height: f64,
    /// Whether lines stand at the ticks.
    pub grid: bool,
    /// The content.
    pub shapes: Vec<Shape>,
}

/// A figure of charts in rows, with a header above and a caption below.
pub struct Sheet {
    /// Title and key.
    pub header: Header,
    /// Rows of charts.
    pub rows: Vec<Vec<Chart>>,
    /// Sentences of the caption.
    pub caption: Vec<String>,
}

impl Sheet {
    /// The caption in lines as wide as the page.
    fn caption_lines(&self) -> Vec<String> {
        let room = (f64::from(WIDTH) - 2.0 * MARGIN) / (1.1 * CAPTION_LETTERS);
        let mut lines: Vec<String> = Vec::new();
        for sentence in &self.caption {
            let mut line = String::new();
            for word in sentence.split_whitespace() {
                let longer = if line.is_empty() {
                    word.to_owned()
                } else {
                    format!("{line} {word}")
                };
                if helvetica::width(&longer, false) > room && !line.is_empty() {
                    lines.push(std::mem::replace(&mut line, word.to_owned()));
                } else {
                    line = longer;
                }
            }
            lines.push(line);
        }
        lines
    }

    fn row_height(row: &[Chart]) -> f64 {
        let heights = row.iter().map(|chart| chart.height);
        TITLE + heights.fold(0.0, f64::max) + X_LABELS
    }
}

impl Picture for Sheet {
    fn title(&self) -> &str {
        &self.header.title
    }

    fn size(&self) -> (u32, u32) {
        let rows: f64 = self.rows.iter().map(|row| Self::row_height(row)).sum();
        let caption = CAPTION_LINE * self.caption_lines().len() as f64;
        let height = self.header.bottom() + rows + 8.0 + caption + MARGIN;
        (WIDTH, whole(height))
    }

    fn draw<DB>(&self, page: &DrawingArea<DB, Shift>) -> Drawn
    where
        DB: DrawingBackend,
        DB::ErrorType: 'static,
    {
        self.header.draw(page)?;
        let mut top = self.header.bottom();
        for row in &self.rows {
            let gaps = GAP * (row.len().max(1) - 1) as f64;
            let room = f64::from(WIDTH) - 2.0 * MARGIN - gaps;
            let parts: f64 = row.iter().map(|chart| chart.width).sum();
            let mut left = MARGIN;
            for chart in row {
                let width = room * chart.width / parts;
                chart.draw(page, (left, top), width)?;
                left += width + GAP;
            }
            top += Self::row_height(row);
        }
        for (k, line) in self.caption_lines().iter().enumerate() {
            let at = (MARGIN, top + 8.0 + CAPTION_LINE * (k as f64 + 0.5));
            let style = text(CAPTION_LETTERS, FontStyle::Normal, HPos::Left, VPos::Center);
            write(page, line, at, style)?;
        }
        Ok(())
    }
}

/// The plot of a chart on the page, px.
struct Plot<'a> {
    chart: &'a Chart,
    left: f64,
    top: f64,
    width: f64,
}

impl Chart {
    /// Room left of the plot, px.
    fn y_labels(&self) -> f64 {
        let ticks = self.y.ticks().into_iter();
        let widths = ticks.map(|(_, label)| 1.1 * TICK_LETTERS * helvetica::width(&label, false));
        Y_LABELS.max(Y_NAME + widths.fold(0.0, f64::max))
    }

    fn draw<DB>(&self, page: &DrawingArea<DB, Shift>, corner: (f64, f64), width: f64) -> Drawn
    where
        DB: DrawingBackend,
        DB::ErrorType: 'static,
    {
        let beside = self.y_labels();
        let plot = Plot {
            chart: self,
            left: corner.0 + beside,
            top: corner.1 + TITLE,
            width: width - beside - 4.0,
        };
        let title = text(12.5, FontStyle::Bold, HPos::Left, VPos::Center);
        let above = (plot.left, corner.1 + 0.55 * TITLE);
        write(page, &self.title, above, title)?;
        plot.axes(page)?;
        for shape in &self.shapes {
            plot.shape(page, shape)?;
        }
        let (right, bottom) = (plot.left + plot.width, plot.top + self.height);
        let corners = [
            (units(plot.left), units(plot.top)),
            (units(right), units(bottom)),
        ];
        page.draw(&Rectangle::new(corners, frame_line()))?;
        let name = text(12.5, FontStyle::Normal, HPos::Center, VPos::Bottom);
        let below = (plot.left + 0.5 * plot.width, bottom + X_LABELS - 3.0);
        write(page, &self.x_label, below, name)?;
        let beside = (corner.0 + 9.0, plot.top + 0.5 * self.height);
        write(page, &self.y_label, beside, upward_text(12.0))
    }
}

impl Plot<'_> {
    /// Place of a point in units of drawing.
    fn at(&self, (x, y): Point) -> (i32, i32) {
        let Self {
            chart,
            left,
            top,
            width,
        } = self;
        let down = chart.height * (1.0 - chart.y.share(y));
        (units(left + width * chart.x.share(x)), units(top + down))
    }

    /// Ticks with their labels; a label that would touch the one before is left out.
    fn axes<DB>(&self, page: &DrawingArea<DB, Shift>) -> Drawn
    where
        DB: DrawingBackend,
        DB::ErrorType: 'static,
    {
        let (right, bottom) = (self.left + self.width, self.top + self.chart.height);
        let mut free = f64::NEG_INFINITY;
        for (value, label) in self.chart.x.ticks() {
            let x = self.left + self.width * self.chart.x.share(value);
            let up = if self.chart.grid { self.top } else { bottom };
            page.draw(&segment([(x, bottom), (x, up)], grid_line()))?;
            page.draw(&segment([(x, bottom), (x, bottom + 4.0)], frame_line()))?;
            let half = 0.5 * 1.1 * TICK_LETTERS * helvetica::width(&label, false);
            if x - half > free {
                free = x + half + 3.0;
                let style = text(TICK_LETTERS, FontStyle::Normal, HPos::Center, VPos::Top);
                write(page, &label, (x, bottom + 7.0), style)?;
            }
        }
        for (value, label) in self.chart.y.ticks() {
            let y = self.top + self.chart.height * (1.0 - self.chart.y.share(value));
            let end = if self.chart.grid { right } else { self.left };
            page.draw(&segment([(self.left, y), (end, y)], grid_line()))?;
            page.draw(&segment(
                [(self.left - 4.0, y), (self.left, y)],
                frame_line(),
            ))?;
            let style = text(TICK_LETTERS, FontStyle::Normal, HPos::Right, VPos::Center);
            write(page, &label, (self.left - 7.0, y), style)?;
        }
        Ok(())
    }

    fn shape<DB>(&self, page: &DrawingArea<DB, Shift>, shape: &Shape) -> Drawn
    where
        DB: DrawingBackend,
        DB::ErrorType: 'static,
    {
        let places = |points: &[Point]| points.iter().map(|p| self.at(*p)).collect::<Vec<_>>();
        match shape {
            Shape::Area(points, color) => {
                page.draw(&Polygon::new(places(points), color.filled()))?;
            }
            Shape::Cell([a, b], color) => {
                page.draw(&Rectangle::new([self.at(*a), self.at(*b)], color.filled()))?;
            }
            Shape::Line(points, color, px) => {
                page.draw(&PathElement::new(places(points), line(*color, *px)))?;
            }
            Shape::Dashed(points, color, px) => {
                page.draw(&dashed(places(points), line(*color, *px)))?;
            }
            Shape::Dot(point, color, px) => {
                page.draw(&Circle::new(self.at(*point), units(*px), color.filled()))?;
            }
        }
        Ok(())
    }
}

fn segment(ends: [(f64, f64); 2], style: ShapeStyle) -> PathElement<(i32, i32)> {
    PathElement::new(ends.map(|(x, y)| (units(x), units(y))), style)
}
