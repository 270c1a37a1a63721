//! The ablation ladder: what each method between the paper's estimators and `best` contributes.

use robhaz_estimator::{EstimatorSettings, Filters};
use robhaz_scene::EstimatorChoice;

/// The paper's two estimators, then from true masses to `best`: every estimator adds one method to the one before.
pub fn ladder() -> Vec<EstimatorChoice> {
    let mut settings = EstimatorSettings::true_mass();
    let mut rungs = vec![
        ("paper-body", EstimatorSettings::paper_body()),
        ("paper-wheels", EstimatorSettings::paper_wheels()),
        ("true-mass", settings),
    ];
    type Step = fn(&mut EstimatorSettings);
    let steps: [(&str, Step); 7] = [
        ("lever", |s| s.moment_lever = 0.2),
        ("kalman", |s| s.filters = Filters::Kalman),
        ("inertia", |s| s.inertia = true),
        ("whitening", |s| s.whitening = true),
        ("nonnegative", |s| s.nonnegative = true),
        ("parity", |s| s.parity = true),
        ("rolling", |s| s.rolling = true),
    ];
    for (name, step) in steps {
        step(&mut settings);
        rungs.push((name, settings));
    }
    rungs
        .into_iter()
        .map(|(name, settings)| EstimatorChoice {
            name: name.to_owned(),
            settings,
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_rung_is_best() {
        let last = ladder().pop().map(|rung| rung.settings);
        assert_eq!(last, Some(EstimatorSettings::best()));
    }
}
