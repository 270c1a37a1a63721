//! Tracks: points of the ground in a text table, as measuring programs write them; which columns
//! are x and height, and in which units.

use crate::Vec2;
use crate::decimals::{Decimals, Grouping, NO_THOUSANDS, NUMBER};
use crate::risers::sorted;
use crate::text_table::{TextRow, TextTable, decimal, name_and_unit};

/// Largest number of points of a track.
const MOST_POINTS: usize = 2_000_000;
/// Largest magnitude of x, and of a height above the first one, m.
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

/// The points of a track, m, x not falling: points of equal x are a riser.
///
/// # Errors
/// [`TrackError`]
pub fn read_track(bytes: &[u8], format: &TrackFormat) -> Result<Vec<Vec2>, TrackError> {
    let unread = |error: std::io::Error| whole(error.to_string());
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let mut table = TextTable::open(bytes).map_err(unread)?;
    let separator = table.separator;
    let (mut points, mut columns) = (Vec::<Vec2>::new(), None);
    let mut row = TextRow::default();
    let mut falls = None;
    while table.read(&mut row).map_err(unread)? {
        let refused = |message: String| TrackError {
            line: Some(row.line),
            message,
        };
        let columns = match &mut columns {
            Some(columns) => columns,
            None => {
                let found = columns_of(&row, format, bytes, separator).map_err(refused)?;
                let is_header = found.is_header;
                let found = columns.insert(found);
                if is_header {
                    continue;
                }
                found
            }
        };
        if points.len() == MOST_POINTS {
            let message = "found more points, allowed: at most 2 000 000";
            return Err(refused(message.to_owned()));
        }
        let point = columns.point(&row, separator.1).map_err(refused)?;
        let before = points.last().filter(|before| before.x > point.x);
        if let (Some(before), None) = (before, &falls) {
            falls = Some(refused(format!(
                "found x = {} m, allowed: x not below that of the point before, {} m",
                point.x, before.x
            )));
        }
        // The same point again says nothing new.
        if points.last() != Some(&point) {
            points.push(point);
        }
    }
    columns.iter().try_for_each(Columns::check_thousands)?;
    let points = match falls {
        _ if format.sort => sorted(&points).map_err(whole)?,
        Some(falls) => return Err(could_sort(falls, &points)),
        None => points,
    };
    let found = match points.len() {
        0 => "no point",
        1 => "one point",
        _ if points.first().map(|p| p.x) == points.last().map(|p| p.x) => "one x",
        _ => return Ok(points),
    };
    Err(whole(format!(
        "found {found} with the separator {}, allowed: 2 to 2 000 000 points, one a line; {HEADER_RULE}",
        separator.1
    )))
}

/// A problem of the file as a whole.
const fn whole(message: String) -> TrackError {
    TrackError {
        line: None,
        message,
    }
}

/// The columns by the first row, a header or a point.
fn columns_of(
    row: &TextRow,
    format: &TrackFormat,
    bytes: &[u8],
    (byte, separator): (u8, &str),
) -> Result<Columns, String> {
    let columns = Columns::of(row, format).map_err(|found| {
        format!("found {found}, read with the separator {separator}; allowed: {HEADER_RULE}")
    })?;
    if !columns.is_header && has_commented_header(bytes, char::from(byte)) {
        return Err(format!(
            "found a header with units in a comment above, allowed: that header without \"#\"; {HEADER_RULE}"
        ));
    }
    Ok(columns)
}

/// The problem of points whose x falls, with what sorts them, if that is possible.
fn could_sort(falls: TrackError, points: &[Vec2]) -> TrackError {
    let remedy = match sorted(points) {
        Ok(_) => "; or sort = \"on\"",
        // A part of the ground that runs back.
        Err(_) => ": one height at each x, without overhangs and points that run back",
    };
    TrackError {
        message: falls.message + remedy,
        ..falls
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

/// Format of a track, for messages.
const HEADER_RULE: &str = "columns separated by comma, semicolon or tab; either two columns, x and height in m, or a \
     first line that names x and height (also y, z, elevation), with units such as x [mm]; among more columns x_column and \
     height_column choose by name or number";

/// Names of the columns that are x and height, in small letters.
const X: &str = "x distance dist position pos station chainage";
const HEIGHT: &str = "height y z h elevation elev altitude";
/// Names of columns that are neither, though they may come first: geographic coordinates, times, and depths, which
/// count downwards.
const NEITHER: &str = "lon long lng longitude lat latitude t time timestamp stamp depth";

/// What must be known of a track beside its text.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct TrackFormat {
    /// The column of x; `None` to find it by its name.
    pub x: Option<Column>,
    /// The column of the height; `None` to find it by its name.
    pub height: Option<Column>,
    /// Whether lines may come in any order of x.
    pub sort: bool,
}

/// How a column is chosen.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Column {
    /// By its name, with or without the unit.
    Name(String),
    /// By its number from 1.
    Number(usize),
}

/// The columns of a track, and what its numbers show of its decimal mark.
struct Columns {
    /// Whether the first line names them.
    is_header: bool,
    /// How many there are.
    count: usize,
    names: Vec<String>,
    /// Those of x and of the height.
    of: [Coordinate; 2],
    decimals: Decimals,
}

/// The column of x or of the height.
struct Coordinate {
    index: usize,
    /// Units in a metre, where the header gives them.
    per_metre: Option<f64>,
    /// That from which lengths count, m.
    first: Option<f64>,
    grouping: Grouping,
}

impl Columns {
    /// Refuses numbers with thousands separators.
    fn check_thousands(&self) -> Result<(), TrackError> {
        for (column, name) in self.of.iter().zip(["x", "the height"]) {
            let is_fine = column.per_metre.is_some_and(|per_metre| per_metre > 1.0);
            if let Some((line, cell)) = column.grouping.thousands(is_fine) {
                return Err(TrackError {
                    line: Some(line),
                    message: format!(
                        "found \"{cell}\" in the column of {name}, allowed: {NO_THOUSANDS}"
                    ),
                });
            }
        }
        Ok(())
    }

    /// From the first line; the error describes what was found.
    fn of(first: &TextRow, format: &TrackFormat) -> Result<Self, String> {
        let cells = first.texts();
        // `nan` and `inf` are lost values, not names.
        let is_number = |cell: &String| decimal(cell).is_some() || with_unit(cell).is_some();
        let is_header = !cells.iter().any(is_number);
        let count = first.filled();
        let names = if is_header { cells } else { Vec::new() };
        if count < 2 {
            return Err("one column".to_owned());
        }
        let (x, height) = (format.x.as_ref(), format.height.as_ref());
        let is_chosen = x.is_some() && height.is_some();
        let mut others = names.iter().filter(|_| !is_chosen && count == 2);
        if let Some(name) = others.find(|name| has(NEITHER, &split(name).0)) {
            let name = short(name);
            return Err(format!(
                "the column \"{name}\", which is neither x nor a height in m"
            ));
        }
        let x = place("x_column", x, X, &names, count)?;
        let height = place("height_column", height, HEIGHT, &names, count)?;
        let (x, height) = match (x, height) {
            (Some(x), Some(height)) => (x, height),
            // Two columns of any names are x and height, unless the names say otherwise.
            (None | Some(0), None | Some(1)) if count == 2 => (0, 1),
            _ => return Err(unclear(&names, count)),
        };
        if x == height {
            return Err(format!("column {} for both x and height", x + 1));
        }
        let coordinate = |index: usize| -> Result<Coordinate, String> {
            Ok(Coordinate {
                index,
                per_metre: names.get(index).map_or(Ok(None), |name| unit_of(name))?,
                first: None,
                grouping: Grouping::default(),
            })
        };
        let [x, height] = [coordinate(x)?, coordinate(height)?];
        // x counts from where the robot starts.
        let x = Coordinate {
            first: Some(0.0),
            ..x
        };
        Ok(Self {
            is_header,
            count,
            of: [x, height],
            names,
            decimals: Decimals::default(),
        })
    }

    /// The point of a row, m.
    fn point(&mut self, row: &TextRow, separator: &str) -> Result<Vec2, String> {
        let (count, allowed) = (row.filled(), self.count);
        if count > allowed {
            return Err(format!(
                "found {count} columns with the separator {separator}, allowed: {allowed} as in the first line; a decimal comma needs \
                 another separator or quotes"
            ));
        }
        let mut point = Vec2::zeros();
        for (coordinate, column) in point.iter_mut().zip(&mut self.of) {
            let cell = row.text(column.index);
            *coordinate =
                column
                    .length(&mut self.decimals, &cell, row.line)
                    .map_err(|allowed| {
                        let found = match cell.is_empty() {
                            true => "nothing".to_owned(),
                            false => format!("\"{}\"", cell.chars().take(60).collect::<String>()),
                        };
                        let name = match self.names.get(column.index) {
                            Some(name) => format!("column \"{}\"", short(name)),
                            None => format!("column {}", column.index + 1),
                        };
                        format!(
                            "found {found} in {name}, allowed: {allowed} (separator {separator})"
                        )
                    })?;
        }
        Ok(point)
    }
}

impl Coordinate {
    /// The length in a cell, m.
    fn length(&mut self, decimals: &mut Decimals, cell: &str, line: u64) -> Result<f64, String> {
        let (number, per_metre) = match self.per_metre {
            Some(per_metre) => (cell, per_metre),
            None => with_unit(cell).unwrap_or((cell, 1.0)),
        };
        let value = decimals.read(number, line)?;
        self.grouping.take(number, value, line);
        let length = value / per_metre;
        // Beyond it a micrometre is lost in rounding.
        if length.is_nan() || length.abs() >= 1e9 {
            return Err(NUMBER.to_owned() + ", below 1e9 m");
        }
        let first = *self.first.get_or_insert(length);
        let is_near = (length - first).abs() <= FARTHEST;
        is_near.then_some(length).ok_or_else(|| {
            let [low, high] = [first - FARTHEST, first + FARTHEST];
            format!("from {low} m to {high} m: x counts from where the robot starts, a height from the first one")
        })
    }
}

/// Index of a column: the chosen one, else the only one with a usual name.
fn place(
    key: &str,
    chosen: Option<&Column>,
    usual: &str,
    names: &[String],
    count: usize,
) -> Result<Option<usize>, String> {
    let named = |is: &dyn Fn(&str) -> bool| -> Vec<usize> {
        let found = names.iter().enumerate().filter(|(_, name)| is(name));
        found.map(|(i, _)| i).collect()
    };
    match chosen {
        Some(Column::Number(number)) if *number > count => {
            Err(format!("{count} columns, but {key} = {number}"))
        }
        Some(Column::Number(number)) => Ok(Some(number - 1)),
        Some(Column::Name(wanted)) => {
            let wanted = wanted.trim().to_lowercase();
            let is = |name: &str| name.to_lowercase() == wanted || split(name).0 == wanted;
            match named(&is).as_slice() {
                [one] => Ok(Some(*one)),
                found => {
                    let columns = match found.is_empty() {
                        true => "no column",
                        false => "several columns",
                    };
                    let (wanted, unclear) = (short(&wanted), unclear(names, count));
                    Err(format!(
                        "{columns} of the name \"{wanted}\" of {key} ({unclear})"
                    ))
                }
            }
        }
        None => {
            let found = named(&|name| has(usual, &split(name).0));
            if found.len() > 1 && count > 2 {
                return Err(unclear(names, count));
            }
            Ok(found.first().copied())
        }
    }
}

fn unclear(names: &[String], count: usize) -> String {
    /// Names shown.
    const MOST: usize = 12;
    if names.is_empty() {
        return format!("{count} columns without names");
    }
    let shown = names.iter().take(MOST);
    let shown: Vec<String> = shown.map(|n| format!("\"{}\"", short(n))).collect();
    let more = if names.len() > MOST { ", ..." } else { "" };
    format!("the columns {}{more}", shown.join(", "))
}

/// Whether a comment is a header of several columns with a unit in brackets, such as
/// `# x [mm], height [mm]`.
fn is_header_with_units(comment: &str, separator: char) -> bool {
    let cells = comment.trim_start_matches('#').split(separator);
    let cells: Vec<&str> = cells.map(str::trim).collect();
    let has_unit = |cell: &&str| {
        cell.ends_with([']', ')']) && split(cell).1.is_some_and(|unit| per_metre(&unit).is_some())
    };
    cells.len() > 1 && cells.iter().any(has_unit)
}

fn short(name: &str) -> String {
    name.chars().take(40).collect()
}

/// A header's name in small letters and its unit: `x [mm]`, `Height (cm)`, `z_mm`, `x / mm`,
/// `x in mm`.
fn split(header: &str) -> (String, Option<String>) {
    let header = header.trim();
    if let Some((name, unit)) = name_and_unit(header) {
        return (name.to_lowercase(), Some(unit.to_owned()));
    }
    if let Some((name, unit)) = header.rsplit_once([' ', '_', '/', '-', '.'])
        && (per_metre(unit).is_some() || has(OTHER_UNITS, &unit.to_lowercase()))
    {
        let name = name.trim_end_matches([' ', '_', '/', '-', '.']);
        let name = name.strip_suffix(" in").unwrap_or(name);
        return (name.trim().to_lowercase(), Some(unit.to_owned()));
    }
    (header.to_lowercase(), None)
}

/// Units in a metre, of the unit that a header names.
fn unit_of(header: &str) -> Result<Option<f64>, String> {
    let Some(unit) = split(header).1 else {
        return Ok(None);
    };
    let found = per_metre(&unit).ok_or_else(|| {
        let (unit, header) = (short(&unit), short(header));
        format!("the unit \"{unit}\" of column \"{header}\", allowed units: m, dm, cm, mm, um")
    });
    found.map(Some)
}

/// Units of a track: signs, prefix of the word, and units in a metre: sub-units divide, since 35 cm
/// is then exactly the double 0.35.
const UNITS: [(&str, &str, f64); 5] = [
    ("m", "", 1.0),
    ("dm", "deci", 1e1),
    ("cm", "centi", 1e2),
    ("mm", "milli", 1e3),
    ("um micron microns", "micro", 1e6),
];
const METRE: [&str; 4] = ["metre", "metres", "meter", "meters"];
/// Units of length that no track may have.
const OTHER_UNITS: &str = "km nm ft feet foot in inch inches yd yards mil mils mi miles kilometers kilometres px pixel pixels";

/// Units in a metre.
fn per_metre(unit: &str) -> Option<f64> {
    // Both signs for micro.
    let unit = unit.to_lowercase().replace(['\u{b5}', '\u{3bc}'], "u");
    let is_it = |(signs, prefix, _): &&(&str, &str, f64)| {
        let word = unit.strip_prefix(prefix).unwrap_or_default();
        has(signs, &unit) || METRE.contains(&word)
    };
    UNITS.iter().find(is_it).map(|(.., per_metre)| *per_metre)
}

/// Whether a list of words has one.
fn has(words: &str, word: &str) -> bool {
    words.split(' ').any(|own| own == word)
}

/// The number of a length with its own unit, and units in a metre.
fn with_unit(cell: &str) -> Option<(&str, f64)> {
    let number = cell.trim_end_matches(char::is_alphabetic);
    let per_metre = per_metre(&cell[number.len()..])?;
    let number = number.trim_end();
    decimal(number)?.is_finite().then_some((number, per_metre))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn headers_name_their_units() {
        for (header, name, unit) in [
            ("x [mm]", "x", Some("mm")),
            ("Height (cm)", "height", Some("cm")),
            ("z_mm", "z", Some("mm")),
            ("x / m", "x", Some("m")),
            ("x in mm", "x", Some("mm")),
            ("elevation", "elevation", None),
            ("wheel_load", "wheel_load", None),
            ("z [\u{b5}m]", "z", Some("\u{b5}m")),
            ("x_millimetres", "x", Some("millimetres")),
            ("height_ft", "height", Some("ft")),
        ] {
            assert_eq!(
                split(header),
                (name.to_owned(), unit.map(str::to_owned)),
                "{header}"
            );
        }
        assert_eq!(unit_of("z [\u{b5}m]"), Ok(Some(1e6)));
        assert!(unit_of("x [ft]").is_err() && unit_of("z_inch").is_err());
        assert_eq!(with_unit("15,5 mm"), Some(("15,5", 1e3)));
        assert_eq!(with_unit("inf m"), None);
    }
}
