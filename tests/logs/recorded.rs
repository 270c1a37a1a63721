//! Runs, their folders as logs, and the command `robhaz estimate` on them.

use crate::support::{on_one_line, robhaz, text, with_run};
use std::path::{Path, PathBuf};
use std::process::Output;

/// A folder with a run of 2.5 s on typical sensors, in a format, with further overrides.
pub fn recorded(format: &str, set: &[&str]) -> (tempfile::TempDir, PathBuf) {
    let fixed = [
        "record.duration=2.5",
        "record.compare_from=1",
        "sensors.grade=typical",
        "sensors.dropped=0.01",
        "model_error.pins=0.001",
    ];
    let sets = fixed.iter().chain(set).flat_map(|set| ["--set", set]);
    let folder = with_run(
        &["--format", format]
            .into_iter()
            .chain(sets)
            .collect::<Vec<_>>(),
    );
    let run = folder.path().join("run");
    (folder, run)
}

/// `robhaz estimate` in a folder without recording.
pub fn estimate(folder: &Path, args: &[&str]) -> Output {
    let mut command = robhaz(folder);
    command.arg("estimate").args(args).args(["--rerun", "off"]);
    command.output().unwrap()
}

/// The same, which succeeds: what it printed.
pub fn estimated(folder: &Path, args: &[&str]) -> String {
    let output = estimate(folder, args);
    assert!(output.status.success(), "{}", text(&output.stderr));
    text(&output.stdout)
}

/// The same, which fails: the error on one line.
pub fn refused(folder: &Path, args: &[&str]) -> String {
    let output = estimate(folder, args);
    assert!(!output.status.success(), "{}", text(&output.stdout));
    on_one_line(&output.stderr)
}

/// The rows of a table, changed by `change` (row, cells), below its header.
pub fn rewritten(table: &Path, out: &Path, change: impl Fn(usize, &mut Vec<String>) -> bool) {
    let text = std::fs::read_to_string(table).unwrap();
    let mut lines = text.lines();
    let mut kept = lines.next().unwrap().to_owned() + "\n";
    for (row, line) in lines.enumerate() {
        let mut cells: Vec<String> = line.split(',').map(str::to_owned).collect();
        if change(row, &mut cells) {
            kept += &(cells.join(",") + "\n");
        }
    }
    std::fs::write(out, kept).unwrap();
}

/// A log with cells of the columns of these names changed: row, value.
pub fn changed(
    log: &Path,
    out: &Path,
    is: impl Fn(&str) -> bool,
    change: impl Fn(usize, f64) -> f64,
) {
    let text = std::fs::read_to_string(log).unwrap();
    let header: Vec<&str> = text.lines().next().unwrap().split(',').collect();
    rewritten(log, out, |row, cells| {
        for (_, cell) in header.iter().zip(cells).filter(|(name, _)| is(name)) {
            *cell = format!("{:?}", change(row, cell.parse().unwrap_or(f64::NAN)));
        }
        true
    });
}

/// The place of a column in a table.
pub fn place_of(table: &Path, column: &str) -> usize {
    let text = std::fs::read_to_string(table).unwrap();
    let mut names = text.lines().next().unwrap().split(',');
    names.position(|name| name == column).unwrap()
}

pub fn assert_same_files(a: &Path, b: &Path, names: &[&str]) {
    for name in names {
        let [a, b] = [a, b].map(|folder| std::fs::read(folder.join(name)).unwrap());
        assert!(a == b, "{name} differs");
    }
}

pub const ESTIMATES: [&str; 3] = ["paper-body", "true-mass", "kalman"];
