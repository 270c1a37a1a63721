//! The figure of the paper that corresponds to an estimator.

use robhaz_estimator::EstimatorSettings;

/// The preset of an estimator, found from its settings. Its label is free and shows nothing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// The preset `paper-body`, Fig. 7.
    PaperBody,
    /// The preset `paper-wheels`, Fig. 8.
    PaperWheels,
    /// The preset `true-mass`.
    TrueMass,
    /// Any other settings.
    Other,
}

impl Kind {
    /// The preset with these settings. The noise budget does not count: it belongs to the scene, and the paper's
    /// method does not use it.
    pub fn of(settings: &EstimatorSettings) -> Self {
        let is = |preset: EstimatorSettings| {
            let budget = settings.budget;
            *settings == EstimatorSettings { budget, ..preset }
        };
        if is(EstimatorSettings::paper_body()) {
            Self::PaperBody
        } else if is(EstimatorSettings::paper_wheels()) {
            Self::PaperWheels
        } else if is(EstimatorSettings::true_mass()) {
            Self::TrueMass
        } else {
            Self::Other
        }
    }

    /// Stem of the file and title of the figure of an estimator with a label.
    pub fn names(self, label: &str) -> (String, String) {
        match self {
            Self::PaperBody => (
                format!("fig7_{label}"),
                "Normal forces, linkage mass lumped to the body (the paper's Fig. 7)".to_owned(),
            ),
            Self::PaperWheels => (
                format!("fig8_{label}"),
                "Normal forces, linkage mass lumped to the wheels (the paper's Fig. 8)".to_owned(),
            ),
            Self::TrueMass | Self::Other => (
                format!("normal_force_{label}"),
                format!("Normal forces, estimator {label}"),
            ),
        }
    }
}
