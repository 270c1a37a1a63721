//! The command as a user types it: new scenes, help, comparisons.

use crate::support::{
    assert_contains, refused, robhaz, root, short_scene, succeeded, summary, text,
};
use std::fs;

/// A new scene is that of the defaults with three of the five estimators; it is not written over
/// another file.
#[test]
fn a_new_scene_runs_with_the_defaults() {
    let dir = tempfile::tempdir().unwrap();
    succeeded(robhaz(dir.path()).args(["new", "mine"]));
    let refused = |name: &str| refused(robhaz(dir.path()).args(["new", name]));
    assert_contains(refused("mine.toml"), "mine.toml exists");
    // A folder is no name of a scene.
    for name in [".", "..", "./", &dir.path().display().to_string()] {
        assert_contains(refused(name), "is a folder");
    }
    assert_eq!(fs::read_dir(dir.path()).unwrap().count(), 1);
    let made = robhaz_scene::Scene::load(&dir.path().join("mine.toml"), &[]).unwrap();
    assert!(made.warnings().is_empty());
    let labels: Vec<&str> = made.estimators.iter().map(|e| e.name.as_str()).collect();
    assert_eq!(labels, ["paper-wheels", "kalman", "kalman-no-angles"]);
    let default = robhaz_scene::Scene {
        name: made.name.clone(),
        estimators: made.estimators.clone(),
        ..Default::default()
    };
    assert_eq!(made.to_toml("x"), default.to_toml("x"));
}

/// A new scene of a rover is that of `robots/`, which runs as it is.
#[test]
fn a_new_scene_can_be_of_a_rover() {
    let dir = tempfile::tempdir().unwrap();
    for (kind, rover) in [
        ("rocker-bogie", "open-source-rover"),
        ("rocker-bogie-rear", "curiosity"),
        ("triple-bogie", "exomy"),
    ] {
        succeeded(robhaz(dir.path()).args(["new", kind, "--robot", kind]));
        let load = |path: &std::path::Path| robhaz_scene::Scene::load(path, &[]).unwrap();
        let of_rover = load(&root().join("robots").join(rover).with_extension("toml"));
        let mut made = load(&dir.path().join(kind).with_extension("toml"));
        rover.clone_into(&mut made.name);
        assert!(made.to_toml("x") == of_rover.to_toml("x"));
    }
}

/// Every key is explained, by part of its name or meaning; a shell gets its completions and `man`
/// its page.
#[test]
fn keys_completions_and_manual_are_printed() {
    let dir = tempfile::tempdir().unwrap();
    let done = |args: &[&str]| text(&succeeded(robhaz(dir.path()).args(args)).stdout);
    let keys: Vec<serde_json::Value> = serde_json::from_str(&done(&["keys", "--json"])).unwrap();
    let expected: Vec<String> = robhaz_scene::reference()
        .into_iter()
        .map(|k| k.key)
        .collect();
    assert_eq!(
        keys.iter()
            .map(|k| k["key"].as_str().unwrap())
            .collect::<Vec<_>>(),
        expected
    );
    let shown = done(&["keys", "TORQUE_LIMIT"]);
    assert!(
        shown.contains("drive.torque_limit") && !shown.contains("mu_s"),
        "{shown}"
    );
    let none = refused(robhaz(dir.path()).args(["keys", "nosuchkey"]));
    assert_contains(none, "nosuchkey");
    for shell in ["bash", "zsh", "fish"] {
        assert_contains(done(&["completions", shell]), "estimate");
    }
}

/// The comparison for scripts has the numbers of `summary.json`.
#[test]
fn runs_are_compared_for_scripts() {
    let dir = short_scene();
    succeeded(robhaz(dir.path()).args(["run", "short.toml", "--out", "a|b"]));
    let summary = summary(&dir.path().join("a|b"));
    let output = succeeded(robhaz(dir.path()).args(["--json", "compare", "a|b"]));
    let rows: Vec<serde_json::Value> = serde_json::from_str(&text(&output.stdout)).unwrap();
    assert!(!rows.is_empty());
    for row in &rows {
        assert_eq!(row["run"], "a|b");
        let errors = &summary["estimators"][row["estimator"].as_str().unwrap()];
        let force = &errors["normal_force"];
        assert_eq!(row["rmse"], force["rmse_all"]);
        assert_eq!(row["bias_middle"], force["bias"][1]);
        assert_eq!(row["max_error_time"], force["max_abs_time_s"]);
        assert_eq!(row["coverage"], errors["coverage"]);
    }
}

/// Every shipped scene loads.
#[test]
fn shipped_scenes_load() {
    let mut count = 0;
    for entry in fs::read_dir(root().join("scenes")).unwrap() {
        let path = entry.unwrap().path();
        robhaz_scene::Scene::load(&path, &[]).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
        count += 1;
    }
    assert!(count >= 7);
}
