//! Why a robot cannot be weighed.

use robhaz_model::PostureError;
use std::fmt;

/// What functions of this crate return.
pub(crate) type Result<T, E = WeighError> = std::result::Result<T, E>;

/// Why a robot cannot be weighed: what was found, what is allowed, what helps.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct WeighError(String);

impl WeighError {
    pub(crate) fn new(message: impl fmt::Display) -> Self {
        Self(message.to_string())
    }

    /// The only axle of a link is above or below pin Q, or P, R and S lie on one line.
    pub(crate) fn undetermined() -> Self {
        Self::new("the static forces of the wheels are not determined in this posture")
    }

    pub(crate) fn not_converged() -> Self {
        Self::new(
            "the least squares do not converge: the readings are far from what this robot can show",
        )
    }

    /// The statics of the robot itself, without a reading.
    pub(crate) fn of_nominal(self) -> Self {
        Self::new(format!(
            "{self}, for the nominal values in a posture of a drive; check the robot's pins"
        ))
    }
}

impl From<PostureError> for WeighError {
    fn from(error: PostureError) -> Self {
        Self::new(error)
    }
}
