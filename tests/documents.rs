//! Documents name paths and versions that exist.

use crate::support::{assert_contains, robhaz, root, text};
use robhaz_sim::EngineKind;
use robhaz_sim::friction::FrictionKind;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// The pages in a folder.
fn pages(folder: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).unwrap();
    let mut pages: Vec<PathBuf> = entries.map(|entry| entry.unwrap().path()).collect();
    pages.retain(|page| page.extension().is_some_and(|e| e == "md"));
    pages.sort();
    pages
}

/// README, CONTRIBUTING and the pages of docs.
fn documents() -> Vec<PathBuf> {
    let root = root();
    let mut documents = vec![root.join("README.md"), root.join("CONTRIBUTING.md")];
    documents.extend(pages(&root.join("docs")));
    documents
}

/// Every path into this repository in backticks or links of the README, of CONTRIBUTING and of the
/// docs exists.
#[test]
fn paths_named_in_documents_exist() {
    let root = root();
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
    for document in documents() {
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

/// The name by which a link finds a heading.
fn anchor(heading: &str) -> String {
    let kept = |c: &char| c.is_alphanumeric() || "_- ".contains(*c);
    let kept: String = heading.to_lowercase().chars().filter(kept).collect();
    kept.replace(' ', "-")
}

/// Every relative link leads to a file, and to a heading where it names one.
#[test]
fn links_of_documents_lead_somewhere() {
    let mut count = 0;
    for document in documents() {
        let text = std::fs::read_to_string(&document).unwrap();
        for rest in text.split("](").skip(1) {
            let link = rest.split(')').next().unwrap();
            if link.starts_with("http") {
                continue;
            }
            let (file, heading) = link.split_once('#').unwrap_or((link, ""));
            let target = match file {
                "" => document.clone(),
                file => document.parent().unwrap().join(file),
            };
            assert!(target.exists(), "{}: {link}", document.display());
            count += 1;
            if heading.is_empty() {
                continue;
            }
            let page = std::fs::read_to_string(&target).unwrap();
            let headings = page.lines().filter(|line| line.starts_with('#'));
            let mut anchors =
                headings.map(|line| anchor(line.trim_start_matches('#').trim_start()));
            assert!(
                anchors.any(|a| a == heading),
                "{}: {link} names no heading",
                document.display()
            );
        }
    }
    assert!(count > 100, "{count}");
}

/// The README's table is what its command prints.
#[test]
fn the_table_of_the_readme_is_printed() {
    let readme = std::fs::read_to_string(root().join("README.md")).unwrap();
    let (_, block) = readme.split_once("```text\n").unwrap();
    let (table, _) = block.split_once("```").unwrap();
    let dir = tempfile::tempdir().unwrap();
    let mut command = robhaz(dir.path());
    command.arg("run").arg(root().join("scenes/smooth.toml"));
    let output = command.output().unwrap();
    assert_contains(table, "kalman-no-angles");
    let shown = text(&output.stdout);
    assert!(shown.contains(table), "README:\n{table}\nprinted:\n{shown}");
}

/// The Rust lines of docs/in-your-program.md are lines of an example, which is compiled.
#[test]
fn snippets_for_your_program_are_those_of_its_example() {
    let example = root().join("crates/scene/examples/in_your_program.rs");
    let example = std::fs::read_to_string(example).unwrap();
    let known: BTreeSet<&str> = example.lines().map(str::trim).collect();
    let page = std::fs::read_to_string(root().join("docs/in-your-program.md")).unwrap();
    let mut count = 0;
    for block in page.split("```rust\n").skip(1) {
        for line in block.split("```").next().unwrap().lines().map(str::trim) {
            assert!(known.contains(line), "{line}");
            count += 1;
        }
    }
    assert!(count > 30, "{count}");
}

/// The scene that `robhaz new` writes lists all friction laws and engines.
#[test]
fn a_new_scene_names_all_choices() {
    let text = std::fs::read_to_string(root().join("crates/cli/src/new_scene.toml")).unwrap();
    let quoted = |names: Vec<&str>| format!("# \"{}\"\n", names.join("\", \""));
    let laws = quoted(FrictionKind::ALL.map(FrictionKind::name).to_vec());
    let engines = quoted(EngineKind::ALL.map(EngineKind::name).to_vec());
    assert!(
        text.contains(&laws) && text.contains(&engines),
        "{laws}{engines}"
    );
}

/// Every page of measured tables is one that `just measure` writes, with the version of the code
/// and the seeds in its head.
#[test]
fn measured_pages_are_written_by_their_recipe() {
    let folder = root().join("docs/measurements");
    let recipe = std::fs::read_to_string(folder.join("measure.py")).unwrap();
    let (_, listed) = recipe.split_once("PAGES = {").unwrap();
    let name = |line: &str| {
        Some(
            line.strip_prefix("    \"")?
                .split_once("\": (")?
                .0
                .to_owned(),
        )
    };
    let listed: BTreeSet<String> = listed.lines().filter_map(name).collect();
    let mut written = BTreeSet::new();
    for page in pages(&folder) {
        let name = page.file_stem().unwrap().to_str().unwrap().to_owned();
        // The list of the pages; and rules that are gone, which no command can measure again.
        if name == "README" || name == "rules" {
            continue;
        }
        let text = std::fs::read_to_string(&page).unwrap();
        let head = format!("\n\nWritten by `just measure {name}`, not by hand. Version: robhaz ");
        assert!(text.contains(&head) && text.contains(", code "), "{name}");
        assert!(text.contains("\nSeeds: "), "{name}");
        written.insert(name);
    }
    assert_eq!(listed, written);
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

/// Files of Rust in a folder and those below it.
fn sources(folder: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).unwrap();
    let paths = entries.map(|entry| entry.unwrap().path());
    let of = |path: PathBuf| match path.is_dir() {
        true => sources(&path),
        false => vec![path],
    };
    let is_rust = |path: &PathBuf| path.extension().is_some_and(|e| e == "rs");
    paths.flat_map(of).filter(is_rust).collect()
}

/// Crates whose manifest has `doctest = false` have no code in their documentation that
/// `cargo test` would have to run.
#[test]
fn examples_in_documentation_are_run() {
    let mut crates = 0;
    for entry in std::fs::read_dir(root().join("crates")).unwrap() {
        let folder = entry.unwrap().path();
        let manifest = std::fs::read_to_string(folder.join("Cargo.toml")).unwrap();
        if !manifest.lines().any(|line| line == "doctest = false") {
            continue;
        }
        crates += 1;
        for path in sources(&folder.join("src")) {
            let text = std::fs::read_to_string(&path).unwrap();
            let comments = text.lines().filter_map(|line| {
                let line = line.trim_start();
                line.strip_prefix("///").or(line.strip_prefix("//!"))
            });
            let fences = comments.filter_map(|line| line.trim().strip_prefix("```"));
            for language in fences.step_by(2) {
                let runs = language.is_empty() || language.starts_with("rust");
                assert!(!runs, "{}: code in a comment", path.display());
            }
        }
    }
    assert!(crates > 5, "{crates}");
}
