//! Why a profile is refused.

/// Why a profile is refused: what was found, what is allowed.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct ProfileError(pub(crate) String);

impl ProfileError {
    /// Refuses a value that is not `inside` its range; `allowed` completes the sentence "it must be
    /// ...".
    pub(crate) fn unless(inside: bool, entry: &str, found: f64, allowed: &str) -> Result<(), Self> {
        match inside {
            true => Ok(()),
            false => Err(Self(format!("{entry} is {found}; it must be {allowed}"))),
        }
    }
}
