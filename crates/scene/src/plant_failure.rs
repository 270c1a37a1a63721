//! Errors of the plant with the keys of the scene file that a user can change.

use robhaz_sim::{NoRest, NoTruth, PlantError};

/// An error of the plant. Its message states the physical fact and then the keys that can help.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("{cause}{}", advice(cause))]
pub struct PlantFailure {
    /// The physical fact.
    pub cause: PlantError,
}

impl From<PlantError> for PlantFailure {
    fn from(cause: PlantError) -> Self {
        Self { cause }
    }
}

/// The keys that can help, as the end of a sentence; empty if it depends on the scene as a whole.
fn advice(cause: &PlantError) -> &'static str {
    match cause {
        PlantError::NoTruth { why, .. } => match why {
            NoTruth::NotFinite { .. } | NoTruth::LoopOpen { .. } => {
                "; a smaller engine.step or the other engine.kind may help"
            }
            NoTruth::EnergyMade { .. } => {
                "; a smaller engine.step, a smaller engine.tolerance or the other engine.kind may help"
            }
            NoTruth::NoStep => "; another engine.tolerance or the other engine.kind may help",
            NoTruth::WheelBelowGround { .. }
            | NoTruth::Overturned { .. }
            | NoTruth::OffTheGround { .. }
            | NoTruth::LoopRange => "",
        },
        PlantError::RawStart { .. } => "; engine.start = \"settled\" takes other ground, too",
        PlantError::NoRest { why } => match why {
            NoRest::Pose | NoRest::Contacts { .. } => {
                "; [terrain] must be smooth and not too steep around x = 0"
            }
            NoRest::Equilibrium => {
                "; a larger contact.mu_s or a flatter [terrain] around x = 0 may help"
            }
            NoRest::Motor { .. } => {
                "; drive.torque_limit, drive.kp and drive.ki determine what it gives"
            }
        },
        PlantError::Stance(_) => "",
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reference;

    /// Every key in the advice is a key of scene files, and the message starts with the physical
    /// fact.
    #[test]
    fn the_advice_names_keys_that_exist() {
        let (time, part, wheel) = (1.0, "body", 1);
        let no_truth = |why| PlantError::NoTruth { time, why };
        let no_rest = |why| PlantError::NoRest { why };
        let causes = [
            no_truth(NoTruth::NotFinite { part }),
            no_truth(NoTruth::LoopOpen { distance: 1e-3 }),
            no_truth(NoTruth::EnergyMade { made: 1.0 }),
            no_truth(NoTruth::NoStep),
            PlantError::RawStart {
                wheel,
                depth: -0.1,
                rest: 1e-3,
            },
            no_rest(NoRest::Pose),
            no_rest(NoRest::Equilibrium),
            no_rest(NoRest::Motor {
                wheel,
                torque: 2.0,
                limit: 1.0,
            }),
            no_rest(NoRest::Contacts { wheel, contacts: 2 }),
        ];
        let keys: Vec<String> = reference().into_iter().map(|row| row.key).collect();
        for cause in causes {
            let message = PlantFailure::from(cause).to_string();
            let fact = cause.to_string();
            let advice = message.strip_prefix(&fact).unwrap_or_default();
            let named: Vec<&str> = advice
                .split([' ', ',', ';'])
                .filter(|word| word.contains('.') || word.starts_with('['))
                .collect();
            assert!(!named.is_empty(), "{message}");
            for word in named {
                let section = word.strip_prefix('[').and_then(|w| w.strip_suffix(']'));
                let found = match section {
                    Some(section) => keys
                        .iter()
                        .any(|key| key.starts_with(&format!("{section}."))),
                    None => keys.iter().any(|key| key == word),
                };
                assert!(found, "{word}");
                // The plant itself knows no keys.
                assert!(!fact.contains(word), "{fact}");
            }
        }
    }
}
