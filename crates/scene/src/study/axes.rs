//! Reads the axes of a study.

use super::axis::{Axis, AxisItem, AxisValue, AxisValues, Distribution};
use crate::error::Problem;
use crate::reader::{Reader, join};
use crate::source::{Node, Value};
use std::collections::HashSet;

/// Keys of `[[axis]]`, of which the last six say how its values are given.
pub const AXIS: [&str; 10] = [
    "key",
    "keys",
    "names",
    "first",
    "values",
    "count",
    "uniform",
    "log_uniform",
    "normal",
    "whole",
];
/// The ways to give values.
pub const WAYS: [&str; 6] = [
    "values",
    "count",
    "uniform",
    "log_uniform",
    "normal",
    "whole",
];

/// Those that draw.
pub const DISTRIBUTIONS: [&str; 4] = ["uniform", "log_uniform", "normal", "whole"];

/// Largest number of runs of a study.
pub const MOST_RUNS: u64 = 100_000_000;
/// What a count may be.
pub const COUNT: &str = "a whole number from 1 to 100000000";
const WHOLE: &str = "a whole number of at least 0 and below 2^63";
const ONE_WAY: &str = "one of values, count, uniform, log_uniform, normal, whole";

/// The axes in the file's order.
pub fn read_axes(reader: &mut Reader, root: &Node) -> Vec<Axis> {
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

pub fn count(reader: &mut Reader, node: &Node, path: &str) -> Option<u64> {
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

/// Adds a problem for every entry with another key.
pub fn known(reader: &mut Reader, node: &Node, path: &str, allowed: &[&str]) {
    for entry in reader.entries(node, path) {
        if !allowed.contains(&entry.key.as_str()) {
            reader.unknown(entry, path, allowed);
        }
    }
}

pub fn missing(reader: &mut Reader, node: &Node, path: &str, allowed: &str) {
    let message = format!("missing, and it has no default; allowed: {allowed}");
    reader.push(Problem::at(&node.origin, path, message).whole());
}
