//! Panels in columns over a common time axis, drawn as SVG.

use super::clip::{clip, range};
use super::style::{
    SCALE, START, estimate_line, finish, frame_line, grid_line, text, truth_line, units,
    upward_text,
};
use super::trace::{Point, Trace};
use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, VPos};
use std::error::Error;
use std::ops::Range;

/// One quantity, true and estimated.
pub struct Panel<'a> {
    /// What it shows, over its left corner.
    pub title: String,
    /// How well it fits, over its right corner.
    pub note: String,
    /// Quantity and unit.
    pub y_label: &'static str,
    /// Least height of the range, in the unit of the data.
    pub least_span: f64,
    /// True values.
    pub truth: &'a Trace,
    /// Estimated values.
    pub estimate: Option<&'a Trace>,
    /// Colour of the estimate.
    pub color: RGBColor,
}

/// Panels from top to bottom.
pub struct Column<'a> {
    /// The panels.
    pub panels: Vec<Panel<'a>>,
    /// Whether all have one range, so that their heights can be compared.
    pub one_scale: bool,
}

impl<'a> Column<'a> {
    /// Panels whose heights can be compared.
    pub fn of_one_scale(panels: impl Iterator<Item = Panel<'a>>) -> Self {
        Self {
            panels: panels.collect(),
            one_scale: true,
        }
    }

    /// The range of each panel, in the unit of the data.
    fn ranges(&self) -> Vec<Range<f64>> {
        let of = |panels: &[Panel<'_>]| {
            let points: Vec<Point> = panels.iter().flat_map(Panel::points).collect();
            let least_span = panels.iter().map(|p| p.least_span).fold(0.0, f64::max);
            range(points.iter(), least_span)
        };
        if self.one_scale {
            vec![of(&self.panels); self.panels.len()]
        } else {
            self.panels.chunks(1).map(of).collect()
        }
    }
}

impl Panel<'_> {
    fn points(&self) -> impl Iterator<Item = Point> {
        let lines = [Some(self.truth), self.estimate];
        lines
            .into_iter()
            .flatten()
            .flat_map(Trace::pieces)
            .flatten()
    }
}

/// Columns of panels, all of one length, over time from 0 to the run's end.
pub struct Figure<'a> {
    /// What the figure shows.
    pub title: String,
    /// More about it; can be empty.
    pub subtitle: String,
    /// Last time, s; above 0.
    pub end: f64,
    /// Errors count from here on, s.
    pub compare_from: f64,
    /// Name of the estimator shown, if any.
    pub estimate_label: Option<String>,
    /// Colours in which its lines are drawn.
    pub estimate_colors: Vec<RGBColor>,
    /// The columns from left to right.
    pub columns: Vec<Column<'a>>,
}

// The layout, px.
const MARGIN: f64 = 14.0;
const GAP: f64 = 12.0;
const TITLE: f64 = 24.0;
const SUBTITLE: f64 = 19.0;
const LEGEND: f64 = 26.0;
const PANEL_TITLE: f64 = 22.0;
const PANEL: f64 = 138.0;
const Y_LABELS: f64 = 58.0;
const X_LABELS: f64 = 40.0;
const WIDTH: u32 = 880;

type Area<'s> = DrawingArea<SVGBackend<'s>, Shift>;
type Drawn = Result<(), Box<dyn Error>>;

/// The figure as the text of an SVG file; the reason in words when it cannot be drawn.
pub fn svg(figure: &Figure<'_>) -> Result<String, String> {
    let layout = Layout::new(figure);
    let mut svg = String::new();
    draw(&mut svg, figure, &layout).map_err(|e| e.to_string())?;
    Ok(finish(&svg, (WIDTH, layout.height)))
}

fn draw(svg: &mut String, figure: &Figure<'_>, layout: &Layout) -> Drawn {
    let size = (units(f64::from(WIDTH)), units(f64::from(layout.height)));
    let root = SVGBackend::with_string(svg, (size.0.unsigned_abs(), size.1.unsigned_abs()))
        .into_drawing_area();
    root.fill(&WHITE)?;
    header(&root, figure, layout)?;
    for (c, column) in figure.columns.iter().enumerate() {
        let left = MARGIN + f64_of(c) * (layout.column + GAP);
        let panels = column.panels.iter().zip(column.ranges());
        for (r, (panel, range)) in panels.enumerate() {
            let top = layout.panels + f64_of(r) * (PANEL_TITLE + PANEL);
            let last = r + 1 == column.panels.len();
            let height = PANEL_TITLE + PANEL + if last { X_LABELS } else { 0.0 };
            let area = root.clone().shrink(
                (units(left), units(top)),
                (units(layout.column), units(height)),
            );
            draw_panel(&area, figure, panel, &range, last)?;
        }
    }
    root.present()?;
    Ok(())
}

/// Where things stand, px.
struct Layout {
    subtitle: f64,
    legend: f64,
    panels: f64,
    column: f64,
    height: u32,
}

impl Layout {
    fn new(figure: &Figure<'_>) -> Self {
        let subtitle = MARGIN + TITLE;
        let legend = subtitle
            + if figure.subtitle.is_empty() {
                0.0
            } else {
                SUBTITLE
            };
        let panels = legend + LEGEND;
        let columns = f64_of(figure.columns.len());
        let rows = figure
            .columns
            .iter()
            .map(|c| c.panels.len())
            .max()
            .unwrap_or(0);
        let height = panels + f64_of(rows) * (PANEL_TITLE + PANEL) + X_LABELS + 0.5 * MARGIN;
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "the height of a picture"
        )]
        let height = height.ceil() as u32;
        Self {
            subtitle,
            legend,
            panels,
            column: (f64::from(WIDTH) - 2.0 * MARGIN - (columns - 1.0) * GAP) / columns,
            height,
        }
    }
}

fn header(root: &Area<'_>, figure: &Figure<'_>, layout: &Layout) -> Drawn {
    write(
        root,
        &figure.title,
        (MARGIN, MARGIN),
        text(16.0, FontStyle::Bold, HPos::Left, VPos::Top),
    )?;
    let plain = || text(12.5, FontStyle::Normal, HPos::Left, VPos::Center);
    if !figure.subtitle.is_empty() {
        write(
            root,
            &figure.subtitle,
            (MARGIN, layout.subtitle + 0.4 * SUBTITLE),
            plain(),
        )?;
    }
    let y = layout.legend + 0.5 * LEGEND;
    let mut x = MARGIN;
    sample(root, (x, y), truth_line())?;
    x += SAMPLE + 6.0;
    write(root, "true", (x, y), plain())?;
    x += 50.0;
    if let Some(name) = &figure.estimate_label {
        for color in &figure.estimate_colors {
            sample(root, (x, y), estimate_line(*color))?;
            x += SAMPLE + 10.0;
        }
        let label = format!("estimated ({name})");
        write(root, &label, (x, y), plain())?;
        x += 7.0 * f64_of(label.chars().count()) + 20.0;
    }
    if figure.compare_from > 0.0 {
        root.draw(&Rectangle::new(
            [
                (units(x), units(y - 6.0)),
                (units(x + 20.0), units(y + 6.0)),
            ],
            START.filled(),
        ))?;
        outline(root, (x, y - 6.0), (x + 20.0, y + 6.0))?;
        let label = format!("start, not compared (before {} s)", figure.compare_from);
        write(root, &label, (x + 26.0, y), plain())?;
    }
    Ok(())
}

/// Length of a line's sample in the legend, px.
const SAMPLE: f64 = 36.0;

fn sample(root: &Area<'_>, (x, y): (f64, f64), style: ShapeStyle) -> Drawn {
    let line = vec![(units(x), units(y)), (units(x + SAMPLE), units(y))];
    root.draw(&PathElement::new(line, style))?;
    Ok(())
}

fn outline(root: &Area<'_>, (x0, y0): (f64, f64), (x1, y1): (f64, f64)) -> Drawn {
    let corners = [(x0, y0), (x1, y0), (x1, y1), (x0, y1), (x0, y0)];
    let corners: Vec<_> = corners.map(|(x, y)| (units(x), units(y))).to_vec();
    root.draw(&PathElement::new(corners, grid_line()))?;
    Ok(())
}

fn write(
    area: &Area<'_>,
    words: &str,
    (x, y): (f64, f64),
    style: plotters::style::TextStyle<'static>,
) -> Drawn {
    area.draw(&Text::new(words.to_owned(), (units(x), units(y)), style))?;
    Ok(())
}

fn draw_panel(
    area: &Area<'_>,
    figure: &Figure<'_>,
    panel: &Panel<'_>,
    y: &Range<f64>,
    last: bool,
) -> Drawn {
    let width = f64::from(area.dim_in_pixel().0) / f64::from(SCALE);
    panel_texts(area, panel, width, cut(panel.points(), y))?;

    let mut chart = ChartBuilder::on(area)
        .margin_top(units(PANEL_TITLE))
        .margin_right(units(2.0))
        .set_label_area_size(LabelAreaPosition::Left, units(Y_LABELS))
        .set_label_area_size(
            LabelAreaPosition::Bottom,
            if last { units(X_LABELS) } else { 0 },
        )
        .build_cartesian_2d(0.0..figure.end, y.clone())?;
    let start = figure.compare_from.clamp(0.0, figure.end);
    chart.draw_series([Rectangle::new(
        [(0.0, y.start), (start, y.end)],
        START.filled(),
    )])?;
    chart
        .configure_mesh()
        .light_line_style(TRANSPARENT)
        .bold_line_style(grid_line())
        .axis_style(frame_line())
        .x_labels(11)
        .y_labels(6)
        .x_label_formatter(&tick)
        .y_label_formatter(&tick)
        .label_style(text(11.5, FontStyle::Normal, HPos::Center, VPos::Center))
        .set_all_tick_mark_size(units(4.0))
        .draw()?;
    for (trace, style) in [
        (Some(panel.truth), truth_line()),
        (panel.estimate, estimate_line(panel.color)),
    ] {
        let pieces = trace.map(Trace::pieces).unwrap_or_default();
        for part in pieces.iter().flat_map(|piece| clip(piece, y)) {
            chart.draw_series([PathElement::new(part, style)])?;
        }
    }
    let frame = [
        (0.0, y.start),
        (figure.end, y.start),
        (figure.end, y.end),
        (0.0, y.end),
        (0.0, y.start),
    ];
    chart.draw_series([PathElement::new(frame.to_vec(), frame_line())])?;
    if last {
        let middle = Y_LABELS + 0.5 * (width - Y_LABELS);
        write(
            area,
            "time (s)",
            (middle, PANEL_TITLE + PANEL + X_LABELS - 4.0),
            text(12.5, FontStyle::Normal, HPos::Center, VPos::Bottom),
        )?;
    }
    Ok(())
}

/// Title, note and name of the vertical axis.
fn panel_texts(area: &Area<'_>, panel: &Panel<'_>, width: f64, cut: Option<String>) -> Drawn {
    let y = 0.55 * PANEL_TITLE;
    write(
        area,
        &panel.title,
        (Y_LABELS, y),
        text(12.5, FontStyle::Bold, HPos::Left, VPos::Center),
    )?;
    let notes: Vec<&str> = [Some(panel.note.as_str()), cut.as_deref()]
        .into_iter()
        .flatten()
        .filter(|note| !note.is_empty())
        .collect();
    write(
        area,
        &notes.join(", "),
        (width - 2.0, y),
        text(12.0, FontStyle::Normal, HPos::Right, VPos::Center),
    )?;
    write(
        area,
        panel.y_label,
        (9.0, PANEL_TITLE + 0.5 * PANEL),
        upward_text(12.0),
    )
}

/// Says so when a panel does not show all.
fn cut(points: impl Iterator<Item = Point>, range: &Range<f64>) -> Option<String> {
    let mut extremes = (f64::INFINITY, f64::NEG_INFINITY);
    for (_, value) in points {
        extremes = (extremes.0.min(value), extremes.1.max(value));
    }
    let (low, high) = extremes;
    let below = low < range.start;
    let above = high > range.end;
    match (below, above) {
        (true, true) => Some(format!("cut: values from {low:.0} to {high:.0}")),
        (true, false) => Some(format!("cut: values down to {low:.0}")),
        (false, true) => Some(format!("cut: values up to {high:.0}")),
        (false, false) => None,
    }
}

/// A tick's number without the noise of binary fractions.
fn tick(value: &f64) -> String {
    // Adding 0 turns -0 into 0.
    format!("{}", (value * 1e6).round() / 1e6 + 0.0)
}

fn f64_of(count: usize) -> f64 {
    #[expect(clippy::cast_precision_loss, reason = "a handful of panels or letters")]
    let count = count as f64;
    count
}
