//! The commands `robhaz view` and `robhaz run --rerun`.

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

/// Standard error in one line, because error reports wrap lines at the terminal's width.
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

/// `--rerun off` writes no recording, and `view` then says how to get one.
#[test]
fn view_needs_a_recording_and_says_how_to_get_one() {
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

/// Without a viewer the error states the command that installs it, and no file is left behind.
#[test]
fn a_missing_viewer_is_an_error_that_says_how_to_install_it() {
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

/// Two runs are compared in one recording; what cannot be compared or shown is refused with a reason.
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
        (&["view", "a", "--pace", "fast"], "for scenes"),
        (&["view", "a", "--force"], "nothing else is written"),
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

/// A comparison never replaces a file that it reads, under any name, and replaces other files only with `--force`.
#[test]
fn a_comparison_replaces_files_only_with_force() {
    let dir = tempfile::tempdir().unwrap();
    flat_scene(dir.path(), 0.3);
    for out in ["a", "b"] {
        let run = robhaz(dir.path(), &["run", "flat.toml", "--out", out]);
        assert!({ run }.output().unwrap().status.success());
    }
    let recording = fs::read(dir.path().join("a/run.rrd")).unwrap();
    let mut names = vec!["a/run.rrd", "b/../a/run.rrd"];
    fs::hard_link(dir.path().join("a/run.rrd"), dir.path().join("hard.rrd")).unwrap();
    names.push("hard.rrd");
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink("a/run.rrd", dir.path().join("soft.rrd")).unwrap();
        names.push("soft.rrd");
    }
    for name in names {
        for force in [&[] as &[&str], &["--force"]] {
            let mut command = robhaz(dir.path(), &["view", "a", "b", "--save", name]);
            let output = command.args(force).output().unwrap();
            assert!(!output.status.success());
            assert!(
                said(&output).contains("is the same file as a/run.rrd"),
                "{}",
                said(&output)
            );
            assert!(
                fs::read(dir.path().join("a/run.rrd")).unwrap() == recording,
                "{name}"
            );
        }
    }
    // The library refuses it as well.
    let scene = robhaz_scene::Scene::load(&dir.path().join("a/scene.toml"), &[]).unwrap();
    let description = robhaz_run::RunDescription::of(&scene).unwrap();
    let paths = ["a", "b"].map(|run| dir.path().join(run).join("run.rrd"));
    let runs = [0, 1].map(|k| robhaz_viewer::ComparedRun {
        label: "run",
        description: &description,
        recording: &paths[k],
    });
    let hard = dir.path().join("hard.rrd");
    assert!(robhaz_viewer::save_comparison(&runs, &hard, &|| None).is_err());
    assert!(fs::read(hard).unwrap() == recording);

    let save = |name: &str, extra: &[&str]| {
        let mut command = robhaz(dir.path(), &["view", "a", "b", "--save", name]);
        command.args(extra).output().unwrap()
    };
    fs::write(dir.path().join("mine.rrd"), "years").unwrap();
    let refused = save("mine.rrd", &[]);
    assert!(!refused.status.success());
    assert!(
        said(&refused).contains("mine.rrd exists"),
        "{}",
        said(&refused)
    );
    assert_eq!(
        fs::read_to_string(dir.path().join("mine.rrd")).unwrap(),
        "years"
    );
    // A failed comparison neither replaces a file nor leaves one behind.
    fs::rename(dir.path().join("b/run.rrd"), dir.path().join("b/kept")).unwrap();
    fs::write(dir.path().join("b/run.rrd"), "no recording").unwrap();
    assert!(!save("mine.rrd", &["--force"]).status.success());
    assert_eq!(
        fs::read_to_string(dir.path().join("mine.rrd")).unwrap(),
        "years"
    );
    fs::rename(dir.path().join("b/kept"), dir.path().join("b/run.rrd")).unwrap();
    assert!(save("mine.rrd", &["--force"]).status.success());
    assert!(fs::read(dir.path().join("mine.rrd")).unwrap().len() > 1000);
    assert!(!save("a/scene.toml", &["--force"]).status.success());
    assert!(!save("a", &["--force"]).status.success());
    let mut left: Vec<_> = fs::read_dir(dir.path())
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    left.retain(|name| !["hard.rrd", "soft.rrd"].contains(&name.as_str()));
    left.sort();
    assert_eq!(left, ["a", "b", "flat.toml", "mine.rrd"]);
}

/// Invalid screenshots are refused before a viewer is searched: wrong format, existing file, time outside of the run.
#[test]
fn invalid_screenshots_are_refused_at_once() {
    let dir = tempfile::tempdir().unwrap();
    flat_scene(dir.path(), 0.3);
    let run = robhaz(dir.path(), &["run", "flat.toml"]).output().unwrap();
    assert!(run.status.success(), "{}", said(&run));
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
        let output = robhaz(dir.path(), &["view", "runs/flat", "--screenshot"])
            .args(arguments)
            .env("PATH", "")
            .output()
            .unwrap();
        assert!(!output.status.success(), "{arguments:?}");
        assert!(
            said(&output).contains(reason),
            "{arguments:?}: {}",
            said(&output)
        );
    }
    assert_eq!(
        fs::read_to_string(dir.path().join("mine.png")).unwrap(),
        "years"
    );
    // The scene, the runs and the existing file; no temporary file.
    assert_eq!(fs::read_dir(dir.path()).unwrap().count(), 3);
}

/// A truncated recording is compared up to its end, with a warning that names it; one without data is an error.
#[test]
fn a_truncated_recording_is_named() {
    let dir = tempfile::tempdir().unwrap();
    flat_scene(dir.path(), 4.5);
    for out in ["a", "b"] {
        let run = robhaz(dir.path(), &["run", "flat.toml", "--out", out]);
        assert!({ run }.output().unwrap().status.success());
    }
    let path = dir.path().join("b/run.rrd");
    let whole = fs::read(&path).unwrap();
    let save = || {
        robhaz(
            dir.path(),
            &["view", "a", "b", "--save", "both.rrd", "--force"],
        )
        .output()
        .unwrap()
    };
    let output = save();
    assert!(
        output.status.success() && output.stderr.is_empty(),
        "{}",
        said(&output)
    );
    // The index at the end is small: this removes rows.
    fs::write(&path, &whole[..whole.len() * 6 / 10]).unwrap();
    let output = save();
    assert!(output.status.success(), "{}", said(&output));
    assert!(
        said(&output).contains("Warning: b/run.rrd is cut off at"),
        "{}",
        said(&output)
    );
    // Within the header, and within the first message.
    for length in [5, 40] {
        fs::write(&path, &whole[..length]).unwrap();
        let output = save();
        assert!(!output.status.success());
        assert!(said(&output).contains("b/run.rrd"), "{}", said(&output));
    }
}

/// Ctrl-C ends the viewer that `view` has started, the processes that the viewer has started, and the command.
#[test]
#[cfg(unix)]
fn view_ends_its_viewer() {
    use std::os::unix::fs::PermissionsExt as _;
    let dir = tempfile::tempdir().unwrap();
    flat_scene(dir.path(), 0.3);
    let run = robhaz(dir.path(), &["run", "flat.toml"]).output().unwrap();
    assert!(run.status.success(), "{}", said(&run));
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
    assert_eq!(output.status.code(), Some(130), "{}", said(&output));
    // On a loaded machine a killed process takes a moment to end. It can remain as a zombie process.
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

/// The viewer's layout works for every shipped scene: each can be recorded and read back to its end.
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
