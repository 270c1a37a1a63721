//! A part of the runs.

use std::fmt;
use std::num::NonZeroU64;

/// A part of the runs, for one of several machines: every `of`-th run from the `part`-th on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shard {
    part: u64,
    of: NonZeroU64,
}

impl Shard {
    /// All runs.
    pub const ALL: Self = Self {
        part: 1,
        of: NonZeroU64::MIN,
    };

    /// Part `part` of `of`, from 1 on; `None` if there is no such part.
    pub fn new(part: u64, of: u64) -> Option<Self> {
        let of = NonZeroU64::new(of)?;
        (1..=of.get()).contains(&part).then_some(Self { part, of })
    }

    /// Whether a run belongs to it.
    pub fn has(&self, run: u64) -> bool {
        run % self.of == self.part - 1
    }

    /// How many of `runs` runs belong to it.
    pub fn count(&self, runs: u64) -> u64 {
        (runs + self.of.get() - self.part) / self.of
    }
}

/// `2-of-8`
impl fmt::Display for Shard {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}-of-{}", self.part, self.of)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Property: every run belongs to one shard, and the shards count right.
    #[test]
    fn shards_share_all_runs() {
        for (runs, of) in [(0, 1), (1, 3), (10, 3), (12, 4), (5, 7)] {
            let shards: Vec<Shard> = (1..=of).filter_map(|part| Shard::new(part, of)).collect();
            assert_eq!(shards.len() as u64, of);
            for shard in &shards {
                let count = (0..runs).filter(|run| shard.has(*run)).count() as u64;
                assert_eq!(count, shard.count(runs), "{shard:?} of {runs}");
            }
            for run in 0..runs {
                assert_eq!(shards.iter().filter(|shard| shard.has(run)).count(), 1);
            }
        }
        assert_eq!((Shard::new(0, 3), Shard::new(4, 3)), (None, None));
        assert_eq!(Shard::new(1, 0), None);
    }
}
