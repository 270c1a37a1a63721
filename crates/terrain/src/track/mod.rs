//! Tracks: points of the ground in a text table, as measuring programs write them.

mod columns;

use crate::Vec2;
use crate::text_table::{TextRow, TextTable};
pub use columns::{Column, TrackFormat};
use columns::{Columns, HEADER_RULE, is_header_with_units};

/// Largest number of points of a track.
const MOST_POINTS: usize = 2_000_000;
/// Largest magnitude of a coordinate, m.
const FARTHEST: f64 = 1000.0;

/// The first problem of a track: what was found, and what is allowed.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{message}")]
pub struct TrackError {
    /// The line, from 1; `None` for the file as a whole.
    pub line: Option<u64>,
    /// What was found, and what is allowed.
    pub message: String,
}

/// The points of a track, m, x increasing.
///
/// # Errors
/// [`TrackError`]
pub fn read_track(bytes: &[u8], format: &TrackFormat) -> Result<Vec<Vec2>, TrackError> {
    let whole = |message: String| TrackError {
        line: None,
        message,
    };
    let unread = |error: std::io::Error| whole(error.to_string());
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let mut table = TextTable::open(bytes).map_err(unread)?;
    let (byte, separator) = table.separator;
    let (mut points, mut columns) = (Vec::<Vec2>::new(), None);
    let mut row = TextRow::default();
    while table.read(&mut row).map_err(unread)? {
        let refused = |message: String| TrackError {
            line: Some(row.line()),
            message,
        };
        let columns = match &columns {
            Some(columns) => columns,
            None => match Columns::of(&row, format) {
                Ok(found) if found.is_header => {
                    columns = Some(found);
                    continue;
                }
                Ok(_) if has_commented_header(bytes, char::from(byte)) => {
                    return Err(refused(format!(
                        "found a header with units in a comment above, allowed: that header without \"#\"; {HEADER_RULE}"
                    )));
                }
                Ok(found) => columns.insert(found),
                Err(found) => {
                    return Err(refused(format!(
                        "found {found}, read with the separator {separator}; allowed: {HEADER_RULE}"
                    )));
                }
            },
        };
        if points.len() == MOST_POINTS {
            let message = "found more points, allowed: at most 2 000 000";
            return Err(refused(message.to_owned()));
        }
        let point = point(columns, &row, separator).map_err(refused)?;
        let before = points.last().filter(|_| !format.sort);
        if let Some(before) = before.filter(|before| before.x >= point.x) {
            return Err(refused(format!(
                "found x = {} m, allowed: x above that of the point before, {} m; or sort = \"on\"",
                point.x, before.x
            )));
        }
        points.push(point);
    }
    if format.sort {
        points = sorted(points);
    }
    let found = match points.len() {
        0 => "no point",
        1 if format.sort => "one x",
        1 => "one point",
        _ => return Ok(points),
    };
    Err(whole(format!(
        "found {found} with the separator {separator}, allowed: 2 to 2 000 000 points, one a line; {HEADER_RULE}"
    )))
}

/// Whether a comment above the first row is a header with units. Its units must not be ignored.
fn has_commented_header(bytes: &[u8], separator: char) -> bool {
    let lines = bytes.split(|b| b"\r\n".contains(b));
    let mut above = lines
        .map(<[u8]>::trim_ascii)
        .take_while(|line| line.is_empty() || line.starts_with(b"#") || line.starts_with(b"sep="));
    above.any(|line| is_header_with_units(&String::from_utf8_lossy(line), separator))
}

fn point(columns: &Columns, row: &TextRow, separator: &str) -> Result<Vec2, String> {
    let (count, allowed) = (row.filled(), columns.count);
    if count > allowed {
        return Err(format!(
            "found {count} columns with the separator {separator}, allowed: {allowed} as in the first line; a decimal comma needs \
             another separator or quotes"
        ));
    }
    let coordinate = |index: usize| {
        let cell = row.text(index);
        let value = columns.value(index, &cell);
        value.filter(|v| v.abs() <= FARTHEST).ok_or_else(|| {
            let found = match cell.is_empty() {
                true => "nothing".to_owned(),
                false => format!("\"{}\"", cell.chars().take(60).collect::<String>()),
            };
            let name = columns.name(index);
            format!(
                "found {found} in {name}, allowed: a number with a decimal point or comma, from -1000 m to 1000 m (separator {separator})"
            )
        })
    };
    let x = coordinate(columns.x)?;
    Ok(Vec2::new(x, coordinate(columns.height)?))
}

/// Sorts by x; points of equal x become one at their mean height.
fn sorted(mut points: Vec<Vec2>) -> Vec<Vec2> {
    points.sort_by(|a, b| a.x.total_cmp(&b.x));
    #[expect(clippy::float_cmp, reason = "the same number in the file")]
    let groups = points.chunk_by(|a, b| a.x == b.x);
    let mean = |group: &[Vec2]| {
        let sum: f64 = group.iter().map(|p| p.y).sum();
        Vec2::new(group[0].x, sum / group.len() as f64)
    };
    groups.map(mean).collect()
}
