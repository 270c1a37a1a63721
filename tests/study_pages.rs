//! The pages on studies: their commands run, on the studies that they show.

use crate::support::{page_commands, robhaz, root, succeeded};
use std::fs;
use std::path::Path;

/// Runs the lines `robhaz ...` of a page in a folder. The others call the script that draws
/// studies, whose own test runs them (examples/python/test_plot_study.py). Returns the number of
/// each.
fn run_all(folder: &Path, page: &str) -> (usize, usize) {
    let (ours, scripts): (Vec<String>, Vec<String>) = page_commands(page)
        .into_iter()
        .partition(|line| line.starts_with("robhaz "));
    for line in &ours {
        let words = line.split_whitespace().skip(1);
        succeeded(robhaz(folder).args(words));
    }
    for line in &scripts {
        let script = "python examples/python/plot_study.py runs/";
        assert!(line.starts_with(script), "{page}: {line}");
    }
    (ours.len(), scripts.len())
}

/// docs/studies.md explains every score that the dataset has.
#[test]
fn the_page_on_studies_has_every_score() {
    let page = fs::read_to_string(root().join("docs/studies.md")).unwrap();
    let scores = robhaz_record::ScoreColumn::all();
    let missing = scores
        .iter()
        .filter(|s| !page.contains(&format!("`{}`", s.name)));
    assert_eq!(missing.map(|s| s.name).collect::<Vec<_>>(), [""; 0]);
}

/// Every command of docs/studies.md runs, on the study that it shows, with fewer seeds and shorter
/// runs.
#[test]
fn the_commands_of_the_page_on_studies_run() {
    let page = fs::read_to_string(root().join("docs/studies.md")).unwrap();
    let study = fs::read_to_string(root().join("studies/speed.toml")).unwrap();
    let shown = page
        .split("```toml\n")
        .nth(1)
        .unwrap()
        .split("```")
        .next()
        .unwrap();
    let axes = |text: &str| text[text.find("scene =").unwrap()..].trim().to_owned();
    assert_eq!(axes(shown), axes(&study), "the page shows another study");

    let dir = tempfile::tempdir().unwrap();
    for folder in ["scenes", "studies"] {
        fs::create_dir(dir.path().join(folder)).unwrap();
    }
    fs::copy(
        root().join("scenes/smooth.toml"),
        dir.path().join("scenes/smooth.toml"),
    )
    .unwrap();
    let mut shorter = study.replace("count = 20", "count = 1");
    for duration in ["50", "26", "14", "10", "8", "6.8", "6"] {
        shorter = shorter.replace(&format!(", {duration}],"), ", 2.1],");
    }
    fs::write(dir.path().join("studies/speed.toml"), shorter).unwrap();
    assert_eq!(run_all(dir.path(), "studies.md"), (6, 2));
    assert!(dir.path().join("runs/speed/report.html").is_file());
    let dataset = |name: &str| fs::read(dir.path().join(name).join("study.parquet")).unwrap();
    assert!(dataset("runs/speed") == dataset("runs/speed-parts"));
}

/// The commands of the pages on the shipped studies run, with one seed and shorter runs.
#[test]
fn the_commands_of_the_studies_pages_run() {
    let dir = tempfile::tempdir().unwrap();
    for folder in ["scenes", "studies"] {
        fs::create_dir(dir.path().join(folder)).unwrap();
        for entry in fs::read_dir(root().join(folder)).unwrap() {
            let path = entry.unwrap().path();
            fs::copy(
                &path,
                dir.path().join(folder).join(path.file_name().unwrap()),
            )
            .unwrap();
        }
    }
    for (name, shorter) in [
        (
            "ladder",
            vec![
                ("count = 4", "count = 1"),
                (", 20]", ", 2.1]"),
                (", 12]", ", 2.1]"),
                (", 8]", ", 2.1]"),
            ],
        ),
        (
            "noise-budget",
            vec![
                ("count = 10", "count = 1"),
                ("set = [", "set = [\n  \"record.duration=2.1\","),
            ],
        ),
    ] {
        let path = dir.path().join(format!("studies/{name}.toml"));
        let mut study = fs::read_to_string(&path).unwrap();
        for (long, short) in shorter {
            assert!(study.contains(long), "{name}: {long}");
            study = study.replace(long, short);
        }
        fs::write(&path, study).unwrap();
        assert_eq!(run_all(dir.path(), &format!("{name}.md")), (1, 1), "{name}");
    }
}
