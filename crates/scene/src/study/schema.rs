//! JSON Schema of study files.

use super::axes::{MOST_RUNS, WAYS};
use super::choice::DrawMethod;
use crate::json::{object, text};
use crate::reference::reference;
use crate::{name, seed};
use serde_json::{Map, Value, json};
use std::collections::BTreeSet;

/// A study file.
pub(crate) fn study() -> Value {
    let count = || json!({"type": "integer", "minimum": 1, "maximum": MOST_RUNS});
    let draw = properties([
        ("count", count(), "number of samples"),
        (
            "seed",
            (seed::FORM.schema)(),
            "seed of the draws. Default: 0",
        ),
        (
            "method",
            json!({"enum": DrawMethod::ALL.map(DrawMethod::name)}),
            "each axis has one sample in each of count equally likely intervals (the default); or independent draws",
        ),
    ]);
    let tables = json!({"anyOf": [
        {"enum": ["none", "all"]},
        {"type": "array", "items": {"type": "integer", "minimum": 0}},
    ]});
    let set = json!({"type": "array", "items": {"type": "string", "pattern": "="}});
    let all = properties([
        (
            "name",
            (name::FORM.schema)(),
            "name of the study and of the default folder. Default: the file's name",
        ),
        (
            "scene",
            text(),
            "the base scene; a path relative to the study file",
        ),
        (
            "set",
            set,
            "overrides key=value of the base scene in every run",
        ),
        (
            "tables",
            tables,
            "runs that keep their full tables. Default: \"none\"",
        ),
        (
            "axis",
            json!({"type": "array", "minItems": 1, "items": axis()}),
            "what varies",
        ),
        (
            "draw",
            object(draw, &["count"]),
            "how axes with a distribution are drawn",
        ),
    ]);
    object(all, &["scene", "axis"])
}

/// `[[axis]]`
fn axis() -> Value {
    let key = key();
    let keys = json!({"type": "array", "items": key, "minItems": 1, "uniqueItems": true});
    let pair = |kind: &str| json!({"type": "array", "items": {"type": kind}, "minItems": 2, "maxItems": 2});
    let names = json!({"type": "array", "items": text(), "uniqueItems": true});
    let all = properties([
        ("key", key, "a key of the scene"),
        ("keys", keys, "keys of the scene that vary together"),
        (
            "values",
            json!({"type": "array", "minItems": 1}),
            "a list; with keys a list of lists with one value a key",
        ),
        (
            "names",
            names,
            "names of the values, which the dataset shows in place of the values of the first key",
        ),
        (
            "count",
            json!({"type": "integer", "minimum": 1, "maximum": MOST_RUNS}),
            "as many whole numbers",
        ),
        (
            "first",
            json!({"type": "integer", "minimum": 0}),
            "the first of them. Default: 0",
        ),
        (
            "uniform",
            pair("number"),
            "drawn uniformly from [low, high]",
        ),
        (
            "log_uniform",
            pair("number"),
            "drawn from [low, high], the logarithm uniformly",
        ),
        (
            "normal",
            pair("number"),
            "drawn from a normal distribution, [mean, standard deviation]",
        ),
        (
            "whole",
            pair("integer"),
            "whole numbers drawn uniformly from [first, last]",
        ),
    ]);
    let mut axis = object(all, &[]);
    let one_of = |names: &[&str]| {
        let each: Vec<Value> = names.iter().map(|n| json!({"required": [n]})).collect();
        json!({"oneOf": each})
    };
    axis["allOf"] = json!([one_of(&["key", "keys"]), one_of(&WAYS)]);
    axis
}

/// A key of scenes, or a table above it: those without an index by name, which an editor can offer.
fn key() -> Value {
    let mut plain = BTreeSet::new();
    let mut indexed = BTreeSet::new();
    for row in reference() {
        let steps: Vec<&str> = row.key.split('.').collect();
        for end in 1..=steps.len() {
            let key = steps[..end].join(".");
            if key.contains("[]") {
                let pattern = key
                    .replace('.', r"\.")
                    .replace("[]", r"(\.[0-9]+|\[[0-9]+\])");
                indexed.insert(pattern);
                // The list itself, too.
                plain.extend(key.strip_suffix("[]").map(str::to_owned));
            } else {
                plain.insert(key);
            }
        }
        // A number of a list, as `robot.geometry.axles.0.1`.
        if row.allowed.starts_with('[') && !row.key.contains("[]") {
            indexed.insert(row.key.replace('.', r"\.") + r"(\.[0-9]+|\[[0-9]+\]){1,2}");
        }
    }
    // A part has the keys of the terrain.
    indexed.insert(r"terrain\.part(\.[0-9]+|\[[0-9]+\])(\..+)?".to_owned());
    // The dataset has columns of this name: see `axes`.
    plain.remove("estimator");
    let indexed: Vec<String> = indexed.into_iter().collect();
    json!({"anyOf": [
        {"enum": plain},
        {"type": "string", "pattern": format!("^({})$", indexed.join("|"))},
    ]})
}

fn properties<const N: usize>(all: [(&str, Value, &str); N]) -> Map<String, Value> {
    let property = |(name, mut schema, meaning): (&str, Value, &str)| {
        schema["description"] = json!(meaning);
        (name.to_owned(), schema)
    };
    all.into_iter().map(property).collect()
}

#[cfg(test)]
mod tests {
    use super::super::axes::AXIS;
    use super::super::load::{DRAW, TOP};
    use super::*;

    /// The schema has the keys that the reader takes.
    #[test]
    fn the_schema_has_the_keys_of_the_reader() {
        let same = |schema: &Value, keys: &[&str]| {
            let found: BTreeSet<String> = match &schema["properties"] {
                Value::Object(all) => all.keys().cloned().collect(),
                _ => BTreeSet::new(),
            };
            assert_eq!(found, keys.iter().map(|k| (*k).to_owned()).collect());
        };
        let study = study();
        same(&study, &TOP);
        same(&study["properties"]["axis"]["items"], &AXIS);
        same(&study["properties"]["draw"], &DRAW);
    }
}
