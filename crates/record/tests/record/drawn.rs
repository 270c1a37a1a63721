//! Figures as SVG, and the lines and areas in it.

use plotters::style::RGBColor;
use robhaz_record::figures::style::line;
use robhaz_record::figures::{Axis, Layer, Page, Panel, Scale, write_figure};

/// A point of an SVG, in units of its inner drawing; y is positive downward.
pub type Pixel = (i32, i32);

/// The SVG of one panel.
pub fn svg(panel: Panel, axis: &Axis, scale: Scale) -> String {
    let folder = tempfile::tempdir().expect("a folder");
    let page = Page {
        title: String::new(),
        subtitle: String::new(),
        key: Vec::new(),
        axis: axis.clone(),
        scale,
        columns: vec![vec![panel]],
    };
    write_figure(folder.path(), "panel", &page).expect("drawn");
    std::fs::read_to_string(folder.path().join("panel.svg")).expect("a figure")
}

/// A line through values at 0, 1, 2 ...
pub fn values(values: impl IntoIterator<Item = f64>, color: RGBColor) -> Layer {
    let points = (0_u32..).map(f64::from).zip(values).collect();
    Layer::line(vec![points], line(color, 1.0))
}

/// Points of the lines of a colour.
pub fn lines(svg: &str, color: RGBColor) -> Vec<Vec<Pixel>> {
    shapes(svg, "<polyline", "stroke", color)
}

/// Corners of the areas of a colour.
pub fn areas(svg: &str, color: RGBColor) -> Vec<Vec<Pixel>> {
    shapes(svg, "<polygon", "fill", color)
}

fn shapes(svg: &str, tag: &str, key: &str, RGBColor(r, g, b): RGBColor) -> Vec<Vec<Pixel>> {
    let color = format!("{key}=\"#{r:02X}{g:02X}{b:02X}\"");
    let of_color = |l: &&str| l.starts_with(tag) && l.contains(&color);
    svg.lines().filter(of_color).map(points).collect()
}

fn points(shape: &str) -> Vec<Pixel> {
    let (_, points) = shape.split_once("points=\"").expect("points");
    let points = points.split('"').next().expect("their end");
    let pixel = |point: &str| {
        let (x, y) = point.split_once(',').expect("two numbers");
        let number = |text: &str| text.parse().expect("a whole number");
        (number(x), number(y))
    };
    points.split_whitespace().map(pixel).collect()
}
