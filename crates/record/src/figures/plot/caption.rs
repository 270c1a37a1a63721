//! The caption of a figure: what is drawn, from which runs, what is left out.

use super::scale::{extremes, label};
use super::selection::{SEEDS, Selection};
use crate::dataset::Dataset;

/// The sentences below a figure that explain `drawn`, after the score and before the runs.
pub fn caption(selection: &Selection<'_>, drawn: String) -> Vec<String> {
    let score = selection.score;
    let mut sentences = vec![
        format!("{}: {}.", score.name, score.description),
        drawn,
        runs(selection.dataset),
    ];
    if !selection.without.is_empty() {
        let estimators = selection.without.iter();
        let list: Vec<String> = estimators
            .map(|(e, n)| format!("{e} in {n} runs"))
            .collect();
        sentences.push(format!("Without {}: {}.", score.name, list.join(", ")));
    }
    sentences.retain(|sentence| !sentence.is_empty());
    sentences
}

/// Study, scene, number of runs, seeds, failures and version.
pub fn runs(dataset: &Dataset) -> String {
    let seeds = SEEDS.into_iter().filter_map(|key| {
        let (low, high) = extremes(dataset.numbers(key).iter().flatten().copied())?;
        Some(format!("{key} {} to {}", label(low, 1.0), label(high, 1.0)))
    });
    let mut seeds: Vec<String> = seeds.collect();
    if seeds.is_empty() {
        seeds.push("one seed".to_owned());
    }
    let failed: u64 = dataset.failures().iter().map(|f| f.1).sum();
    let failures = match failed {
        0 => "none failed".to_owned(),
        failed => format!("{failed} of them failed and are not drawn"),
    };
    format!(
        "Study {}, scene {}: {} runs, {}; {failures}. Made by {}.",
        dataset.study.name,
        dataset.study.scene.display(),
        dataset.runs,
        seeds.join(", "),
        dataset.version
    )
}
