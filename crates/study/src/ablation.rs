//! The ablation ladder: what each method between the paper's estimators and `kalman` contributes.

use robhaz_scene::{EstimatorChoice, FileError, Scene};
use std::path::Path;

/// The study of the ladder. The paper's two estimators, then from true masses to `kalman`: every
/// estimator adds one method to the one before. After `kalman` (`rolling`) the same without given
/// contact angles: from the rolling constraints alone, then with the parity residual.
const STUDY: &str = include_str!("../../../studies/ladder.toml");

/// Its estimators as an override of a scene: its only text in three quotes.
pub(crate) fn steps() -> &'static str {
    STUDY.split("\"\"\"").nth(1).unwrap_or_default()
}

/// The estimators of the ladder.
///
/// # Errors
/// [`FileError`]: none, as the test of this function shows.
pub fn ladder() -> Result<Vec<EstimatorChoice>, FileError> {
    let overrides = [steps().to_owned()];
    Ok(Scene::parse("", "ladder", Path::new(""), &overrides)?.estimators)
}

#[cfg(test)]
mod tests {
    use super::*;
    use robhaz_estimator::{ContactAngles, EstimatorSettings, KalmanMethod, Method};

    /// Every step has one method more than the one before, from the paper's estimators to `kalman`,
    /// with and without contact angles.
    #[test]
    fn every_step_adds_one_method() -> Result<(), FileError> {
        let true_mass = EstimatorSettings::true_mass();
        let lever = EstimatorSettings {
            moment_lever: 0.2,
            ..true_mass
        };
        let filters = KalmanMethod::FILTERS_ONLY;
        let inertia = KalmanMethod {
            inertia: true,
            ..filters
        };
        let whitening = KalmanMethod {
            whitening: true,
            ..inertia
        };
        let parity = KalmanMethod {
            parity: true,
            ..whitening
        };
        let unknown = KalmanMethod {
            parity: false,
            rolling: true,
            contact_angles: ContactAngles::Unknown,
            ..parity
        };
        let kalman = |method| EstimatorSettings {
            method: Method::Kalman(method),
            ..lever
        };
        let bounded = |method| EstimatorSettings {
            nonnegative: true,
            ..kalman(method)
        };
        let steps = [
            ("paper-body", EstimatorSettings::paper_body()),
            ("paper-wheels", EstimatorSettings::paper_wheels()),
            ("true-mass", true_mass),
            ("lever", lever),
            ("kalman", kalman(filters)),
            ("inertia", kalman(inertia)),
            ("whitening", kalman(whitening)),
            ("nonnegative", bounded(whitening)),
            ("parity", bounded(parity)),
            ("rolling", EstimatorSettings::kalman()),
            ("unknown-angles", bounded(unknown)),
            (
                "kalman-no-angles",
                EstimatorSettings::kalman_without_angles(),
            ),
        ];
        let expected = steps.map(|(name, settings)| EstimatorChoice {
            name: name.to_owned(),
            settings,
            damping: None,
        });
        assert_eq!(ladder()?, expected);
        Ok(())
    }
}
