//! docs/architecture.md agrees with the code.

use crate::support::{cargo, root};
use std::collections::BTreeSet;

/// Direct dependencies between the workspace's crates without dev-dependencies, as pairs of names
/// without `robhaz-`.
fn dependencies() -> BTreeSet<(String, String)> {
    let metadata = cargo(&["metadata", "--no-deps", "--format-version", "1"]);
    let metadata: serde_json::Value = serde_json::from_str(&metadata).unwrap();
    let short = |name: &serde_json::Value| {
        let name = name.as_str().unwrap();
        match name.strip_prefix("robhaz-") {
            Some(short) => Some(short.to_owned()),
            None => (name == "robhaz").then(|| "cli".to_owned()),
        }
    };
    let mut edges = BTreeSet::new();
    for package in metadata["packages"].as_array().unwrap() {
        let Some(from) = short(&package["name"]) else {
            continue;
        };
        for dependency in package["dependencies"].as_array().unwrap() {
            if dependency["kind"].is_null()
                && let Some(to) = short(&dependency["name"])
            {
                edges.insert((from.clone(), to));
            }
        }
    }
    edges
}

/// docs/architecture.md lists every crate once, each after those that it depends on.
#[test]
fn crates_depend_on_layers_before_them() {
    let text = std::fs::read_to_string(root().join("docs/architecture.md")).unwrap();
    let table = text.split("## Crates, by layers").nth(1).unwrap();
    let table = table.split("\n### ").next().unwrap();
    let of_row = |line: &str| {
        let cell = line.split('|').nth(2)?.trim();
        let name = cell.strip_prefix('`')?.strip_suffix('`')?;
        Some(name.trim_start_matches("crates/").to_owned())
    };
    let listed: Vec<String> = table.lines().filter_map(of_row).collect();
    let place = |name: &String| {
        let places: Vec<usize> = (0..listed.len()).filter(|i| listed[*i] == *name).collect();
        assert_eq!(
            places.len(),
            1,
            "docs/architecture.md lists {name} {places:?}"
        );
        places[0]
    };
    let found = dependencies();
    assert!(found.len() > 20, "{found:?}");
    let mut all: BTreeSet<&String> = BTreeSet::new();
    for (from, to) in &found {
        assert!(
            place(to) < place(from),
            "{from} depends on {to}, which docs/architecture.md lists after it"
        );
        all.extend([from, to]);
    }
    assert_eq!(all.len(), listed.len(), "{listed:?}");
}
