//! The settings of every run.

use crate::draw::Samples;
use robhaz_scene::{Axis, AxisValue, AxisValues, Setting, StudyChoice};

/// The runs of a study. Axes that are lists make a grid, in which the first axis varies slowest. All drawn axes together are
/// one more list, of the samples, which varies fastest: every place of the grid has the same samples.
#[derive(Clone, Debug)]
pub struct Plan {
    axes: Vec<Axis>,
    /// The samples of each drawn axis, `None` for others.
    samples: Vec<Option<Samples>>,
    sample_count: u64,
    runs: u64,
}

impl Plan {
    /// The runs of a study.
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
        let sample_count = study.draws.map_or(1, |draws| draws.count);
        Self {
            samples: samples.collect(),
            axes: study.axes.clone(),
            sample_count,
            // The study file was checked: no overflow.
            runs: study.axes.iter().filter_map(Axis::length).product::<u64>() * sample_count,
        }
    }

    /// The axes.
    pub fn axes(&self) -> &[Axis] {
        &self.axes
    }

    /// Number of runs.
    pub fn runs(&self) -> u64 {
        self.runs
    }

    /// The settings of a run, axis by axis.
    pub fn settings(&self, run: u64) -> Vec<Setting> {
        let sample = run % self.sample_count;
        let mut rest = run / self.sample_count;
        let mut items = vec![0; self.axes.len()];
        for (item, axis) in items.iter_mut().zip(&self.axes).rev() {
            if let Some(length) = axis.length() {
                (*item, rest) = (rest % length, rest / length);
            }
        }
        let mut settings = Vec::new();
        for (axis, item) in items.into_iter().enumerate() {
            let keys = self.axes[axis].keys.iter();
            let values = self.values(axis, item, sample);
            let mut name = self.name(axis, item);
            settings.extend(keys.zip(values).map(|(key, value)| Setting {
                axis,
                item,
                key: key.clone(),
                value,
                // That of the first key alone.
                name: name.take(),
            }));
        }
        settings
    }

    /// The name of an item of a list.
    fn name(&self, axis: usize, item: u64) -> Option<String> {
        match &self.axes[axis].values {
            AxisValues::List(items) => items.get(usize::try_from(item).ok()?)?.name.clone(),
            _ => None,
        }
    }

    fn values(&self, axis: usize, item: u64, sample: u64) -> Vec<AxisValue> {
        match (&self.axes[axis].values, &self.samples[axis]) {
            (AxisValues::List(items), _) => {
                let item = usize::try_from(item).ok().and_then(|i| items.get(i));
                item.map_or_else(Vec::new, |item| item.values.clone())
            }
            (AxisValues::Whole { first, .. }, _) => {
                // The study file was checked: no overflow.
                let item = i64::try_from(item).unwrap_or(i64::MAX);
                vec![AxisValue::Whole(first.saturating_add(item))]
            }
            (AxisValues::Drawn(_), Some(samples)) => vec![samples.value(sample)],
            (AxisValues::Drawn(_), None) => Vec::new(),
        }
    }

    /// Runs that have every item of every list once, the others at their first item; of an axis that counts the first and
    /// the last, of a drawn one the least and the largest.
    pub fn representatives(&self) -> Vec<u64> {
        let mut runs = vec![0];
        let mut stride = self.sample_count;
        for (axis, samples) in self.axes.iter().zip(&self.samples).rev() {
            if let Some(samples) = samples {
                runs.extend(samples.extremes());
            }
            let Some(length) = axis.length() else {
                continue;
            };
            match axis.values {
                AxisValues::List(_) => runs.extend((1..length).map(|item| item * stride)),
                _ => runs.push((length - 1) * stride),
            }
            stride *= length;
        }
        runs.sort_unstable();
        runs.dedup();
        runs
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
