//! What the inclinometers have felt over some samples.

/// What has been felt since it last corrected the states.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct FeltMean {
    /// Sum of the differences, m/s^2.
    pub sum: f64,
    /// Sum of what link 1 shows more than link 2, m/s^2.
    pub apart: f64,
    /// Number of samples with a reading.
    pub count: f64,
    /// Time, s.
    pub time: f64,
}
