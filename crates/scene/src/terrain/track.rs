//! A track: points of the ground in a CSV file, as measuring programs write them.

use super::columns::{Choice, Columns, HEADER_RULE, is_header_with_units};
use crate::error::Problem;
use crate::quantity::grouped;
use crate::reader::Reader;
use crate::source::{Origin, Source};
use crate::text_table::{TextRow, TextTable};
use robhaz_model::Vec2;
use std::cell::OnceCell;
use std::path::Path;
use std::sync::Arc;

/// Largest number of points of a track.
pub(crate) const MOST_POINTS: usize = 2_000_000;
/// Largest magnitude of a coordinate, m.
const FARTHEST: f64 = 1000.0;

/// A file of points as the scene names it, with its content: the run's folder gets a copy.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Track {
    /// Index of the part of the ground, from 0; `None` for the whole ground.
    pub part: Option<usize>,
    /// The file's content.
    pub bytes: Arc<[u8]>,
    pub(crate) choice: Choice,
}

impl Track {
    /// Name of the copy in a run's folder.
    pub fn file_name(&self) -> String {
        match self.part {
            None => "track.csv".to_owned(),
            Some(part) => format!("track-{part}.csv"),
        }
    }

    /// The hash that the resolved scene states: `sha256:` and 64 digits.
    pub fn hash(&self) -> String {
        hash(&self.bytes)
    }
}

pub(crate) fn hash(bytes: &[u8]) -> String {
    use sha2::Digest;
    let digest = sha2::Sha256::digest(bytes);
    let digits: Vec<String> = digest.iter().map(|b| format!("{b:02x}")).collect();
    format!("sha256:{}", digits.concat())
}

/// The points of a track, m; `None` after a problem. `path` is the key that names the file.
pub(crate) fn read(
    reader: &mut Reader,
    (file, path): (&Path, &str),
    bytes: &[u8],
    choice: &Choice,
) -> Option<Vec<Vec2>> {
    let name = file.display().to_string();
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let unread = |reader: &mut Reader, message| reader.push(Problem::unread(&name, message));
    let mut table = match TextTable::open(bytes) {
        Ok(table) => table,
        Err(error) => {
            unread(reader, error.to_string());
            return None;
        }
    };
    let separator = table.separator_name();
    let mark = reader.mark();
    let (mut points, mut columns) = (Vec::<Vec2>::new(), None);
    let text = OnceCell::new();
    let mut row = TextRow::default();
    // Reading from memory cannot fail.
    while table.read(&mut row).unwrap_or(false) {
        let mut complain = |message: &dyn Fn() -> String| {
            let source = text.get_or_init(|| shown(&name, bytes));
            reader.complain(&origin(source, row.line()), path, message);
        };
        let columns = match &columns {
            Some(columns) => columns,
            None => match Columns::of(&row, choice) {
                Ok(found) if found.is_header => {
                    columns = Some(found);
                    continue;
                }
                Ok(_) if has_commented_header(bytes, table.separator()) => {
                    complain(&|| {
                        format!(
                            "found a header with units in a comment above, allowed: that header without \"#\"; {HEADER_RULE}"
                        )
                    });
                    return None;
                }
                Ok(found) => columns.insert(found),
                Err(found) => {
                    complain(&|| {
                        format!(
                            "found {found}, read with the separator {separator}; allowed: {HEADER_RULE}"
                        )
                    });
                    return None;
                }
            },
        };
        if points.len() == MOST_POINTS {
            let most = grouped(MOST_POINTS);
            complain(&|| format!("found more points, allowed: at most {most}"));
            return None;
        }
        let (point, before) = match point(columns, &row, separator) {
            Ok(point) => (point, points.last()),
            Err(message) => {
                complain(&|| message.clone());
                continue;
            }
        };
        // Without sorting, x must grow from line to line.
        if let Some(before) = before.filter(|before| !choice.sort && before.x >= point.x) {
            complain(&|| {
                format!(
                    "found x = {} m, allowed: x above that of the point before, {} m; or sort = \"on\"",
                    point.x, before.x
                )
            });
        }
        points.push(point);
    }
    if choice.sort {
        points = sorted(points);
    }
    if points.len() < 2 && reader.mark() == mark {
        let found = match points.len() {
            0 => "no point",
            _ if choice.sort => "one x",
            _ => "one point",
        };
        let most = grouped(MOST_POINTS);
        unread(
            reader,
            format!(
                "found {found} with the separator {separator}, allowed: 2 to {most} points, one a line; {HEADER_RULE}"
            ),
        );
    }
    (reader.mark() == mark).then_some(points)
}

/// The file's text for messages: one character for each invalid byte, so that positions do not change.
fn shown(name: &str, bytes: &[u8]) -> Arc<Source> {
    let mut text = String::with_capacity(bytes.len());
    for chunk in bytes.utf8_chunks() {
        text += chunk.valid();
        text.extend(chunk.invalid().iter().map(|_| '?'));
    }
    Source::file(name, &text)
}

fn origin(source: &Arc<Source>, line: u64) -> Origin {
    let line = usize::try_from(line).unwrap_or(usize::MAX);
    Origin {
        source: Arc::clone(source),
        span: source.line_span(line).unwrap_or_default(),
    }
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
    Ok(Vec2::new(
        coordinate(columns.x)?,
        coordinate(columns.height)?,
    ))
}

/// Sorts by x; points of equal x become one at their mean height.
fn sorted(mut points: Vec<Vec2>) -> Vec<Vec2> {
    points.sort_by(|a, b| a.x.total_cmp(&b.x));
    #[expect(clippy::float_cmp, reason = "the same number in the file")]
    let groups = points.chunk_by(|a, b| a.x == b.x);
    #[expect(clippy::cast_precision_loss, reason = "a count of points")]
    let mean = |group: &[Vec2]| {
        let sum: f64 = group.iter().map(|p| p.y).sum();
        Vec2::new(group[0].x, sum / group.len() as f64)
    };
    groups.map(mean).collect()
}
