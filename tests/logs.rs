//! `robhaz estimate` and `robhaz export`: recorded logs give the estimates of the run, and faults of logs are reported.

use crate::support::{robhaz, root, text};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::Output;

/// A folder with a run of 2.5 s on typical sensors, in a format, with further overrides.
fn recorded(format: &str, set: &[&str]) -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let mut command = robhaz(folder.path());
    command.arg("run").arg(root().join("scenes/smooth.toml"));
    command.args(["--engine", "direct", "--rerun", "off", "--format", format]);
    let fixed = [
        "record.duration=2.5",
        "record.compare_from=1",
        "sensors.grade=typical",
        "sensors.dropped=0.01",
        "model_error.pins=0.001",
    ];
    for set in fixed.iter().chain(set) {
        command.args(["--set", set]);
    }
    let output = command.args(["--out", "run"]).output().unwrap();
    assert!(output.status.success(), "{}", text(&output.stderr));
    let run = folder.path().join("run");
    (folder, run)
}

/// `robhaz estimate` in a folder without recording.
fn estimate(folder: &Path, args: &[&str]) -> Output {
    let mut command = robhaz(folder);
    command.arg("estimate").args(args).args(["--rerun", "off"]);
    command.output().unwrap()
}

/// The same, which succeeds: what it printed.
fn estimated(folder: &Path, args: &[&str]) -> String {
    let output = estimate(folder, args);
    assert!(output.status.success(), "{}", text(&output.stderr));
    text(&output.stdout)
}

/// The same, which fails: the error on one line.
fn refused(folder: &Path, args: &[&str]) -> String {
    let output = estimate(folder, args);
    assert!(!output.status.success(), "{}", text(&output.stdout));
    let error = text(&output.stderr);
    error
        .split_whitespace()
        .filter(|word| !matches!(*word, "│" | "×"))
        .collect::<Vec<_>>()
        .join(" ")
}

fn summary(folder: &Path) -> serde_json::Value {
    let json = std::fs::read_to_string(folder.join("summary.json")).unwrap();
    serde_json::from_str(&json).unwrap()
}

fn assert_same_files(a: &Path, b: &Path, names: &[&str]) {
    for name in names {
        let [a, b] = [a, b].map(|folder| std::fs::read(folder.join(name)).unwrap());
        assert!(a == b, "{name} differs");
    }
}

/// The numbers of a CSV table by columns; empty cells as not a number.
fn table(path: &Path) -> (Vec<String>, Vec<Vec<f64>>) {
    let mut reader = csv::Reader::from_path(path).unwrap();
    let names = reader
        .headers()
        .unwrap()
        .iter()
        .map(str::to_owned)
        .collect();
    let rows = reader.records().map(|row| {
        let row = row.unwrap();
        row.iter()
            .map(|cell| cell.parse().unwrap_or(f64::NAN))
            .collect()
    });
    (names, rows.collect())
}

/// Largest difference of the columns of two tables whose names end like this, over rows from a time (s) on.
fn difference(a: &Path, b: &Path, end: &str, from: f64) -> f64 {
    let ((names, a), (other, b)) = (table(a), table(b));
    assert_eq!((&names, a.len()), (&other, b.len()));
    let columns: Vec<usize> = (0..names.len())
        .filter(|i| names[*i].ends_with(end))
        .collect();
    assert!(!columns.is_empty());
    let mut largest = 0.0_f64;
    for (a, b) in a.iter().zip(&b).filter(|(a, _)| a[0] >= from) {
        for i in &columns {
            assert!(
                a[*i].is_nan() == b[*i].is_nan(),
                "{} at {}",
                names[*i],
                a[0]
            );
            largest = largest.max((a[*i] - b[*i]).abs());
        }
    }
    largest
}

const ESTIMATES: [&str; 3] = ["paper-body", "true-mass", "best"];

/// Equivalence: the folder of a run, its table alone, and the estimate's own folder give the run's estimates to the bit,
/// as Parquet and as CSV, with lost readings and model errors.
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
        assert!(
            printed.contains("Results in runs/run-estimate"),
            "{printed}"
        );
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
        assert!(!folder.path().join("alone/figures/comparison.svg").exists());
    }
}

/// Equivalence: with the truth of the run the summary has the run's errors, digit for digit; without it means, which add up
/// to the weight of the robot, and counts of the records.
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
    let figures = folder.path().join("runs/run-estimate/figures");
    assert!(figures.join("comparison.svg").is_file());

    estimated(folder.path(), &["run", "--force"]);
    let found = summary(&folder.path().join("runs/run-estimate"));
    let best = &found["estimators"]["best"];
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

/// A run that records every tenth reading only cannot be repeated: it is reported, and estimated from what there is.
#[test]
fn a_run_with_unrecorded_readings_is_told() {
    let (folder, _) = recorded("parquet", &["record.rate=100"]);
    let output = estimate(folder.path(), &["run"]);
    assert!(output.status.success());
    let warning = text(&output.stderr);
    assert!(
        warning.contains("recorded every 10th reading only"),
        "{warning}"
    );
}

/// Equivalence: MCAP and CSV as exported give the run's estimates to the bit.
#[test]
fn exported_logs_give_the_same_estimates() {
    let (folder, run) = recorded("parquet", &[]);
    let names = ESTIMATES.map(|e| format!("estimate-{e}.parquet"));
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    for format in ["mcap", "csv"] {
        let mut export = robhaz(folder.path());
        let output = export
            .args(["export", "run", "--to", format])
            .output()
            .unwrap();
        assert!(output.status.success(), "{}", text(&output.stderr));
        assert!(
            text(&output.stdout).contains("2501 rows"),
            "{}",
            text(&output.stdout)
        );
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
        assert!(
            text(&again.stderr).contains("exists"),
            "{}",
            text(&again.stderr)
        );
    }
}

/// The standard messages in an exported file, read with the example's description: time stamps are whole nanoseconds and
/// inclinations pass through a quaternion, which changes N by less than 10 nN.
#[test]
fn standard_messages_give_nearly_the_same_estimates() {
    let (folder, _) = recorded("csv", &["sensors.dropped=0"]);
    let mut export = robhaz(folder.path());
    assert!(
        export
            .args(["export", "run", "--to", "mcap"])
            .status()
            .unwrap()
            .success()
    );
    let example = std::fs::read_to_string(root().join("examples/logs/SENSORS.toml")).unwrap();
    // The exported IMUs have no delay.
    let sensors = folder.path().join("SENSORS.toml");
    std::fs::write(&sensors, example.replace("\"-2 ms\"", "0")).unwrap();
    let common = [
        "--sensors",
        "SENSORS.toml",
        "--estimator",
        "best",
        "--format",
        "csv",
    ];
    let direct = [
        &[
            "run/sensors.csv",
            "--contact-angles",
            "none",
            "--out",
            "direct",
        ],
        &common[2..],
    ];
    // The same budget for both: that of the example, without its columns.
    let budget: String = example
        .split("[[channel]]")
        .next()
        .unwrap()
        .lines()
        .filter(|line| !line.starts_with("missing") && !line.starts_with("time_base"))
        .fold(String::new(), |text, line| text + line + "\n");
    std::fs::write(folder.path().join("budget.toml"), budget).unwrap();
    estimated(
        folder.path(),
        &[&direct.concat()[..], &["--sensors", "budget.toml"]].concat(),
    );
    estimated(
        folder.path(),
        &[&["run.mcap", "--out", "mcap"], &common[..]].concat(),
    );
    let [a, b] = ["direct", "mcap"].map(|f| folder.path().join(f).join("estimate-best.csv"));
    let largest = difference(&a, &b, "normal_force", 0.0);
    // Ten times what was found over 20 s; a wrong sign or a lost reading changes N by 0.01 N and more.
    assert!(largest < 1e-8, "{largest} N");
    assert!(largest > 0.0, "nothing was rounded: the files are the same");
}

/// Two tables with clocks, rates, units and signs of their own give estimates as accurate as the run's readings.
#[test]
fn two_clocks_are_brought_onto_one_time() {
    let (folder, run) = recorded("csv", &["sensors.dropped=0"]);
    let (names, rows) = table(&run.join("sensors.csv"));
    let column = |name: &str| names.iter().position(|n| n == name).unwrap();
    let log = folder.path().join("log");
    std::fs::create_dir(&log).unwrap();
    let mut joints = "stamp;encoder1;encoder2;encoder3;current1;current2;current3\n".to_owned();
    let mut imus = "t,a1x,a1y,a1z,g1x,g1y,g1z,a2x,a2y,a2z,g2x,g2y,g2z\n".to_owned();
    for (k, row) in rows.iter().enumerate() {
        let stamp = 1_700_000_000_000_000 + (row[0] * 1e6).round() as i64;
        let counts = |i: usize| {
            (row[column(&format!("wheel{i}_angle"))] * 160_000.0 / std::f64::consts::TAU).round()
        };
        let current = |i: usize| {
            format!(
                "{:.9}",
                row[column(&format!("wheel{i}_motor_torque"))] / 4.0
            )
            .replace('.', ",")
        };
        let (c1, c2, c3) = (counts(1), counts(2), -counts(3));
        writeln!(
            joints,
            "{stamp};{c1};{c2};{c3};{};{};{}",
            current(1),
            current(2),
            current(3)
        )
        .unwrap();
        // Every second reading.
        if k % 2 == 0 {
            let imu = |link: usize| {
                let (sin, cos) = row[column(&format!("link{link}_inclination"))].sin_cos();
                let rate = row[column(&format!("link{link}_rate"))].to_degrees();
                format!("{},0.1,{},0,{},0", 9.81 * sin, 9.81 * cos, -rate)
            };
            let time = 1_700_000_100.0 + row[0] - 1e-5;
            writeln!(imus, "{time:?},{},{}", imu(1), imu(2)).unwrap();
        }
    }
    std::fs::write(log.join("joints.csv"), joints).unwrap();
    std::fs::write(log.join("imus.csv"), imus).unwrap();
    let example = root().join("examples/logs/two-tables.toml");
    let mut description = std::fs::read_to_string(example).unwrap();
    description +=
        "\n[[channel]]\nname = \"truth\"\noffset = 1700000000\n\n[record]\ncompare_from = 1\n";
    std::fs::write(folder.path().join("two.toml"), description).unwrap();
    let args = ["log", "--sensors", "two.toml", "--truth", "run/truth.csv"];
    let printed = estimated(folder.path(), &args);
    assert!(
        printed.contains("joints: 2501 rows at 1000 Hz"),
        "{printed}"
    );
    assert!(printed.contains("imus: 1251 rows at 500 Hz"), "{printed}");
    let found = summary(&folder.path().join("runs/log-estimate"));
    // Half of the frames have no new inclination.
    assert_eq!(found["log"]["missing"]["link1_inclination"], 1250);
    assert_eq!(found["log"]["missing"]["wheel1_angle"], 0);
    let nrmse = found["estimators"]["no-angles"]["normal_force"]["nrmse"].as_f64();
    // The run's own figure without contact angles is 2 to 4 % at the start of the course; wrong signs give 20 % and more.
    assert!(nrmse.unwrap() < 0.06, "{nrmse:?}");
    // An offset that is forgotten leaves no row in common.
    let text = std::fs::read_to_string(folder.path().join("two.toml")).unwrap();
    std::fs::write(
        folder.path().join("bad.toml"),
        text.replace("\"-100 s\"", "0"),
    )
    .unwrap();
    let error = refused(folder.path(), &["log", "--sensors", "bad.toml"]);
    assert!(
        error.contains("imus") && error.contains("`offset`"),
        "{error}"
    );
}

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
fn faults_are_told_with_their_place() {
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

/// Recordings that were killed: an Arrow stream in the folder of a run, and an MCAP file without its end. All that is
/// there is estimated, and it is reported.
#[test]
fn killed_recordings_are_recovered() {
    let (folder, run) = recorded("parquet", &[]);
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

    // A run stopped in the middle of a batch leaves streams; here one is made from the table of a run.
    let killed = folder.path().join("killed.partial");
    std::fs::create_dir(&killed).unwrap();
    std::fs::copy(run.join("scene.toml"), killed.join("scene.toml")).unwrap();
    std::fs::write(killed.join("sensors.arrows"), stream_of(&run)).unwrap();
    let printed = estimated(folder.path(), &["killed.partial", "--out", "of-killed"]);
    assert!(
        printed.contains("the stream ends within a batch"),
        "{printed}"
    );
    assert_eq!(
        summary(&folder.path().join("of-killed"))["log"]["channels"][0]["rows"],
        1001
    );
}

/// The stream of a run's readings as it is 1.5 s after the start, cut in its last batch.
fn stream_of(run: &Path) -> Vec<u8> {
    use robhaz_record::{TableFormat, TableSink};
    use robhaz_run::{Frame, RunDescription, Sink};
    let scene = robhaz_scene::Scene::load(&run.join("scene.toml"), &[]).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let mut sink = TableSink::new(folder.path(), TableFormat::Parquet);
    sink.begin(&RunDescription::of(&scene).unwrap()).unwrap();
    let kept = crate::support::keep(&scene);
    for (i, (truth, sensors)) in kept.truth.iter().zip(&kept.sensors).enumerate().take(2001) {
        let estimates: Vec<_> = kept.estimates.iter().map(|list| list[i]).collect();
        let frame = Frame {
            clearances: None,
            time: truth.time,
            truth: Some(truth),
            sensors,
            estimates: &estimates,
            commands: None,
            ground: robhaz_run::FeltGround::default(),
        };
        sink.frame(&frame).unwrap();
    }
    let bytes = std::fs::read(folder.path().join("sensors.arrows")).unwrap();
    bytes[..bytes.len() - 1000].to_vec()
}

/// Every column of the truth that a run writes has its place when it is read, but for the contacts of a wheel one by one and the
/// clearance, which is no truth of a sensor.
#[test]
fn every_column_of_the_truth_is_read() {
    let table = robhaz_record::Table::truth();
    let is_read = |name: &str| {
        !name.contains("_contact1_") && !name.contains("_contact2_") && name != "clearance"
    };
    let columns: Vec<_> = table.columns.iter().filter(|c| is_read(&c.name)).collect();
    assert!(columns.len() > 70, "{}", columns.len());
    for column in columns.iter().skip(1) {
        assert!(robhaz_log::is_truth_column(&column.name), "{}", column.name);
    }
}

/// The commands of docs/logs.md work one after another, as in the folder of the repository.
#[test]
fn the_commands_of_the_document_work() {
    let document = std::fs::read_to_string(root().join("docs/logs.md")).unwrap();
    let block = document.split("```sh\n").nth(1).unwrap();
    let commands = block.split("```").next().unwrap().lines();
    let folder = tempfile::tempdir().unwrap();
    let scenes = folder.path().join("scenes");
    std::fs::create_dir(&scenes).unwrap();
    let scene = root().join("scenes/smooth.toml");
    std::fs::copy(scene, scenes.join("smooth.toml")).unwrap();
    let mut count = 0;
    for line in commands {
        let mut words = line.split_whitespace();
        assert_eq!(words.next(), Some("robhaz"));
        let mut command = robhaz(folder.path());
        command.args(words);
        if !line.contains("export") {
            command.args(["--rerun", "off"]);
        }
        let output = command.output().unwrap();
        assert!(output.status.success(), "{line}\n{}", text(&output.stderr));
        count += 1;
    }
    assert!(count >= 5, "{count}");
}

/// docs/logs.md describes every key as the reader implements it.
#[test]
fn the_document_has_every_key() {
    let document = std::fs::read_to_string(root().join("docs/logs.md")).unwrap();
    let row = |[key, unit, default, allowed, meaning]: [String; 5]| {
        format!("| `{key}` | {unit} | {default} | {allowed} | {meaning} |")
    };
    let rows: Vec<String> = robhaz_scene::log_reference().into_iter().map(row).collect();
    let missing: Vec<&String> = rows
        .iter()
        .filter(|row| !document.lines().any(|l| l == *row))
        .collect();
    assert!(missing.is_empty(), "not in docs/logs.md:\n{missing:#?}");
    let known = |line: &&str| line.starts_with("| `") && line.matches('|').count() == 6;
    for line in document.lines().filter(known) {
        assert!(rows.iter().any(|row| row == line), "{line}");
    }
}
