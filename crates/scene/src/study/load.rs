//! From a file to a [`StudyChoice`].

use super::axis::{Axis, AxisItem, AxisValue, AxisValues, Distribution};
use super::choice::{DrawMethod, Draws, StudyChoice, StudyTables};
use crate::error::{Problem, SceneError};
use crate::key::quoted;
use crate::reader::{Reader, join};
use crate::source::{Node, Source, Value};
use crate::{file, name, seed};
use std::path::{Path, PathBuf};

/// Keys of a study file.
const TOP: [&str; 6] = ["name", "scene", "set", "tables", "axis", "draw"];
/// Keys of `[draw]`.
const DRAW: [&str; 3] = ["count", "seed", "method"];
/// Keys of `[[axis]]`, of which the last six say how its values are given.
const AXIS: [&str; 9] = [
    "key",
    "keys",
    "first",
    "values",
    "count",
    "uniform",
    "log_uniform",
    "normal",
    "whole",
];
const WAYS: [&str; 6] = [
    "values",
    "count",
    "uniform",
    "log_uniform",
    "normal",
    "whole",
];

/// Largest number of runs of a study.
const MOST_RUNS: u64 = 100_000_000;
/// Largest number of values of one axis that is a list.
const COUNT: &str = "a whole number from 1 to 100000000";
const WHOLE: &str = "a whole number of at least 0 and below 2^63";
const ONE_WAY: &str = "one of values, count, uniform, log_uniform, normal, whole";

impl StudyChoice {
    /// Reads a study file.
    ///
    /// # Errors
    /// [`SceneError`] with all problems of the file. The base scene is not read: see [`super::BaseScene`].
    pub fn load(path: &Path) -> Result<Self, SceneError> {
        let shown = path.display().to_string();
        let text = file::read_toml(path).map_err(|error| {
            let message = format!("{error}; allowed: a study file in TOML, UTF-8");
            SceneError::unread(&shown, message)
        })?;
        Self::parse(&text, &shown)
    }

    /// Reads the text of a study file. `source_name` is the file's name in messages.
    ///
    /// # Errors
    /// As [`StudyChoice::load`].
    pub fn parse(text: &str, source_name: &str) -> Result<Self, SceneError> {
        file::check_toml(text).map_err(|error| SceneError::unread(source_name, error))?;
        let mut reader = Reader::new(PathBuf::new(), |_| None);
        let root = reader.document(&Source::file(source_name, text));
        let study = read(&mut reader, &root, text, source_name);
        reader.finish(study)
    }
}

fn read(reader: &mut Reader, root: &Node, text: &str, source_name: &str) -> StudyChoice {
    known(reader, root, "", &TOP);
    let stem = Path::new(source_name).file_stem().unwrap_or_default();
    let given = root.get("name").map(|n| name::read(reader, n, "name"));
    let scene = root.get("scene");
    if scene.is_none() {
        missing(reader, root, "scene", "the path of a scene file");
    }
    let path = scene.and_then(|n| match &n.value {
        Value::Text(path) if !path.is_empty() => Some(PathBuf::from(path)),
        _ => {
            reader.refuse(n, "scene", "the path of a scene file");
            None
        }
    });
    let set = read_set(reader, root);
    let axes = read_axes(reader, root);
    let study = StudyChoice {
        name: given
            .flatten()
            .unwrap_or_else(|| name::from_stem(&stem.to_string_lossy())),
        scene: path.unwrap_or_default(),
        set: set.iter().map(|(text, _)| text.clone()).collect(),
        draws: read_draws(reader, root, &axes),
        tables: read_tables(reader, root),
        text: text.to_owned(),
        scene_origin: scene.map_or(&root.origin, |n| &n.origin).clone(),
        set_origins: set.iter().map(|(_, node)| node.origin.clone()).collect(),
        axes,
    };
    if let Some(message) = too_many(&study) {
        reader.push(Problem::at(&root.origin, "", message).whole());
    }
    study
}

/// Adds a problem for every entry with another key.
fn known(reader: &mut Reader, node: &Node, path: &str, allowed: &[&str]) {
    for entry in reader.entries(node, path) {
        if !allowed.contains(&entry.key.as_str()) {
            reader.unknown(entry, path, allowed);
        }
    }
}

fn missing(reader: &mut Reader, node: &Node, path: &str, allowed: &str) {
    let message = format!("missing, and it has no default; allowed: {allowed}");
    reader.push(Problem::at(&node.origin, path, message).whole());
}

fn read_set<'n>(reader: &mut Reader, root: &'n Node) -> Vec<(String, &'n Node)> {
    const ALLOWED: &str = "a list of texts key=value, such as [\"drive.kp=2\"]";
    let Some(node) = root.get("set") else {
        return Vec::new();
    };
    let Value::Array(items) = &node.value else {
        reader.refuse(node, "set", ALLOWED);
        return Vec::new();
    };
    let mut set = Vec::new();
    for (i, item) in items.iter().enumerate() {
        match &item.value {
            Value::Text(text) => set.push((text.clone(), item)),
            _ => reader.refuse(item, &format!("set[{i}]"), ALLOWED),
        }
    }
    set
}

fn read_tables(reader: &mut Reader, root: &Node) -> StudyTables {
    const ALLOWED: &str = "\"none\", \"all\", or a list of runs such as [0, 7]";
    let Some(node) = root.get("tables") else {
        return StudyTables::None;
    };
    let runs = match &node.value {
        Value::Text(text) if text == "none" => return StudyTables::None,
        Value::Text(text) if text == "all" => return StudyTables::All,
        Value::Array(items) => {
            let runs = items.iter().map(|item| match item.value {
                Value::Integer(Some(run), _) => u64::try_from(run).ok(),
                _ => None,
            });
            runs.collect::<Option<Vec<u64>>>()
        }
        _ => None,
    };
    if runs.is_none() {
        reader.refuse(node, "tables", ALLOWED);
    }
    StudyTables::Runs(runs.unwrap_or_default())
}

fn read_draws(reader: &mut Reader, root: &Node, axes: &[Axis]) -> Option<Draws> {
    let drawn = axes.iter().find(|axis| axis.is_drawn());
    let Some(node) = root.get("draw") else {
        if let Some(axis) = drawn {
            let message = "an axis with a distribution needs [draw] with its number of samples, such as count = 100";
            reader.push(Problem::at(&axis.origin, "draw", message.to_owned()));
        }
        return None;
    };
    known(reader, node, "draw", &DRAW);
    if drawn.is_none() {
        let message =
            "has no effect: no axis has a distribution (uniform, log_uniform, normal, whole)";
        reader.push(Problem::at(&node.origin, "draw", message.to_owned()));
    }
    if node.get("count").is_none() {
        missing(reader, node, "draw.count", COUNT);
    }
    let count = node
        .get("count")
        .and_then(|n| count(reader, n, "draw.count"));
    let seed = node
        .get("seed")
        .and_then(|n| seed::read(reader, n, "draw.seed"));
    let method = node.get("method").map(|n| {
        let found = match &n.value {
            Value::Text(text) => DrawMethod::ALL.into_iter().find(|m| m.name() == text),
            _ => None,
        };
        if found.is_none() {
            reader.refuse(
                n,
                "draw.method",
                &quoted(&DrawMethod::ALL.map(DrawMethod::name)),
            );
        }
        found.unwrap_or_default()
    });
    Some(Draws {
        count: count?,
        seed: seed.unwrap_or(0),
        method: method.unwrap_or_default(),
    })
}

fn read_axes(reader: &mut Reader, root: &Node) -> Vec<Axis> {
    let items = match root.get("axis").map(|n| (n, &n.value)) {
        None => {
            missing(reader, root, "axis", "one table [[axis]] or several");
            return Vec::new();
        }
        Some((_, Value::Array(items))) => items.as_slice(),
        Some((node, _)) => {
            reader.refuse(node, "axis", "one table [[axis]] or several");
            return Vec::new();
        }
    };
    let mut axes: Vec<Axis> = Vec::new();
    for (i, item) in items.iter().enumerate() {
        let path = format!("axis[{i}]");
        let Some(axis) = read_axis(reader, item, &path) else {
            continue;
        };
        for key in &axis.keys {
            if axes.iter().any(|other| other.keys.contains(key)) {
                let message = format!("{key} is varied by an axis above");
                reader.push(Problem::at(&item.origin, &path, message));
            }
        }
        axes.push(axis);
    }
    axes
}

fn read_axis(reader: &mut Reader, node: &Node, path: &str) -> Option<Axis> {
    known(reader, node, path, &AXIS);
    node.entries()?;
    let keys = read_keys(reader, node, path);
    let given: Vec<&str> = WAYS
        .into_iter()
        .filter(|way| node.get(way).is_some())
        .collect();
    let [way] = given.as_slice() else {
        let found = match given.is_empty() {
            true => "nothing".to_owned(),
            false => given.join(" and "),
        };
        let message = format!("found {found}, allowed: {ONE_WAY}");
        reader.push(Problem::at(&node.origin, path, message).whole());
        return None;
    };
    let keys = keys?;
    let origin = &node.get(way)?.origin;
    if let Some(first) = node.get("first").filter(|_| *way != "count") {
        let message = "has no effect without count".to_owned();
        reader.push(Problem::at(&first.origin, &join(path, "first"), message));
    }
    if *way != "values" && keys.len() > 1 {
        let message = "keys that vary together need values: one list a value, with one item a key";
        reader.push(Problem::at(origin, &join(path, way), message.to_owned()));
        return None;
    }
    let (value, at) = (node.get(way)?, join(path, way));
    let values = match *way {
        "values" => AxisValues::List(read_values(reader, value, &at, keys.len())?),
        "count" => {
            let first = node.get("first");
            let first = first.map_or(Some(0), |n| whole(reader, n, &join(path, "first")));
            let (first, count) = (first?, count(reader, value, &at)?);
            if i64::try_from(count)
                .ok()
                .and_then(|n| first.checked_add(n))
                .is_none()
            {
                reader.refuse(value, &at, "a count whose last number is below 2^63");
                return None;
            }
            AxisValues::Whole { first, count }
        }
        way => AxisValues::Drawn(read_distribution(reader, value, &at, way)?),
    };
    Some(Axis {
        keys,
        values,
        origin: origin.clone(),
    })
}

/// The keys of an axis.
fn read_keys(reader: &mut Reader, node: &Node, path: &str) -> Option<Vec<String>> {
    const ONE: &str = "a key of the scene, such as \"drive.speed\"";
    const LIST: &str = "a list of keys of the scene, such as [\"drive.kp\", \"drive.ki\"]";
    let (nodes, path) = match (node.get("key"), node.get("keys")) {
        (Some(key), None) => (std::slice::from_ref(key), join(path, "key")),
        (None, Some(keys)) => match &keys.value {
            Value::Array(items) if !items.is_empty() => (items.as_slice(), join(path, "keys")),
            _ => {
                reader.refuse(keys, &join(path, "keys"), LIST);
                return None;
            }
        },
        (Some(_), Some(both)) => {
            let message = "found key and keys, allowed: one of them".to_owned();
            reader.push(Problem::at(&both.origin, &join(path, "keys"), message));
            return None;
        }
        (None, None) => {
            missing(reader, node, &join(path, "key"), ONE);
            return None;
        }
    };
    let mut keys = Vec::new();
    for key in nodes {
        match &key.value {
            // The dataset has columns of these names.
            Value::Text(text) if text == "estimator" || text == "index" => {
                let allowed = "a key below it, such as \"estimator.0.observer_pole\"";
                reader.refuse(key, &path, allowed);
            }
            Value::Text(text) if keys.contains(text) => {
                reader.refuse(key, &path, "each key once");
            }
            Value::Text(text) if !text.is_empty() && !text.contains('=') => keys.push(text.clone()),
            _ => reader.refuse(key, &path, ONE),
        }
    }
    (keys.len() == nodes.len()).then_some(keys)
}

fn read_values(reader: &mut Reader, node: &Node, path: &str, keys: usize) -> Option<Vec<AxisItem>> {
    let Value::Array(items) = &node.value else {
        reader.refuse(node, path, "a list of values");
        return None;
    };
    if items.is_empty() {
        reader.refuse(node, path, "at least one value");
        return None;
    }
    let mut out = Vec::new();
    for (i, item) in items.iter().enumerate() {
        let path = format!("{path}[{i}]");
        let nodes = match &item.value {
            _ if keys == 1 => std::slice::from_ref(item),
            Value::Array(nodes) if nodes.len() == keys => nodes.as_slice(),
            _ => {
                reader.refuse(item, &path, &format!("a list of {keys} values, one a key"));
                continue;
            }
        };
        let values: Option<Vec<AxisValue>> = nodes.iter().map(AxisValue::of).collect();
        match values {
            Some(values) => out.push(AxisItem {
                values,
                origin: item.origin.clone(),
            }),
            None => reader.refuse(
                item,
                &path,
                "a finite number, a whole number below 2^63, a text, true or false, an array or a table",
            ),
        }
    }
    (out.len() == items.len()).then_some(out)
}

fn read_distribution(
    reader: &mut Reader,
    node: &Node,
    path: &str,
    way: &str,
) -> Option<Distribution> {
    let allowed = match way {
        "uniform" => "[low, high], low below high",
        "log_uniform" => "[low, high], 0 below low below high",
        "normal" => "[mean, standard deviation], the second above 0",
        _ => "[first, last], whole numbers from 0 on, first not above last",
    };
    let pair: Option<&[Node; 2]> = match &node.value {
        Value::Array(items) => items.as_slice().try_into().ok(),
        _ => None,
    };
    let number = |node: &Node| match node.value {
        Value::Float(number) | Value::Integer(_, number) if number.is_finite() => Some(number),
        _ => None,
    };
    let index = |node: &Node| match node.value {
        Value::Integer(Some(whole), _) => i64::try_from(whole).ok(),
        _ => None,
    };
    let found = pair.and_then(|[a, b]| {
        Some(match way {
            "uniform" => Distribution::Uniform(number(a)?, number(b)?),
            "log_uniform" => Distribution::LogUniform(number(a)?, number(b)?),
            "normal" => Distribution::Normal(number(a)?, number(b)?),
            _ => Distribution::Whole(index(a)?, index(b)?),
        })
    });
    let valid = |d: &Distribution| match *d {
        Distribution::Uniform(low, high) => low < high && (high - low).is_finite(),
        Distribution::LogUniform(low, high) => 0.0 < low && low < high,
        Distribution::Normal(_, sigma) => sigma > 0.0,
        Distribution::Whole(first, last) => 0 <= first && first <= last,
    };
    let found = found.filter(valid);
    if found.is_none() {
        reader.refuse(node, path, allowed);
    }
    found
}

fn count(reader: &mut Reader, node: &Node, path: &str) -> Option<u64> {
    let found = match node.value {
        Value::Integer(Some(count), _) => u64::try_from(count).ok(),
        _ => None,
    };
    let found = found.filter(|count| (1..=MOST_RUNS).contains(count));
    if found.is_none() {
        reader.refuse(node, path, COUNT);
    }
    found
}

fn whole(reader: &mut Reader, node: &Node, path: &str) -> Option<i64> {
    let found = match node.value {
        Value::Integer(Some(whole), _) => i64::try_from(whole).ok(),
        _ => None,
    };
    let found = found.filter(|whole| *whole >= 0);
    if found.is_none() {
        reader.refuse(node, path, WHOLE);
    }
    found
}

/// A message where a study has too many runs, or keeps tables of runs that it does not have.
fn too_many(study: &StudyChoice) -> Option<String> {
    let lengths = study.axes.iter().filter_map(Axis::length);
    let samples = study.draws.iter().map(|draws| draws.count);
    let runs = lengths
        .chain(samples)
        .try_fold(1_u64, u64::checked_mul)
        .filter(|runs| *runs <= MOST_RUNS);
    match (runs, &study.tables) {
        (None, _) => Some(format!(
            "the product of the axes has more than {MOST_RUNS} runs, allowed: at most as many"
        )),
        (Some(runs), StudyTables::Runs(kept)) => {
            let beyond = kept.iter().find(|run| **run >= runs)?;
            Some(format!(
                "tables: found run {beyond}, allowed: 0 to {} (the study has {runs} runs)",
                runs - 1
            ))
        }
        _ => None,
    }
}
