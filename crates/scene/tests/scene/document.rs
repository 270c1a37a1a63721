//! `docs/scenes.md` describes every key as the reader implements it.
#![allow(
    clippy::unwrap_used,
    reason = "helpers of tests may stop at the first surprise"
)]

use robhaz_scene::{KeyReference, reference};

const DOCUMENT: &str = include_str!("../../../../docs/scenes.md");

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

/// To update the document, replace the old rows by those that this test prints.
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

/// The rows of each section are in the order of the declarations.
#[test]
fn rows_are_in_the_order_of_the_declarations() {
    let rows: Vec<_> = reference().iter().map(row).collect();
    let places: Vec<_> = DOCUMENT
        .lines()
        .filter_map(|line| rows.iter().position(|row| row == line))
        .collect();
    let section = |place: usize| rows[place].split('.').next();
    for pair in places.windows(2) {
        assert!(
            section(pair[0]) != section(pair[1]) || pair[0] < pair[1],
            "{} comes too late",
            rows[pair[1]]
        );
    }
}

#[test]
fn the_document_has_no_row_of_a_key_that_is_gone() {
    let rows: Vec<_> = reference().iter().map(row).collect();
    for line in DOCUMENT.lines().filter(|l| l.starts_with("| `")) {
        assert!(
            rows.iter().any(|r| r == line),
            "docs/scenes.md has a row that no key has, changed or removed:\n{line}"
        );
    }
}

/// The scenes in the document can be run without changes.
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

/// The table of the grades has their values; angles in degrees.
#[test]
fn the_document_has_the_values_of_the_grades() {
    let grades = ["ideal", "typical", "poor"].map(|grade| {
        let overrides = [format!("sensors.grade={grade}")];
        let scene = robhaz_scene::Scene::parse("", "x.toml", "".as_ref(), &overrides).unwrap();
        scene.to_toml("x")
    });
    let value = |grade: &str, section: &str, key: &str| {
        let section = grade.split(&format!("[{section}]")).nth(1).unwrap();
        let line = section
            .lines()
            .find(|l| l.starts_with(&format!("{key} = ")));
        line.unwrap()
            .split([' ', '"'])
            .filter(|w| !w.is_empty())
            .nth(2)
            .unwrap()
            .to_owned()
    };
    let mut rows = vec!["| | unit | ideal | typical | poor |".to_owned()];
    for key in reference() {
        let Some((section, name)) = key.key.split_once('.') else {
            continue;
        };
        let of_grade = section == "sensors" && !["grade", "rate"].contains(&name)
            || key.key == "model_error.viscous_damping";
        if !of_grade {
            continue;
        }
        let in_degrees = key.unit.replacen("rad", "deg", 1);
        let values = grades.each_ref().map(|grade| {
            let text = value(grade, section, name);
            match text.parse::<f64>() {
                Ok(angle) if in_degrees != key.unit => {
                    let degrees = (angle.to_degrees() * 1e9).round() / 1e9;
                    format!("{degrees}")
                }
                Ok(number) => format!("{number}"),
                Err(_) => text,
            }
        });
        let name = if section == "sensors" { name } else { &key.key };
        rows.push(format!(
            "| {name} | {in_degrees} | {} |",
            values.join(" | ")
        ));
    }
    let missing: Vec<_> = rows
        .iter()
        .filter(|row| !DOCUMENT.lines().any(|line| line == *row))
        .collect();
    assert!(
        missing.is_empty(),
        "not in docs/scenes.md:\n{}",
        rows.join("\n")
    );
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
