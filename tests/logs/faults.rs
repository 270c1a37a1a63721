//! Faults of logs: what is usable is estimated and counted, the rest is an error with its place.

use super::recorded::{changed, estimate, estimated, place_of, recorded, refused, rewritten};
use crate::support::{assert_contains, robhaz, succeeded, summary};
use std::path::Path;

/// A log of a run at rest and slow, as lines of text: the names, then the rows.
fn lines(run: &Path) -> Vec<String> {
    let text = std::fs::read_to_string(run.join("sensors.csv")).unwrap();
    text.lines().map(str::to_owned).collect()
}

/// Lost rows, repeated rows, late rows and a row that is cut are reported and counted; the rest is
/// estimated.
#[test]
fn faults_that_leave_the_rest_usable_are_counted() {
    let (folder, run) = recorded("csv", &[]);
    let mut rows = lines(&run);
    // One in a hundred is lost, one is repeated, one comes late, the last is cut.
    rows.swap(501, 502);
    rows.insert(301, rows[300].clone());
    let kept: Vec<&String> = rows
        .iter()
        .enumerate()
        .filter(|(i, _)| *i < 600 || i % 100 != 50)
        .map(|(_, row)| row)
        .collect();
    let mut text = kept
        .iter()
        .fold(String::new(), |text, row| text + row + "\n");
    text.truncate(text.len() - 30);
    std::fs::write(folder.path().join("log.csv"), text).unwrap();
    let printed = estimated(folder.path(), &["log.csv"]);
    assert_contains(&printed, "CUT OFF");
    let found = summary(&folder.path().join("runs/log-estimate"));
    let channel = &found["log"]["channels"][0];
    assert_eq!(channel["duplicates"], 1);
    assert_eq!(channel["late"], 1);
    // 19 rows that were left out, and the row whose place is taken by the late one.
    assert_eq!(channel["lost"], 20);
    assert!(
        channel["cut_off"].as_str().unwrap().contains("line 2484"),
        "{channel}"
    );
}

/// A name of two columns is refused with its line and column; whichever of them counted, the other
/// would be lost in silence. Comments and empty lines are no rows and no names, and lines are
/// counted with them. A pipe is refused, not waited for.
#[test]
fn the_head_of_a_table_is_checked() {
    let (folder, run) = recorded("csv", &[]);
    let rows = lines(&run);
    let write = |name: &str, rows: &[String]| {
        let text = rows.iter().fold(String::new(), |t, row| t + row + "\n");
        std::fs::write(folder.path().join(name), text).unwrap();
    };
    let mut twice = rows.clone();
    twice[0] += ",wheel1_angle";
    twice[1..].iter_mut().for_each(|row| *row += ",0");
    write("twice.csv", &twice);
    let error = refused(folder.path(), &["twice.csv"]);
    let place = "line 1, column 17: found the name wheel1_angle again";
    assert_contains(&error, place);
    assert_contains(&error, "column 2 has it");

    let mut commented = rows.clone();
    commented.insert(0, "# rover 7, \"gravel\"".to_owned());
    commented.insert(1, String::new());
    commented.insert(700, "# bump".to_owned());
    write("commented.csv", &commented);
    write("plain.csv", &rows);
    for log in ["commented", "plain"] {
        estimated(folder.path(), &[&format!("{log}.csv"), "--format", "csv"]);
    }
    let [a, b] =
        ["commented", "plain"].map(|log| format!("runs/{log}-estimate/estimate-kalman.csv"));
    let read = |name: String| std::fs::read(folder.path().join(name)).unwrap();
    assert!(read(a) == read(b));
    commented[800] = "abc".to_owned() + &commented[800];
    write("commented.csv", &commented);
    let error = refused(folder.path(), &["commented.csv"]);
    assert_contains(&error, "line 801, column time");
    commented[2] = format!("# {}", commented[2]);
    write("commented.csv", &commented);
    let error = refused(folder.path(), &["commented.csv"]);
    assert_contains(&error, "line 4 has numbers, not names");
    #[cfg(unix)]
    {
        let pipe = folder.path().join("pipe.csv");
        let made = std::process::Command::new("mkfifo").arg(&pipe).status();
        assert!(made.unwrap().success());
        let error = refused(folder.path(), &["pipe.csv"]);
        assert_contains(&error, "pipe.csv: found a folder, pipe or device");
    }
}

/// A table of `--truth` that no row can be compared with is refused with the reason, and one that
/// lacks some rows says how many count. Without it the same log is estimated.
#[test]
fn a_truth_that_cannot_be_used_says_why() {
    let (folder, run) = recorded("csv", &[]);
    let table = run.join("truth.csv");
    let column = place_of(&table, "wheel2_normal_force");
    // The time of each row, and whether its cell of N is empty.
    let write = |name: &str, row: &dyn Fn(f64) -> Option<(f64, bool)>| {
        rewritten(&table, &folder.path().join(name), |_, cells| {
            let Some((time, is_empty)) = row(cells[0].parse().unwrap()) else {
                return false;
            };
            cells[0] = time.to_string();
            if is_empty {
                cells[column].clear();
            }
            true
        });
    };
    write("empty.csv", &|time| Some((time, true)));
    write("late.csv", &|time| Some((time + 100.0, false)));
    write("early.csv", &|time| (time < 0.5).then_some((time, false)));
    write("some.csv", &|time| Some((time, time < 1.5)));
    for (truth, parts) in [
        (
            "empty.csv",
            [
                "no row can be compared with",
                "no number for wheel2_normal_force in 2501",
            ],
        ),
        ("late.csv", ["no row in common", "offset"]),
        (
            "early.csv",
            [
                "from 0.000 to 0.499 s after the start",
                "record.compare_from = 1 s",
            ],
        ),
    ] {
        let error = refused(
            folder.path(),
            &["run", "--truth", truth, "--out", "refused"],
        );
        for part in parts.iter().chain(&[truth]) {
            assert!(error.contains(part), "{truth}: {part}: {error}");
        }
        assert!(!folder.path().join("refused").exists());
    }
    // The unit in a name is read, and one of no force is refused.
    let in_unit = |name: &str, unit: &str, size: f64| {
        let is_force = |name: &str| name.ends_with("_normal_force") || name.ends_with("_traction");
        let with_unit = |name: &str| match is_force(name) {
            true => format!("{name} [{unit}]"),
            false => name.to_owned(),
        };
        let path = folder.path().join(name);
        changed(&table, &path, is_force, |_, force| force / size);
        let out = std::fs::read_to_string(&path).unwrap();
        let (head, rows) = out.split_once('\n').unwrap();
        let head: Vec<String> = head.split(',').map(with_unit).collect();
        std::fs::write(path, head.join(",") + "\n" + rows).unwrap();
    };
    let errors = |truth: &str| {
        let out = ["--out", "compared", "--force", "--estimator", "kalman"];
        let args = [&["run", "--truth", truth], &out[..]].concat();
        let output = super::recorded::estimate(folder.path(), &args);
        assert!(output.status.success(), "{truth}");
        let summary = summary(&folder.path().join("compared"));
        summary["estimators"]["kalman"]["normal_force"].clone()
    };
    in_unit("newton.csv", "N", 1.0);
    in_unit("kilonewton.csv", "kN", 1000.0);
    in_unit("volt.csv", "V", 1.0);
    let expected = errors("run/truth.csv");
    assert_eq!(errors("newton.csv"), expected);
    let found = errors("kilonewton.csv")["nrmse"].as_f64();
    let found = found.zip(expected["nrmse"].as_f64());
    // Rounding.
    assert!(found.is_some_and(|(a, b)| (a / b - 1.0).abs() < 1e-9));
    let error = refused(
        folder.path(),
        &["run", "--truth", "volt.csv", "--out", "refused"],
    );
    assert_contains(&error, "has the unit V, allowed: N or kN");
    let output = super::recorded::estimate(folder.path(), &["run", "--truth", "some.csv"]);
    let said = crate::support::text(&output.stderr);
    assert!(output.status.success(), "{said}");
    assert_contains(&said, "for wheel2_normal_force in 1500");
    assert!(crate::support::text(&output.stdout).contains("Errors count from 1 s on"));
}

/// A recording that was killed: an MCAP file without its end. All that is there is estimated, and
/// it is reported.
#[test]
fn a_killed_recording_is_estimated_as_far_as_it_goes() {
    let (folder, _) = recorded("parquet", &[]);
    let mut export = robhaz(folder.path());
    assert!(
        export
            .args(["export", "run", "--to", "mcap"])
            .status()
            .unwrap()
            .success()
    );
    let whole = std::fs::read(folder.path().join("run.mcap")).unwrap();
    std::fs::write(
        folder.path().join("cut.mcap"),
        &whole[..whole.len() * 7 / 10],
    )
    .unwrap();
    let printed = estimated(folder.path(), &["cut.mcap"]);
    assert_contains(&printed, "CUT OFF");
    assert_contains(&printed, "was killed");
    let rows = summary(&folder.path().join("runs/cut-estimate"))["log"]["channels"][0]["rows"]
        .as_u64()
        .unwrap();
    assert!((1000..2501).contains(&rows), "{rows}");
}

/// A table of estimates with a fault in its middle is left out of an export and named; the rest is
/// whole.
#[test]
fn a_faulty_table_is_left_out_of_an_export() {
    let (folder, run) = recorded("csv", &[]);
    let path = run.join("estimate-kalman.csv");
    let column = place_of(&path, "wheel2_normal_force");
    rewritten(&path, &path, |row, cells| {
        if row == 999 {
            "suspect".clone_into(&mut cells[column]);
        }
        true
    });
    for format in ["csv", "mcap"] {
        let output = succeeded(robhaz(folder.path()).args(["export", "run", "--to", format]));
        let said = crate::support::text(&output.stderr);
        let place = "left out: run/estimate-kalman.csv, line 1001, column wheel2_normal_force: found \"suspect";
        assert_contains(&said, place);
        let parts = crate::support::text(&output.stdout);
        assert!(
            parts.contains("2501 rows") && parts.contains("truth") && !parts.contains("kalman "),
            "{parts}"
        );
    }
}

/// A log without any estimate is not said to be one without truth. Its page tells the log and its
/// description.
#[test]
fn a_log_without_an_estimate_says_so() {
    let (folder, run) = recorded("csv", &[]);
    let (readings, upside) = (run.join("sensors.csv"), folder.path().join("upside.csv"));
    // No linkage closes at 3 rad.
    changed(
        &readings,
        &upside,
        |name| name == "link1_inclination",
        |_, _| 3.0,
    );
    let truth = ["upside.csv", "--truth", "run/truth.csv"];
    let output = estimate(
        folder.path(),
        &[&truth[..], &["--estimator", "paper-body"]].concat(),
    );
    assert!(!output.status.success());
    let said = String::from_utf8_lossy(&output.stdout);
    assert_contains(&said, "No estimator has an estimate");
    assert!(!said.contains("Without truth"), "{said}");
    succeeded(robhaz(folder.path()).args(["report", "runs/upside-estimate"]));
    let page = folder.path().join("runs/upside-estimate/report.html");
    let page = std::fs::read_to_string(page).unwrap();
    for part in ["How it was made", "upside.csv", "[budget]"] {
        assert!(page.contains(part), "{part}");
    }
}
