//! Faults of logs: what is usable is estimated and counted, the rest is an error with its place.

use super::recorded::{estimated, recorded, refused, summary};
use crate::support::robhaz;
use std::path::Path;

/// A log of a run at rest and slow, as lines of text: the names, then the rows.
fn lines(run: &Path) -> Vec<String> {
    let text = std::fs::read_to_string(run.join("sensors.csv")).unwrap();
    text.lines().map(str::to_owned).collect()
}

/// Lost rows, repeated rows, late rows and a row that is cut are reported and counted; the rest is estimated.
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
    assert!(printed.contains("CUT OFF"), "{printed}");
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

/// Faults that make a log unusable name file, place, what was found, what is allowed and what helps; nothing is written.
#[test]
fn faults_are_reported_with_their_place() {
    let (folder, run) = recorded("csv", &[]);
    let rows = lines(&run);
    let log = folder.path().join("log.csv");
    let check = |text: String, parts: &[&str]| {
        std::fs::write(&log, text).unwrap();
        let error = refused(folder.path(), &["log.csv"]);
        for part in parts {
            assert!(error.contains(part), "{part}: {error}");
        }
    };
    let joined = |rows: &[String]| rows.iter().fold(String::new(), |t, row| t + row + "\n");
    let renamed = joined(&rows).replacen("wheel2_angle", "wheel2_angel", 1);
    check(
        renamed,
        &["log.csv", "has no column wheel2_angle", "--sensors"],
    );
    let unit = joined(&rows).replacen("link1_rate", "link1_rate [deg/s]", 1);
    check(
        unit,
        &["link1_rate [deg/s] has the unit deg/s, allowed: rad/s"],
    );
    let mut back = rows.clone();
    back.extend_from_slice(&rows[1..]);
    check(
        joined(&back),
        &["line 2503", "jumps back by 2.500 s", "split the log"],
    );
    let mut word = rows.clone();
    word[700] = word[700].replacen(',', ",abc", 1);
    check(
        joined(&word),
        &[
            "line 701, column wheel1_angle",
            "found \"abc",
            "allowed: a number",
        ],
    );
    let mut short = rows.clone();
    short[700] = "0.7,1".to_owned();
    check(joined(&short), &["line 701", "found 2 cells, allowed: 14"]);
    check(rows[0].clone() + "\n", &["has no row"]);
    check(String::new(), &["it is empty"]);
    assert!(!folder.path().join("runs").exists());
    std::fs::write(folder.path().join("log.parquet"), "PAR1 and no more").unwrap();
    let error = refused(folder.path(), &["log.parquet"]);
    assert!(
        error.contains("cannot be read as Parquet") && error.contains("no footer"),
        "{error}"
    );
    let error = refused(folder.path(), &["none.csv"]);
    assert!(error.contains("no such file"), "{error}");
    let error = refused(folder.path(), &["run", "--estimator", "bets"]);
    assert!(error.contains("did you mean best?"), "{error}");
    let error = refused(
        folder.path(),
        &[
            "run",
            "--estimator",
            "paper-body",
            "--contact-angles",
            "none",
        ],
    );
    assert!(
        error.contains("cannot estimate without contact angles"),
        "{error}"
    );
}

/// A recording that was killed: an MCAP file without its end. All that is there is estimated, and it is
/// reported.
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
    assert!(
        printed.contains("CUT OFF") && printed.contains("was killed"),
        "{printed}"
    );
    let rows = summary(&folder.path().join("runs/cut-estimate"))["log"]["channels"][0]["rows"]
        .as_u64()
        .unwrap();
    assert!((1000..2501).contains(&rows), "{rows}");
}
