//! The ground that the estimators of a run have found.

use robhaz_estimator::{Estimator, GroundPoint};

/// The ground as the estimators of a run know it.
#[derive(Clone, Copy, Debug, Default)]
pub struct EstimatedTerrain<'a> {
    /// The estimators, which have the points in memory.
    pub(crate) estimators: &'a [Estimator],
    /// Copies of these points, one of each estimator, where the estimators are ahead of the records.
    pub(crate) copies: &'a [Vec<GroundPoint>],
    /// The points that each has completed.
    pub(crate) completed: &'a [Vec<GroundPoint>],
}

impl<'a> EstimatedTerrain<'a> {
    /// Points that left the memory of an estimator since the last record, in their final form: see
    /// [`Estimator::completed_ground`]. In a run on several threads some records share them: the
    /// last one has them.
    pub fn completed(&self, estimator: usize) -> &'a [GroundPoint] {
        self.completed.get(estimator).map_or(&[], Vec::as_slice)
    }

    /// Whether this record has the points in memory. In a run on several threads one in 0.2 s has
    /// them.
    pub const fn has_memory(&self) -> bool {
        !self.estimators.is_empty() || !self.copies.is_empty()
    }

    /// Points in the memory of an estimator: see [`Estimator::ground`]. None where
    /// [`Self::has_memory`] is false.
    pub fn in_memory(&self, estimator: usize) -> impl Iterator<Item = GroundPoint> + 'a {
        let live = self.estimators.get(estimator).into_iter();
        let copied = self.copies.get(estimator).into_iter().flatten().copied();
        live.flat_map(Estimator::ground).chain(copied)
    }
}
