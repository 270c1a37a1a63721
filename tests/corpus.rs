//! What the command says today, frozen: bad inputs with their messages, logs with what is said of
//! them. A change of the code that means to keep behaviour passes the corpus unchanged.
//!
//! A difference is a change that a user sees. Mend the code; or, if the new text is meant, renew
//! the corpus with
//!
//! ```sh
//! ROBHAZ_BLESS=1 cargo test --release -p robhaz --test robhaz corpus
//! ```
//!
//! read `git diff tests/corpus` line by line, and say in the commit what changed and why.
//!
//! A file of `tests/corpus/` is one group of cases. Each case runs in a folder of its own:
//!
//! ```text
//! == name of a case
//! -- scene.toml                   a file: the lines below it
//! -- log.csv from run/sensors.csv an edited copy of a table, see `edited`
//! $ run scene.toml                a command line of robhaz, with '...' around an argument that has spaces; after
//!                                 ` | without A, B`, lines of its output that start with A or B do not count
//! > what it prints on standard output
//! ! what it prints on standard error
//! ? its exit code, where it is not 0
//! ```
//!
//! Files and commands before the first case are there for all cases: the commands run once. Lines
//! with `>`, `!` and `?` are what the test expects, and what it renews. The folder and the
//! durations of a command are left out.

use crate::support::{robhaz, root, text};
use rayon::prelude::*;
use std::fmt::Write as _;
use std::fs;
use std::path::Path;

/// One case, or what stands before the first.
#[derive(Default)]
struct Case {
    /// The line `== name`, empty before the first case, and comments above.
    head: Vec<String>,
    steps: Vec<Step>,
}

enum Step {
    /// `-- name`, its lines.
    File(String, Vec<String>),
    /// `$ arguments`, the lines that are expected.
    Command(String, Vec<String>),
}

fn parse(group: &str) -> Vec<Case> {
    let mut cases = vec![Case::default()];
    for line in group.lines() {
        let last = cases.last_mut().unwrap();
        if line.starts_with("== ") {
            cases.push(Case {
                head: vec![line.to_owned()],
                ..Case::default()
            });
        } else if let Some(name) = line.strip_prefix("-- ") {
            last.steps.push(Step::File(name.to_owned(), Vec::new()));
        } else if let Some(arguments) = line.strip_prefix("$ ") {
            last.steps
                .push(Step::Command(arguments.to_owned(), Vec::new()));
        } else {
            match last.steps.last_mut() {
                None => last.head.push(line.to_owned()),
                Some(Step::File(_, lines) | Step::Command(_, lines)) => lines.push(line.to_owned()),
            }
        }
    }
    cases
}

/// The text of a case as in its file.
fn written(case: &Case) -> String {
    let mut out = String::new();
    let mut line = |text: &str| writeln!(out, "{text}").unwrap();
    case.head.iter().for_each(|head| line(head));
    for step in &case.steps {
        let (mark, first, lines) = match step {
            Step::File(name, lines) => ("--", name, lines),
            Step::Command(arguments, lines) => ("$", arguments, lines),
        };
        line(&format!("{mark} {first}"));
        lines.iter().for_each(|text| line(text));
    }
    out
}

/// Words of a command line; single quotes keep spaces.
fn words(line: &str) -> Vec<String> {
    let mut words: Vec<String> = Vec::new();
    let (mut is_quoted, mut is_new) = (false, true);
    for c in line.chars() {
        match c {
            '\'' => {
                is_quoted = !is_quoted;
                if std::mem::take(&mut is_new) {
                    words.push(String::new());
                }
            }
            ' ' if !is_quoted => is_new = true,
            _ => {
                if std::mem::take(&mut is_new) {
                    words.push(String::new());
                }
                words.last_mut().unwrap().push(c);
            }
        }
    }
    words
}

/// Does the steps of a case in a folder, and puts what the commands print in place of what was
/// expected.
fn perform(case: &Case, folder: &Path) -> Case {
    let step = |step: &Step| match step {
        Step::File(name, lines) => {
            make_file(folder, name, lines);
            Step::File(name.clone(), lines.clone())
        }
        Step::Command(arguments, before) => {
            let (command, left_out) = arguments.split_once(" | without ").unzip();
            let mut said = answer(folder, &words(command.unwrap_or(arguments)));
            if let Some(starts) = left_out {
                let is_out = |line: &str| starts.split(", ").any(|start| line.starts_with(start));
                said.retain(|line| !is_out(line[1..].trim_start()));
            }
            // An empty line parts cases.
            said.extend(
                before
                    .iter()
                    .rev()
                    .take_while(|line| line.is_empty())
                    .cloned(),
            );
            Step::Command(arguments.clone(), said)
        }
    };
    Case {
        head: case.head.clone(),
        steps: case.steps.iter().map(step).collect(),
    }
}

/// What a command prints, marked.
fn answer(folder: &Path, arguments: &[String]) -> Vec<String> {
    // No viewer is found: what is said does not depend on the machine.
    let command = &mut robhaz(folder);
    let output = command.args(arguments).env("PATH", "").output().unwrap();
    let mut lines = Vec::new();
    for (mark, bytes) in [(">", &output.stdout), ("!", &output.stderr)] {
        for line in text(bytes).lines() {
            let line = normal(line, folder);
            lines.push(format!("{mark} {line}").trim_end().to_owned());
        }
    }
    match output.status.code() {
        Some(0) => {}
        code => lines.push(format!("? {}", code.unwrap_or(-1))),
    }
    lines
}

/// A line without what depends on the machine and on the hour.
fn normal(line: &str, folder: &Path) -> String {
    let mut line = line.replace(&folder.display().to_string(), "FOLDER");
    if let Some(end) = line.find(" times real time") {
        let start = line[..end].rfind(" in ").unwrap_or(end);
        line.replace_range(start..end, " in TIME,");
    }
    if let Some(at) = line.find("; the whole command took ") {
        line.truncate(at);
    }
    if line.contains(" s each (mean of ") {
        line.truncate(line.find(',').unwrap_or_default());
    }
    line
}

/// A file with these lines, or an edited copy: `name from table`, an edit a line.
fn make_file(folder: &Path, name: &str, lines: &[String]) {
    let end = lines.iter().rposition(|line| !line.is_empty());
    let lines = &lines[..end.map_or(0, |i| i + 1)];
    let (path, content) = match name.split_once(" from ") {
        None => (
            name,
            lines.iter().fold(String::new(), |t, line| t + line + "\n"),
        ),
        Some((path, table)) => (path, edited(&folder.join(table), lines)),
    };
    let path = folder.join(path);
    fs::create_dir_all(path.parent().unwrap()).unwrap();
    fs::write(path, content).unwrap();
}

/// A CSV table after edits, each on a line:
///
/// - `rows FROM TO`: these rows alone, from 0 on, TO not included
/// - `scale COLUMN FACTOR`, `add COLUMN VALUE`: of all cells
/// - `swap COLUMN COLUMN`, `copy COLUMN COLUMN`, `drop COLUMN`, `rename COLUMN NAME`
/// - `late COLUMN N`: by N rows
/// - `add-from ROW COLUMN VALUE`: of the cells from this row on
/// - `cell ROW COLUMN TEXT`: one cell
/// - `cut N`: the last N bytes are missing
fn edited(table: &Path, edits: &[String]) -> String {
    let text = fs::read_to_string(table).unwrap();
    let mut rows: Vec<Vec<String>> = text
        .lines()
        .map(|line| line.split(',').map(str::to_owned).collect())
        .collect();
    let mut cut = 0;
    for edit in edits {
        let words: Vec<&str> = edit.split(' ').collect();
        let column = |name: &str| {
            let at = rows[0].iter().position(|cell| cell == name);
            at.unwrap_or_else(|| panic!("no column {name}"))
        };
        let number = |text: &str| text.parse::<f64>().unwrap();
        let change = |rows: &mut [Vec<String>], at: usize, f: &dyn Fn(f64) -> f64| {
            for row in rows {
                row[at] = f(number(&row[at])).to_string();
            }
        };
        match words[..] {
            ["rows", from, to] => {
                let [from, to] = [from, to].map(|t| t.parse::<usize>().unwrap());
                rows.truncate(to + 1);
                rows.drain(1..=from);
            }
            ["scale", name, factor] => {
                let at = column(name);
                change(&mut rows[1..], at, &|x| x * number(factor));
            }
            ["add", name, value] => {
                let at = column(name);
                change(&mut rows[1..], at, &|x| x + number(value));
            }
            ["add-from", row, name, value] => {
                let at = column(name);
                let from = row.parse::<usize>().unwrap() + 1;
                change(&mut rows[from..], at, &|x| x + number(value));
            }
            ["swap", a, b] => {
                let (a, b) = (column(a), column(b));
                rows[1..].iter_mut().for_each(|row| row.swap(a, b));
            }
            ["copy", from, to] => {
                let (from, to) = (column(from), column(to));
                for row in &mut rows[1..] {
                    row[to] = row[from].clone();
                }
            }
            ["drop", name] => {
                let at = column(name);
                for row in &mut rows {
                    row.remove(at);
                }
            }
            ["rename", name, new] => {
                let at = column(name);
                rows[0][at] = new.to_owned();
            }
            ["late", name, n] => {
                let at = column(name);
                let n: usize = n.parse().unwrap();
                for i in (n + 1..rows.len()).rev() {
                    rows[i][at] = rows[i - n][at].clone();
                }
            }
            ["cell", row, name, text] => {
                let at = column(name);
                rows[row.parse::<usize>().unwrap() + 1][at] = text.to_owned();
            }
            ["cut", n] => cut = n.parse().unwrap(),
            _ => panic!("unknown edit: {edit}"),
        }
    }
    let mut out = rows
        .iter()
        .fold(String::new(), |text, row| text + &row.join(",") + "\n");
    out.truncate(out.len() - cut);
    out
}

/// Copies the content of a folder into another.
fn copy(from: &Path, to: &Path) {
    fs::create_dir_all(to).unwrap();
    for entry in fs::read_dir(from).unwrap() {
        let entry = entry.unwrap();
        let target = to.join(entry.file_name());
        if entry.file_type().unwrap().is_dir() {
            copy(&entry.path(), &target);
        } else {
            fs::copy(entry.path(), target).unwrap();
        }
    }
}

/// The lines that differ, with one line before them.
fn difference(expected: &str, found: &str) -> String {
    let (old, new): (Vec<&str>, Vec<&str>) = (expected.lines().collect(), found.lines().collect());
    let start = old.iter().zip(&new).take_while(|(a, b)| a == b).count();
    let ends = old[start..].iter().rev().zip(new[start..].iter().rev());
    let end = ends.take_while(|(a, b)| a == b).count();
    let mut out = String::new();
    let mut lines = |mark: &str, lines: &[&str]| {
        for line in lines {
            writeln!(out, "{mark} {line}").unwrap();
        }
    };
    lines(" ", &old[start.saturating_sub(1)..start]);
    lines("-", &old[start..old.len() - end]);
    lines("+", &new[start..new.len() - end]);
    out
}

/// Runs all cases of a group; the differences as text.
fn differences(path: &Path) -> String {
    let base = tempfile::tempdir().unwrap();
    let expected = fs::read_to_string(path).unwrap();
    let cases = parse(&expected);
    let common = perform(&cases[0], base.path());
    let done: Vec<Case> = cases[1..]
        .par_iter()
        .map(|case| {
            let folder = tempfile::tempdir().unwrap();
            copy(base.path(), folder.path());
            perform(case, folder.path())
        })
        .collect();
    let found = done
        .iter()
        .fold(written(&common), |text, case| text + &written(case));
    if std::env::var_os("ROBHAZ_BLESS").is_some() {
        fs::write(path, found).unwrap();
        return String::new();
    }
    let all = std::iter::once(&common).chain(&done);
    let mut out = String::new();
    for (before, after) in cases.iter().zip(all) {
        let (before, after) = (written(before), written(after));
        if before != after {
            let name = path.file_name().unwrap().display();
            let case = before.lines().next().unwrap_or_default();
            writeln!(out, "{name}: {case}\n{}", difference(&before, &after)).unwrap();
        }
    }
    out
}

/// Every case of the corpus says what it said before.
#[test]
fn the_corpus_is_unchanged() {
    let mut groups: Vec<_> = fs::read_dir(root().join("tests/corpus"))
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.extension().is_some_and(|e| e == "txt"))
        .collect();
    groups.sort();
    assert!(groups.len() >= 8, "{groups:?}");
    let said: String = groups.par_iter().map(|path| differences(path)).collect();
    assert!(
        said.is_empty(),
        "{said}\nROBHAZ_BLESS=1 renews the corpus: see tests/corpus.rs"
    );
}
