//! Points that the ground goes through, in the scene itself or in a separate file.

use super::columns::{Choice, Column};
use super::track::{self, Track};
use crate::error::Problem;
use crate::file;
use crate::json;
use crate::key::{Form, Number, SWITCH};
use crate::range::at_least;
use crate::reader::{Reader, grouped, join};
use crate::source::{Node, Value};
use crate::units::LENGTH;
use robhaz_model::Vec2;
use serde_json::json;

/// Largest number of points in a scene; more belong into a file.
const MOST: usize = 100_000;
/// What `points` may be.
pub(super) const POINTS: Form = Form {
    words: "an array of 2 to 100000 points [x, y], each at least -1000 and at most 1000, x increasing",
    schema: || json::array(json::array(json::number(&COORDINATE), 2, 2), 2, MOST),
};
/// What `file` may be.
pub(super) const FILE: Form = Form {
    words: "the path of a .csv file of at most 2000000 points and 100 MB, relative to the scene file",
    schema: json::text,
};
/// What the keys of columns may be.
pub(super) const COLUMN: Form = Form {
    words: "a name of the first line, or a number from 1",
    schema: || json!({"anyOf": [json::text(), {"type": "integer", "minimum": 1}]}),
};

/// The keys that describe the file.
const OF_FILE: [&str; 4] = ["x_column", "height_column", "sort", "file_hash"];

/// A coordinate.
const COORDINATE: Number = Number {
    unit: LENGTH,
    range: at_least(-1000.0).at_most(1000.0),
};

/// Reads the points of a table, and the file that they come from.
pub(crate) fn read(reader: &mut Reader, node: &Node, path: &str) -> (Vec<Vec2>, Option<Track>) {
    match (node.get("file"), node.get("points")) {
        (Some(file), None) => {
            let track = from_file(reader, node, file, path);
            track.map_or((Vec::new(), None), |(points, track)| (points, Some(track)))
        }
        (None, Some(points)) => {
            for key in OF_FILE {
                if let Some(given) = node.get(key) {
                    reader.refuse(
                        given,
                        &join(path, key),
                        "no such key beside points; it belongs to file",
                    );
                }
            }
            (of_nodes(reader, points, &join(path, "points")), None)
        }
        (file, _) => {
            let found = if file.is_some() { "both" } else { "neither" };
            let message = format!("found {found} of file and points, allowed: one of them");
            reader.push(Problem::at(&node.origin, path, message).whole());
            (Vec::new(), None)
        }
    }
}

fn of_nodes(reader: &mut Reader, node: &Node, path: &str) -> Vec<Vec2> {
    let items = match &node.value {
        Value::Array(items) if (2..=MOST).contains(&items.len()) => items,
        Value::Array(items) => {
            let count = grouped(items.len());
            reader.complain(&node.origin, path, || {
                format!(
                    "found {count} points, allowed: {}; more can stand in a file",
                    POINTS.words
                )
            });
            return Vec::new();
        }
        _ => {
            reader.refuse(node, path, POINTS.words);
            return Vec::new();
        }
    };
    let mut points: Vec<Vec2> = Vec::with_capacity(items.len());
    for (i, item) in items.iter().enumerate() {
        let path = format!("{path}[{i}]");
        let Some(point) = reader.point(&COORDINATE, item, &path) else {
            continue;
        };
        if let Some(before) = points.last().filter(|p| p.x >= point.x) {
            let allowed = format!("x above that of the point before, {} m", before.x);
            reader.refuse(item, &path, &allowed);
        }
        points.push(point);
    }
    points
}

/// The points of a file.
fn from_file(
    reader: &mut Reader,
    node: &Node,
    file: &Node,
    path: &str,
) -> Option<(Vec<Vec2>, Track)> {
    let key = join(path, "file");
    let Value::Text(name) = &file.value else {
        reader.refuse(file, &key, FILE.words);
        return None;
    };
    let choice = choice(reader, node, path)?;
    let found = reader.base_dir.join(name);
    let bytes = match file::read(&found, file::MOST_TRACK) {
        Ok(bytes) => bytes,
        Err(error) => {
            let shown = found.display();
            reader.complain(&file.origin, &key, || {
                let name = file.origin.found();
                format!("found {name}, but {shown} {error}; allowed: {}", FILE.words)
            });
            return None;
        }
    };
    let points = track::read(reader, (&found, &key), &bytes, &choice)?;
    let track = Track {
        part: None,
        bytes: bytes.into(),
        choice,
    };
    if let Some(given) = node.get("file_hash") {
        let hash = track.hash();
        if !matches!(&given.value, Value::Text(text) if *text == hash) {
            let allowed = format!("{hash}, which the file has: it is not the one that was meant");
            reader.refuse(given, &join(path, "file_hash"), &allowed);
        }
    }
    Some((points, track))
}

/// Choices of the scene about the file; `None` after a problem.
fn choice(reader: &mut Reader, node: &Node, path: &str) -> Option<Choice> {
    let mark = reader.mark();
    let mut column = |key: &str| -> Option<Column> {
        let given = node.get(key)?;
        match &given.value {
            Value::Text(name) if !name.trim().is_empty() => Some(Column::Name(name.clone())),
            Value::Integer(Some(number), _) if (1..=100_000).contains(number) => {
                usize::try_from(*number).ok().map(Column::Number)
            }
            _ => {
                reader.refuse(given, &join(path, key), COLUMN.words);
                None
            }
        }
    };
    let (x, height) = (column("x_column"), column("height_column"));
    let sort = node
        .get("sort")
        .and_then(|given| reader.word(SWITCH, given, &join(path, "sort")));
    let choice = Choice {
        x,
        height,
        sort: sort == Some(1),
    };
    (reader.mark() == mark).then_some(choice)
}
