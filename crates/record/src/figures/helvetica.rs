//! Widths of the letters of Helvetica, one of the fonts that every PDF reader has.
//!
//! Source: Adobe's font metrics (AFM) of Helvetica, characters 32 to 126, in thousandths of the size.

#[rustfmt::skip]
const WIDTHS: [u16; 95] = [
    278, 278, 355, 556, 556, 889, 667, 191, 333, 333, 389, 584, 278, 333, 278, 278,
    556, 556, 556, 556, 556, 556, 556, 556, 556, 556, 278, 278, 584, 584, 584, 556,
    1015, 667, 667, 722, 722, 667, 611, 778, 722, 278, 500, 667, 556, 833, 722, 778,
    667, 778, 722, 667, 611, 722, 667, 944, 667, 667, 611, 278, 278, 278, 469, 556,
    333, 556, 556, 500, 556, 556, 278, 556, 556, 222, 222, 500, 222, 833, 556, 556,
    556, 556, 333, 500, 278, 556, 500, 722, 500, 500, 500, 334, 260, 334, 584,
];
/// Width of a line of text in sizes of its font. Characters outside of ASCII count as wide as `?`.
pub fn width(text: &str) -> f64 {
    let of = |c: char| {
        let index = (c as usize).checked_sub(32);
        index.and_then(|i| WIDTHS.get(i)).copied().unwrap_or(556)
    };
    text.chars().map(|c| f64::from(of(c))).sum::<f64>() / 1000.0
}
