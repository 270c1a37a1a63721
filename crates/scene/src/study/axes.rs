//! Reads the axes of a study.

use super::choice::{Axis, AxisItem, AxisValue, AxisValues, Distribution};
use crate::load::reference;
use robhaz_keys::prelude::*;
use serde_json::{Value as Json, json};
use std::collections::{BTreeSet, HashSet};

/// The ways to give values: a list, whole numbers, and those that draw.
const WAYS: [&str; 6] = [
    "values",
    "count",
    "uniform",
    "log_uniform",
    "normal",
    "whole",
];

/// Largest number of runs of a study.
pub(super) const MOST_RUNS: u64 = 100_000_000;

/// A number of runs or samples.
pub(super) const RUNS: Plain<u64> = Plain {
    words: "a whole number from 1 to 100000000",
    schema: || json!({"type": "integer", "minimum": 1, "maximum": MOST_RUNS}),
    read: |node| {
        let runs = u64::try_from(node.whole()?).ok();
        runs.filter(|n| (1..=MOST_RUNS).contains(n))
    },
    text: |count| Some(count.to_string()),
};

/// The values of the keys of an axis, which depend on each other.
#[derive(Default)]
struct Raw {
    keys: Vec<String>,
    names: Vec<String>,
    first: i64,
    values: Vec<Node>,
    count: u64,
    drawn: Option<Distribution>,
}

keys! {
    /// The keys of `[[axis]]`.
    AXIS: Raw;

    /// a key of the scene
    key: KEY => keys;

    /// keys of the scene that vary together
    keys: read_only(
        "a list of different keys of the scene, such as [\"drive.kp\", \"drive.ki\"]",
        || json!({"type": "array", "items": key_schema(), "minItems": 1, "uniqueItems": true}),
        |node| {
            let keys: Vec<String> = node.array()?.iter().map(key_of).collect::<Option<_>>()?;
            let different = keys.iter().collect::<HashSet<_>>().len();
            (different > 0 && different == keys.len()).then_some(keys)
        },
    ) => keys;

    /// names of the values, which the dataset shows in place of the values of the first key
    names: read_only(
        "a list of different texts, one a value",
        || json!({"type": "array", "items": text("").schema(None), "uniqueItems": true}),
        |node| node.array()?.iter().map(text("").read).collect(),
    ) => names;

    /// the first of count whole numbers
    first ("0"): read_only(
        "a whole number of at least 0 and below 2^63",
        || json!({"type": "integer", "minimum": 0}), index,
    ) => first;

    /// a list; with keys a list of lists with one value a key
    values: read_only(
        "a list of at least one value", || json!({"type": "array", "minItems": 1}),
        |node| Some(node.array().filter(|items| !items.is_empty())?.to_vec()),
    ) => values;

    /// as many whole numbers
    count: RUNS => count;

    /// drawn uniformly from [low, high]
    uniform: drawn("[low, high], low below high", |node| {
        let [low, high] = pair(node, number)?;
        let valid = low < high && (high - low).is_finite();
        valid.then_some(Some(Distribution::Uniform(low, high)))
    }) => drawn;

    /// drawn from [low, high], the logarithm uniformly
    log_uniform: drawn("[low, high], 0 below low below high", |node| {
        let [low, high] = pair(node, number)?;
        (0.0 < low && low < high).then_some(Some(Distribution::LogUniform(low, high)))
    }) => drawn;

    /// drawn from a normal distribution, [mean, standard deviation]
    normal: drawn("[mean, standard deviation], the second above 0", |node| {
        let [mean, deviation] = pair(node, number)?;
        (deviation > 0.0).then_some(Some(Distribution::Normal(mean, deviation)))
    }) => drawn;

    /// whole numbers drawn uniformly from [first, last]
    whole: Plain {
        schema: || items(json!({"type": "integer"}), [2, 2]),
        ..drawn("[first, last], whole numbers from 0 on, first not above last", |node| {
            let [first, last] = pair(node, index)?;
            (first <= last).then_some(Some(Distribution::Whole(first, last)))
        })
    } => drawn;
}

const KEY: Plain<Vec<String>> = read_only(
    "a key of the scene, such as \"drive.speed\"",
    key_schema,
    |node| Some(vec![key_of(node)?]),
);
/// A distribution by two numbers.
const fn drawn(
    words: &'static str,
    read: fn(&Node) -> Option<Option<Distribution>>,
) -> Plain<Option<Distribution>> {
    read_only(words, || items(json!({"type": "number"}), [2, 2]), read)
}

fn key_of(node: &Node) -> Option<String> {
    let key = node.as_text()?;
    (!key.is_empty() && !key.contains('=')).then(|| key.to_owned())
}

fn number(node: &Node) -> Option<f64> {
    match node.value {
        Value::Float(number) | Value::Integer(_, number) if number.is_finite() => Some(number),
        _ => None,
    }
}

fn index(node: &Node) -> Option<i64> {
    let whole = i64::try_from(node.whole()?).ok()?;
    (whole >= 0).then_some(whole)
}

fn pair<N>(node: &Node, read: fn(&Node) -> Option<N>) -> Option<[N; 2]> {
    let [a, b] = node.array()? else {
        return None;
    };
    Some([read(a)?, read(b)?])
}

/// `[[axis]]`: what varies, in the file's order.
pub(super) struct Axes;

impl Form for Axes {
    type Value = Vec<Axis>;

    fn read(&self, reader: &mut Reader, node: &Node, path: &str, into: &mut Vec<Axis>) {
        for (item, path) in reader.items(node, path, 0..=usize::MAX, || self.allowed()) {
            let Some(axis) = read_axis(reader, item, &path) else {
                continue;
            };
            for key in &axis.keys {
                if into.iter().any(|other| other.keys.contains(key)) {
                    let message = format!("{key} is varied by an axis above");
                    reader.push(Problem::at(&item.origin, &path, message));
                }
            }
            into.push(axis);
        }
    }

    fn about(&self) -> About {
        About::new("one table [[axis]] or several")
    }

    fn schema(&self, _defaults: Option<&mut Vec<Axis>>) -> Json {
        let mut axis = key::schema(AXIS, None);
        let one_of = |names: &[&str]| {
            let each: Vec<Json> = names.iter().map(|n| json!({"required": [n]})).collect();
            json!({"oneOf": each})
        };
        axis["allOf"] = json!([one_of(&["key", "keys"]), one_of(&WAYS)]);
        json!({"type": "array", "minItems": 1, "items": axis})
    }
}

fn read_axis(reader: &mut Reader, node: &Node, path: &str) -> Option<Axis> {
    let (mark, mut raw) = (reader.mark(), Raw::default());
    reader.table(AXIS, node, path, &mut raw);
    node.entries()?;
    let mut given = WAYS.to_vec();
    given.retain(|way| node.get(way).is_some());
    let [way] = given.as_slice() else {
        let found = match given.is_empty() {
            true => "nothing".to_owned(),
            false => given.join(" and "),
        };
        let message = format!("found {found}, allowed: one of {}", WAYS.join(", "));
        reader.push(Problem::at(&node.origin, path, message).whole());
        return None;
    };
    check_keys(reader, node, path, &raw.keys);
    for (key, of) in [("first", "count"), ("names", "values")] {
        if let Some(found) = node.get(key).filter(|_| *way != of) {
            let message = format!("has no effect without {of}");
            reader.push(Problem::at(&found.origin, &join(path, key), message));
        }
    }
    let (value, at) = (node.get(way)?, join(path, way));
    if *way != "values" && raw.keys.len() > 1 {
        let message = "keys that vary together need values: one list a value, with one item a key";
        reader.push(Problem::at(&value.origin, &at, message.to_owned()));
    }
    if i64::try_from(raw.count).is_ok_and(|count| raw.first.checked_add(count).is_none()) {
        reader.refuse(value, &at, "a count whose last number is below 2^63");
    }
    if reader.mark() > mark {
        return None;
    }
    let values = match raw.drawn {
        Some(drawn) => AxisValues::Drawn(drawn),
        None if *way == "count" => AxisValues::Whole {
            first: raw.first,
            count: raw.count,
        },
        None => AxisValues::List(read_values(reader, node, path, &raw)?),
    };
    let of_keys = node.get("key").or(node.get("keys"))?;
    Some(Axis {
        keys: raw.keys,
        values,
        keys_origin: of_keys.origin.clone(),
        origin: value.origin.clone(),
    })
}

/// There are keys, under one name, and none has the name of a column of the dataset.
fn check_keys(reader: &mut Reader, node: &Node, path: &str, keys: &[String]) {
    match (node.get("key"), node.get("keys")) {
        (Some(_), Some(both)) => {
            let message = "found key and keys, allowed: one of them".to_owned();
            reader.push(Problem::at(&both.origin, &join(path, "keys"), message));
        }
        (None, None) => reader.missing(node, &join(path, "key"), KEY.words),
        (one, other) => {
            let found = one
                .or(other)
                .filter(|_| keys.iter().any(|key| key == "estimator" || key == "index"));
            if let Some(found) = found {
                let path = join(path, if one.is_some() { "key" } else { "keys" });
                let allowed = "a key below it, such as \"estimator.0.observer_pole\"";
                reader.refuse(found, &path, allowed);
            }
        }
    }
}

/// The items of a list of values with their names.
fn read_values(reader: &mut Reader, node: &Node, path: &str, raw: &Raw) -> Option<Vec<AxisItem>> {
    let (mark, keys, mut read) = (reader.mark(), raw.keys.len(), Vec::new());
    for (i, item) in raw.values.iter().enumerate() {
        let path = format!("{path}.values[{i}]");
        let nodes = match item.array() {
            _ if keys == 1 => std::slice::from_ref(item),
            Some(nodes) if nodes.len() == keys => nodes,
            _ => {
                reader.refuse(item, &path, &format!("a list of {keys} values, one a key"));
                continue;
            }
        };
        match nodes.iter().map(AxisValue::of).collect() {
            Some(values) => read.push(AxisItem {
                name: raw.names.get(i).cloned(),
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
    let different: HashSet<&String> = raw.names.iter().collect();
    let fit = [different.len(), raw.values.len()] == [raw.names.len(); 2];
    if !fit {
        let count = raw.values.len();
        let allowed = format!("a list of {count} different texts, one a value");
        reader.refuse_given(node, path, "names", &allowed);
    }
    (reader.mark() == mark).then_some(read)
}

/// A key of scenes, or a table above it: those without an index by name, which an editor can offer.
fn key_schema() -> Json {
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
