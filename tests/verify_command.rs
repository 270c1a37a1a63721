//! The command `robhaz verify`.

use crate::support::{assert_contains, robhaz, short_scene, text};

/// `verify` prints a verdict a line and succeeds where all hold; a run that it cannot keep in
/// memory is refused.
#[test]
fn verify_prints_a_verdict_a_line() {
    let dir = short_scene();
    let output = robhaz(dir.path())
        .args(["verify", "short.toml"])
        .output()
        .unwrap();
    let shown = text(&output.stdout);
    assert!(output.status.success(), "{shown}{}", text(&output.stderr));
    assert!(
        shown.lines().filter(|l| l.starts_with("passed")).count() >= 8,
        "{shown}"
    );
    let output = robhaz(dir.path())
        .args(["verify", "short.toml", "--set", "record.duration=1000"])
        .output()
        .unwrap();
    assert!(!output.status.success());
    assert_contains(text(&output.stderr), "500000");
}

/// A reader of `verify` that goes away is no error, and an engine that stops does not hide what the
/// other found.
#[test]
fn verify_survives_its_reader_and_its_engines() {
    use std::io::Read;
    let dir = short_scene();
    let mut child = robhaz(dir.path())
        .args(["verify", "short.toml"])
        .stdout(std::process::Stdio::piped())
        .stderr(std::process::Stdio::piped())
        .spawn()
        .unwrap();
    drop(child.stdout.take());
    let mut said = String::new();
    child
        .stderr
        .take()
        .unwrap()
        .read_to_string(&mut said)
        .unwrap();
    assert!(child.wait().unwrap().success(), "{said}");
    assert!(said.is_empty(), "{said}");

    let output = robhaz(dir.path())
        .args(["verify", "short.toml", "--set", "record.duration=6"])
        .args([
            "--set",
            "terrain.kind=ramp",
            "--set",
            "terrain.angle=-60 deg",
        ])
        .output()
        .unwrap();
    assert!(!output.status.success());
    let shown = text(&output.stdout);
    for words in [
        "FAILED      rapier: runs to its end",
        "turned over",
        "passed      rapier: momentum",
        "passed      direct: energy",
        "not judged  the engines",
    ] {
        assert!(shown.contains(words), "{words} is missing in:\n{shown}");
    }
}
