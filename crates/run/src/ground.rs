//! The ground that the estimators of a run have found.

use robhaz_estimator::GroundPoint;

/// The ground as the estimators of a run know it.
#[derive(Clone, Copy, Debug, Default)]
pub struct EstimatedTerrain<'a> {
    /// The points in the memory of each.
    pub(crate) memory: &'a [Vec<GroundPoint>],
    /// The points that each has completed.
    pub(crate) completed: &'a [Vec<GroundPoint>],
}

impl<'a> EstimatedTerrain<'a> {
    /// Points that left the memory of an estimator since the last record, in their final form: see
    /// [`robhaz_estimator::Estimator::completed_ground`]. Without a control some records share
    /// them: the last one has them.
    pub fn completed(&self, estimator: usize) -> &'a [GroundPoint] {
        self.completed.get(estimator).map_or(&[], Vec::as_slice)
    }

    /// Whether this record has the points in memory: one in 0.2 s has them.
    pub const fn has_memory(&self) -> bool {
        !self.memory.is_empty()
    }

    /// Points in the memory of an estimator: see [`robhaz_estimator::Estimator::ground`]. None where
    /// [`Self::has_memory`] is false.
    pub fn in_memory(&self, estimator: usize) -> &'a [GroundPoint] {
        self.memory.get(estimator).map_or(&[], Vec::as_slice)
    }
}
