//! From a file to a [`StudyChoice`].

use super::axes::{COUNT, DISTRIBUTIONS, MOST_RUNS, count, known, missing, read_axes};
use super::axis::Axis;
use super::choice::{DrawMethod, Draws, StudyChoice, StudyTables};
use crate::error::{Problem, SceneError};
use crate::key::quoted;
use crate::reader::Reader;
use crate::source::{Node, Source, Value};
use crate::{file, name, seed};
use std::path::{Path, PathBuf};

/// Keys of a study file.
pub(super) const TOP: [&str; 6] = ["name", "scene", "set", "tables", "axis", "draw"];
/// Keys of `[draw]`.
pub(super) const DRAW: [&str; 3] = ["count", "seed", "method"];
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

/// Whether the file has an axis with a distribution, right or wrong.
fn asks_for_draws(root: &Node) -> bool {
    let items = match root.get("axis").map(|n| &n.value) {
        Some(Value::Array(items)) => items.as_slice(),
        _ => &[],
    };
    let has = |axis: &Node| DISTRIBUTIONS.iter().any(|way| axis.get(way).is_some());
    items.iter().any(has)
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
    // An axis with a mistake is not among the axes.
    if drawn.is_none() && !asks_for_draws(root) {
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

/// A message where a study has too many runs, or keeps tables of runs that it does not have.
fn too_many(study: &StudyChoice) -> Option<String> {
    let lengths = study.axes.iter().filter_map(Axis::length);
    let samples = study.draws.iter().map(|draws| draws.count);
    let runs = lengths.chain(samples).try_fold(1_u64, u64::checked_mul);
    let allowed = format!("allowed: a product of the axes of at most {MOST_RUNS} runs");
    match (runs, &study.tables) {
        (None, _) => Some(format!("found more than 2^64 runs, {allowed}")),
        (Some(runs), _) if runs > MOST_RUNS => Some(format!("found {runs} runs, {allowed}")),
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
