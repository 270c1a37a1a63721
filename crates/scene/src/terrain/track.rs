//! A track: points of the ground in a CSV file, as measuring programs write them.

use super::columns::{Choice, Columns, HEADER_RULE, is_header_with_units};
use crate::error::Problem;
use crate::quantity::grouped;
use crate::reader::Reader;
use crate::source::{Origin, Source};
use csv::{ByteRecord, ReaderBuilder};
use robhaz_model::Vec2;
use std::cell::OnceCell;
use std::path::Path;
use std::sync::Arc;

/// Largest number of points of a track.
pub(crate) const MOST_POINTS: usize = 2_000_000;
/// Largest magnitude of a coordinate, m.
const FARTHEST: f64 = 1000.0;
/// Records from which the separator is found.
const SAMPLE: usize = 20;
/// Separators in the order in which they are tried: a comma may be the decimal mark of the others.
const SEPARATORS: [(u8, &str); 3] = [(b'\t', "tab"), (b';', "semicolon"), (b',', "comma")];

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
    let shown = file.display().to_string();
    if bytes.starts_with(&[0xff, 0xfe]) || bytes.starts_with(&[0xfe, 0xff]) {
        let message = "found text in UTF-16, allowed: UTF-8 or plain ASCII";
        reader.push(Problem::unread(&shown, message.to_owned()));
        return None;
    }
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let mut parser = Parser {
        reader,
        path,
        text: Text {
            bytes,
            name: shown,
            source: OnceCell::new(),
        },
        separator: separator(bytes),
    };
    let mark = parser.reader.mark();
    let points = parser.points(choice);
    (parser.reader.mark() == mark).then_some(points)
}

/// The separator by which every one of the first lines has two columns, else the one by which the first line has.
fn separator(bytes: &[u8]) -> (u8, &'static str) {
    let counts = |separator: u8| -> Vec<usize> {
        let records = csv_reader(bytes, separator).into_byte_records();
        let filled = records.map_while(Result::ok).filter(|r| !is_blank(r));
        filled.take(SAMPLE).map(|r| r.len()).collect()
    };
    let tried = SEPARATORS.map(|(byte, _)| counts(byte));
    let all = tried
        .iter()
        .position(|c| !c.is_empty() && c.iter().all(|n| *n > 1));
    let first = || tried.iter().position(|c| c.first().is_some_and(|n| *n > 1));
    SEPARATORS[all.or_else(first).unwrap_or(2)]
}

fn csv_reader(bytes: &[u8], separator: u8) -> csv::Reader<&[u8]> {
    ReaderBuilder::new()
        .delimiter(separator)
        .has_headers(false)
        .flexible(true)
        .comment(Some(b'#'))
        .from_reader(bytes)
}

/// Whether a record has no data: only separators, an indented comment, or the line `sep=;` that spreadsheets write.
fn is_blank(record: &ByteRecord) -> bool {
    let first = record.get(0).unwrap_or_default().trim_ascii_start();
    first.starts_with(b"#")
        || first.starts_with(b"sep=")
        || record.iter().all(|cell| cell.trim_ascii().is_empty())
}

/// The file's text, made only when a problem has to show a line of it.
struct Text<'a> {
    bytes: &'a [u8],
    name: String,
    source: OnceCell<Arc<Source>>,
}

impl Text<'_> {
    fn source(&self) -> &Arc<Source> {
        self.source.get_or_init(|| {
            // One character for each invalid byte, so that positions do not change.
            let mut text = String::with_capacity(self.bytes.len());
            for chunk in self.bytes.utf8_chunks() {
                text += chunk.valid();
                text.extend(chunk.invalid().iter().map(|_| '?'));
            }
            Source::file(&self.name, &text)
        })
    }

    /// The line on which a record starts.
    fn origin(&self, record: &ByteRecord) -> Origin {
        let at = record.position().map_or(0, csv::Position::byte);
        let at = usize::try_from(at)
            .unwrap_or(usize::MAX)
            .min(self.bytes.len());
        // The position of a record is in front of the blank lines and comments before it.
        let source = Arc::clone(self.source());
        let mut line = source.line_of(at);
        while let Some(span) = source.line_span(line) {
            let text = self.bytes[span.clone()].trim_ascii_start();
            if !text.is_empty() && !text.starts_with(b"#") {
                return Origin { source, span };
            }
            line += 1;
        }
        Origin {
            source,
            span: at..at,
        }
    }
}

struct Parser<'a> {
    reader: &'a mut Reader,
    path: &'a str,
    text: Text<'a>,
    separator: (u8, &'static str),
}

impl Parser<'_> {
    fn complain(&mut self, record: &ByteRecord, message: impl FnOnce() -> String) {
        let origin = self.text.origin(record);
        self.reader.complain(&origin, self.path, message);
    }

    fn points(&mut self, choice: &Choice) -> Vec<Vec2> {
        let mark = self.reader.mark();
        let mut points = Vec::new();
        let mut records = csv_reader(self.text.bytes, self.separator.0);
        let mut record = ByteRecord::new();
        let mut columns: Option<Columns> = None;
        // Reading from memory cannot fail, and lines may have any number of cells.
        while records.read_byte_record(&mut record).unwrap_or(false) {
            if is_blank(&record) {
                continue;
            }
            let columns = match &columns {
                Some(columns) => columns,
                None => match Columns::of(&record, choice) {
                    Ok(found) => {
                        let is_header = found.is_header;
                        let found = columns.insert(found);
                        if is_header {
                            continue;
                        }
                        if self.has_commented_header() {
                            self.complain(&record, || {
                                format!(
                                    "found a header with units in a comment above, allowed: that header without \"#\"; {HEADER_RULE}"
                                )
                            });
                            return points;
                        }
                        found
                    }
                    Err(message) => {
                        let separator = self.separator.1;
                        self.complain(&record, || {
                            format!("found {message}, read with the separator {separator}; allowed: {HEADER_RULE}")
                        });
                        return points;
                    }
                },
            };
            if points.len() == MOST_POINTS {
                self.complain(&record, || {
                    format!(
                        "found more points, allowed: at most {}",
                        grouped(MOST_POINTS)
                    )
                });
                return points;
            }
            match self.point(columns, &record) {
                Ok(point) => {
                    self.in_order(&points, point, &record, choice);
                    points.push(point);
                }
                Err(message) => self.complain(&record, || message),
            }
        }
        if choice.sort {
            points = sorted(points);
        }
        if points.len() < 2 && self.reader.mark() == mark {
            let message = format!(
                "found {} with the separator {}, allowed: 2 to {} points, one a line; {HEADER_RULE}",
                match points.len() {
                    0 => "no point",
                    _ if choice.sort => "one x",
                    _ => "one point",
                },
                self.separator.1,
                grouped(MOST_POINTS)
            );
            self.reader.push(Problem::unread(&self.text.name, message));
        }
        points
    }

    /// Whether a comment above the first record is a header with units. Its units must not be ignored.
    fn has_commented_header(&self) -> bool {
        let lines = self.text.bytes.split(|b| *b == b'\n' || *b == b'\r');
        let mut above = lines.map(<[u8]>::trim_ascii).take_while(|line| {
            line.is_empty() || line.starts_with(b"#") || line.starts_with(b"sep=")
        });
        above.any(|line| is_header_with_units(&String::from_utf8_lossy(line), self.separator.0))
    }

    fn point(&self, columns: &Columns, record: &ByteRecord) -> Result<Vec2, String> {
        let filled = record.iter().rposition(|c| !c.trim_ascii().is_empty());
        let count = filled.map_or(0, |last| last + 1);
        if count > columns.count {
            return Err(format!(
                "found {count} columns with the separator {}, allowed: {} as in the first line; a decimal comma needs \
                 another separator or quotes",
                self.separator.1, columns.count
            ));
        }
        let coordinate = |index: usize| -> Result<f64, String> {
            let cell = String::from_utf8_lossy(record.get(index).unwrap_or_default());
            let value = columns.value(index, cell.trim());
            value.filter(|v| v.abs() <= FARTHEST).ok_or_else(|| {
                let found: String = cell.trim().chars().take(60).collect();
                let found = match found.as_str() {
                    "" => "nothing".to_owned(),
                    found => format!("\"{found}\""),
                };
                format!(
                    "found {found} in {}, allowed: a number with a decimal point or comma, from -1000 m to 1000 m \
                     (separator {})",
                    columns.name(index),
                    self.separator.1
                )
            })
        };
        Ok(Vec2::new(
            coordinate(columns.x)?,
            coordinate(columns.height)?,
        ))
    }

    /// Without sorting, x must grow from line to line.
    fn in_order(&mut self, points: &[Vec2], point: Vec2, record: &ByteRecord, choice: &Choice) {
        if let Some(before) = points.last().filter(|p| !choice.sort && p.x >= point.x) {
            self.complain(record, || {
                format!(
                    "found x = {} m, allowed: x above that of the point before, {} m; or sort = \"on\"",
                    point.x, before.x
                )
            });
        }
    }
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
