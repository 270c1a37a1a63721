//! Points that the ground goes through, in the scene itself or in a file of their own.

use crate::error::Problem;
use crate::key::{Key, Number};
use crate::range::at_least;
use crate::reader::{Reader, join};
use crate::source::{Node, Origin, Source, Value};
use crate::terrain_keys::Shape;
use crate::units::LENGTH;
use robhaz_model::Vec2;
use std::sync::Arc;

/// More points than this are a mistake.
const MOST: usize = 100_000;
const POINTS: &str =
    "an array of 2 to 100000 points [x, y], each at least -1000 and at most 1000, x increasing";
const FILE: &str = "the path of a .csv file with lines x,y in m, relative to the scene file";

/// The keys of kind `heights` that are read here.
pub(crate) const KEYS: &[Key<Shape>] = &[
    Key::own(
        "file",
        "none",
        FILE,
        "kind heights only: points from a file; either this or points",
    ),
    Key::own(
        "points",
        "none",
        POINTS,
        "kind heights only: points that the ground goes through, m; heights count from the first",
    ),
];

/// A coordinate.
const COORDINATE: Number = Number {
    unit: LENGTH,
    range: at_least(-1000.0).at_most(1000.0),
};

/// Reads the points of a table.
pub(crate) fn read(reader: &mut Reader, node: &Node, path: &str) -> Vec<Vec2> {
    match (node.get("file"), node.get("points")) {
        (Some(file), None) => {
            let path = join(path, "file");
            let points = from_file(reader, file, &path);
            points.map_or(Vec::new(), |p| of_nodes(reader, &p, &path))
        }
        (None, Some(points)) => of_nodes(reader, points, &join(path, "points")),
        (file, _) => {
            let found = if file.is_some() { "both" } else { "neither" };
            let message = format!("found {found} of file and points, allowed: one of them");
            reader.push(Problem::at(&node.origin, path, message).whole());
            Vec::new()
        }
    }
}

fn of_nodes(reader: &mut Reader, node: &Node, path: &str) -> Vec<Vec2> {
    let items = match &node.value {
        Value::Array(items) if (2..=MOST).contains(&items.len()) => items,
        _ => {
            reader.refuse(node, path, POINTS);
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

/// The lines of a file as an array of points.
fn from_file(reader: &mut Reader, node: &Node, path: &str) -> Option<Node> {
    let Value::Text(name) = &node.value else {
        reader.refuse(node, path, FILE);
        return None;
    };
    let file = reader.base_dir.join(name);
    let shown = file.display().to_string();
    match std::fs::read_to_string(&file) {
        Ok(text) => Some(lines(&Source::file(&shown, &text))),
        Err(error) => {
            let found = node.origin.found();
            let message =
                format!("found {found}, but {shown} cannot be read: {error}; allowed: {FILE}");
            reader.push(Problem::at(&node.origin, path, message));
            None
        }
    }
}

/// Every line is a point, but for empty ones, those that start with `#`, and a first one `x,y` that names the columns.
fn lines(source: &Arc<Source>) -> Node {
    let text = source.named.inner();
    let origin = |part: &str| {
        let start = part.as_ptr() as usize - text.as_ptr() as usize;
        Origin {
            source: Arc::clone(source),
            span: start..start + part.len(),
        }
    };
    let cell = |cell: &str| {
        let cell = cell.trim();
        Node {
            origin: origin(cell),
            value: cell
                .parse()
                .map_or_else(|_| Value::Text(cell.to_owned()), Value::Float),
        }
    };
    let is_header = |line: &str| line.split(',').map(str::trim).eq(["x", "y"]);
    let rows = text
        .lines()
        .map(|line| line.trim_start_matches('\u{feff}').trim())
        .filter(|line| !line.is_empty() && !line.starts_with('#'))
        .enumerate()
        .filter(|(i, line)| *i > 0 || !is_header(line))
        .map(|(_, line)| Node {
            origin: origin(line),
            value: Value::Array(line.split(',').map(cell).collect()),
        });
    Node {
        value: Value::Array(rows.collect()),
        origin: origin(text),
    }
}
