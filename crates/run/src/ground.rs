//! The ground that the estimators of a run have found.

use robhaz_estimator::{Estimator, GroundPoint};

/// The ground as the estimators of a run know it.
#[derive(Clone, Copy, Debug, Default)]
pub struct EstimatedTerrain<'a> {
    pub(crate) memory: Memory<'a>,
    /// The points that each has completed.
    pub(crate) completed: &'a [Vec<GroundPoint>],
}

/// Where the points in memory are.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Memory<'a> {
    /// In the estimators themselves.
    Live(&'a [Estimator]),
    /// In copies, one of each estimator, because the estimators are ahead of the records.
    Copied(&'a [Vec<GroundPoint>]),
}

impl Default for Memory<'_> {
    fn default() -> Self {
        Self::Live(&[])
    }
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
        match self.memory {
            Memory::Live(estimators) => !estimators.is_empty(),
            Memory::Copied(copies) => !copies.is_empty(),
        }
    }

    /// Points in the memory of an estimator: see [`Estimator::ground`]. None where
    /// [`Self::has_memory`] is false.
    pub fn in_memory(&self, estimator: usize) -> impl Iterator<Item = GroundPoint> + 'a {
        let (live, copied): (&[Estimator], &[Vec<GroundPoint>]) = match self.memory {
            Memory::Live(estimators) => (estimators, &[]),
            Memory::Copied(copies) => (&[], copies),
        };
        let live = live.get(estimator).into_iter();
        let copied = copied.get(estimator).into_iter().flatten().copied();
        live.flat_map(Estimator::ground).chain(copied)
    }
}
