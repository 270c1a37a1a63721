//! The settings of every run, and which runs have one truth.

use crate::draw::Samples;
use robhaz_scene::{Axis, AxisValue, AxisValues, Setting, StudyChoice};

/// The runs of a study. Axes that are lists make a grid, in which the first axis varies slowest.
/// All drawn axes together are one more list, of the samples, which varies fastest: every place of
/// the grid has the same samples.
#[derive(Clone, Debug)]
pub struct Plan {
    axes: Vec<Axis>,
    /// The samples of each drawn axis, `None` for others.
    samples: Vec<Option<Samples>>,
    /// The slowest first; the last one is that of the samples.
    lists: Vec<List>,
}

/// What varies in one direction of the grid.
#[derive(Clone, Debug)]
struct List {
    /// Its axis; `None` for the samples.
    axis: Option<usize>,
    length: u64,
    /// Runs from an item to the next.
    stride: u64,
    /// Whether the truth depends on it.
    changes_truth: bool,
}

impl List {
    fn item(&self, run: u64) -> u64 {
        run / self.stride % self.length
    }
}

impl Plan {
    /// The runs of a study. Until [`Self::share`] each has a truth of its own.
    pub fn new(study: &StudyChoice) -> Self {
        let samples = study
            .axes
            .iter()
            .map(|axis| match (&axis.values, study.draws) {
                (AxisValues::Drawn(distribution), Some(draws)) => {
                    let key = axis.keys.first()?;
                    Some(Samples::new(key, *distribution, draws))
                }
                _ => None,
            });
        let of_axes = study.axes.iter().enumerate();
        let of_axes = of_axes.filter_map(|(i, axis)| Some((Some(i), axis.length()?)));
        let sample_count = study.draws.map_or(1, |draws| draws.count);
        let mut lists: Vec<List> = of_axes
            .chain([(None, sample_count)])
            .map(|(axis, length)| List {
                axis,
                length,
                stride: 1,
                changes_truth: true,
            })
            .collect();
        let mut stride = 1;
        for list in lists.iter_mut().rev() {
            list.stride = stride;
            // The study file was checked: no overflow.
            stride *= list.length;
        }
        Self {
            samples: samples.collect(),
            axes: study.axes.clone(),
            lists,
        }
    }

    /// The axes.
    pub fn axes(&self) -> &[Axis] {
        &self.axes
    }

    /// Number of runs.
    pub fn runs(&self) -> u64 {
        self.lists.iter().map(|list| list.length).product()
    }

    /// Number of different truths. Each is that of [`Self::runs_of_truth`] runs.
    pub fn truths(&self) -> u64 {
        self.count(true)
    }

    /// Number of runs of each truth.
    pub fn runs_of_truth(&self) -> u64 {
        self.count(false)
    }

    fn count(&self, changes_truth: bool) -> u64 {
        let lists = self.lists.iter();
        let those = lists.filter(|list| list.changes_truth == changes_truth);
        those.map(|list| list.length).product()
    }

    /// A run of a truth, each counted from 0 on.
    pub fn run(&self, mut truth: u64, mut place: u64) -> u64 {
        let mut run = 0;
        for list in self.lists.iter().rev() {
            let rest = match list.changes_truth {
                true => &mut truth,
                false => &mut place,
            };
            run += *rest % list.length * list.stride;
            *rest /= list.length;
        }
        run
    }

    /// Notes which lists leave the truth as it is: those for which `same` says so of the first run
    /// and each of the [`Self::representatives`] of the list.
    pub fn share(&mut self, same: impl Fn(u64) -> bool) {
        let found: Vec<bool> = self
            .lists
            .iter()
            .map(|list| self.of_list(list).into_iter().all(&same))
            .collect();
        for (list, same) in self.lists.iter_mut().zip(found) {
            list.changes_truth = !same;
        }
    }

    /// The settings of a run, axis by axis.
    pub fn settings(&self, run: u64) -> Vec<Setting> {
        let mut settings = Vec::new();
        for (place, axis) in self.axes.iter().enumerate() {
            let list = self.lists.iter().find(|list| list.axis == Some(place));
            let item = list.map_or(0, |list| list.item(run));
            let (mut name, values) = self.item(place, item, run);
            settings.extend(axis.keys.iter().zip(values).map(|(key, value)| Setting {
                axis: place,
                item,
                key: key.clone(),
                value,
                // That of the first key alone.
                name: name.take(),
            }));
        }
        settings
    }

    /// Name and values of an item of an axis, in a run.
    fn item(&self, axis: usize, item: u64, run: u64) -> (Option<String>, Vec<AxisValue>) {
        match (&self.axes[axis].values, &self.samples[axis]) {
            (AxisValues::List(items), _) => {
                let item = usize::try_from(item).ok().and_then(|i| items.get(i));
                let item = item.map(|item| (item.name.clone(), item.values.clone()));
                item.unwrap_or_default()
            }
            (AxisValues::Whole { first, .. }, _) => {
                // The study file was checked: no overflow.
                let item = i64::try_from(item).unwrap_or(i64::MAX);
                (None, vec![AxisValue::Whole(first.saturating_add(item))])
            }
            (AxisValues::Drawn(_), samples) => {
                let count = self.lists.last().map_or(1, |list| list.length);
                let sample = samples.iter().map(|samples| samples.value(run % count));
                (None, sample.collect())
            }
        }
    }

    /// Runs that have every item of every list once, the others at their first item; of an axis
    /// that counts the first and the last, of a drawn one the least and the largest.
    pub fn representatives(&self) -> Vec<u64> {
        let of_lists = self.lists.iter().flat_map(|list| self.of_list(list));
        let mut runs: Vec<u64> = std::iter::once(0).chain(of_lists).collect();
        runs.sort_unstable();
        runs.dedup();
        runs
    }

    /// Those of one list.
    fn of_list(&self, list: &List) -> Vec<u64> {
        match list.axis.map(|axis| &self.axes[axis].values) {
            None => self
                .samples
                .iter()
                .flatten()
                .flat_map(Samples::extremes)
                .collect(),
            Some(AxisValues::List(_)) => (1..list.length).map(|item| item * list.stride).collect(),
            Some(_) => vec![(list.length - 1) * list.stride],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use robhaz_scene::SceneError;
    use std::collections::HashSet;

    fn plan(axes: &str) -> Result<Plan, SceneError> {
        let text = format!("scene = \"a.toml\"\n{axes}");
        Ok(Plan::new(&StudyChoice::parse(&text, "study.toml")?))
    }

    fn shown(plan: &Plan, run: u64) -> String {
        let settings = plan.settings(run).into_iter();
        settings
            .map(|s| s.as_override())
            .collect::<Vec<_>>()
            .join(" ")
    }

    /// Every combination once, the first axis slowest; linked keys vary together.
    #[test]
    fn a_grid_has_every_combination_once() -> Result<(), SceneError> {
        let plan = plan(
            "[[axis]]\nkey = \"a\"\nvalues = [1, 2.5]\n[[axis]]\nkeys = [\"b\", \"c\"]\nvalues = [[\"x\", true], [\"y\", false]]\n\
             [[axis]]\nkey = \"seed\"\nfirst = 7\ncount = 3",
        )?;
        assert_eq!(plan.runs(), 12);
        assert_eq!(shown(&plan, 0), "a=1 b=\"x\" c=true seed=7");
        assert_eq!(shown(&plan, 1), "a=1 b=\"x\" c=true seed=8");
        assert_eq!(shown(&plan, 3), "a=1 b=\"y\" c=false seed=7");
        assert_eq!(shown(&plan, 11), "a=2.5 b=\"y\" c=false seed=9");
        let all: HashSet<String> = (0..12).map(|run| shown(&plan, run)).collect();
        assert_eq!(all.len(), 12);
        // Every item of every list once.
        assert_eq!(plan.representatives(), [0, 2, 3, 6]);
        Ok(())
    }

    /// Each run belongs to one truth. Those of one truth differ in the lists alone that leave it as
    /// it is.
    #[test]
    fn runs_of_one_truth_differ_in_what_leaves_it() -> Result<(), SceneError> {
        let mut plan = plan(
            "[[axis]]\nkey = \"seed\"\ncount = 3\n[[axis]]\nkey = \"a\"\nvalues = [1, 2]\n\
             [[axis]]\nkey = \"b\"\nuniform = [0, 1]\n[draw]\ncount = 4",
        )?;
        assert_eq!((plan.truths(), plan.runs_of_truth()), (24, 1));
        // Only `a`, every fourth run, changes the truth.
        plan.share(|run| run / 4 % 2 == 0);
        assert_eq!((plan.truths(), plan.runs_of_truth()), (2, 12));
        let mut all = HashSet::new();
        for truth in 0..2 {
            for place in 0..12 {
                let run = plan.run(truth, place);
                assert_eq!(run / 4 % 2, truth);
                all.insert(run);
            }
        }
        assert_eq!(all, (0..24).collect());
        Ok(())
    }

    /// Every place of a grid has the same samples, in pairs of the drawn axes.
    #[test]
    fn samples_are_the_same_everywhere() -> Result<(), SceneError> {
        let plan = plan(
            "[[axis]]\nkey = \"a\"\nuniform = [0, 1]\n[[axis]]\nkey = \"b\"\nvalues = [1, 2]\n\
             [[axis]]\nkey = \"c\"\nwhole = [0, 9]\n[draw]\ncount = 4",
        )?;
        assert_eq!(plan.runs(), 8);
        for run in 0..4 {
            let [here, there] = [run, run + 4].map(|run| plan.settings(run));
            assert_eq!((&here[0], &here[2]), (&there[0], &there[2]));
            assert_ne!(here[1], there[1]);
        }
        Ok(())
    }
}
