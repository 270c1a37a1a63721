//! The estimator never sees the truth: it has no path to the simulator.

use crate::support::root;
use std::collections::BTreeSet;
use std::process::Command;

/// Names of all packages that a package needs, directly or not, without what only its tests use.
fn dependencies(package: &str) -> BTreeSet<String> {
    let output = Command::new(env!("CARGO"))
        .args(["tree", "--offline", "--locked", "--package", package])
        .args([
            "--edges",
            "normal,build",
            "--prefix",
            "none",
            "--format",
            "{p}",
        ])
        .current_dir(root())
        .output()
        .unwrap();
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    String::from_utf8_lossy(&output.stdout)
        .lines()
        .filter_map(|line| line.split_whitespace().next())
        .map(str::to_owned)
        .collect()
}

/// The estimator's dependencies, direct or not, hold neither the simulator nor its engines, terrain or scenes.
#[test]
fn the_estimator_cannot_reach_the_simulator() {
    let names = dependencies("robhaz-estimator");
    let own: Vec<&String> = names.iter().filter(|n| n.starts_with("robhaz")).collect();
    assert_eq!(own, ["robhaz-estimator", "robhaz-model"]);
    assert!(
        !names
            .iter()
            .any(|n| n.starts_with("rapier") || n.starts_with("parry")),
        "{names:?}"
    );
    // The list would prove nothing if it held direct dependencies only.
    assert!(
        names.contains("nalgebra") && names.contains("simba"),
        "{names:?}"
    );
    assert!(dependencies("robhaz-sim").contains("rapier2d-f64"));
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
