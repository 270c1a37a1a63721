//! The command as a user types it: new scenes, help, comparisons.

use crate::support::{robhaz, root, short_scene, text};
use std::fs;

/// A new scene is that of the defaults with three of the five estimators; it is not written over
/// another file.
#[test]
fn a_new_scene_runs_with_the_defaults() {
    let dir = tempfile::tempdir().unwrap();
    let new = |name: &str| robhaz(dir.path()).args(["new", name]).output().unwrap();
    assert!(new("mine").status.success());
    let again = new("mine.toml");
    assert!(!again.status.success() && text(&again.stderr).contains("mine.toml exists"));
    // A folder is no name of a scene.
    for name in [".", "..", "./", &dir.path().display().to_string()] {
        let refused = new(name);
        let said = text(&refused.stderr);
        assert!(
            !refused.status.success() && said.contains("is a folder"),
            "{said}"
        );
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
        let mut new = robhaz(dir.path());
        let done = new.args(["new", kind, "--robot", kind]).output().unwrap();
        assert!(done.status.success());
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
    let done = |args: &[&str]| robhaz(dir.path()).args(args).output().unwrap();
    let keys: Vec<serde_json::Value> =
        serde_json::from_slice(&done(&["keys", "--json"]).stdout).unwrap();
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
    let shown = text(&done(&["keys", "TORQUE_LIMIT"]).stdout);
    assert!(
        shown.contains("drive.torque_limit") && !shown.contains("mu_s"),
        "{shown}"
    );
    let none = done(&["keys", "nosuchkey"]);
    assert!(!none.status.success() && text(&none.stderr).contains("nosuchkey"));
    for shell in ["bash", "zsh", "fish"] {
        assert!(
            text(&done(&["completions", shell]).stdout).contains("estimate"),
            "{shell}"
        );
    }
}

/// The comparison for scripts has the numbers of `summary.json`.
#[test]
fn runs_are_compared_for_scripts() {
    let dir = tempfile::tempdir().unwrap();
    short_scene(dir.path(), "");
    let run = robhaz(dir.path())
        .args(["run", "short.toml", "--out", "a|b"])
        .output()
        .unwrap();
    assert!(run.status.success(), "{}", text(&run.stderr));
    let summary = std::fs::read_to_string(dir.path().join("a|b/summary.json")).unwrap();
    let summary: serde_json::Value = serde_json::from_str(&summary).unwrap();
    let output = robhaz(dir.path())
        .args(["--json", "compare", "a|b"])
        .output()
        .unwrap();
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
