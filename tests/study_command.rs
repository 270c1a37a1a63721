//! The command `robhaz study`.

use crate::support::{robhaz, short_scene, text};
use std::fs;

/// A study prints its table, says what was run, writes the same as JSON, and repeats to the bit.
#[test]
fn study_prints_a_table_and_writes_json() {
    let dir = tempfile::tempdir().unwrap();
    short_scene(dir.path(), "");
    let study = |json: &str| {
        let output = robhaz(dir.path())
            .args(["study", "short.toml", "--ladder", "--engine", "direct"])
            .args(["--set", "sensors.grade=typical", "--seeds", "5"])
            .args(["--out", json])
            .output()
            .unwrap();
        assert!(output.status.success(), "{}", text(&output.stderr));
        // No progress bar in a pipe.
        assert!(output.stderr.is_empty(), "{}", text(&output.stderr));
        let json = fs::read_to_string(dir.path().join(json)).unwrap();
        (text(&output.stdout), json)
    };
    let (shown, json) = study("first.json");
    for words in [
        "paper-wheels",
        "rolling",
        "NEES",
        "Cramer-Rao bound of one sample",
        "short: 5 seeds, 0 to 4; engine direct, sensors typical; 1001 samples a seed from 0.5 s on, none left out",
    ] {
        assert!(shown.contains(words), "{words} is missing in:\n{shown}");
    }
    let report: serde_json::Value = serde_json::from_str(&json).unwrap();
    assert_eq!(report["samples"], 1001);
    assert_eq!(report["estimators"].as_array().unwrap().len(), 12);
    let best = &report["estimators"][9];
    assert_eq!(best["nrmse"]["runs"], 5);
    // Of mean N, with errors of T of about 1 N of 46: at least a thousandth, at most the bound of one sample of some percent.
    let error = best["nrmse"]["mean"].as_f64().unwrap();
    assert!(error > 1e-3 && error < 0.1, "{error}");
    assert!(best["consistency"]["nees"]["mean"].as_f64().unwrap() > 0.0);
    // The paper's filters state no covariance: nothing, not zero.
    assert!(report["estimators"][0]["stated"].is_null());
    assert!((shown, json) == study("second.json"));
    // No file is replaced unasked, and the scene never.
    for (json, why) in [
        ("first.json", "first.json exists"),
        ("short.toml", "short.toml"),
    ] {
        let output = robhaz(dir.path())
            .args(["study", "short.toml", "--out", json])
            .output()
            .unwrap();
        assert!(!output.status.success());
        assert!(text(&output.stderr).contains(why));
    }
}

/// What cannot be studied is refused with the reason.
#[test]
fn study_refuses_what_it_cannot_do() {
    let dir = tempfile::tempdir().unwrap();
    short_scene(dir.path(), "");
    let refused = [
        (vec!["--set", "estimator=[]"], "no estimator"),
        (vec!["--seeds", "0"], "1..=10000"),
        (
            vec!["--set", "seed=18446744073709551615"],
            "the last seed must be below 2^64",
        ),
        (
            vec![
                "--set",
                "record.duration=1e4",
                "--set",
                "record.compare_from=1",
            ],
            "10000001 samples",
        ),
        (vec!["--engine", "box2d"], "direct"),
        (vec!["--out", "nowhere/out.json"], "nowhere/out.json"),
    ];
    for (args, reason) in refused {
        let output = robhaz(dir.path())
            .args(["study", "short.toml"])
            .args(&args)
            .output()
            .unwrap();
        let message = text(&output.stderr);
        assert!(!output.status.success(), "{args:?}");
        assert!(message.contains(reason), "{args:?}: {message}");
    }
}
