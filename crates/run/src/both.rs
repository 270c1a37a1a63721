//! What the records of a log of both sides have.

use robhaz_estimator::whole::{WholeEstimate, WholeFrame};
use robhaz_sim::Truth;

/// Readings of both sides at one instant.
#[derive(Clone, Debug)]
pub struct BothSides {
    /// The readings.
    pub readings: WholeFrame,
    /// The truth, where the log has a table of it.
    pub truth: Option<BothTruth>,
}

/// True forces of both sides, left and right.
#[derive(Clone, Copy, Debug)]
pub struct BothTruth {
    /// N and T of the wheels of each side; N in the wheels' planes where it is known, else along the
    /// ground's normal.
    pub sides: [Truth; 2],
    /// N along the ground's normal, N.
    pub normal_force: [f64; 6],
    /// N in the planes of the wheels, N, where it is known.
    pub in_plane: Option<[f64; 6]>,
}

/// What a record of a log of both sides has beside what its sides have. Their estimates are those
/// of the two estimators of the run, left and right.
#[derive(Clone, Copy, Debug)]
pub struct BothFrame<'a> {
    /// Readings and truth.
    pub sides: &'a BothSides,
    /// The estimate; `None` where there is none.
    pub estimate: Option<&'a WholeEstimate>,
}
