//! Output folders of runs: what may be replaced, and what is left alone.

use crate::support::{
    assert_contains, on_one_line, refused, robhaz, short_scene, succeeded, text, write_short_scene,
};
use robhaz_scene::ControlKind;
use std::fs;

/// Nothing is overwritten unasked, and never what is not a run.
#[test]
fn an_existing_folder_is_safe() {
    let dir = short_scene();
    fs::create_dir(dir.path().join("precious")).unwrap();
    fs::write(dir.path().join("precious/thesis.txt"), "years").unwrap();
    for force in [false, true] {
        let mut command = robhaz(dir.path());
        command.args(["run", "short.toml", "--out", "precious"]);
        if force {
            command.arg("--force");
        }
        assert_contains(refused(&mut command), "precious");
        assert_eq!(
            fs::read_to_string(dir.path().join("precious/thesis.txt")).unwrap(),
            "years"
        );
    }
    let run = |extra: &[&str]| {
        let mut command = robhaz(dir.path());
        command.args(["run", "short.toml", "--set", "record.duration=1"]);
        command.args(extra);
        command
    };
    succeeded(&mut run(&[]));
    assert_contains(refused(&mut run(&[])), "--force");
    succeeded(&mut run(&["--force", "--format", "csv"]));
    let run = dir.path().join("runs/short");
    assert!(run.join("truth.csv").exists() && !run.join("truth.parquet").exists());
}

/// A slash at the end, an empty folder, a file, a run that broke off, a folder with something else
/// beside the run.
#[test]
fn output_folders_are_distinguished() {
    let dir = short_scene();
    let run = |out: &str, extra: &[&str]| {
        let mut command = robhaz(dir.path());
        command.args(["run", "short.toml", "--set", "record.duration=0.6"]);
        command.args(["--out", out]).args(extra);
        command
    };
    succeeded(&mut run("a/", &[]));
    assert!(dir.path().join("a/summary.json").exists());
    fs::create_dir(dir.path().join("empty")).unwrap();
    succeeded(&mut run("empty", &[]));
    fs::write(dir.path().join("file"), "x").unwrap();
    refused(&mut run("file", &["--force"]));
    assert_eq!(fs::read_to_string(dir.path().join("file")).unwrap(), "x");

    // What broke off is kept until it is given up.
    fs::create_dir(dir.path().join("b.partial")).unwrap();
    fs::copy(
        dir.path().join("a/scene.toml"),
        dir.path().join("b.partial/scene.toml"),
    )
    .unwrap();
    assert_contains(refused(&mut run("b", &[])), "b.partial");
    succeeded(&mut run("b", &["--force"]));

    // A user's note in a run's folder, and a user's own scene, stop --force.
    fs::write(dir.path().join("a/note.txt"), "mine").unwrap();
    refused(&mut run("a", &["--force"]));
    assert!(dir.path().join("a/note.txt").exists());
    fs::create_dir(dir.path().join("own")).unwrap();
    fs::write(dir.path().join("own/scene.toml"), "").unwrap();
    refused(&mut run("own", &["--force"]));
    assert!(dir.path().join("own/scene.toml").exists());
}

/// The folder of a run that a user has put something into is not replaced: not in `figures` either,
/// nor where that is a link.
#[test]
fn force_removes_only_what_a_run_wrote() {
    let dir = short_scene();
    let run = |out: &str| {
        let output = robhaz(dir.path())
            .args(["run", "short.toml", "--set", "record.duration=0.6"])
            .args(["--out", out, "--force"])
            .output()
            .unwrap();
        (output.status.success(), on_one_line(&output.stderr))
    };
    // All that a run leaves may be replaced by the next.
    assert!(run("a").0);
    assert!(run("a").0);
    for mine in [
        "figures/mine.svg",
        "figures/fig7_thesis.svg",
        "figures/notes/x",
    ] {
        let path = dir.path().join("a").join(mine);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(&path, "years").unwrap();
        let (done, said) = run("a");
        assert!(!done && said.contains("which no run has written"), "{said}");
        assert_eq!(fs::read_to_string(&path).unwrap(), "years");
        fs::remove_file(&path).unwrap();
    }
    fs::remove_dir(dir.path().join("a/figures/notes")).unwrap();
    // Names that only resemble those of a run, and a folder of such a name.
    for mine in [
        "truth.notes.csv",
        "track-7.csv",
        "run.txt",
        "estimate-a.b.csv",
    ] {
        let path = dir.path().join("a").join(mine);
        fs::write(&path, "years").unwrap();
        let (done, said) = run("a");
        assert!(!done && said.contains(mine), "{said}");
        fs::remove_file(&path).unwrap();
    }
    fs::create_dir(dir.path().join("a/terrain.csv")).unwrap();
    assert!(!run("a").0);
    fs::remove_dir(dir.path().join("a/terrain.csv")).unwrap();
    assert!(run("a").0);

    // What is found is said as it is.
    fs::write(dir.path().join("file"), "x").unwrap();
    let said = run("file").1;
    assert_contains(&said, "file is a file, not the folder of a run");
    fs::create_dir(dir.path().join("own")).unwrap();
    fs::write(dir.path().join("own/scene.toml"), "").unwrap();
    let said = run("own").1;
    assert_contains(
        &said,
        "own has no scene.toml or log.toml that a run has written",
    );
    #[cfg(unix)]
    {
        fs::rename(dir.path().join("a/figures"), dir.path().join("elsewhere")).unwrap();
        std::os::unix::fs::symlink("../elsewhere", dir.path().join("a/figures")).unwrap();
        let (done, said) = run("a");
        assert!(!done && said.contains("a holds figures, which"), "{said}");
        assert!(dir.path().join("elsewhere/fig6_forces.svg").exists());
    }
}

/// `--force` replaces the folder of a run with any control: some write the table `commands`.
#[test]
fn force_replaces_a_run_of_every_control() {
    let dir = tempfile::tempdir().unwrap();
    for kind in ControlKind::ALL {
        let mut control = format!("[drive]\nkind = \"{}\"\n", kind.name());
        if kind == ControlKind::FrictionTest {
            control += "[drive.friction_test]\nstart = 0.55\n";
        }
        write_short_scene(dir.path(), &control);
        for format in ["parquet", "csv"] {
            let mut command = robhaz(dir.path());
            command.args(["run", "short.toml", "--set", "record.duration=0.6"]);
            succeeded(command.args(["--out", "a", "--force", "--format", format]));
        }
    }
}

/// A folder in which a run is writing is left alone, even with `--force`, and so is a target that
/// appears during the run.
#[cfg(unix)]
#[test]
fn a_run_in_progress_is_left_alone() {
    let dir = short_scene();
    let mut first = robhaz(dir.path())
        .args(["run", "short.toml", "--out", "a", "--pace", "real-time"])
        .stdout(std::process::Stdio::null())
        .stderr(std::process::Stdio::piped())
        .spawn()
        .unwrap();
    while !dir.path().join("a.partial/truth.parquet.partial").exists() {
        assert!(first.try_wait().unwrap().is_none());
        std::thread::sleep(std::time::Duration::from_millis(10));
    }
    let second = refused(robhaz(dir.path()).args(["run", "short.toml", "--out", "a", "--force"]));
    assert_contains(second, "another run is writing");
    fs::create_dir(dir.path().join("a")).unwrap();
    fs::write(dir.path().join("a/mine"), "years").unwrap();
    let ended = first.wait_with_output().unwrap();
    assert!(!ended.status.success());
    let said = text(&ended.stderr);
    assert_contains(&said, "the complete run is in a.partial");
    assert!(dir.path().join("a.partial/summary.json").exists());
    assert_eq!(
        fs::read_to_string(dir.path().join("a/mine")).unwrap(),
        "years"
    );
}

/// An output folder that is a link stays a link, and the results are where it leads.
#[cfg(unix)]
#[test]
fn a_linked_output_folder_stays_a_link() {
    let dir = short_scene();
    fs::create_dir_all(dir.path().join("disk/results")).unwrap();
    std::os::unix::fs::symlink("disk/results", dir.path().join("a")).unwrap();
    succeeded(robhaz(dir.path()).args(["run", "short.toml", "--out", "a"]));
    assert!(dir.path().join("a").is_symlink());
    assert!(dir.path().join("disk/results/summary.json").exists());
}

/// A start that fails leaves no folder, and says why in one chain.
#[test]
fn a_start_that_fails_leaves_no_folder() {
    let dir = short_scene();
    for (set, reason) in [
        ("robot.geometry.body_cg=[1.0, 0.3]", "tips forward"),
        (
            "drive.torque_limit=0.1",
            "finds no rest at its start: the motor of wheel",
        ),
    ] {
        let mut command = robhaz(dir.path());
        command.args(["run", "short.toml", "--set", set]);
        command.args(["--set", "terrain.kind=heights"]);
        command.args(["--set", "terrain.interpolation=corners"]);
        command.args(["--set", "terrain.points=[[-5, -1], [5, 1]]"]);
        let said = on_one_line(refused(&mut command).as_bytes());
        assert_contains(&said, reason);
        assert!(!said.contains("broke off"), "{said}");
        assert!(!dir.path().join("runs").exists(), "{set}");
    }
}
