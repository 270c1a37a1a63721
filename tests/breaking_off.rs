//! Runs that are stopped or killed, or that run out of disk space: a stopped run keeps its records,
//! and nothing that is not complete looks finished.
#![cfg(unix)]

use crate::support::{assert_contains, on_one_line, refused, succeeded, summary, words};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

/// Longest wait for an event that takes a moment on an idle machine, and longer on a loaded one.
const PATIENCE: Duration = Duration::from_secs(60);

fn robhaz(folder: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_robhaz"));
    command.current_dir(folder).args(arguments);
    command.stdout(Stdio::piped()).stderr(Stdio::piped());
    command
}

/// A folder with a scene whose run takes much longer than any test.
fn long_scene() -> tempfile::TempDir {
    let dir = tempfile::tempdir().unwrap();
    let text = "[terrain]\nkind = \"flat\"\n[engine]\nkind = \"direct\"\n[record]\nduration = 1e4\ncompare_from = 0.1\n";
    fs::write(dir.path().join("long.toml"), text).unwrap();
    dir
}

fn wait_until(missing: &str, mut reached: impl FnMut() -> bool) {
    let start = Instant::now();
    while !reached() {
        assert!(start.elapsed() < PATIENCE, "{missing}");
        std::thread::sleep(Duration::from_millis(20));
    }
}

fn size(path: &Path) -> u64 {
    fs::metadata(path).map_or(0, |m| m.len())
}

fn signal(child: &Child, name: &str) {
    let sent = Command::new("kill")
        .args([name, &child.id().to_string()])
        .status();
    assert!(sent.unwrap().success());
}

/// Waits until a process has installed its handlers of SIGINT and SIGTERM, which /proc shows on
/// Linux.
fn wait_until_it_listens(child: &Child) {
    let status = PathBuf::from(format!("/proc/{}/status", child.id()));
    if !status.exists() {
        std::thread::sleep(Duration::from_secs(2));
        return;
    }
    wait_until("no handler for SIGINT and SIGTERM", || {
        let text = fs::read_to_string(&status).unwrap_or_default();
        let caught = text.lines().find_map(|l| l.strip_prefix("SigCgt:"));
        let caught = caught.and_then(|hex| u64::from_str_radix(hex.trim(), 16).ok());
        // Signal n is bit n - 1: SIGINT is 2, SIGTERM is 15.
        let both = 1 << 1 | 1 << 14;
        caught.is_some_and(|caught| caught & both == both)
    });
}

/// A child process that is killed if a test fails before the process ends.
struct Running(Option<Child>);

impl Running {
    fn start(mut command: Command) -> Self {
        Self(Some(command.spawn().unwrap()))
    }

    fn child(&mut self) -> &mut Child {
        self.0.as_mut().unwrap()
    }

    fn output(mut self) -> Output {
        let start = Instant::now();
        while self.child().try_wait().unwrap().is_none() {
            assert!(start.elapsed() < PATIENCE, "it does not end");
            std::thread::sleep(Duration::from_millis(20));
        }
        self.0.take().unwrap().wait_with_output().unwrap()
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        if let Some(child) = &mut self.0 {
            let _ = child.kill();
            let _ = child.wait();
        }
    }
}

/// Standard error on one line.
fn said(output: &Output) -> String {
    on_one_line(&output.stderr)
}

/// The table of the truth while it is written.
fn growing(format: &str) -> String {
    format!("truth.{format}.partial")
}

/// Ctrl-C and SIGTERM end a run in order: complete tables, figures, a summary with time and cause,
/// the shell's exit codes.
#[test]
fn a_stopped_run_keeps_all_its_records() {
    for (name, format, cause, code) in [
        ("-INT", "parquet", "Ctrl-C", 130),
        ("-TERM", "csv", "SIGTERM", 143),
    ] {
        let dir = long_scene();
        let mut run = Running::start(robhaz(
            dir.path(),
            &["run", "long.toml", "--format", format],
        ));
        let partial = dir.path().join("runs/long.partial");
        let growing = partial.join(growing(format));
        wait_until("no rows", || size(&growing) > 2_000_000);
        signal(run.child(), name);
        let output = run.output();
        let said = said(&output);
        assert_eq!(output.status.code(), Some(code), "{said}");
        assert_contains(&said, format!("stopped by {cause}"));
        assert_contains(&said, "runs/long.partial");
        let shown = String::from_utf8_lossy(&output.stdout);
        assert_contains(&shown, "broke off at");

        assert!(!dir.path().join("runs/long").exists());
        let summary = summary(&partial);
        let reason = summary["broken_off"]["reason"].as_str().unwrap();
        assert_contains(reason, cause);
        let end = summary["broken_off"]["time_s"].as_f64().unwrap();
        assert!(end > 0.5 && end < 1e4, "{end}");
        assert!(
            summary["estimators"]["true-mass"]["samples"]
                .as_u64()
                .unwrap()
                > 100
        );
        assert!(size(&partial.join("figures/fig6_forces.svg")) > 1000);
        assert_eq!(
            fs::read_dir(&partial)
                .unwrap()
                .filter(|entry| {
                    let name = entry.as_ref().unwrap().file_name();
                    let name = name.to_string_lossy();
                    name.ends_with(".partial")
                })
                .count(),
            0
        );
        if format == "csv" {
            // The last row has the time of the summary.
            let table = fs::read_to_string(partial.join("truth.csv")).unwrap();
            let last = table.lines().last().unwrap().split(',').next().unwrap();
            assert!((last.parse::<f64>().unwrap() - end).abs() < 1e-9);
        } else {
            let table = fs::read(partial.join("truth.parquet")).unwrap();
            assert!(table.starts_with(b"PAR1") && table.ends_with(b"PAR1"));
        }
        #[cfg(feature = "viewer")]
        {
            // The last record is in it.
            let shown = robhaz_viewer::recording_end(&partial.join("run.rrd")).unwrap();
            assert!(
                shown.is_some_and(|shown| (end - shown).abs() < 1e-9),
                "{shown:?} {end}"
            );
        }

        // `compare` reads the folder and states the cause.
        let compared = succeeded(&mut robhaz(dir.path(), &["compare", "runs/long.partial"]));
        assert!(String::from_utf8_lossy(&compared.stdout).contains(cause));
    }
}

/// A second Ctrl-C ends a run at once while its files are being completed. No table looks complete.
#[test]
fn a_second_signal_ends_at_once() {
    let dir = long_scene();
    let arguments = ["run", "long.toml", "--format", "csv"];
    let mut run = Running::start(robhaz(dir.path(), &arguments));
    let partial = dir.path().join("runs/long.partial");
    let growing = partial.join(growing("csv"));
    wait_until("no rows", || size(&growing) > 500_000);
    // Opening a pipe for writing blocks until there is a reader: the run cannot complete this
    // figure.
    fs::create_dir_all(partial.join("figures")).unwrap();
    let pipe = Command::new("mkfifo")
        .arg(partial.join("figures/fig6_forces.svg"))
        .status();
    assert!(pipe.unwrap().success());
    signal(run.child(), "-INT");
    std::thread::sleep(Duration::from_millis(500));
    assert!(
        run.child().try_wait().unwrap().is_none(),
        "nothing to wait for"
    );
    signal(run.child(), "-INT");
    let output = run.output();
    assert_eq!(output.status.code(), Some(130), "{}", said(&output));
    assert!(!dir.path().join("runs/long").exists());
}

/// A run that is killed leaves nothing that looks finished, and the same command with `--force`
/// replaces what it has left.
#[test]
fn a_killed_run_looks_unfinished_and_is_replaced() {
    for format in ["parquet", "csv"] {
        let dir = long_scene();
        let arguments = ["run", "long.toml", "--format", format];
        let mut run = Running::start(robhaz(dir.path(), &arguments));
        let partial = dir.path().join("runs/long.partial");
        let growing = partial.join(growing(format));
        wait_until("no rows", || size(&growing) > 2_000_000);
        run.child().kill().unwrap();
        run.output();
        assert!(!dir.path().join("runs/long").exists());
        let complete = [&format!("truth.{format}"), "summary.json"];
        assert!(complete.iter().all(|name| !partial.join(name).exists()));
        let compared = refused(&mut robhaz(dir.path(), &["compare", "runs/long.partial"]));
        assert_contains(on_one_line(compared.as_bytes()), "was killed");
        let short = words("run long.toml --set record.duration=0.5 --force");
        succeeded(&mut robhaz(dir.path(), &short));
    }
}

/// If a file cannot grow, the run ends with an error that names it, and a summary that says so.
#[test]
fn a_full_disk_is_an_error_that_names_the_file() {
    for format in ["parquet", "csv"] {
        let dir = long_scene();
        let mut command = Command::new("sh");
        // A limit of the file size in blocks of 512 or 1024 bytes: writes fail as on a full disk.
        let script =
            format!("ulimit -f 8000 && exec \"$0\" run long.toml --rerun off --format {format}");
        command.args(["-c", &script, env!("CARGO_BIN_EXE_robhaz")]);
        command.current_dir(dir.path());
        command.stdout(Stdio::piped()).stderr(Stdio::piped());
        let output = Running::start(command).output();
        let said = said(&output);
        assert_eq!(output.status.code(), Some(1), "{said}");
        let table = format!("cannot write runs/long.partial/truth.{format}");
        assert_contains(&said, &table);
        assert_contains(&said, "File too large");
        let partial = dir.path().join("runs/long.partial");
        assert!(!partial.join("truth.parquet").exists() && !dir.path().join("runs/long").exists());
        let summary = fs::read_to_string(partial.join("summary.json")).unwrap();
        assert_contains(&summary, "File too large");
    }
}

/// A table that cannot grow any more ends with its last whole group of rows, under its own name, and
/// is read as any other.
#[test]
fn on_a_full_disk_tables_end_with_their_last_whole_rows() {
    // In blocks of 512 or 1024 bytes. The truth reaches it first: 16 384 of its rows have 14 MB, as
    // text 24 MB.
    for (format, limit) in [("parquet", 40_000), ("csv", 64_000)] {
        let dir = long_scene();
        let mut command = Command::new("sh");
        let script = format!(
            "ulimit -f {limit} && exec \"$0\" run long.toml --set 'estimator=[{{name=\"true-mass\"}}]' --rerun off --format {format}"
        );
        command.args(["-c", &script, env!("CARGO_BIN_EXE_robhaz")]);
        command.current_dir(dir.path());
        command.stdout(Stdio::piped()).stderr(Stdio::piped());
        let output = Running::start(command).output();
        assert_eq!(output.status.code(), Some(1), "{}", said(&output));
        let truth = format!("runs/long.partial/truth.{format}");
        assert!(!dir.path().join(format!("{truth}.partial")).exists());
        let truth_of = ["estimate", "runs/long.partial", "--truth", &truth];
        let rest = words("--estimator true-mass --rerun off --out again");
        let estimate = robhaz(dir.path(), &[&truth_of[..], &rest].concat());
        succeeded(&mut { estimate });
        let summary = summary(&dir.path().join("again"));
        // Records with a truth, from 0.1 s on: at least one group.
        let samples = summary["estimators"]["true-mass"]["samples"].as_u64();
        assert!(samples > Some(16_384 - 100), "{samples:?}");
    }
}

/// A folder with a run of a duration (s), `a`.
fn flat_run(duration: u32) -> tempfile::TempDir {
    let dir = tempfile::tempdir().unwrap();
    let start = "[terrain]\nkind = \"flat\"\n[engine]\nkind = \"direct\"\n[record]\nduration";
    fs::write(dir.path().join("a.toml"), format!("{start} = {duration}\n")).unwrap();
    let run = ["run", "a.toml", "--rerun", "off", "--out", "a"];
    assert!(robhaz(dir.path(), &run).status().unwrap().success());
    dir
}

/// Ctrl-C ends an export: no file is left, neither the log nor the one that was being written.
#[test]
fn an_export_that_is_stopped_leaves_nothing() {
    let dir = flat_run(20);
    let files = || fs::read_dir(dir.path()).unwrap().count();
    let before = files();
    for to in ["mcap", "csv"] {
        let export = robhaz(dir.path(), &["export", "a", "--to", to]).spawn();
        let export = export.unwrap();
        wait_until("no file to write into", || files() > before);
        signal(&export, "-INT");
        let output = export.wait_with_output().unwrap();
        assert_eq!(output.status.code(), Some(130), "{}", said(&output));
        assert_contains(said(&output), "stopped by Ctrl-C");
        assert_eq!(files(), before, "{to}");
    }
}

/// A file that cannot be written is named as the user named it, and as one to be written.
#[test]
fn an_export_on_a_full_disk_says_what_it_cannot_write() {
    let dir = flat_run(5);
    for to in ["mcap", "csv"] {
        let mut command = Command::new("sh");
        // A limit of the file size: writes fail as on a full disk.
        let script = format!("ulimit -f 100 && exec \"$0\" export a --to {to}");
        command.args(["-c", &script, env!("CARGO_BIN_EXE_robhaz")]);
        let output = command.current_dir(dir.path()).output().unwrap();
        assert_eq!(output.status.code(), Some(1), "{}", said(&output));
        let expected = format!("cannot write a.{to}");
        assert_contains(said(&output), &expected);
        assert!(!said(&output).contains("cannot read"), "{}", said(&output));
    }
}

/// `study` and `verify` leave no files before their end: a signal ends them at once, with the
/// shell's exit code.
#[test]
fn study_and_verify_can_be_stopped() {
    for (arguments, name, code) in [
        (
            &words("study long.toml --seeds 10000 --set record.duration=20") as &[&str],
            "-INT",
            130,
        ),
        (
            &words("study long.toml --seeds 10000 --set record.duration=20"),
            "-TERM",
            143,
        ),
        (
            &["verify", "long.toml", "--set", "record.duration=400"],
            "-INT",
            130,
        ),
    ] {
        let dir = long_scene();
        let mut command = Running::start(robhaz(dir.path(), arguments));
        wait_until_it_listens(command.child());
        signal(command.child(), name);
        let output = command.output();
        assert_eq!(output.status.code(), Some(code), "{}", said(&output));
        assert_contains(said(&output), "nothing was written");
        let left: Vec<_> = fs::read_dir(dir.path()).unwrap().collect();
        assert_eq!(left.len(), 1, "{left:?}");
    }
}
