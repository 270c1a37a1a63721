//! `robhaz view` and `robhaz run --rerun`, as a user types them.

use crate::support::root;
use std::fs;
use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::time::Duration;

fn robhaz(folder: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_robhaz"));
    command.current_dir(folder).args(arguments);
    command
}

/// What was said, in one line: the report breaks lines where the terminal would.
fn said(output: &Output) -> String {
    let text = String::from_utf8_lossy(&output.stderr).into_owned();
    text.replace('│', " ")
        .split_whitespace()
        .collect::<Vec<_>>()
        .join(" ")
}

fn flat_scene(folder: &Path, duration: f64) {
    let text = format!(
        "[terrain]\nkind = \"flat\"\n[engine]\nkind = \"direct\"\n[record]\nduration = {duration}\ncompare_from = 0.1\n"
    );
    fs::write(folder.join("flat.toml"), text).unwrap();
}

/// A run that is killed leaves a recording that can be read up to the last full two seconds, at the least.
#[test]
#[cfg(unix)]
fn the_recording_of_a_killed_run_can_be_read() {
    let dir = tempfile::tempdir().unwrap();
    flat_scene(dir.path(), 10_000.0);
    let mut run = robhaz(dir.path(), &["run", "flat.toml", "--out", "killed"])
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let recording = dir.path().join("killed.partial/run.rrd");
    // A megabyte is more than the layout: several seconds of the run are in it.
    let large = || fs::metadata(&recording).is_ok_and(|m| m.len() > 1_000_000);
    for _ in 0..600 {
        if large() {
            break;
        }
        std::thread::sleep(Duration::from_millis(50));
    }
    run.kill().unwrap();
    let status = run.wait().unwrap();
    assert!(!status.success() && large(), "{status}");
    let end = robhaz_viewer::recording_end(&recording).unwrap().unwrap();
    assert!(end >= 2.0, "{end} s");
    assert!(!dir.path().join("killed").exists());
}

/// `--rerun off` leaves no recording, and `view` says what to do then.
#[test]
fn without_a_recording_there_is_nothing_to_view() {
    let dir = tempfile::tempdir().unwrap();
    flat_scene(dir.path(), 0.3);
    let run = robhaz(dir.path(), &["run", "flat.toml", "--rerun", "off"])
        .output()
        .unwrap();
    assert!(run.status.success(), "{}", said(&run));
    assert!(dir.path().join("runs/flat/summary.json").exists());
    assert!(!dir.path().join("runs/flat/run.rrd").exists());
    let view = robhaz(dir.path(), &["view", "runs/flat"]).output().unwrap();
    assert!(!view.status.success());
    assert!(
        said(&view).contains("without `--rerun off`"),
        "{}",
        said(&view)
    );
}

/// Without a viewer the answer is the one command that gets it, and nothing was started or left behind.
#[test]
fn without_a_viewer_the_answer_is_how_to_get_it() {
    let dir = tempfile::tempdir().unwrap();
    flat_scene(dir.path(), 0.3);
    let run = robhaz(dir.path(), &["run", "flat.toml"]).output().unwrap();
    assert!(run.status.success(), "{}", said(&run));
    for arguments in [
        &["view", "runs/flat"] as &[&str],
        &["view", "runs/flat", "--screenshot", "shot.png"],
    ] {
        let output = robhaz(dir.path(), arguments)
            .env("PATH", "")
            .output()
            .unwrap();
        assert!(!output.status.success(), "{arguments:?}");
        let said = said(&output);
        assert!(said.contains("pip install rerun-sdk==0.36.3"), "{said}");
    }
    assert!(!dir.path().join("shot.png").exists());
}

/// A comparison of two runs in one file; what cannot be compared or shown is refused with a reason.
#[test]
fn runs_are_compared_in_one_recording() {
    let dir = tempfile::tempdir().unwrap();
    flat_scene(dir.path(), 0.3);
    for (engine, out) in [("direct", "a"), ("rapier", "b")] {
        let arguments = ["run", "flat.toml", "--engine", engine, "--out", out];
        let run = robhaz(dir.path(), &arguments).output().unwrap();
        assert!(run.status.success(), "{}", said(&run));
    }
    let compared = robhaz(dir.path(), &["view", "a", "b/", "--save", "both.rrd"])
        .output()
        .unwrap();
    assert!(compared.status.success(), "{}", said(&compared));
    let end = robhaz_viewer::recording_end(&dir.path().join("both.rrd")).unwrap();
    assert!((end.unwrap() - 0.3).abs() < 1e-9);

    for (arguments, reason) in [
        (&["view", "a", "--save", "x.rrd"] as &[&str], "several runs"),
        (&["view", "flat.toml", "--save", "x.rrd"], "run it first"),
        (&["view", "flat.toml", "a"], "is a scene"),
        (
            &["view", "a", "nowhere", "--save", "x.rrd"],
            "no scene.toml",
        ),
        (&["view", "a/summary.json"], "neither"),
        (&["view", "a", "--set", "seed=1"], "for scenes"),
        (&["view", "a", "--at", "1"], "--screenshot"),
        (
            &["run", "flat.toml", "--rerun", "maybe"],
            "off, save, spawn",
        ),
        (
            &["run", "flat.toml", "--rerun", "connect=nowhere"],
            "not the address",
        ),
    ] {
        let output = robhaz(dir.path(), arguments).output().unwrap();
        assert!(!output.status.success(), "{arguments:?}");
        assert!(
            said(&output).contains(reason),
            "{arguments:?}: {}",
            said(&output)
        );
    }
    assert!(!dir.path().join("x.rrd").exists());
    assert!(!dir.path().join("runs").exists());
}

/// The layout holds for every shipped scene: each can be recorded and read back to its end.
#[test]
fn every_shipped_scene_can_be_recorded() {
    let dir = tempfile::tempdir().unwrap();
    let mut recorded = 0;
    for entry in fs::read_dir(root().join("scenes")).unwrap() {
        let scene = entry.unwrap().path();
        if scene.extension().is_none_or(|e| e != "toml") {
            continue;
        }
        let name = scene.file_stem().unwrap().to_string_lossy().into_owned();
        let sets = [
            "record.duration=0.1",
            "record.compare_from=0",
            "engine.kind=direct",
        ];
        let sets = sets.map(str::to_owned);
        let scene = robhaz_scene::Scene::load(&scene, &sets).unwrap();
        let path = dir.path().join(format!("{name}.rrd"));
        let mut sink = robhaz_viewer::RecordingSink::save(&path).unwrap();
        robhaz_run::run(&scene, &mut [&mut sink]).unwrap();
        let end = robhaz_viewer::recording_end(&path).unwrap().unwrap();
        assert!((end - 0.1).abs() < 1e-9, "{name}: {end}");
        recorded += 1;
    }
    assert!(recorded >= 10, "{recorded}");
}
