//! The ablation ladder: what each method between the paper's estimators and `best` contributes.

use robhaz_estimator::{ContactAngles, EstimatorSettings, KalmanMethod, Method};
use robhaz_scene::EstimatorChoice;

/// The paper's two estimators, then from true masses to `best`: every estimator adds one method to the one before. After `best`
/// (`rolling`) the same without given contact angles: from the rolling constraints alone, then with the parity residual.
pub fn ladder() -> Vec<EstimatorChoice> {
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
    let rolling = KalmanMethod {
        rolling: true,
        ..parity
    };
    let unknown = |method| KalmanMethod {
        contact_angles: ContactAngles::Unknown,
        ..method
    };
    let rolling_alone = KalmanMethod {
        parity: false,
        ..rolling
    };
    let kalman = |method| EstimatorSettings {
        method: Method::Kalman(method),
        ..lever
    };
    let bounded = |method| EstimatorSettings {
        nonnegative: true,
        ..kalman(method)
    };
    let rungs = [
        ("paper-body", EstimatorSettings::paper_body()),
        ("paper-wheels", EstimatorSettings::paper_wheels()),
        ("true-mass", true_mass),
        ("lever", lever),
        ("kalman", kalman(filters)),
        ("inertia", kalman(inertia)),
        ("whitening", kalman(whitening)),
        ("nonnegative", bounded(whitening)),
        ("parity", bounded(parity)),
        ("rolling", bounded(rolling)),
        ("unknown-angles", bounded(unknown(rolling_alone))),
        ("no-angles", bounded(unknown(rolling))),
    ];
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
    fn the_ladder_leads_to_best_with_and_without_contact_angles() {
        let of = |name: &str| ladder().into_iter().find(|rung| rung.name == name);
        let settings = |name| of(name).map(|rung| rung.settings);
        assert_eq!(settings("rolling"), Some(EstimatorSettings::best()));
        let without = EstimatorSettings::best_without_angles();
        assert_eq!(settings("no-angles"), Some(without));
    }
}
