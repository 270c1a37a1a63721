//! `docs/scenes.md` tells of every key exactly what the reader does.
#![allow(
    clippy::unwrap_used,
    reason = "helpers of tests may stop at the first surprise"
)]

use robhaz_scene::{KeyReference, reference};

const DOCUMENT: &str = include_str!("../../../docs/scenes.md");

fn row(key: &KeyReference) -> String {
    let unit = match (key.unit, key.other_units.as_str()) {
        (unit, "") => unit.to_owned(),
        (unit, others) => format!("{unit} ({others})"),
    };
    format!(
        "| `{}` | {unit} | {} | {} | {} |",
        key.key, key.default, key.allowed, key.meaning
    )
}

/// To renew the document, put the rows that this test prints in the place of the old ones.
#[test]
fn the_document_has_the_row_of_every_key() {
    let missing: Vec<_> = reference()
        .iter()
        .map(row)
        .filter(|row| !DOCUMENT.lines().any(|line| line == row))
        .collect();
    assert!(
        missing.is_empty(),
        "not in docs/scenes.md:\n{}",
        missing.join("\n")
    );
}

#[test]
fn the_document_has_no_row_of_a_key_that_is_gone() {
    let rows: Vec<_> = reference().iter().map(row).collect();
    for line in DOCUMENT.lines().filter(|l| l.starts_with("| `")) {
        assert!(rows.iter().any(|r| r == line), "{line}");
    }
}

/// The scene shown in the document can be run as it stands.
#[test]
fn examples_in_the_document_are_scenes() {
    let examples: Vec<&str> = DOCUMENT
        .split("```toml\n")
        .skip(1)
        .filter_map(|rest| rest.split("```").next())
        .collect();
    assert!(examples.len() >= 2);
    for text in examples {
        let top = concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenes");
        let scene = robhaz_scene::Scene::parse(text, "x.toml", top.as_ref(), &[]);
        scene.unwrap_or_else(|e| panic!("{e}\n{text}"));
    }
}

#[test]
fn every_key_has_a_meaning_and_is_declared_once() {
    let keys = reference();
    for key in &keys {
        assert!(
            !key.meaning.is_empty() && !key.allowed.is_empty(),
            "{}",
            key.key
        );
        assert!(!key.default.is_empty(), "{}", key.key);
        assert_eq!(keys.iter().filter(|k| k.key == key.key).count(), 1);
    }
}
