//! Points that the ground goes through, in the scene itself or in a separate file, a track.

use super::ground::{Ground, TerrainChoice, Track};
use robhaz_keys::prelude::*;
use robhaz_model::Vec2;
use robhaz_terrain::{Column, Heights, Profile, TrackError, check_risers, read_track};
use serde_json::{Value as Json, json};

/// Largest number of points in a scene; more belong into a file.
const MOST: usize = 100_000;
/// Largest size of a track, bytes.
const MOST_BYTES: usize = 100_000_000;
const POINT: Array<Number, Vec2> = point(number(LENGTH, at_least(-1000.0).at_most(1000.0)));

/// The file of the points.
pub(super) const FILE: Plain<String> = text(
    "the path of a .csv file of at most 2000000 points and 100 MB, relative to the scene file",
);
/// The hash of that file.
pub(super) const HASH: Plain<String> = Plain {
    schema: || json!({"type": "string", "pattern": "^sha256:[0-9a-f]{64}$"}),
    ..text("\"sha256:\" and 64 digits")
};

/// Points, x not falling.
pub(super) struct Points;

impl Form for Points {
    type Value = Vec<Vec2>;

    fn read(&self, reader: &mut Reader, node: &Node, path: &str, into: &mut Self::Value) {
        if let Value::Array(items) = &node.value
            && !(2..=MOST).contains(&items.len())
        {
            let (count, allowed) = (source::grouped(items.len()), self.allowed());
            let message =
                format!("found {count} points, allowed: {allowed}; more can stand in a file");
            return reader.push(Problem::at(&node.origin, path, message));
        }
        for (item, path) in reader.items(node, path, 2..=MOST, || self.allowed()) {
            let (mark, mut point) = (reader.mark(), Vec2::zeros());
            POINT.read(reader, item, &path, &mut point);
            if reader.mark() > mark {
                continue;
            }
            if let Some(before) = into.last().filter(|p| p.x > point.x || **p == point) {
                let allowed = format!(
                    "x above that of the point before, {} m, or the same with another height, a riser",
                    before.x
                );
                reader.refuse(item, &path, &allowed);
            }
            into.push(point);
        }
    }

    fn text(&self, value: &mut Self::Value) -> Option<String> {
        let lines = value.iter_mut().filter_map(|at| POINT.text(at));
        let lines: Vec<String> = lines.map(|point| format!("    {point},\n")).collect();
        (!lines.is_empty()).then(|| format!("[\n{}]", lines.concat()))
    }

    fn about(&self) -> About {
        About::new(
            "an array of 2 to 100000 points [x, y], each at least -1000 and at most 1000, x increasing; equal with corners, a riser",
        )
    }

    fn schema(&self, _defaults: Option<&mut Self::Value>) -> Json {
        items(POINT.schema(None), [2, MOST])
    }
}

/// A column of the file.
pub(super) const COLUMN: Plain<Option<Column>> = Plain {
    words: "a name of the first line, or a number from 1",
    schema: || json!({"anyOf": [text("").schema(None), {"type": "integer", "minimum": 1}]}),
    read: |node| match node.as_text() {
        Some(name) => (!name.trim().is_empty()).then(|| Some(Column::Name(name.to_owned()))),
        None => {
            let number = usize::try_from(node.whole()?).ok()?;
            let column = Some(Column::Number(number));
            (1..=100_000).contains(&number).then_some(column)
        }
    },
    text: |column| {
        Some(match column.as_ref()? {
            Column::Name(name) => quote(name),
            Column::Number(number) => number.to_string(),
        })
    },
};

/// The ground through the points that a table states, or the file that it names.
pub(super) fn build(reader: &mut Reader, node: &Node, path: &str, ground: &mut TerrainChoice) {
    let values = &mut ground.values;
    let points = match (node.get("file"), node.get("points")) {
        (Some(file), None) => {
            let Some((points, track)) = from_file(reader, node, file, path, values) else {
                return;
            };
            // A resolved scene names the copy.
            (values.file, values.file_hash) = (track.file_name(), track.hash());
            ground.tracks.push(track);
            points
        }
        (None, Some(_)) => {
            for key in ["x_column", "height_column", "sort", "file_hash"] {
                let allowed = "no such key beside points; it belongs to file";
                reader.refuse_given(node, path, key, allowed);
            }
            values.points.clone()
        }
        (file, _) => {
            let found = if file.is_some() { "both" } else { "neither" };
            let message = format!("found {found} of file and points, allowed: one of them");
            return reader.push(Problem::at(&node.origin, path, message).whole());
        }
    };
    let (interpolation, smoothing) = (values.interpolation, values.smoothing);
    match check_risers(&points, interpolation, smoothing) {
        Ok(()) => {
            let heights = Heights::with_smoothing(points, interpolation, smoothing);
            ground.profile = Profile::Heights(heights);
        }
        Err(error) => {
            reader.push(Problem::at(&node.origin, path, error.to_string()).whole());
        }
    }
}

fn from_file(
    reader: &mut Reader,
    node: &Node,
    file: &Node,
    path: &str,
    keys: &Ground,
) -> Option<(Vec<Vec2>, Track)> {
    let key = join(path, "file");
    // Empty after a problem.
    if keys.file.is_empty() {
        return None;
    }
    let found = reader.base_dir.join(&keys.file);
    let shown = found.display().to_string();
    let bytes = source::read(&found, MOST_BYTES).map_err(|error| {
        let (name, allowed) = (file.origin.found(), FILE.words);
        let message = format!("found {name}, but {shown} {error}; allowed: {allowed}");
        Problem::at(&file.origin, &key, message)
    });
    let bytes = reader.keep(bytes)?;
    let track = Track {
        part: None,
        bytes: bytes.into(),
    };
    let points = read_track(&track.bytes, &keys.format);
    let points = points.map_err(|error| problem(&shown, &track.bytes, &key, error));
    let points = reader.keep(points)?;
    let hash = track.hash();
    if keys.file_hash != hash {
        let allowed = format!("{hash}, which the file has: it is not the one that was meant");
        reader.refuse_given(node, path, "file_hash", &allowed);
    }
    Some((points, track))
}

/// The problem of a track at its line.
fn problem(file: &str, bytes: &[u8], key: &str, error: TrackError) -> Problem {
    let TrackError { line, message } = error;
    let Some(line) = line.and_then(|line| usize::try_from(line).ok()) else {
        return Problem::unread(file, message);
    };
    let text = String::from_utf8_lossy(bytes);
    let source = Source::file(file, text.trim_start_matches('\u{feff}'));
    let span = source.line_span(line).unwrap_or_default();
    let origin = Origin { source, span };
    Problem::at(&origin, key, message)
}
