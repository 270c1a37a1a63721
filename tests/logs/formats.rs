//! The same faults in each format: lost rows, a recording that was killed, tables with clocks of
//! their own.

use super::recorded::{estimated, recorded, refused};
use crate::support::{assert_contains, robhaz, summary};
use std::fmt::Write as _;
use std::path::Path;

fn exported(folder: &Path, run: &str, out: &str) {
    let mut export = robhaz(folder);
    export.args(["export", run, "--to", "mcap", "--out", out]);
    assert!(export.status().unwrap().success());
}

/// `summary.json` of an estimate with `kalman`, compared with the truth of the run.
fn compared(folder: &Path, log: &str, out: &str, args: &[&str]) -> serde_json::Value {
    let truth = ["--truth", "run/truth.csv", "--estimator", "kalman"];
    let fixed: [&[&str]; 3] = [&[log, "--out", out], &truth, args];
    estimated(folder, &fixed.concat());
    summary(&folder.join(out))
}

fn nrmse(summary: &serde_json::Value) -> f64 {
    summary["estimators"]["kalman"]["normal_force"]["nrmse"]
        .as_f64()
        .unwrap()
}

/// One row of a hundred is lost: the estimates are the same bits from CSV, Parquet and MCAP, each
/// of which counts the rows, and as accurate as those of the whole log.
#[test]
fn lost_rows_cost_no_accuracy_in_any_format() {
    let (folder, run) = recorded("csv", &["sensors.dropped=0"]);
    let folder = folder.path();
    let text = std::fs::read_to_string(run.join("sensors.csv")).unwrap();
    let lost = text.lines().enumerate().filter(|(i, _)| i % 100 != 50);
    let lost = lost.fold(String::new(), |text, (_, row)| text + row + "\n");
    std::fs::write(folder.join("log.csv"), lost).unwrap();
    let whole = nrmse(&compared(folder, "run/sensors.csv", "whole", &[]));
    let of_csv = compared(folder, "log.csv", "of-csv", &[]);
    exported(folder, "of-csv", "log.mcap");
    let of_mcap = compared(folder, "log.mcap", "of-mcap", &[]);
    let of_parquet = compared(folder, "of-csv/sensors.parquet", "of-parquet", &[]);
    for summary in [&of_csv, &of_mcap, &of_parquet] {
        let channel = &summary["log"]["channels"][0];
        assert_eq!(
            (&channel["rows"], &channel["lost"]),
            (&2476.into(), &25.into())
        );
        // A lost row is 0.2 mm of the way: only noise differs.
        let ratio = nrmse(summary) / whole;
        assert!((ratio - 1.0).abs() < 0.1, "{ratio}");
    }
    // To the last digit: the rows that are left are the same bits.
    let errors = |summary: &serde_json::Value| summary["estimators"]["kalman"].clone();
    assert_eq!(errors(&of_csv), errors(&of_mcap));
    assert_eq!(errors(&of_csv), errors(&of_parquet));
}

/// A Parquet file that was killed while it was written has no footer: an error, and nothing is
/// written.
#[test]
fn a_parquet_file_without_its_end_is_refused() {
    let (folder, run) = recorded("parquet", &[]);
    let whole = std::fs::read(run.join("sensors.parquet")).unwrap();
    for length in [whole.len() - 1, whole.len() * 7 / 10, 4, 0] {
        std::fs::write(folder.path().join("log.parquet"), &whole[..length]).unwrap();
        let error = refused(folder.path(), &["log.parquet"]);
        assert!(error.contains("log.parquet"), "{length}: {error}");
        assert!(
            error.contains("cannot be read as Parquet"),
            "{length}: {error}"
        );
    }
    assert!(!folder.path().join("runs").exists());
}

/// Two Parquet tables with clocks of their own: that of the inertial units started half a second
/// later. With its offset the readings are those of the run, row for row.
#[test]
fn two_parquet_tables_with_two_clocks() {
    let (folder, run) = recorded("csv", &["sensors.dropped=0", "record.compare_from=1.2"]);
    let folder = folder.path();
    let text = std::fs::read_to_string(run.join("sensors.csv")).unwrap();
    let rows: Vec<&str> = text.lines().collect();
    let later = rows.iter().take(1).chain(&rows[501..]);
    let later = later.fold(String::new(), |text, row| text + row + "\n");
    std::fs::write(folder.join("later.csv"), later).unwrap();
    std::fs::create_dir(folder.join("log")).unwrap();
    // The table `sensors` of an estimate begins at time 0.
    for (log, table) in [("run/sensors.csv", "joints"), ("later.csv", "imus")] {
        estimated(folder, &[log, "--estimator", "true-mass", "--out", table]);
        let from = folder.join(table).join("sensors.parquet");
        std::fs::copy(from, folder.join(format!("log/{table}.parquet"))).unwrap();
    }
    let description = |name: &str, offset: &str| {
        let mut text = format!(
            "[record]\ncompare_from = 1.2\n\n[[channel]]\nname = \"joints\"\ntable = \"joints.parquet\"\n\n\
             [[channel]]\nname = \"imus\"\ntable = \"imus.parquet\"\noffset = \"{offset}\"\n\n"
        );
        let columns = rows[0].split(',').filter(|c| *c != "time");
        for column in columns {
            let channel = if column.starts_with("link") {
                "imus"
            } else {
                "joints"
            };
            writeln!(
                text,
                "[reading.{column}]\nchannel = \"{channel}\"\ncolumn = \"{column}\""
            )
            .unwrap();
        }
        std::fs::write(folder.join(name), text).unwrap();
    };
    description("right.toml", "0.5 s");
    let args = ["--sensors", "right.toml", "--format", "csv"];
    let found = compared(folder, "log", "right", &args);
    assert_eq!(found["log"]["missing"]["link1_inclination"], 500);
    assert_eq!(found["log"]["missing"]["wheel1_angle"], 0);
    let read = std::fs::read_to_string(folder.join("right/sensors.csv")).unwrap();
    let read: Vec<&str> = read.lines().collect();
    assert_eq!(read.len(), rows.len());
    assert!(read[501..] == rows[501..], "readings of other times");
    let whole = nrmse(&compared(folder, "run/sensors.csv", "whole", &[]));
    // Without the rest at the start the biases of the angles are known less well.
    assert!(nrmse(&found) < 1.5 * whole, "{whole}");
    // A wrong offset beyond the log is an error.
    description("wrong.toml", "5 s");
    let error = refused(folder, &["log", "--sensors", "wrong.toml"]);
    assert_contains(&error, "no row in common");
}
