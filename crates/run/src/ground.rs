//! The ground that the estimators of a run have found.

use robhaz_estimator::{Estimator, GroundPoint};

/// The ground as the estimators of a run know it.
#[derive(Clone, Copy, Debug, Default)]
pub struct FeltGround<'a> {
    estimators: &'a [Estimator],
    completed: &'a [Vec<GroundPoint>],
}

impl<'a> FeltGround<'a> {
    /// The ground of estimators, and the points that each has completed.
    pub(crate) const fn new(
        estimators: &'a [Estimator],
        completed: &'a [Vec<GroundPoint>],
    ) -> Self {
        Self {
            estimators,
            completed,
        }
    }

    /// Points that left the memory of an estimator since the last record, in their final form: see
    /// [`Estimator::completed_ground`]. For recorded readings several records may share them: the last one has them.
    pub fn completed(&self, estimator: usize) -> &'a [GroundPoint] {
        self.completed.get(estimator).map_or(&[], Vec::as_slice)
    }

    /// Points in the memory of an estimator: see [`Estimator::ground`]. None for recorded readings, whose estimators are ahead
    /// of the records.
    pub fn in_memory(&self, estimator: usize) -> impl Iterator<Item = GroundPoint> + 'a {
        let estimator = self.estimators.get(estimator);
        estimator.into_iter().flat_map(Estimator::ground)
    }
}
