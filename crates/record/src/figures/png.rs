//! A figure as a PNG file: its SVG file, drawn with the fonts of this machine.

use resvg::tiny_skia::{Pixmap, Transform};
use resvg::usvg::fontdb::{Database, Family, Query, Weight};
use resvg::usvg::{Options, Tree};
use std::sync::Arc;

/// Pixels of the file for a px of the figure: 192 dots an inch.
const PIXELS: f32 = 2.0;

/// Fonts with the widths of Helvetica, for which figures are laid out; then other ones without serifs, which most machines
/// have one of.
const FONTS: [&str; 10] = [
    "Helvetica",
    "Nimbus Sans",
    "Liberation Sans",
    "Arimo",
    "Arial",
    "TeX Gyre Heros",
    "FreeSans",
    "Noto Sans",
    "Open Sans",
    "DejaVu Sans",
];

/// The bytes of the file; the reason when it cannot be drawn.
pub fn png(svg: &[u8]) -> Result<Vec<u8>, String> {
    let mut fonts = Database::new();
    fonts.load_system_fonts();
    let font = sans_serif(&fonts).ok_or_else(no_font)?;
    // The figure asks for Helvetica, Arial, or any font without serifs.
    fonts.set_sans_serif_family(font);
    let options = Options {
        font_family: font.to_owned(),
        fontdb: Arc::new(fonts),
        ..Options::default()
    };
    let tree = Tree::from_data(svg, &options).map_err(|e| e.to_string())?;
    let size = tree.size().to_int_size();
    let size = size.scale_by(PIXELS).unwrap_or(size);
    let mut pixmap = Pixmap::new(size.width(), size.height()).ok_or("it is too large")?;
    let scale = Transform::from_scale(PIXELS, PIXELS);
    resvg::render(&tree, scale, &mut pixmap.as_mut());
    pixmap.encode_png().map_err(|e| e.to_string())
}

/// The first of the fonts that this machine has, in normal and bold.
fn sans_serif(fonts: &Database) -> Option<&'static str> {
    let has = |name: &str, weight| {
        let query = Query {
            families: &[Family::Name(name)],
            weight,
            ..Query::default()
        };
        fonts.query(&query).is_some()
    };
    let usable = |name: &&str| has(name, Weight::NORMAL) && has(name, Weight::BOLD);
    FONTS.into_iter().find(usable)
}

fn no_font() -> String {
    format!(
        "this machine has none of the fonts {}: install one of them (Debian: fonts-liberation), or draw SVG or PDF, which need none",
        FONTS.join(", ")
    )
}
