//! A bar that touches the ground: the run says so, `verify` fails, `path` says no-go.

use crate::support::{assert_contains, robhaz, root, scene, succeeded, summary, text};
use robhaz_path::{Options, PathSetup, Reason, judge};
use std::process::Output;

/// A body that hangs down to 20 mm, less its wall of 15 mm: the nose would have to rise by 45 mm
/// for a kerb of 50 mm.
const LOW_BODY: &str = "robot.geometry.outline.body_lower=[-0.17, 0.02]";

fn robhaz_on_step(arguments: &[&str]) -> Output {
    let dir = tempfile::tempdir().unwrap();
    let step = root().join("scenes/step.toml");
    let arguments = [arguments[0], step.to_str().unwrap()]
        .into_iter()
        .chain(arguments[1..].iter().copied());
    robhaz(dir.path()).args(arguments).output().unwrap()
}

/// Boundary: the kerb is go for the nominal outline and no-go for a body that hangs lower than it,
/// by its clearance.
#[test]
fn a_path_is_no_go_where_the_body_touches() {
    let report = |overrides: &[&str]| {
        let setup = PathSetup::new(&scene("step", overrides), Options::default()).unwrap();
        judge(&setup).unwrap()
    };
    let (high, low) = (report(&[]), report(&[LOW_BODY]));
    assert!(
        high.go && high.clearance.unwrap() > 0.05,
        "{:?}",
        high.clearance
    );
    let failure = low.first_failure.unwrap();
    assert!(
        !low.go && failure.reason == Reason::Clearance,
        "{failure:?}"
    );
    // The body's box reaches from 0.2 m behind its centre to 0.2 m ahead of it, and the kerb is at
    // 0.7 m.
    assert!(failure.x > 0.3 && failure.x < 1.0, "{failure:?}");
    assert!(low.clearance.unwrap() <= 0.0 && low.probability.abs() < 1e-15);
}

/// The run of such a robot reports the touch and has the least clearance in `summary.json` and in
/// the table; without it, it reports nothing.
#[test]
fn a_run_says_where_a_bar_touched() {
    let dir = tempfile::tempdir().unwrap();
    let step = root().join("scenes/step.toml");
    let run = |out: &str, extra: &[&str]| {
        let output = succeeded(
            robhaz(dir.path())
                .args([
                    "run",
                    step.to_str().unwrap(),
                    "--rerun",
                    "off",
                    "--format",
                    "csv",
                    "--out",
                    out,
                ])
                .args(["--set", "record.rate=100", "--engine", "direct"])
                .args(extra),
        );
        let summary = summary(&dir.path().join(out));
        (text(&output.stdout), summary)
    };
    let (said, summary) = run("high", &[]);
    let clearance = &summary["clearance"];
    assert!(!said.contains("TOUCHED"), "{said}");
    assert!(clearance["least_m"].as_f64().unwrap() > 0.0 && clearance["touches"] == 0);
    assert_eq!(summary["events"]["touches"], 0);
    let (said, summary) = run("low", &["--set", LOW_BODY]);
    let clearance = &summary["clearance"];
    assert_contains(&said, "body TOUCHED THE GROUND at");
    assert!(clearance["touches"].as_u64().unwrap() >= 1 && clearance["bar"] == "body");
    assert_eq!(summary["events"]["touches"], clearance["touches"]);
    // The table has the same least value.
    let mut table = csv::Reader::from_path(dir.path().join("low/truth.csv")).unwrap();
    let index = table
        .headers()
        .unwrap()
        .iter()
        .position(|name| name == "clearance")
        .unwrap();
    let values = table
        .records()
        .map(|row| row.unwrap()[index].parse::<f64>().unwrap());
    let least = values.fold(f64::INFINITY, f64::min);
    assert!((least - clearance["least_m"].as_f64().unwrap()).abs() < 1e-9);
}

/// `verify` fails for such a robot by this verdict, and passes it for the nominal outline.
#[test]
fn verify_fails_where_a_bar_touches() {
    let short = ["verify", "--set", "record.duration=6"];
    let line = |output: &Output| {
        let said = text(&output.stdout);
        let lines: Vec<_> = said
            .lines()
            .filter(|l| l.contains("clear of the ground"))
            .map(str::to_owned)
            .collect();
        assert_eq!(lines.len(), 2, "{said}");
        lines
    };
    let high = robhaz_on_step(&short);
    let low = robhaz_on_step(&[&short[..], &["--set", LOW_BODY]].concat());
    assert!(!low.status.success());
    for (high, low) in line(&high).iter().zip(line(&low)) {
        assert_contains(high, "passed");
        assert_contains(&low, "FAILED");
        assert_contains(&low, "body");
    }
}
