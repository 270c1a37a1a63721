//! The estimator never sees the truth: it has no path to the simulator.

use cargo_metadata::{DependencyKind, Metadata, MetadataCommand, PackageId};
use std::collections::BTreeSet;

use crate::support::root;

fn reached(metadata: &Metadata, from: &PackageId, names: &mut BTreeSet<String>) {
    let resolve = metadata.resolve.as_ref().unwrap();
    let node = resolve.nodes.iter().find(|n| n.id == *from).unwrap();
    if !names.insert(metadata[from].name.to_string()) {
        return;
    }
    for dependency in &node.deps {
        // What its own tests use does not come along onto a robot.
        if dependency
            .dep_kinds
            .iter()
            .any(|k| k.kind != DependencyKind::Development)
        {
            reached(metadata, &dependency.pkg, names);
        }
    }
}

/// The estimator's dependencies, direct or not, hold neither the simulator nor its engine, terrain or scenes.
#[test]
fn the_estimator_cannot_reach_the_simulator() {
    let metadata = MetadataCommand::new()
        .manifest_path(root().join("Cargo.toml"))
        .other_options(vec!["--offline".to_owned(), "--locked".to_owned()])
        .exec()
        .unwrap();
    let estimator = metadata
        .packages
        .iter()
        .find(|p| p.name == "robhaz-estimator")
        .unwrap();
    let mut names = BTreeSet::new();
    reached(&metadata, &estimator.id, &mut names);
    let own: Vec<&String> = names.iter().filter(|n| n.starts_with("robhaz")).collect();
    assert_eq!(own, ["robhaz-estimator", "robhaz-model"]);
    assert!(
        !names
            .iter()
            .any(|n| n.starts_with("rapier") || n.starts_with("parry")),
        "{names:?}"
    );
    // The walk would prove nothing if it did not follow dependencies.
    assert!(
        names.contains("nalgebra") && names.contains("simba"),
        "{names:?}"
    );
}

/// Model and estimator run on a robot: `no_std`, said in their first lines and kept by the compiler.
#[test]
fn model_and_estimator_are_no_std() {
    for name in ["model", "estimator"] {
        let text =
            std::fs::read_to_string(root().join(format!("crates/{name}/src/lib.rs"))).unwrap();
        assert!(text.lines().any(|line| line == "#![no_std]"), "{name}");
    }
}
