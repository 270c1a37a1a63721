//! The command as a user types it.

use crate::support::root;
use std::fs;
use std::path::Path;
use std::process::Command;

fn robhaz(folder: &Path) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_robhaz"));
    command.current_dir(folder);
    command
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// A scene of one second that a test may edit.
fn short_scene(folder: &Path, extra: &str) -> std::path::PathBuf {
    let path = folder.join("short.toml");
    fs::write(
        &path,
        format!(
            "[terrain]\nkind = \"flat\"\n\n[record]\nduration = 1.5\ncompare_from = 0.5\n{extra}"
        ),
    )
    .unwrap();
    path
}

/// One run leaves everything that was promised, and says where.
#[test]
fn run_leaves_tables_figures_summary_and_scene() {
    let dir = tempfile::tempdir().unwrap();
    short_scene(dir.path(), "");
    let output = robhaz(dir.path())
        .args(["run", "short.toml"])
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", text(&output.stderr));
    let run = dir.path().join("runs/short");
    let mut expected = vec![
        "truth.parquet",
        "sensors.parquet",
        "estimate-paper-body.parquet",
        "estimate-paper-wheels.parquet",
        "estimate-true-mass.parquet",
        "summary.json",
        "scene.toml",
        "figures/fig5_linkage.svg",
        "figures/fig6_forces.svg",
        "figures/fig7_paper-body.svg",
        "figures/fig8_paper-wheels.svg",
        "figures/comparison.svg",
        "figures/comparison.pdf",
        "figures/path.svg",
        "figures/path.pdf",
    ];
    if cfg!(feature = "viewer") {
        expected.push("run.rrd");
    }
    for name in expected {
        let size = fs::metadata(run.join(name))
            .unwrap_or_else(|e| panic!("{name}: {e}"))
            .len();
        assert!(size > 100, "{name} has {size} bytes");
    }
    let shown = text(&output.stdout);
    for word in [
        "paper-body",
        "paper-wheels",
        "true-mass",
        "runs/short",
        "RMSE",
    ] {
        assert!(shown.contains(word), "{word} is missing in:\n{shown}");
    }
    // No progress bar in a pipe.
    assert!(output.stderr.is_empty(), "{}", text(&output.stderr));

    let summary: serde_json::Value =
        serde_json::from_str(&fs::read_to_string(run.join("summary.json")).unwrap()).unwrap();
    assert_eq!(summary["scene"], "short");
    assert_eq!(summary["engine"], "rapier");
    assert_eq!(summary["seed"], 0);
    assert_eq!(summary["duration_s"], 1.5);
    let error = &summary["estimators"]["true-mass"]["normal_force"];
    assert_eq!(error["rmse"].as_array().unwrap().len(), 3);
    // Statics with true masses, nearly at rest on level ground: a thousandth of the load is far more than the start leaves.
    assert!(error["nrmse"].as_f64().unwrap() < 1e-2, "{error}");

    let compared = robhaz(dir.path())
        .args(["compare", "runs/short"])
        .output()
        .unwrap();
    assert!(compared.status.success());
    assert!(text(&compared.stdout).contains("paper-wheels"));
}

/// What a run resolved can be run again, and gives the same tables to the bit; so does the scene itself.
#[test]
fn the_resolved_scene_runs_again_to_the_same_bits() {
    let dir = tempfile::tempdir().unwrap();
    short_scene(dir.path(), "");
    for (scene, out) in [("short.toml", "first"), ("first/scene.toml", "second")] {
        let output = robhaz(dir.path())
            .args(["run", scene, "--out", out, "--set", "record.duration=1"])
            .output()
            .unwrap();
        assert!(output.status.success(), "{}", text(&output.stderr));
    }
    for name in [
        "truth.parquet",
        "sensors.parquet",
        "estimate-true-mass.parquet",
        "scene.toml",
    ] {
        let [first, second] =
            ["first", "second"].map(|run| fs::read(dir.path().join(run).join(name)).unwrap());
        assert!(first == second, "{name} differs");
    }
}

/// Nothing is overwritten unasked, and never what is not a run.
#[test]
fn an_existing_folder_is_safe() {
    let dir = tempfile::tempdir().unwrap();
    short_scene(dir.path(), "");
    fs::create_dir(dir.path().join("precious")).unwrap();
    fs::write(dir.path().join("precious/thesis.txt"), "years").unwrap();
    for force in [false, true] {
        let mut command = robhaz(dir.path());
        command.args(["run", "short.toml", "--out", "precious"]);
        if force {
            command.arg("--force");
        }
        let output = command.output().unwrap();
        assert!(!output.status.success());
        assert!(
            text(&output.stderr).contains("precious"),
            "{}",
            text(&output.stderr)
        );
        assert_eq!(
            fs::read_to_string(dir.path().join("precious/thesis.txt")).unwrap(),
            "years"
        );
    }
    let run = |extra: &[&str]| {
        robhaz(dir.path())
            .args(["run", "short.toml", "--set", "record.duration=1"])
            .args(extra)
            .output()
            .unwrap()
    };
    assert!(run(&[]).status.success());
    let refused = run(&[]);
    assert!(!refused.status.success());
    assert!(
        text(&refused.stderr).contains("--force"),
        "{}",
        text(&refused.stderr)
    );
    assert!(run(&["--force", "--format", "csv"]).status.success());
    let run = dir.path().join("runs/short");
    assert!(run.join("truth.csv").exists() && !run.join("truth.parquet").exists());
}

/// A run that breaks off says so, keeps what it recorded, and leaves no folder that looks finished.
#[test]
fn a_run_that_breaks_off_keeps_what_it_has() {
    let dir = tempfile::tempdir().unwrap();
    // Ground too soft to carry the robot: the wheels sink in until their centres are below it.
    short_scene(
        dir.path(),
        "\n[engine]\nstart = \"raw\"\n\n[contact]\nstiffness = 1.0e3\ndamping = 0.0\n",
    );
    let output = robhaz(dir.path())
        .args(["run", "short.toml", "--format", "csv"])
        .output()
        .unwrap();
    assert!(!output.status.success());
    let said = text(&output.stderr);
    assert!(
        said.contains("below the ground") && said.contains("short.partial"),
        "{said}"
    );
    assert!(!dir.path().join("runs/short").exists());
    let table = fs::read_to_string(dir.path().join("runs/short.partial/truth.csv")).unwrap();
    assert!(table.starts_with("time,"));
    // Without a record there is nothing to compare.
    let compared = robhaz(dir.path())
        .args(["compare", "runs/short.partial"])
        .output()
        .unwrap();
    assert!(!compared.status.success());

    // With records there is; it does not pass for a complete run.
    short_scene(dir.path(), "");
    let steep = ["terrain.kind=ramp", "terrain.angle=-60 deg"];
    let mut command = robhaz(dir.path());
    command.args(["run", "short.toml", "--out", "steep"]);
    command.args(["--set", "record.duration=12"]);
    for set in steep {
        command.args(["--set", set]);
    }
    let said = text(&command.output().unwrap().stderr);
    let said = said.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(said.contains("short broke off at"), "{said}");
    let compared = robhaz(dir.path())
        .args(["compare", "steep.partial"])
        .output()
        .unwrap();
    let shown = text(&compared.stdout);
    assert!(
        shown.contains("steep.partial broke off at") && shown.contains("turned over"),
        "{shown}"
    );
}

/// Bad scenes: file, line, key, what was found, what is allowed.
#[test]
fn bad_scenes_are_told_apart() {
    let dir = tempfile::tempdir().unwrap();
    let cases = [
        (
            "\n[drive]\ntorque_limit = -3\n",
            ["short.toml", ":9", "drive.torque_limit", "-3", "above 0"],
        ),
        (
            "\n[drive]\nspeeed = 0.2\n",
            ["short.toml", ":9", "drive.speeed", "unknown", "speed"],
        ),
        (
            "\n[drive]\nspeed = \"2 kg\"\n",
            ["short.toml", ":9", "drive.speed", "kg", "m/s"],
        ),
        (
            "\n[wheels]\ncount = 6\n",
            ["short.toml", ":8", "wheels", "unknown", "robot"],
        ),
    ];
    for (extra, words) in cases {
        short_scene(dir.path(), extra);
        let output = robhaz(dir.path())
            .args(["run", "short.toml"])
            .output()
            .unwrap();
        assert!(!output.status.success());
        let said = text(&output.stderr);
        for word in words {
            assert!(said.contains(word), "{word} is missing in:\n{said}");
        }
        assert!(!dir.path().join("runs").exists());
    }
    let output = robhaz(dir.path())
        .args(["run", "nowhere.toml"])
        .output()
        .unwrap();
    assert!(text(&output.stderr).contains("nowhere.toml"));
}

/// `verify` prints a verdict a line and succeeds where all hold; a run that it cannot keep in memory is refused.
#[test]
fn verify_prints_a_verdict_a_line() {
    let dir = tempfile::tempdir().unwrap();
    short_scene(dir.path(), "");
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
    assert!(
        text(&output.stderr).contains("500000"),
        "{}",
        text(&output.stderr)
    );
}

/// A reader of `verify` that goes away is no error, and an engine that stops does not hide what the other found.
#[test]
fn verify_survives_its_reader_and_its_engines() {
    use std::io::Read;
    let dir = tempfile::tempdir().unwrap();
    short_scene(dir.path(), "");
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

/// A start that fails leaves no folder, and says why in one chain.
#[test]
fn a_start_that_fails_leaves_no_folder() {
    let dir = tempfile::tempdir().unwrap();
    short_scene(dir.path(), "");
    for (set, reason) in [
        ("robot.geometry.body_cg=[1.0, 0.3]", "tips forward"),
        (
            "drive.torque_limit=0.1",
            "finds no rest at its start: the motor of wheel",
        ),
    ] {
        let output = robhaz(dir.path())
            .args(["run", "short.toml", "--set", set])
            .args([
                "--set",
                "terrain.kind=heights",
                "--set",
                "terrain.interpolation=corners",
            ])
            .args(["--set", "terrain.points=[[-5, -1], [5, 1]]"])
            .output()
            .unwrap();
        assert!(!output.status.success());
        let said = text(&output.stderr);
        let said = said
            .split_whitespace()
            .filter(|w| *w != "│")
            .collect::<Vec<_>>()
            .join(" ");
        assert!(said.contains(reason), "{said}");
        assert!(!said.contains("broke off"), "{said}");
        assert!(!dir.path().join("runs").exists(), "{set}");
    }
}

/// A robot that is stuck is reported at the end of its run and in its summary.
#[test]
fn a_stuck_robot_is_reported() {
    let dir = tempfile::tempdir().unwrap();
    let scene = root().join("scenes/stairs.toml");
    let output = robhaz(dir.path())
        .args(["run", &scene.to_string_lossy(), "--engine", "direct"])
        .args([
            "--rerun",
            "off",
            "--out",
            "out",
            "--set",
            "record.duration=10",
        ])
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", text(&output.stderr));
    let shown = text(&output.stdout);
    assert!(
        shown.contains("stairs: the robot is STUCK since 6.2 s"),
        "{shown}"
    );
    let summary = fs::read_to_string(dir.path().join("out/summary.json")).unwrap();
    let summary: serde_json::Value = serde_json::from_str(&summary).unwrap();
    let since = summary["progress"]["stuck_since_s"].as_f64().unwrap();
    assert!((since - 6.2).abs() < 0.1, "{since}");
    assert_eq!(
        summary["progress"]["spinning_s"].as_array().unwrap().len(),
        3
    );
    // Wheels touch tread and riser at once, and spin against the riser.
    for event in ["two_contacts", "slips"] {
        assert!(summary["events"][event].as_u64().unwrap() > 0, "{event}");
    }
}

/// `--seed` and `--set` end up in the resolved scene and in the summary.
#[test]
fn seed_and_overrides_are_kept() {
    let dir = tempfile::tempdir().unwrap();
    short_scene(dir.path(), "");
    let output = robhaz(dir.path())
        .args([
            "run",
            "short.toml",
            "--seed",
            "42",
            "--set",
            "drive.kp=2",
            "--set",
            "record.duration=1",
        ])
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", text(&output.stderr));
    let run = dir.path().join("runs/short");
    assert!(
        fs::read_to_string(run.join("summary.json"))
            .unwrap()
            .contains("\"seed\": 42")
    );
    let resolved = robhaz_scene::Scene::load(&run.join("scene.toml"), &[]).unwrap();
    assert_eq!(resolved.seed, 42);
    assert!((resolved.drive.kp - 2.0).abs() < f64::EPSILON);
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

/// A slash at the end, an empty folder, a file, a run that broke off, a folder with something else beside the run.
#[test]
fn output_folders_are_told_apart() {
    let dir = tempfile::tempdir().unwrap();
    short_scene(dir.path(), "");
    let run = |out: &str, extra: &[&str]| {
        robhaz(dir.path())
            .args([
                "run",
                "short.toml",
                "--set",
                "record.duration=0.6",
                "--out",
                out,
            ])
            .args(extra)
            .output()
            .unwrap()
    };
    assert!(run("a/", &[]).status.success());
    assert!(dir.path().join("a/summary.json").exists());
    fs::create_dir(dir.path().join("empty")).unwrap();
    assert!(run("empty", &[]).status.success());
    fs::write(dir.path().join("file"), "x").unwrap();
    assert!(!run("file", &["--force"]).status.success());
    assert_eq!(fs::read_to_string(dir.path().join("file")).unwrap(), "x");

    // What broke off is kept until it is given up.
    fs::create_dir(dir.path().join("b.partial")).unwrap();
    fs::copy(
        dir.path().join("a/scene.toml"),
        dir.path().join("b.partial/scene.toml"),
    )
    .unwrap();
    let refused = run("b", &[]);
    assert!(
        text(&refused.stderr).contains("b.partial"),
        "{}",
        text(&refused.stderr)
    );
    assert!(run("b", &["--force"]).status.success());

    // A user's note in a run's folder, and a user's own scene, stop --force.
    fs::write(dir.path().join("a/note.txt"), "mine").unwrap();
    assert!(!run("a", &["--force"]).status.success());
    assert!(dir.path().join("a/note.txt").exists());
    fs::create_dir(dir.path().join("own")).unwrap();
    fs::write(dir.path().join("own/scene.toml"), "").unwrap();
    assert!(!run("own", &["--force"]).status.success());
    assert!(dir.path().join("own/scene.toml").exists());
}

/// Runs that leave what the simulation knows say so: a robot on its back, a start inside a bump.
#[test]
fn runs_out_of_range_stop_with_a_reason() {
    let dir = tempfile::tempdir().unwrap();
    short_scene(dir.path(), "");
    let run = |name: &str, sets: &[&str]| {
        let mut command = robhaz(dir.path());
        command.args([
            "run",
            "short.toml",
            "--out",
            name,
            "--set",
            "record.duration=12",
        ]);
        for set in sets {
            command.args(["--set", set]);
        }
        let output = command.output().unwrap();
        assert!(!output.status.success(), "{name}");
        // The report breaks lines where the terminal would.
        let said = text(&output.stderr);
        said.split_whitespace().collect::<Vec<_>>().join(" ")
    };
    for engine in ["engine.kind=rapier", "engine.kind=direct"] {
        for (start, bump, expected) in [
            ("raw", "{height=0.05, centre=0, width=0.2}", "must be level"),
            // Steeper than friction holds.
            (
                "settled",
                "{height=0.8, centre=0.5, width=0.5}",
                "finds no rest",
            ),
        ] {
            let sets = [
                "terrain.kind=bumps",
                &format!("terrain.bumps=[{bump}]"),
                &format!("engine.start={start}"),
                engine,
            ];
            let said = run(&format!("{start}-{engine}"), &sets);
            assert!(said.contains(expected), "{said}");
        }
        let steep = ["terrain.kind=ramp", "terrain.angle=-60 deg", engine];
        // Starts that fail leave no folder.
        assert!(fs::read_dir(dir.path()).unwrap().count() <= 2);
        let said = run(&format!("steep-{engine}"), &steep);
        assert!(said.contains("turned over"), "{said}");
    }
}

/// A study prints its table, says what was run, writes the same as JSON, and repeats to the bit.
#[test]
fn study_prints_a_table_and_writes_json() {
    let dir = tempfile::tempdir().unwrap();
    short_scene(dir.path(), "");
    let study = |json: &str| {
        let output = robhaz(dir.path())
            .args(["study", "short.toml", "--ladder", "--engine", "direct"])
            .args(["--set", "sensors.grade=typical", "--seeds", "5"])
            .args(["--json", json])
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
    assert_eq!(report["estimators"].as_array().unwrap().len(), 10);
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
            .args(["study", "short.toml", "--json", json])
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
        (vec!["--json", "nowhere/out.json"], "nowhere/out.json"),
    ];
    for (args, reason) in refused {
        let output = robhaz(dir.path())
            .args(["study", "short.toml"])
            .args(&args)
            .output()
            .unwrap();
        let told = text(&output.stderr);
        assert!(!output.status.success(), "{args:?}");
        assert!(told.contains(reason), "{args:?}: {told}");
    }
}

/// The folder of a run that a user has put something into is not replaced: not in `figures` either, nor where that is a link.
#[test]
fn force_removes_only_what_a_run_wrote() {
    let dir = tempfile::tempdir().unwrap();
    short_scene(dir.path(), "");
    let run = |out: &str| {
        let output = robhaz(dir.path())
            .args(["run", "short.toml", "--set", "record.duration=0.6"])
            .args(["--out", out, "--force"])
            .output()
            .unwrap();
        let said = text(&output.stderr).replace('│', " ");
        let said: Vec<&str> = said.split_whitespace().collect();
        (output.status.success(), said.join(" "))
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
    assert!(
        said.contains("file is a file, not the folder of a run"),
        "{said}"
    );
    fs::create_dir(dir.path().join("own")).unwrap();
    fs::write(dir.path().join("own/scene.toml"), "").unwrap();
    let said = run("own").1;
    assert!(
        said.contains("own has no scene.toml that a run has written"),
        "{said}"
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

/// A folder in which a run is writing is left alone, even with `--force`, and so is a target that appears during the run.
#[cfg(unix)]
#[test]
fn a_run_in_progress_is_left_alone() {
    let dir = tempfile::tempdir().unwrap();
    short_scene(dir.path(), "");
    let mut first = robhaz(dir.path())
        .args(["run", "short.toml", "--out", "a", "--pace", "real-time"])
        .stdout(std::process::Stdio::null())
        .stderr(std::process::Stdio::piped())
        .spawn()
        .unwrap();
    while !dir.path().join("a.partial/truth.arrows").exists() {
        assert!(first.try_wait().unwrap().is_none());
        std::thread::sleep(std::time::Duration::from_millis(10));
    }
    let second = robhaz(dir.path())
        .args(["run", "short.toml", "--out", "a", "--force"])
        .output()
        .unwrap();
    let said = text(&second.stderr);
    assert!(said.contains("another run is writing"), "{said}");
    let recovered = robhaz(dir.path())
        .args(["recover", "a.partial"])
        .output()
        .unwrap();
    let said = text(&recovered.stderr);
    assert!(said.contains("a run is writing"), "{said}");
    fs::create_dir(dir.path().join("a")).unwrap();
    fs::write(dir.path().join("a/mine"), "years").unwrap();
    let ended = first.wait_with_output().unwrap();
    assert!(!ended.status.success());
    let said = text(&ended.stderr);
    assert!(said.contains("the complete run is in a.partial"), "{said}");
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
    let dir = tempfile::tempdir().unwrap();
    short_scene(dir.path(), "");
    fs::create_dir_all(dir.path().join("disk/results")).unwrap();
    std::os::unix::fs::symlink("disk/results", dir.path().join("a")).unwrap();
    let output = robhaz(dir.path())
        .args(["run", "short.toml", "--out", "a"])
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", text(&output.stderr));
    assert!(dir.path().join("a").is_symlink());
    assert!(dir.path().join("disk/results/summary.json").exists());
}

/// The last line says how long the command took, beside what the simulation took of it.
#[test]
fn the_last_line_tells_the_time_of_the_whole_command() {
    let dir = tempfile::tempdir().unwrap();
    short_scene(dir.path(), "");
    let output = robhaz(dir.path())
        .args(["run", "short.toml"])
        .output()
        .unwrap();
    let shown = text(&output.stdout);
    let last = shown.lines().last().unwrap();
    let numbers: Vec<f64> = last
        .split_whitespace()
        .filter_map(|word| word.parse().ok())
        .collect();
    let [whole, simulation] = numbers[..] else {
        panic!("{last}");
    };
    assert!(last.contains("the whole command took"), "{last}");
    // Rounded to 0.01 s each.
    assert!(whole + 0.02 > simulation && simulation > 0.0, "{last}");
}
