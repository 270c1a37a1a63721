//! Colours, widths and letters, the same in every figure.
//!
//! True: a thick solid light line. Estimated: a thin dashed dark line on it. So they are told apart on a grey print too.
//! The wheels have the blue, vermilion and bluish green of Okabe and Ito, which the colour-blind can tell apart.

use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{Color, FontStyle, FontTransform, IntoFont, RGBColor, ShapeStyle, TextStyle};

/// Units of drawing in a unit of the picture: the drawing library places points on whole units only.
pub const SCALE: u32 = 4;

/// True values.
pub const TRUTH: RGBColor = RGBColor(0xB4, 0xB4, 0xB4);
/// [`TRUTH`] as it stands in the file.
#[cfg(test)]
pub const TRUTH_HEX: &str = "#B4B4B4";
/// Estimates of wheels 1, 2 and 3.
pub const WHEELS: [RGBColor; 3] = [
    RGBColor(0x00, 0x72, 0xB2),
    RGBColor(0xD5, 0x5E, 0x00),
    RGBColor(0x00, 0x9E, 0x73),
];
/// Estimates of the linkage.
pub const LINKAGE: RGBColor = RGBColor(0x1A, 0x1A, 0x1A);
/// What does not count in the errors.
pub const START: RGBColor = RGBColor(0xF2, 0xF2, 0xEE);
const GRID: RGBColor = RGBColor(0xE0, 0xE0, 0xE0);
const FRAME: RGBColor = RGBColor(0x70, 0x70, 0x70);
const TEXT: RGBColor = RGBColor(0x20, 0x20, 0x21);

/// Dash and gap, in units of drawing.
const DASHES: &str = "26 14";

/// Length in units of drawing.
pub fn units(px: f64) -> i32 {
    #[expect(
        clippy::cast_possible_truncation,
        reason = "lengths of a picture are small"
    )]
    let units = (px * f64::from(SCALE)).round() as i32;
    units
}

fn line(color: RGBColor, px: f64) -> ShapeStyle {
    color.stroke_width(units(px).unsigned_abs())
}

/// The line of the true values.
pub fn truth_line() -> ShapeStyle {
    line(TRUTH, 3.2)
}

/// The line of an estimate; dashed by [`finish`].
pub fn estimate_line(color: RGBColor) -> ShapeStyle {
    line(color, 1.4)
}

/// Light lines at the ticks.
pub fn grid_line() -> ShapeStyle {
    line(GRID, 0.7)
}

/// The frame of a panel.
pub fn frame_line() -> ShapeStyle {
    line(FRAME, 0.9)
}

/// Letters of a size in px.
pub fn text(px: f64, style: FontStyle, h: HPos, v: VPos) -> TextStyle<'static> {
    // The drawing library writes this fraction of a font's size into the file.
    let size = 1.24 * px * f64::from(SCALE);
    TextStyle::from(("sans-serif", size).into_font().style(style))
        .color(&TEXT)
        .pos(Pos::new(h, v))
}

/// Letters that run upwards.
pub fn upward_text(px: f64) -> TextStyle<'static> {
    text(px, FontStyle::Normal, HPos::Center, VPos::Center).transform(FontTransform::Rotate270)
}

/// The finished file: of its nominal size, joints round, and every line of an estimate's colour dashed.
pub fn finish(svg: &str, (width, height): (u32, u32)) -> String {
    let drawn = format!("width=\"{}\" height=\"{}\"", width * SCALE, height * SCALE);
    let shown = format!("width=\"{width}\" height=\"{height}\"");
    let mut svg = svg.replacen(&drawn, &shown, 1).replace(
        "<polyline fill=\"none\"",
        "<polyline fill=\"none\" stroke-linejoin=\"round\"",
    );
    for RGBColor(r, g, b) in WHEELS.into_iter().chain([LINKAGE]) {
        let stroke = format!("stroke=\"#{r:02X}{g:02X}{b:02X}\"");
        svg = svg.replace(&stroke, &format!("{stroke} stroke-dasharray=\"{DASHES}\""));
    }
    svg
}
