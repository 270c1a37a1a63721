//! Draws on a page of a PDF file. Text is in Helvetica, which every reader has, so that the file needs no font.

use super::helvetica;
use super::style::FONT_FACTOR;
use pdf_writer::types::{LineCapStyle, LineJoinStyle};
use pdf_writer::{Content, Finish, Name, Pdf, Rect, Ref, Str, TextStr};
use plotters::style::text_anchor::{HPos, VPos};
use plotters::style::{FontStyle, FontTransform};
use plotters_backend::{
    BackendColor, BackendCoord, BackendStyle, BackendTextStyle, DrawingBackend, DrawingErrorKind,
};
use std::convert::Infallible;

type Done = Result<(), DrawingErrorKind<Infallible>>;

/// A page of a PDF file. The file is complete once [`DrawingBackend::present`] has been called.
pub struct PdfBackend<'a> {
    out: &'a mut Vec<u8>,
    size: (u32, u32),
    /// Points in a unit of drawing.
    points: f64,
    title: &'a str,
    content: Content,
}

impl<'a> PdfBackend<'a> {
    /// An empty page of a size in units of drawing, each of so many `points` (1/72 inch).
    pub fn new(out: &'a mut Vec<u8>, size: (u32, u32), points: f64, title: &'a str) -> Self {
        let mut content = Content::new();
        // Coordinates of the drawing library run down from the upper left corner.
        let scale = single(points);
        content.transform([
            scale,
            0.0,
            0.0,
            -scale,
            0.0,
            single(points * f64::from(size.1)),
        ]);
        content.set_line_join(LineJoinStyle::RoundJoin);
        content.set_line_cap(LineCapStyle::ButtCap);
        Self {
            out,
            size,
            points,
            title,
            content,
        }
    }

    fn file(&mut self) -> Vec<u8> {
        let [catalog, pages, page, content, normal, bold, info] =
            [1, 2, 3, 4, 5, 6, 7].map(Ref::new);
        let mut pdf = Pdf::new();
        pdf.catalog(catalog).pages(pages);
        pdf.pages(pages).kids([page]).count(1);
        let mut sheet = pdf.page(page);
        let [width, height] =
            [self.size.0, self.size.1].map(|units| single(self.points * f64::from(units)));
        sheet.media_box(Rect::new(0.0, 0.0, width, height));
        sheet.parent(pages);
        sheet.contents(content);
        let mut resources = sheet.resources();
        resources.fonts().pair(NORMAL, normal).pair(BOLD, bold);
        resources.finish();
        sheet.finish();
        for (font, name) in [(normal, &b"Helvetica"[..]), (bold, b"Helvetica-Bold")] {
            pdf.type1_font(font)
                .base_font(Name(name))
                .encoding_predefined(Name(b"WinAnsiEncoding"));
        }
        let drawn = std::mem::replace(&mut self.content, Content::new()).finish();
        pdf.stream(content, &drawn);
        pdf.document_info(info)
            .title(TextStr(self.title))
            .producer(TextStr("robhaz"));
        pdf.finish()
    }

    /// Draws the path that was begun: filled, or with the line of a style.
    fn paint(&mut self, style: &impl BackendStyle, fill: bool) {
        let [r, g, b] = rgb(style.color());
        if fill {
            self.content.set_fill_rgb(r, g, b);
            self.content.fill_nonzero();
        } else {
            self.content.set_stroke_rgb(r, g, b);
            self.content.set_line_width(style.stroke_width() as f32);
            self.content.stroke();
        }
    }

    fn trace(&mut self, points: impl IntoIterator<Item = BackendCoord>) {
        for (k, (x, y)) in points.into_iter().enumerate() {
            if k == 0 {
                self.content.move_to(x as f32, y as f32);
            } else {
                self.content.line_to(x as f32, y as f32);
            }
        }
    }
}

const NORMAL: Name<'static> = Name(b"F1");
const BOLD: Name<'static> = Name(b"F2");

/// Where the baseline is below the anchor, in sizes of the font: half the height of a small letter for the middle.
fn baseline(v: VPos) -> f64 {
    match v {
        VPos::Top => 0.76,
        VPos::Center => 0.26,
        VPos::Bottom => -0.26,
    }
}

fn single(value: f64) -> f32 {
    #[expect(clippy::cast_possible_truncation, reason = "a page is small")]
    let value = value as f32;
    value
}

fn rgb(color: BackendColor) -> [f32; 3] {
    let (r, g, b) = color.rgb;
    [r, g, b].map(|channel| f32::from(channel) / 255.0)
}

/// ASCII characters unchanged, all others as `?`: the encoding of the fonts.
fn encode(text: &str) -> Vec<u8> {
    let byte = |c: char| {
        if (' '..='~').contains(&c) {
            c as u8
        } else {
            b'?'
        }
    };
    text.chars().map(byte).collect()
}

impl DrawingBackend for PdfBackend<'_> {
    type ErrorType = Infallible;

    fn get_size(&self) -> (u32, u32) {
        self.size
    }

    fn ensure_prepared(&mut self) -> Done {
        Ok(())
    }

    fn present(&mut self) -> Done {
        if self.out.is_empty() {
            *self.out = self.file();
        }
        Ok(())
    }

    fn draw_pixel(&mut self, (x, y): BackendCoord, color: BackendColor) -> Done {
        self.draw_rect((x, y), (x + 1, y + 1), &color, true)
    }

    fn draw_line<S: BackendStyle>(
        &mut self,
        from: BackendCoord,
        to: BackendCoord,
        style: &S,
    ) -> Done {
        self.draw_path([from, to], style)
    }

    fn draw_rect<S: BackendStyle>(
        &mut self,
        (left, top): BackendCoord,
        (right, bottom): BackendCoord,
        style: &S,
        fill: bool,
    ) -> Done {
        if style.color().alpha > 0.0 {
            let (width, height) = ((right - left) as f32, (bottom - top) as f32);
            self.content.rect(left as f32, top as f32, width, height);
            self.paint(style, fill);
        }
        Ok(())
    }

    fn draw_path<S: BackendStyle, I: IntoIterator<Item = BackendCoord>>(
        &mut self,
        path: I,
        style: &S,
    ) -> Done {
        if style.color().alpha > 0.0 && style.stroke_width() > 0 {
            self.trace(path);
            self.paint(style, false);
        }
        Ok(())
    }

    fn draw_circle<S: BackendStyle>(
        &mut self,
        (x, y): BackendCoord,
        radius: u32,
        style: &S,
        fill: bool,
    ) -> Done {
        if style.color().alpha > 0.0 {
            let corner = |k: u32| {
                let (sin, cos) = (std::f64::consts::TAU * f64::from(k) / 48.0).sin_cos();
                let at =
                    |centre: i32, way: f64| single(f64::from(centre) + f64::from(radius) * way);
                (at(x, cos), at(y, sin))
            };
            let (x, y) = corner(0);
            self.content.move_to(x, y);
            for (x, y) in (1..48).map(corner) {
                self.content.line_to(x, y);
            }
            self.content.close_path();
            self.paint(style, fill);
        }
        Ok(())
    }

    fn fill_polygon<S: BackendStyle, I: IntoIterator<Item = BackendCoord>>(
        &mut self,
        corners: I,
        style: &S,
    ) -> Done {
        if style.color().alpha > 0.0 {
            self.trace(corners);
            self.content.close_path();
            self.paint(style, true);
        }
        Ok(())
    }

    fn draw_text<S: BackendTextStyle>(
        &mut self,
        text: &str,
        style: &S,
        (x, y): BackendCoord,
    ) -> Done {
        let bold = matches!(style.style(), FontStyle::Bold);
        let size = style.size() / FONT_FACTOR;
        let anchor = style.anchor();
        let shift = match anchor.h_pos {
            HPos::Left => 0.0,
            HPos::Center => -0.5,
            HPos::Right => -1.0,
        };
        let along = shift * size * helvetica::width(text, bold);
        let down = baseline(anchor.v_pos) * size;
        // Direction of the text; y is down.
        let (dx, dy) = match style.transform() {
            FontTransform::None => (1.0, 0.0),
            FontTransform::Rotate90 => (0.0, 1.0),
            FontTransform::Rotate180 => (-1.0, 0.0),
            FontTransform::Rotate270 => (0.0, -1.0),
        };
        let origin = (
            f64::from(x) + dx * along - dy * down,
            f64::from(y) + dy * along + dx * down,
        );
        let [r, g, b] = rgb(style.color());
        self.content.set_fill_rgb(r, g, b);
        self.content.begin_text();
        self.content
            .set_font(if bold { BOLD } else { NORMAL }, single(size));
        self.content.set_text_matrix([
            single(dx),
            single(dy),
            single(dy),
            single(-dx),
            single(origin.0),
            single(origin.1),
        ]);
        self.content.show(Str(&encode(text)));
        self.content.end_text();
        Ok(())
    }

    fn estimate_text_size<S: BackendTextStyle>(
        &self,
        text: &str,
        style: &S,
    ) -> Result<(u32, u32), DrawingErrorKind<Self::ErrorType>> {
        let bold = matches!(style.style(), FontStyle::Bold);
        let size = style.size() / FONT_FACTOR;
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a line of text is small"
        )]
        let units = |length: f64| length.ceil() as u32;
        Ok((units(size * helvetica::width(text, bold)), units(size)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Closed form: a sigma is outside of the encoding.
    #[test]
    fn letters_outside_of_ascii_are_replaced_not_dropped() {
        assert_eq!(encode("a \u{3c3}~"), b"a ?~");
    }
}
