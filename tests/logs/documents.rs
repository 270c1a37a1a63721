//! docs/logs.md and the columns of the truth say what the reader does.

use crate::support::{robhaz, root, text};
use robhaz_scene::KeyReference;

/// Every column of the truth that is read has the name that a run writes.
#[test]
fn the_columns_of_the_truth_are_those_of_runs() {
    let table = robhaz_record::Table::truth();
    for name in robhaz_log::truth_columns(false) {
        assert!(table.columns.iter().any(|c| c.name == name), "{name}");
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
    let row = |row: KeyReference| {
        let KeyReference {
            key,
            unit,
            default,
            allowed,
            meaning,
            ..
        } = row;
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
