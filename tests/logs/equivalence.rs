//! A recorded run gives the estimates and errors of the run, in every format.

use super::recorded::{ESTIMATES, assert_same_files, estimate, estimated, recorded};
use crate::support::{assert_contains, robhaz, root, succeeded, summary, text};

/// Equivalence: the folder of a run, its table alone, and the estimate's own folder give the run's
/// estimates to the bit, as Parquet and as CSV, with lost readings and model errors.
#[test]
fn a_recorded_run_gives_its_own_estimates_to_the_bit() {
    for format in ["parquet", "csv"] {
        let (folder, run) = recorded(format, &[]);
        let names: Vec<String> = ["sensors".to_owned()]
            .into_iter()
            .chain(ESTIMATES.map(|e| format!("estimate-{e}")))
            .map(|name| format!("{name}.{format}"))
            .collect();
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        let printed = estimated(folder.path(), &["run", "--format", format]);
        assert_contains(&printed, "Results in runs/run-estimate");
        let first = folder.path().join("runs/run-estimate");
        assert_same_files(&run, &first, &names);
        // The folder of an estimate is a log as well.
        estimated(
            folder.path(),
            &["runs/run-estimate", "--format", format, "--out", "again"],
        );
        assert_same_files(&run, &folder.path().join("again"), &names);
        // The table alone, with the description that the estimate left.
        let alone = format!("run/sensors.{format}");
        let args = [alone.as_str(), "--sensors", "runs/run-estimate/log.toml"];
        let more = ["--format", format, "--out", "alone"];
        estimated(folder.path(), &[&args[..], &more[..]].concat());
        assert_same_files(&run, &folder.path().join("alone"), &names);
        assert!(
            folder
                .path()
                .join("alone/figures/fig7_paper-body.svg")
                .is_file()
        );
        assert!(!folder.path().join("alone/figures/path.svg").exists());
    }
}

/// Equivalence: with the truth of the run the summary has the run's errors, digit for digit;
/// without it means, which add up to the weight of the robot, and counts of the records.
#[test]
fn truth_gives_the_errors_of_the_run() {
    let (folder, run) = recorded("parquet", &[]);
    estimated(folder.path(), &["run", "--truth", "run/truth.parquet"]);
    let (expected, found) = (
        summary(&run),
        summary(&folder.path().join("runs/run-estimate")),
    );
    for name in ESTIMATES {
        let (expected, found) = (&expected["estimators"][name], &found["estimators"][name]);
        for key in [
            "normal_force",
            "traction",
            "coverage",
            "nees",
            "samples",
            "missing",
        ] {
            assert_eq!(expected[key], found[key], "{name} {key}");
        }
        assert!(found["normal_force"]["rmse_all"].as_f64().unwrap() > 0.0);
    }

    estimated(folder.path(), &["run", "--force"]);
    let found = summary(&folder.path().join("runs/run-estimate"));
    let best = &found["estimators"]["kalman"];
    assert!(best["normal_force"].is_null());
    // 1 s to 2.5 s at 1 kHz.
    assert_eq!(best["samples"], 1501);
    let sum: f64 = (0..3)
        .map(|i| best["means"]["normal_force"][i].as_f64().unwrap())
        .sum();
    // 14 kg on rolling ground: the vertical acceleration is small.
    assert!((sum - 14.0 * 9.81).abs() < 3.0, "{sum}");
    assert_eq!(found["log"]["channels"][0]["rows"], 2501);
    assert!(found["log"]["missing"]["link1_rate"].as_u64().unwrap() > 0);
}

/// A run that records every tenth reading only cannot be repeated: it is reported, and estimated
/// from what there is.
#[test]
fn a_run_with_unrecorded_readings_is_reported() {
    let (folder, _) = recorded("parquet", &["record.rate=100"]);
    let output = estimate(folder.path(), &["run"]);
    assert!(output.status.success());
    let warning = text(&output.stderr);
    assert_contains(&warning, "recorded every 10th reading only");
}

/// An exported MCAP file says which robot drove and what is known of its sensors: without a
/// description it gives the run's estimates to the bit, here those of another robot than robot A. A
/// CSV file cannot say so, and the command warns.
#[test]
fn an_exported_log_carries_its_robot() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let scene = root().join("robots/exomy.toml");
    let run = |args: &[&str]| {
        let output = succeeded(robhaz(at).args(args));
        text(&output.stderr).to_owned()
    };
    let short = ["--engine", "direct", "--set", "record.duration=3"];
    let out = ["--rerun", "off", "--out", "run"];
    run(&[&["run", scene.to_str().unwrap()], &short[..], &out].concat());
    assert_eq!(run(&["export", "run", "--to", "mcap"]), "");
    let warning = run(&["export", "run", "--to", "csv"]);
    assert_contains(&warning, "no place for the robot");
    estimated(at, &["run.mcap", "--out", "mcap"]);
    assert_same_files(
        &at.join("run"),
        &at.join("mcap"),
        &["estimate-kalman.parquet"],
    );
    let [ours, theirs] = ["run.mcap", "run.csv"].map(|log| {
        let output = robhaz(at).args(["check", log]).output().unwrap();
        text(&output.stdout).contains("robot A")
    });
    assert!(!ours && theirs);
}

/// Equivalence: MCAP and CSV as exported give the run's estimates to the bit.
#[test]
fn exported_logs_give_the_same_estimates() {
    let (folder, run) = recorded("parquet", &[]);
    let names = ESTIMATES.map(|e| format!("estimate-{e}.parquet"));
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    for format in ["mcap", "csv"] {
        let output = succeeded(robhaz(folder.path()).args(["export", "run", "--to", format]));
        assert_contains(text(&output.stdout), "2501 rows");
        estimated(folder.path(), &["run", "--out", "direct", "--force"]);
        let log = format!("run.{format}");
        let args = [
            log.as_str(),
            "--sensors",
            "direct/log.toml",
            "--out",
            format,
        ];
        estimated(folder.path(), &args);
        assert_same_files(&run, &folder.path().join(format), &names);
        let again = robhaz(folder.path())
            .args(["export", "run", "--to", format])
            .output()
            .unwrap();
        assert_contains(text(&again.stderr), "exists");
    }
}

/// What an estimate of a log leaves of its forces beside the tables: the needed friction, which is
/// T/N for estimators without Kalman filters, in the exported table and as a figure; and on the
/// page of `robhaz report` means, needed friction, flags and health in place of errors.
#[test]
fn the_results_of_a_log_show_needed_friction_flags_and_health() {
    let (folder, _) = recorded("csv", &[]);
    estimated(folder.path(), &["run", "--out", "log", "--format", "csv"]);
    let done = |args: &[&str]| succeeded(robhaz(folder.path()).args(args));
    done(&["export", "log", "--to", "csv"]);
    let mut exported = csv::Reader::from_path(folder.path().join("log.csv")).unwrap();
    let names = exported.headers().unwrap().clone();
    let column = |name: &str| names.iter().position(|n| n == name).unwrap();
    let [force, traction, needed] = ["normal_force", "traction", "needed_friction"]
        .map(|c| column(&format!("paper-body.wheel2_{c}")));
    column("kalman.wheel2_needed_friction_sigma");
    for row in exported.records() {
        let row = row.unwrap();
        let number = |k: usize| row[k].parse::<f64>().ok();
        let expected = number(traction)
            .zip(number(force))
            .filter(|(_, n)| *n >= 1.0);
        let found = number(needed).zip(expected).map(|(f, (t, n))| f - t / n);
        assert!(found.is_none_or(|d| d == 0.0) && number(needed).is_some() == expected.is_some());
    }

    done(&["report", "log"]);
    let page = std::fs::read_to_string(folder.path().join("log/report.html")).unwrap();
    assert!(!page.contains("Errors of the estimators"));
    let found = summary(&folder.path().join("log"));
    let means = &found["estimators"]["kalman"]["means"];
    let number = |key: &str| means[key][1].as_f64().unwrap();
    let [normal, sigma] = ["normal_force", "normal_force_sigma"].map(number);
    let [needed, most] = ["needed_friction", "largest_needed_friction"].map(number);
    for part in [
        "Means of the estimates",
        "flags and health",
        "<th>reading missing, %</th>",
        &format!("<td>{normal:.2} {:>6}</td>", format!("{sigma:.2}")),
        &format!("<td>{needed:.3} ({most:.3})</td>"),
    ] {
        assert!(page.contains(part), "{part}");
    }
}

/// A table of forces that is cut is left out of an export and named; readings and the other forces
/// are written.
#[test]
fn a_cut_table_of_forces_is_left_out_of_an_export() {
    let (folder, run) = recorded("parquet", &[]);
    let truth = std::fs::read(run.join("truth.parquet")).unwrap();
    std::fs::write(run.join("truth.parquet"), &truth[..truth.len() / 2]).unwrap();
    for to in ["csv", "mcap"] {
        let output = succeeded(robhaz(folder.path()).args(["export", "run", "--to", to]));
        let said = text(&output.stderr);
        assert_contains(&said, "left out: run/truth.parquet cannot be read");
        let printed = text(&output.stdout);
        assert_contains(&printed, "2501 rows");
        assert_contains(&printed, "kalman");
        assert!(!printed.contains("truth"), "{printed}");
    }
}
