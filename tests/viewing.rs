//! The commands `robhaz view` and `robhaz run --rerun`.

use crate::support::{self, assert_contains, on_one_line, root, succeeded, text};
use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;

fn robhaz(folder: &Path, arguments: &[&str]) -> Command {
    let mut command = support::robhaz(folder);
    command.args(arguments);
    command
}

/// The error of a command that fails, on one line.
#[track_caller]
fn refused(command: &mut Command) -> String {
    on_one_line(support::refused(command).as_bytes())
}

fn flat_scene(folder: &Path, duration: f64) {
    let text = format!(
        "[terrain]\nkind = \"flat\"\n[engine]\nkind = \"direct\"\n[record]\nduration = {duration}\ncompare_from = 0.1\n"
    );
    fs::write(folder.join("flat.toml"), text).unwrap();
}

/// `--rerun off` writes no recording, and `view` then says how to get one.
#[test]
fn view_needs_a_recording_and_says_how_to_get_one() {
    let dir = tempfile::tempdir().unwrap();
    flat_scene(dir.path(), 0.3);
    succeeded(&mut robhaz(
        dir.path(),
        &["run", "flat.toml", "--rerun", "off"],
    ));
    assert!(dir.path().join("runs/flat/summary.json").exists());
    assert!(!dir.path().join("runs/flat/run.rrd").exists());
    let said = refused(&mut robhaz(dir.path(), &["view", "runs/flat"]));
    assert_contains(said, "without `--rerun off`");
}

/// Without a viewer the error states the command that installs it, and no file is left behind.
#[test]
fn a_missing_viewer_is_an_error_that_says_how_to_install_it() {
    let dir = tempfile::tempdir().unwrap();
    flat_scene(dir.path(), 0.3);
    succeeded(&mut robhaz(dir.path(), &["run", "flat.toml"]));
    for arguments in [
        &["view", "runs/flat"] as &[&str],
        &["view", "runs/flat", "--screenshot", "shot.png"],
    ] {
        let said = refused(robhaz(dir.path(), arguments).env("PATH", ""));
        assert_contains(said, "pip install rerun-sdk==0.36.3");
    }
    assert!(!dir.path().join("shot.png").exists());
}

/// What cannot be shown is refused with a reason.
#[test]
fn what_cannot_be_shown_is_refused() {
    let dir = tempfile::tempdir().unwrap();
    flat_scene(dir.path(), 0.3);
    succeeded(&mut robhaz(dir.path(), &["run", "flat.toml", "--out", "a"]));
    for (arguments, reason) in [
        (
            &["view", "a", "a", "--screenshot", "x.png"] as &[&str],
            "takes one run",
        ),
        (&["view", "flat.toml"], "`robhaz run SCENE --rerun live`"),
        (&["view", "a", "nowhere"], "neither"),
        (&["view", "a/summary.json"], "neither"),
        (&["view", "a", "--force"], "--screenshot"),
        (&["view", "a", "--at", "1"], "--screenshot"),
        (&["run", "flat.toml", "--rerun", "maybe"], "off, save, live"),
        (
            &["run", "flat.toml", "--rerun", "live=nowhere"],
            "not the address",
        ),
    ] {
        assert_contains(refused(&mut robhaz(dir.path(), arguments)), reason);
    }
    assert!(!dir.path().join("runs").exists());
}

/// Invalid screenshots are refused before a viewer is searched: wrong format, existing file, time
/// outside of the run.
#[test]
fn invalid_screenshots_are_refused_at_once() {
    let dir = tempfile::tempdir().unwrap();
    flat_scene(dir.path(), 0.3);
    succeeded(&mut robhaz(dir.path(), &["run", "flat.toml"]));
    fs::write(dir.path().join("mine.png"), "years").unwrap();
    for (arguments, reason) in [
        (&["x.jpg"] as &[&str], "x.jpg does not end in .png"),
        (&["x"], "x does not end in .png"),
        (&["mine.png"], "mine.png exists"),
        (&["nowhere/x.png"], "cannot write nowhere/x.png"),
        (
            &["x.png", "--at", "500"],
            "500 s is not in the run: its recording goes from 0 s to 0.300 s",
        ),
        (&["x.png", "--at=-1"], "-1 s is not in the run"),
        (&["x.png", "--at", "nan"], "NaN s is not in the run"),
        // Only the viewer is missing.
        (&["x.png", "--at", "0.3"], "pip install rerun-sdk"),
        (&["mine.png", "--force"], "pip install rerun-sdk"),
    ] {
        let mut view = robhaz(dir.path(), &["view", "runs/flat", "--screenshot"]);
        assert_contains(refused(view.args(arguments).env("PATH", "")), reason);
    }
    assert_eq!(
        fs::read_to_string(dir.path().join("mine.png")).unwrap(),
        "years"
    );
    // The scene, the runs and the existing file; no temporary file.
    assert_eq!(fs::read_dir(dir.path()).unwrap().count(), 3);
}

/// Ctrl-C ends the viewer that `view` has started, the processes that the viewer has started, and
/// the command.
#[test]
#[cfg(unix)]
fn view_ends_its_viewer() {
    use std::os::unix::fs::PermissionsExt as _;
    let dir = tempfile::tempdir().unwrap();
    flat_scene(dir.path(), 0.3);
    succeeded(&mut robhaz(dir.path(), &["run", "flat.toml"]));
    // A replacement for the viewer, which pip installs as a script that starts a program.
    let script = "#!/bin/sh\n[ \"$1\" = --version ] && echo rerun-cli 0.36.3 && exit\nsleep 300 &\necho $! > viewer\nwait\n";
    fs::create_dir(dir.path().join("bin")).unwrap();
    let viewer = dir.path().join("bin/rerun");
    fs::write(&viewer, script).unwrap();
    fs::set_permissions(&viewer, fs::Permissions::from_mode(0o755)).unwrap();
    let path = format!(
        "{}:{}",
        dir.path().join("bin").display(),
        std::env::var("PATH").unwrap()
    );
    let mut view = robhaz(dir.path(), &["view", "runs/flat"]);
    let view = view
        .env("PATH", path)
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let started = dir.path().join("viewer");
    for _ in 0..1000 {
        if fs::read_to_string(&started).is_ok_and(|text| text.ends_with('\n')) {
            break;
        }
        std::thread::sleep(Duration::from_millis(20));
    }
    let program = fs::read_to_string(&started).unwrap().trim().to_owned();
    let kill = |arguments: &[&str]| {
        Command::new("kill")
            .args(arguments)
            .status()
            .unwrap()
            .success()
    };
    assert!(kill(&["-INT", &view.id().to_string()]));
    let output = view.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(130), "{}", text(&output.stderr));
    // On a loaded machine a killed process takes a moment to end. It can remain as a zombie
    // process.
    let runs = || {
        let state = fs::read_to_string(format!("/proc/{program}/stat")).unwrap_or_default();
        let state = state.rsplit_once(") ").map_or("?", |(_, rest)| rest);
        !state.starts_with('Z') && kill(&["-0", &program])
    };
    for _ in 0..1000 {
        if !runs() {
            return;
        }
        std::thread::sleep(Duration::from_millis(20));
    }
    panic!("the viewer still runs");
}

/// The viewer's layout works for every shipped scene: each can be recorded and read back to its
/// end.
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
