//! Why a robot cannot be weighed.

use crate::statics::PlateError;

/// Why a robot cannot be weighed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum WeighError {
    /// Nothing was measured.
    #[error("there is no reading of a scale; allowed: at least one")]
    Nothing,
    /// A tolerance or an accuracy is not possible.
    #[error("{name} is {found}; allowed: {allowed}")]
    Deviation {
        /// In words.
        name: &'static str,
        /// Its value.
        found: f64,
        /// The range.
        allowed: &'static str,
    },
    /// The statics of a posture.
    #[error("line {line}: {source}; check the inclinations and the robot's pins")]
    Posture {
        /// Line of the table.
        line: u64,
        /// The cause.
        source: PlateError,
    },
    /// The statics of the robot itself, without a reading.
    #[error("{0}, for the nominal values in a posture of a drive; check the robot's pins")]
    Statics(PlateError),
    /// A posture beyond the end stops of pin Q.
    #[error(
        "line {line}: theta_1 - theta_2 is {found:.1} deg, beyond the end stops of pin Q; allowed: {lower:.1} to {upper:.1} deg; \
         check signs and units"
    )]
    Stop {
        /// Line of the table.
        line: u64,
        /// The angle, deg.
        found: f64,
        /// Limits, deg.
        lower: f64,
        /// Upper limit, deg.
        upper: f64,
    },
    /// The iteration does not settle.
    #[error(
        "the least squares do not converge: the readings are far from what this robot can show"
    )]
    NotConverged,
    /// The result is not a valid robot, or cannot stand.
    #[error("the readings lead to an impossible robot: {reason}")]
    Impossible {
        /// In words.
        reason: String,
    },
    /// The readings contradict each other or the nominal values.
    #[error(
        "the readings do not fit a robot within the stated errors: the weighted sum of squares is {sum:.1}, allowed: at most \
         {most:.1} for {readings} readings{worst}"
    )]
    Misfit {
        /// The sum.
        sum: f64,
        /// The limit.
        most: f64,
        /// Number of readings.
        readings: usize,
        /// The worst reading, in words.
        worst: String,
    },
}
