//! The command as a user types it: runs, comparisons, verification.

use crate::support::{robhaz, root, short_scene, text};
use std::fs;

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

/// A new scene is that of the defaults with three of the five estimators; it is not written over another file.
#[test]
fn a_new_scene_runs_with_the_defaults() {
    let dir = tempfile::tempdir().unwrap();
    let new = |name: &str| robhaz(dir.path()).args(["new", name]).output().unwrap();
    assert!(new("mine").status.success());
    let again = new("mine.toml");
    assert!(!again.status.success() && text(&again.stderr).contains("mine.toml exists"));
    let made = robhaz_scene::Scene::load(&dir.path().join("mine.toml"), &[]).unwrap();
    assert!(made.warnings().is_empty());
    let labels: Vec<&str> = made.estimators.iter().map(|e| e.name.as_str()).collect();
    assert_eq!(labels, ["paper-wheels", "best", "no-angles"]);
    let default = robhaz_scene::Scene {
        name: made.name.clone(),
        estimators: made.estimators.clone(),
        ..Default::default()
    };
    assert_eq!(made.to_toml("x"), default.to_toml("x"));
}

/// Every key is explained, by part of its name or meaning; a shell gets its completions and `man` its page.
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
    assert!(text(&done(&["man"]).stdout).contains("ROBHAZ RUN"));
}

/// Several scenes run one after the other, each into its folder; two with one name are refused before the first runs.
#[test]
fn several_scenes_run_one_after_the_other() {
    let dir = tempfile::tempdir().unwrap();
    short_scene(dir.path(), "");
    let short = std::fs::read_to_string(dir.path().join("short.toml")).unwrap();
    std::fs::write(dir.path().join("other.toml"), &short).unwrap();
    let run = |files: [&str; 2]| {
        let mut command = robhaz(dir.path());
        command.arg("run").args(files).args(["--out", "both"]);
        command.output().unwrap()
    };
    std::fs::write(
        dir.path().join("same.toml"),
        format!("name = \"short\"\n{short}"),
    )
    .unwrap();
    let refused = run(["short.toml", "same.toml"]);
    let message = text(&refused.stderr);
    assert!(
        !refused.status.success() && message.contains("the same name"),
        "{message}"
    );
    assert!(!dir.path().join("both").exists());
    let done = run(["short.toml", "other.toml"]);
    assert!(done.status.success(), "{}", text(&done.stderr));
    for name in ["short", "other"] {
        assert!(
            dir.path()
                .join("both")
                .join(name)
                .join("summary.json")
                .is_file()
        );
    }
}

/// The page of a run belongs to its folder: it is written once, and does not keep the run from being replaced.
#[test]
fn a_run_has_a_page() {
    let dir = tempfile::tempdir().unwrap();
    short_scene(dir.path(), "");
    let done = |args: &[&str]| {
        let output = robhaz(dir.path()).args(args).output().unwrap();
        (output.status.success(), text(&output.stderr))
    };
    let run = ["run", "short.toml", "--out", "a", "--force"];
    assert_eq!(done(&run), (true, String::new()));
    assert!(done(&["report", "a"]).0);
    let page = std::fs::read_to_string(dir.path().join("a/report.html")).unwrap();
    assert!(page.starts_with("<!DOCTYPE html>") && page.ends_with("</html>"));
    assert!(page.contains("compare_from = 0.5"));
    let (again, message) = done(&["report", "a"]);
    assert!(!again && message.contains("--force"), "{message}");
    assert!(done(&["report", "a", "--force"]).0);
    assert_eq!(done(&run), (true, String::new()));
    assert!(!dir.path().join("a/report.html").exists());
}

/// The comparison in other forms: the numbers of `summary.json`, the same in all of them.
#[test]
fn runs_are_compared_in_the_form_that_is_asked_for() {
    let dir = tempfile::tempdir().unwrap();
    short_scene(dir.path(), "");
    let run = robhaz(dir.path())
        .args(["run", "short.toml", "--out", "a|b"])
        .output()
        .unwrap();
    assert!(run.status.success(), "{}", text(&run.stderr));
    let shown = |format: &str| {
        let output = robhaz(dir.path())
            .args(["compare", "a|b", "--format", format])
            .output()
            .unwrap();
        assert!(output.status.success(), "{}", text(&output.stderr));
        text(&output.stdout)
    };
    let summary = std::fs::read_to_string(dir.path().join("a|b/summary.json")).unwrap();
    let summary: serde_json::Value = serde_json::from_str(&summary).unwrap();
    let rows: Vec<serde_json::Value> = serde_json::from_str(&shown("json")).unwrap();
    let csv = shown("csv");
    let mut reader = csv::Reader::from_reader(csv.as_bytes());
    let header = reader.headers().unwrap().clone();
    let records: Vec<csv::StringRecord> = reader.records().map(Result::unwrap).collect();
    assert_eq!(rows.len(), records.len());
    for (row, record) in rows.iter().zip(&records) {
        assert_eq!(row["run"], "a|b");
        let errors = &summary["estimators"][row["estimator"].as_str().unwrap()];
        let force = &errors["normal_force"];
        assert_eq!(row["rmse"], force["rmse_all"]);
        assert_eq!(row["bias_wheel2"], force["bias"][1]);
        assert_eq!(row["largest_error_time"], force["max_abs_time_s"]);
        assert_eq!(row["coverage"], errors["coverage"]);
        assert_eq!(row.as_object().unwrap().len(), header.len());
        for (name, field) in header.iter().zip(record) {
            match &row[name] {
                serde_json::Value::Null => assert_eq!(field, "", "{name}"),
                serde_json::Value::String(value) => assert_eq!(field, value),
                number => assert_eq!(field.parse::<f64>().ok(), number.as_f64(), "{name}"),
            }
        }
    }
    let markdown = shown("markdown");
    let columns = |line: &str| line.replace("\\|", "").matches('|').count();
    let lines: Vec<usize> = markdown.lines().map(columns).collect();
    assert_eq!(lines, vec![header.len() + 1; rows.len() + 2], "{markdown}");
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
            "--set",
            "robot.geometry=A",
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
