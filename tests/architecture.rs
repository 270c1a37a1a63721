//! docs/architecture.md agrees with the code.

use crate::support::root;
use std::collections::BTreeSet;
use std::process::Command;

/// Direct dependencies between the workspace's crates without dev-dependencies, as pairs of names without `robhaz-`.
fn dependencies() -> BTreeSet<(String, String)> {
    let output = Command::new(env!("CARGO"))
        .args(["metadata", "--no-deps", "--offline", "--locked"])
        .args(["--format-version", "1"])
        .current_dir(root())
        .output()
        .unwrap();
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    let metadata: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
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

/// The crate graph in docs/architecture.md equals that of `cargo metadata`.
#[test]
fn the_crate_graph_is_documented() {
    let text = std::fs::read_to_string(root().join("docs/architecture.md")).unwrap();
    let graph = text.split("graph TD\n").nth(1).unwrap();
    let graph = graph.split("```").next().unwrap();
    let documented: BTreeSet<(String, String)> = graph
        .lines()
        .filter_map(|line| line.trim().split_once(" --> "))
        .map(|(from, to)| (from.to_owned(), to.to_owned()))
        .collect();
    let found = dependencies();
    // Two empty graphs would be equal, too.
    assert!(found.len() > 20, "{found:?}");
    let missing: Vec<_> = found.difference(&documented).collect();
    let stale: Vec<_> = documented.difference(&found).collect();
    assert!(
        missing.is_empty() && stale.is_empty(),
        "docs/architecture.md lacks {missing:?}; it shows {stale:?}, which do not exist"
    );
}
