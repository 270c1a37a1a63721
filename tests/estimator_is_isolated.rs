//! Estimator and control never see the truth: they do not depend on the simulator.

use crate::support::{cargo, root};
use std::collections::BTreeSet;

/// Names of all direct and indirect dependencies of a package, without dev-dependencies.
fn dependencies(package: &str) -> BTreeSet<String> {
    let arguments = ["tree", "--package", package, "--edges", "normal,build"];
    let form = ["--prefix", "none", "--format", "{p}"];
    cargo(&[&arguments[..], &form].concat())
        .lines()
        .filter_map(|line| line.split_whitespace().next())
        .map(str::to_owned)
        .collect()
}

/// Estimator and control depend, directly or indirectly, neither on the simulator nor on its
/// engines, terrain or scenes.
#[test]
fn estimator_and_control_cannot_reach_the_simulator() {
    let allowed: [&[&str]; 2] = [
        &["robhaz-estimator", "robhaz-model"],
        &["robhaz-control", "robhaz-estimator", "robhaz-model"],
    ];
    for (package, allowed) in ["robhaz-estimator", "robhaz-control"].iter().zip(allowed) {
        let names = dependencies(package);
        let own: Vec<&String> = names.iter().filter(|n| n.starts_with("robhaz")).collect();
        assert_eq!(own, allowed);
        assert!(
            !names
                .iter()
                .any(|n| n.starts_with("rapier") || n.starts_with("parry")),
            "{names:?}"
        );
        // The list must contain indirect dependencies, or the test proves nothing.
        assert!(
            names.contains("nalgebra") && names.contains("simba"),
            "{names:?}"
        );
    }
    assert!(dependencies("robhaz-sim").contains("rapier2d-f64"));
}

/// Model, estimator and control can run on a robot: they declare `no_std`, which the compiler
/// enforces.
#[test]
fn model_estimator_and_control_are_no_std() {
    for name in ["model", "estimator", "control"] {
        let text =
            std::fs::read_to_string(root().join(format!("crates/{name}/src/lib.rs"))).unwrap();
        assert!(text.lines().any(|line| line == "#![no_std]"), "{name}");
    }
}
