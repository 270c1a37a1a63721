//! Colours, widths and letters, the same in every figure, and how words and lines are drawn.
//!
//! True: a wide light line. Estimated: a thin dark line on it. So they can be distinguished on a
//! grey print too. The wheels have the blue, vermilion and bluish green of Okabe and Ito, which
//! colour-blind readers can distinguish.

use plotters::coord::Shift;
use plotters::element::{DashedPathElement, DynElement, IntoDynElement, PathElement};
use plotters::prelude::{DrawingArea, SVGBackend, Text};
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{Color, FontStyle, FontTransform, IntoFont, RGBColor, ShapeStyle, TextStyle};
use std::error::Error;

/// The result of drawing a part of a figure.
pub type Drawn = Result<(), Box<dyn Error>>;
/// A part of the page. A px has [`SCALE`] units.
pub type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;

/// Units of drawing in a unit of the picture: the drawing library places points on whole units
/// only.
pub const SCALE: u32 = 4;
/// The drawing library writes a font's size divided by this into the file.
pub const FONT_FACTOR: f64 = 1.24;

/// True values.
pub const TRUTH: RGBColor = RGBColor(0xB4, 0xB4, 0xB4);
/// Estimates of wheels 1, 2 and 3.
pub const WHEELS: [RGBColor; 3] = [
    RGBColor(0x00, 0x72, 0xB2),
    RGBColor(0xD5, 0x5E, 0x00),
    RGBColor(0x00, 0x9E, 0x73),
];
/// Estimates of the linkage.
pub const LINKAGE: RGBColor = RGBColor(0x1A, 0x1A, 0x1A);
/// Time that does not count in the errors.
pub const START: RGBColor = RGBColor(0xF2, 0xF2, 0xEE);
/// The ground, and its surface.
pub const GROUND: RGBColor = RGBColor(0xEC, 0xE6, 0xDC);
/// The surface of the ground.
pub const SURFACE: RGBColor = RGBColor(0x8A, 0x7F, 0x70);
/// Links and body of the robot.
pub const ROBOT: RGBColor = RGBColor(0x55, 0x55, 0x55);
/// Light lines at the ticks.
pub const GRID: RGBColor = RGBColor(0xE0, 0xE0, 0xE0);
const FRAME: RGBColor = RGBColor(0x70, 0x70, 0x70);
const TEXT: RGBColor = RGBColor(0x20, 0x20, 0x21);

/// A length in px as units of drawing.
pub fn units(px: f64) -> i32 {
    // Lengths of a picture are small.
    (px * f64::from(SCALE)).round() as i32
}

/// A line of a width in px.
pub fn line(color: RGBColor, px: f64) -> ShapeStyle {
    color.stroke_width(units(px).unsigned_abs())
}

/// The line of the true values.
pub fn truth_line() -> ShapeStyle {
    line(TRUTH, 3.2)
}

/// The line of an estimate.
pub fn estimate_line(color: RGBColor) -> ShapeStyle {
    line(color, 1.0)
}

/// The frame of a panel.
pub fn frame_line() -> ShapeStyle {
    line(FRAME, 0.9)
}

/// The area of two standard deviations around an estimate: opaque, since not every printer mixes
/// colours alike.
pub fn band_color(RGBColor(r, g, b): RGBColor) -> RGBColor {
    const WHITE: f64 = 0.78;
    let mixed = |channel: u8| {
        let value = f64::from(channel) * (1.0 - WHITE) + 255.0 * WHITE;
        // Between two bytes.
        value.round() as u8
    };
    RGBColor(mixed(r), mixed(g), mixed(b))
}

/// Letters of a size in px.
pub fn text(px: f64, style: FontStyle, h: HPos, v: VPos) -> TextStyle<'static> {
    let size = FONT_FACTOR * px * f64::from(SCALE);
    let font = ("Helvetica, Arial, sans-serif", size).into_font();
    let text = TextStyle::from(font.style(style)).color(&TEXT);
    text.pos(Pos::new(h, v))
}

/// Letters that run upwards.
pub fn upward_text(px: f64) -> TextStyle<'static> {
    text(px, FontStyle::Normal, HPos::Center, VPos::Center).transform(FontTransform::Rotate270)
}

/// Writes words at a place in px.
pub fn write(area: &Area<'_>, words: &str, (x, y): (f64, f64), style: TextStyle<'static>) -> Drawn {
    area.draw(&Text::new(words.to_owned(), (units(x), units(y)), style))?;
    Ok(())
}

/// A line through points, dashed or not, by the drawing library's own elements.
pub fn path<'a, C: Clone + 'static>(
    points: Vec<C>,
    style: ShapeStyle,
    is_dashed: bool,
) -> DynElement<'static, SVGBackend<'a>, C> {
    match is_dashed {
        true => DashedPathElement::new(points, units(7.0), units(4.0), style).into_dyn(),
        false => PathElement::new(points, style).into_dyn(),
    }
}
