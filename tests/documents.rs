//! Documents name paths and versions that exist.

use crate::support::root;
use robhaz_sim::EngineKind;

/// Every path into this repository in backticks or links of the README and the docs exists.
#[test]
fn paths_named_in_documents_exist() {
    let root = root();
    let mut documents = vec![root.join("README.md")];
    for entry in std::fs::read_dir(root.join("docs")).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_some_and(|e| e == "md") {
            documents.push(path);
        }
    }
    let ours = [
        "crates/",
        "scenes/",
        "studies/",
        "robots/",
        "docs/",
        "examples/python/",
        "tests/",
        "benches/",
        ".ci/",
    ];
    let mut checked = 0;
    for document in documents {
        let text = std::fs::read_to_string(&document).unwrap();
        // Blocks of terminal output name files of the reader.
        let prose: String = text
            .split("```")
            .filter(|block| !block.starts_with("text"))
            .collect();
        for word in prose.split(|c: char| c.is_whitespace() || "`()[]|,;\"".contains(c)) {
            let word = word
                .split('#')
                .next()
                .unwrap_or_default()
                .trim_end_matches(['.', ':']);
            if ours.iter().any(|start| word.starts_with(start)) && !word.contains('*') {
                assert!(
                    root.join(word).exists(),
                    "{}: {word} does not exist",
                    document.display()
                );
                checked += 1;
            }
        }
    }
    assert!(checked > 5, "{checked}");
}

/// The library version that a resolved scene states for an engine is the version in Cargo.lock.
#[test]
fn the_engines_versions_are_the_locked_ones() {
    let lock = std::fs::read_to_string(root().join("Cargo.lock")).unwrap();
    for kind in EngineKind::ALL {
        let (name, version) = kind.library().split_once(' ').unwrap();
        // The f64 variant of rapier2d has a name of its own.
        let found = [name.to_owned(), format!("{name}-f64")]
            .iter()
            .any(|n| lock.contains(&format!("name = \"{n}\"\nversion = \"{version}\"\n")));
        assert!(found, "{name} {version}");
    }
}
