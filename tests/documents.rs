//! Documents name paths that exist.

use crate::support::root;

/// Every path in backticks or links of the README and the docs that looks like one of ours is there.
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
        "crates/", "scenes/", "robots/", "docs/", "tests/", "benches/", ".ci/",
    ];
    let mut checked = 0;
    for document in documents {
        let text = std::fs::read_to_string(&document).unwrap();
        for word in text.split(|c: char| c.is_whitespace() || "`()[]|,;\"".contains(c)) {
            let word = word.trim_end_matches(['.', ':']);
            if ours.iter().any(|start| word.starts_with(start)) && !word.contains('*') {
                assert!(
                    root.join(word).exists(),
                    "{}: {word} is not there",
                    document.display()
                );
                checked += 1;
            }
        }
    }
    assert!(checked > 5, "{checked}");
}
