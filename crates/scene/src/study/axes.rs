//! Reads the axes of a study.

use super::axis::{Axis, AxisItem, AxisValue, AxisValues, Distribution};
use crate::error::Problem;
use crate::form::{Dependent, Form, dependent, items, text};
use crate::key::{self, keys};
use crate::reader::{Reader, join};
use crate::reference::reference;
use crate::source::{Node, Value};
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
pub const MOST_RUNS: u64 = 100_000_000;
const WHOLE: &str = "a whole number of at least 0 and below 2^63";
const ONE_WAY: &str = "one of values, count, uniform, log_uniform, normal, whole";

const fn pair(words: &'static str) -> Dependent<()> {
    dependent(words, || items(json!({"type": "number"}), 2, 2))
}

/// A number of runs or samples.
pub(super) struct RunCount;

impl Form for RunCount {
    type Value = u64;

    fn read(&self, reader: &mut Reader, node: &Node, path: &str, into: &mut u64) {
        match node.whole().map(u64::try_from) {
            Some(Ok(count @ 1..=MOST_RUNS)) => *into = count,
            _ => reader.refuse(node, path, &self.allowed()),
        }
    }

    fn text(&self, value: &u64) -> Option<String> {
        Some(value.to_string())
    }

    fn allowed(&self) -> String {
        "a whole number from 1 to 100000000".to_owned()
    }

    fn schema(&self, _defaults: Option<&mut u64>) -> Json {
        json!({"type": "integer", "minimum": 1, "maximum": MOST_RUNS})
    }
}

keys! {
    /// The keys of `[[axis]]`. How each is read depends on the others.
    AXIS: ();

    /// a key of the scene
    key: KEY => |axis| axis;

    /// keys of the scene that vary together
    keys: KEY_LIST => |axis| axis;

    /// names of the values, which the dataset shows in place of the values of the first key
    names: dependent("a list of different texts, one a value", || {
        json!({"type": "array", "items": text("").schema(None), "uniqueItems": true})
    }) => |axis| axis;

    /// the first of count whole numbers
    first ("0"): dependent(WHOLE, || json!({"type": "integer", "minimum": 0})) => |axis| axis;

    /// a list; with keys a list of lists with one value a key
    values: dependent("a list of values", || json!({"type": "array", "minItems": 1}))
        => |axis| axis;

    /// as many whole numbers
    count: dependent("a count", || RunCount.schema(None)) => |axis| axis;

    /// drawn uniformly from [low, high]
    uniform: pair("[low, high], low below high") => |axis| axis;

    /// drawn from [low, high], the logarithm uniformly
    log_uniform: pair("[low, high], 0 below low below high") => |axis| axis;

    /// drawn from a normal distribution, [mean, standard deviation]
    normal: pair("[mean, standard deviation], the second above 0") => |axis| axis;

    /// whole numbers drawn uniformly from [first, last]
    whole: dependent("[first, last], whole numbers from 0 on, first not above last", || {
        items(json!({"type": "integer"}), 2, 2)
    }) => |axis| axis;
}

const KEY: Dependent<()> = dependent("a key of the scene, such as \"drive.speed\"", key_schema);
const KEY_LIST: Dependent<()> = dependent(
    "a list of keys of the scene, such as [\"drive.kp\", \"drive.ki\"]",
    || json!({"type": "array", "items": key_schema(), "minItems": 1, "uniqueItems": true}),
);

/// `[[axis]]`: what varies, in the file's order.
pub(super) struct Axes;

impl Form for Axes {
    type Value = Vec<Axis>;

    fn read(&self, reader: &mut Reader, node: &Node, path: &str, into: &mut Vec<Axis>) {
        for (item, path) in reader.items(node, path, 0..=usize::MAX, &self.allowed()) {
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

    fn text(&self, _value: &Vec<Axis>) -> Option<String> {
        None
    }

    fn allowed(&self) -> String {
        "one table [[axis]] or several".to_owned()
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

/// Whether an axis has a distribution, right or wrong.
pub(super) fn asks_for_draws(root: &Node) -> bool {
    let items = match root.get("axis").map(|n| &n.value) {
        Some(Value::Array(items)) => items.as_slice(),
        _ => &[],
    };
    let has = |axis: &Node| WAYS[2..].iter().any(|way| axis.get(way).is_some());
    items.iter().any(has)
}

fn read_axis(reader: &mut Reader, node: &Node, path: &str) -> Option<Axis> {
    reader.table(AXIS, node, path, &mut ());
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
    if let Some(names) = node.get("names").filter(|_| *way != "values") {
        let message = "has no effect without values".to_owned();
        reader.push(Problem::at(&names.origin, &join(path, "names"), message));
    }
    if *way != "values" && keys.len() > 1 {
        let message = "keys that vary together need values: one list a value, with one item a key";
        reader.push(Problem::at(origin, &join(path, way), message.to_owned()));
        return None;
    }
    let (value, at) = (node.get(way)?, join(path, way));
    let values = match *way {
        "values" => {
            let mut items = read_values(reader, value, &at, keys.len())?;
            name_items(reader, node, path, &mut items)?;
            AxisValues::List(items)
        }
        "count" => {
            let first = node.get("first");
            let first = first.map_or(Some(0), |n| whole(reader, n, &join(path, "first")));
            let (first, mark, mut count) = (first?, reader.mark(), 1);
            RunCount.read(reader, value, &at, &mut count);
            if reader.mark() > mark {
                return None;
            }
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
    let (nodes, path) = match (node.get("key"), node.get("keys")) {
        (Some(key), None) => (std::slice::from_ref(key), join(path, "key")),
        (None, Some(keys)) => match &keys.value {
            Value::Array(items) if !items.is_empty() => (items.as_slice(), join(path, "keys")),
            _ => {
                reader.refuse(keys, &join(path, "keys"), KEY_LIST.words);
                return None;
            }
        },
        (Some(_), Some(both)) => {
            let message = "found key and keys, allowed: one of them".to_owned();
            reader.push(Problem::at(&both.origin, &join(path, "keys"), message));
            return None;
        }
        (None, None) => {
            reader.missing(node, &join(path, "key"), KEY.words);
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
            _ => reader.refuse(key, &path, KEY.words),
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
                name: None,
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

/// Gives the items their names, where the axis has names.
fn name_items(reader: &mut Reader, node: &Node, path: &str, items: &mut [AxisItem]) -> Option<()> {
    let Some(node) = node.get("names") else {
        return Some(());
    };
    let path = join(path, "names");
    let allowed = format!("a list of {} different texts, one a value", items.len());
    let names: Option<Vec<&String>> = match &node.value {
        Value::Array(names) if names.len() == items.len() => names
            .iter()
            .map(|name| match &name.value {
                Value::Text(text) if !text.trim().is_empty() => Some(text),
                _ => None,
            })
            .collect(),
        _ => None,
    };
    let names = names.filter(|names| names.iter().collect::<HashSet<_>>().len() == names.len());
    let Some(names) = names else {
        reader.refuse(node, &path, &allowed);
        return None;
    };
    for (item, name) in items.iter_mut().zip(names) {
        item.name = Some(name.clone());
    }
    Some(())
}

fn read_distribution(
    reader: &mut Reader,
    node: &Node,
    path: &str,
    way: &str,
) -> Option<Distribution> {
    let pair: Option<&[Node; 2]> = match &node.value {
        Value::Array(items) => items.as_slice().try_into().ok(),
        _ => None,
    };
    let number = |node: &Node| match node.value {
        Value::Float(number) | Value::Integer(_, number) if number.is_finite() => Some(number),
        _ => None,
    };
    let index = |node: &Node| i64::try_from(node.whole()?).ok();
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
        let key = AXIS.iter().find(|key| key.name == way);
        let allowed = key.map_or(String::new(), |key| key.field.allowed());
        reader.refuse(node, path, &allowed);
    }
    found
}

fn whole(reader: &mut Reader, node: &Node, path: &str) -> Option<i64> {
    let found = node.whole().and_then(|whole| i64::try_from(whole).ok());
    let found = found.filter(|whole| *whole >= 0);
    if found.is_none() {
        reader.refuse(node, path, WHOLE);
    }
    found
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
