//! From a file to a [`StudyChoice`].

use super::axes::{Axes, MOST_RUNS, RUNS};
use super::choice::{Axis, DrawMethod, Draws, StudyChoice, StudyTables};
use robhaz_keys::prelude::*;
use serde_json::json;
use std::path::{Path, PathBuf};

keys! {
    /// The keys of a study file.
    pub(crate) STUDY: StudyChoice;

    /// name of the study and of the default folder
    name ("the file's name"): NAME => name;

    /// the base scene; a path relative to the study file
    scene (required): read_only("the path of a scene file", || text("").schema(None), |node| {
        let path = node.as_text().filter(|text| !text.is_empty())?;
        Some((path.into(), node.origin.clone()))
    }) => base;

    /// overrides key=value of the base scene in every run
    set: read_only(
        "a list of texts key=value, such as [\"drive.kp=2\"]",
        || json!({"type": "array", "items": {"type": "string", "pattern": "="}}),
        |node| {
            let item = |item: &Node| Some((item.as_text()?.to_owned(), item.origin.clone()));
            node.array()?.iter().map(item).collect()
        },
    ) => overrides;

    /// runs that keep their full tables
    tables ("\"none\""): read_only(
        "\"none\", \"all\", or a list of runs such as [0, 7]",
        || json!({"anyOf": [
            {"enum": ["none", "all"]},
            {"type": "array", "items": {"type": "integer", "minimum": 0}},
        ]}),
        |node| match (node.as_text(), node.array()) {
            (Some("none"), _) => Some(StudyTables::None),
            (Some("all"), _) => Some(StudyTables::All),
            (_, items) => {
                let runs = items?.iter().map(|item| u64::try_from(item.whole()?).ok());
                Some(StudyTables::Runs(runs.collect::<Option<_>>()?))
            }
        },
    ) => tables;

    /// what varies
    axis (required): Axes => axes;

    /// how axes with a distribution are drawn
    draw: section(DRAW) => (|s| s.draws.get_or_insert(Draws {
        count: 1,
        seed: 0,
        method: DrawMethod::LatinHypercube,
    }));
}

keys! {
    DRAW: Draws;

    /// number of samples
    count (required): RUNS => count;

    /// seed of the draws
    seed ("0"): SEED => seed;

    /// each axis has one sample in each of count equally likely intervals (the default); or
    /// independent draws
    method: word(&DrawMethod::ALL, DrawMethod::name) => method;
}

impl StudyChoice {
    /// Reads a study file.
    ///
    /// # Errors
    /// [`FileError`] with all problems of the file. The base scene is not read: see
    /// [`super::BaseScene`].
    pub fn load(path: &Path) -> Result<Self, FileError> {
        let (text, shown, _) = Reader::load(path, "a study file in TOML, UTF-8")?;
        Self::parse(&text, &shown)
    }

    /// Reads the text of a study file. `source_name` is the file's name in messages.
    ///
    /// # Errors
    /// As [`StudyChoice::load`].
    pub fn parse(text: &str, source_name: &str) -> Result<Self, FileError> {
        let reader = Reader::new(PathBuf::new(), |_| None);
        reader.read(source_name, text, |reader, root| {
            read(reader, &root, text, source_name)
        })
    }
}

fn read(reader: &mut Reader, root: &Node, text: &str, source_name: &str) -> StudyChoice {
    let stem = Path::new(source_name).file_stem().unwrap_or_default();
    let mut study = StudyChoice {
        name: from_stem(&stem.to_string_lossy()),
        base: (PathBuf::new(), root.origin.clone()),
        overrides: Vec::new(),
        axes: Vec::new(),
        draws: None,
        tables: StudyTables::None,
        text: text.to_owned(),
    };
    reader.table(STUDY, root, "", &mut study);
    for (text, origin) in &study.overrides {
        let key = text.split('=').next().unwrap_or_default().trim();
        // The axis sets it, or the table that it is in, anew.
        let is_set = |of: &&String| {
            let rest = key.strip_prefix(of.as_str());
            rest.is_some_and(|rest| rest.is_empty() || rest.starts_with(['.', '[']))
        };
        if let Some(varied) = study.axes.iter().flat_map(|axis| &axis.keys).find(is_set) {
            let message = format!(
                "found {text:?}, and an axis varies {varied}, so that it has no effect; allowed: one of them"
            );
            reader.push(Problem::at(origin, "set", message));
        }
    }
    let drawn = study.axes.iter().find(|axis| axis.length().is_none());
    let problem = match (root.get("draw"), drawn) {
        (None, Some(axis)) => Some((
            &axis.origin,
            "an axis with a distribution needs [draw] with its number of samples, such as count = 100",
        )),
        // An axis with a mistake is not among the axes.
        (Some(draw), None) if reader.is_clean(&["axis"]) => Some((
            &draw.origin,
            "has no effect: no axis has a distribution (uniform, log_uniform, normal, whole)",
        )),
        _ => None,
    };
    if let Some((origin, message)) = problem {
        reader.push(Problem::at(origin, "draw", message.to_owned()));
    }
    if let Some((key, message)) = too_many(&study) {
        let node = root.find(key).unwrap_or(root);
        reader.push(Problem::at(&node.origin, key, message).whole());
    }
    study
}

/// Key and message where a study has too many runs, or keeps tables of runs that it does not have.
fn too_many(study: &StudyChoice) -> Option<(&'static str, String)> {
    let lengths = study.axes.iter().filter_map(Axis::length);
    let samples = study.draws.iter().map(|draws| draws.count);
    let runs = lengths.chain(samples).try_fold(1_u64, u64::checked_mul);
    let allowed = format!("allowed: a product of the axes of at most {MOST_RUNS} runs");
    match (runs, &study.tables) {
        (None, _) => Some(("", format!("found more than 2^64 runs, {allowed}"))),
        (Some(runs), _) if runs > MOST_RUNS => Some(("", format!("found {runs} runs, {allowed}"))),
        (Some(runs), StudyTables::Runs(kept)) => {
            let beyond = kept.iter().find(|run| **run >= runs)?;
            let message = format!(
                "found run {beyond}, allowed: 0 to {} (the study has {runs} runs)",
                runs - 1
            );
            Some(("tables", message))
        }
        _ => None,
    }
}
