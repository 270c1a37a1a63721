//! The command `robhaz run`: what it leaves behind, and what it says when a run breaks off.

use crate::support::{
    assert_contains, on_one_line, refused, robhaz, root, short_scene, succeeded, summary, text,
    words, write_short_scene,
};
use std::fs;

/// One run leaves everything that was promised, and says where.
#[test]
fn run_leaves_tables_figures_summary_and_scene() {
    let dir = short_scene();
    let output = succeeded(robhaz(dir.path()).args(["run", "short.toml"]));
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
        "figures/path.svg",
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

    let summary = summary(&run);
    assert_eq!(summary["scene"], "short");
    assert_eq!(summary["engine"], "rapier");
    assert_eq!(summary["seed"], 0);
    assert_eq!(summary["duration_s"], 1.5);
    let error = &summary["estimators"]["true-mass"]["normal_force"];
    assert_eq!(error["rmse"].as_array().unwrap().len(), 3);
    // Statics with true masses, nearly at rest on level ground: a thousandth of the load is far
    // more than the start leaves.
    assert!(error["nrmse"].as_f64().unwrap() < 1e-2, "{error}");

    let compared = succeeded(robhaz(dir.path()).args(["compare", "runs/short"]));
    assert!(text(&compared.stdout).contains("paper-wheels"));
}

/// Several scenes run one after the other, each into its folder; two with one name are refused
/// before the first runs.
#[test]
fn several_scenes_run_one_after_the_other() {
    let dir = short_scene();
    let short = std::fs::read_to_string(dir.path().join("short.toml")).unwrap();
    std::fs::write(dir.path().join("other.toml"), &short).unwrap();
    let run = |files: [&str; 2]| {
        let mut command = robhaz(dir.path());
        command.arg("run").args(files).args(["--out", "both"]);
        command
    };
    std::fs::write(
        dir.path().join("same.toml"),
        format!("name = \"short\"\n{short}"),
    )
    .unwrap();
    let message = refused(&mut run(["short.toml", "same.toml"]));
    assert_contains(message, "the same name");
    assert!(!dir.path().join("both").exists());
    succeeded(&mut run(["short.toml", "other.toml"]));
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

/// The page of a run belongs to its folder: it is written once, and does not keep the run from
/// being replaced.
#[test]
fn a_run_has_a_page() {
    let dir = short_scene();
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

/// What a run resolved can be run again, and gives the same tables to the bit; so does the scene
/// itself.
#[test]
fn the_resolved_scene_runs_again_to_the_same_bits() {
    let dir = short_scene();
    for (scene, out) in [("short.toml", "first"), ("first/scene.toml", "second")] {
        succeeded(robhaz(dir.path()).args([
            "run",
            scene,
            "--out",
            out,
            "--set",
            "record.duration=1",
        ]));
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
    // The robot drives over the edge of a drop and turns over.
    let scene = "[terrain]\nkind = \"step\"\nstart = 0.45\nkerb = -5\n\n[drive]\nspeed = 0.5\nstart_time = 0\n\n\
                 [engine]\nstart = \"raw\"\n\n[record]\nduration = 3.5\ncompare_from = 3\n";
    fs::write(dir.path().join("short.toml"), scene).unwrap();
    let said = refused(robhaz(dir.path()).args(["run", "short.toml", "--format", "csv"]));
    assert_contains(&said, "has turned over");
    assert_contains(&said, "short.partial");
    assert!(!dir.path().join("runs/short").exists());
    let table = fs::read_to_string(dir.path().join("runs/short.partial/truth.csv")).unwrap();
    assert!(table.starts_with("time,"));
    // It is compared, and does not pass for a complete run.
    write_short_scene(dir.path(), "");
    let steep = ["terrain.kind=ramp", "terrain.angle=-60 deg"];
    let mut command = robhaz(dir.path());
    command.args(["run", "short.toml", "--out", "steep"]);
    command.args(["--set", "record.duration=12"]);
    for set in steep {
        command.args(["--set", set]);
    }
    let said = on_one_line(refused(&mut command).as_bytes());
    assert_contains(&said, "short broke off at");
    let mut compare = robhaz(dir.path());
    let shown = text(&succeeded(compare.args(["compare", "steep.partial"])).stdout);
    assert_contains(&shown, "steep.partial broke off at");
    assert_contains(&shown, "turned over");
}

/// A robot that is stuck is reported at the end of its run and in its summary.
#[test]
fn a_stuck_robot_is_reported() {
    let dir = tempfile::tempdir().unwrap();
    let scene = root().join("scenes/stairs.toml");
    let output = succeeded(
        robhaz(dir.path())
            .args(["run", &scene.to_string_lossy(), "--engine", "direct"])
            .args(words(
                "--rerun off --out out --set record.duration=10 --set robot.geometry=A",
            )),
    );
    let shown = text(&output.stdout);
    assert_contains(&shown, "stairs: the robot is STUCK since 6.2 s");
    let summary = summary(&dir.path().join("out"));
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
    let dir = short_scene();
    succeeded(robhaz(dir.path()).args(words(
        "run short.toml --seed 42 --set drive.kp=2 --set record.duration=1",
    )));
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

/// Runs that leave what the simulation knows say so: a robot on its back, a start inside a bump.
#[test]
fn runs_out_of_range_stop_with_a_reason() {
    let dir = short_scene();
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
        on_one_line(refused(&mut command).as_bytes())
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
            assert_contains(&said, expected);
        }
        let steep = ["terrain.kind=ramp", "terrain.angle=-60 deg", engine];
        // Starts that fail leave no folder.
        assert!(fs::read_dir(dir.path()).unwrap().count() <= 2);
        let said = run(&format!("steep-{engine}"), &steep);
        assert_contains(&said, "turned over");
    }
}

/// The last line says how the run is seen, the one before it how long the command took, beside what
/// the simulation took of it.
#[test]
fn the_last_lines_tell_the_time_of_the_whole_command_and_how_to_see_the_run() {
    let dir = short_scene();
    let output = succeeded(robhaz(dir.path()).args(["run", "short.toml"]));
    let shown = text(&output.stdout);
    let mut lines = shown.lines().rev();
    if cfg!(feature = "viewer") {
        let see = lines.next().unwrap();
        assert!(
            see.starts_with("See it with `robhaz view runs/short`"),
            "{see}"
        );
    }
    let last = lines.next().unwrap();
    let numbers: Vec<f64> = last
        .split_whitespace()
        .filter_map(|word| word.parse().ok())
        .collect();
    let [whole, simulation] = numbers[..] else {
        panic!("{last}");
    };
    assert_contains(last, "the whole command took");
    // Rounded to 0.01 s each.
    assert!(whole + 0.02 > simulation && simulation > 0.0, "{last}");
}
