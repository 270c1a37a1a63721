//! The command `robhaz study` on a scene.

use crate::support::{assert_contains, refused, robhaz, short_scene, succeeded, text};
use std::fs;

/// A study prints its table, says what was run, prints the same as JSON, repeats to the bit, and
/// with a folder leaves its dataset, also of shards.
#[test]
fn study_prints_a_table_and_writes_its_dataset() {
    let dir = short_scene();
    let study = |more: &[&str]| {
        let output = succeeded(
            robhaz(dir.path())
                .args(["study", "short.toml", "--ladder", "--engine", "direct"])
                .args(["--set", "sensors.grade=typical", "--seeds", "5"])
                .args(more),
        );
        // No progress bar in a pipe.
        assert!(output.stderr.is_empty(), "{}", text(&output.stderr));
        text(&output.stdout)
    };
    let shown = study(&[]);
    for words in [
        "paper-wheels",
        "rolling",
        "NEES",
        "Cramer-Rao bound of one sample",
        "short: 5 seeds, 0 to 4; engine direct, sensors typical; 1001 samples a seed from 0.5 s on, none left out",
    ] {
        assert!(shown.contains(words), "{words} is missing in:\n{shown}");
    }
    assert_eq!(fs::read_dir(dir.path()).unwrap().count(), 1);
    let report: serde_json::Value = serde_json::from_str(&study(&["--json"])).unwrap();
    assert_eq!(report["samples"], 1001);
    assert_eq!(report["estimators"].as_array().unwrap().len(), 12);
    let best = &report["estimators"][9];
    assert_eq!(best["nrmse"]["runs"], 5);
    // Of mean N, with errors of T of about 1 N of 46: at least a thousandth, at most the bound of
    // one sample of some percent.
    let error = best["nrmse"]["mean"].as_f64().unwrap();
    assert!(error > 1e-3 && error < 0.1, "{error}");
    assert!(best["consistency"]["nees"]["mean"].as_f64().unwrap() > 0.0);
    // The paper's filters state no covariance: nothing, not zero.
    assert!(report["estimators"][0]["stated"].is_null());
    assert_eq!(shown, study(&["--jobs", "1"]));
    let whole = study(&["--out", "whole"]);
    assert!(whole.starts_with(shown.trim_end()) && whole.contains("Dataset: whole/study.parquet"));
    study(&["--out", "parts", "--shard", "2/2"]);
    study(&["--out", "parts", "--shard", "1/2"]);
    assert!(study(&["--out", "parts"]).starts_with(shown.trim_end()));
    let dataset = |name: &str| fs::read(dir.path().join(name).join("study.parquet")).unwrap();
    assert!(dataset("whole") == dataset("parts"));
}

/// What cannot be studied is refused with the reason.
#[test]
fn study_refuses_what_it_cannot_do() {
    let dir = short_scene();
    let cases = [
        (vec!["--set", "estimator=[]"], "no estimator"),
        (vec!["--seeds", "0"], "1..=10000"),
        (
            vec!["--set", "seed=18446744073709551615"],
            "the last seed must be below 2^63",
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
    ];
    for (args, reason) in cases {
        let message = refused(robhaz(dir.path()).args(["study", "short.toml"]).args(args));
        assert_contains(message, reason);
    }
}
