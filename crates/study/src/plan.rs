//! The settings of every run, and which runs have one truth. Drawn values are a function of the
//! study's seed, the key and the sample's index.

use robhaz_scene::{
    Axis, AxisValue, AxisValues, Distribution, DrawMethod, Draws, Setting, StudyChoice,
};
use robhaz_sim::random::Stream;

/// The runs of a study. Axes that are lists make a grid, in which the first axis varies slowest.
/// All drawn axes together are one more list, of the samples, which varies fastest: every place of
/// the grid has the same samples.
#[derive(Clone, Debug)]
pub struct Plan {
    /// The axes.
    pub axes: Vec<Axis>,
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
        let samples = |axis: &Axis| match (&axis.values, study.draws) {
            (AxisValues::Drawn(distribution), Some(draws)) => {
                let key = axis.keys.first()?;
                Some(Samples::new(key, *distribution, draws))
            }
            _ => None,
        };
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
            samples: study.axes.iter().map(samples).collect(),
            axes: study.axes.clone(),
            lists,
        }
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
        let is_same = |list: &List| self.of_list(list).into_iter().all(&same);
        let found: Vec<bool> = self.lists.iter().map(is_same).collect();
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
            None => {
                let samples = self.samples.iter().flatten();
                samples.flat_map(Samples::extremes).collect()
            }
            Some(AxisValues::List(_)) => (1..list.length).map(|item| item * list.stride).collect(),
            Some(_) => vec![(list.length - 1) * list.stride],
        }
    }
}

/// The samples of one drawn axis.
#[derive(Clone, Debug)]
struct Samples {
    key: String,
    distribution: Distribution,
    draws: Draws,
    /// The interval of each sample in a Latin hypercube; empty for independent draws.
    order: Vec<u32>,
}

impl Samples {
    /// The samples of a key.
    fn new(key: &str, distribution: Distribution, draws: Draws) -> Self {
        let order = match draws.method {
            DrawMethod::LatinHypercube => shuffled(key, draws),
            DrawMethod::Random => Vec::new(),
        };
        Self {
            key: key.to_owned(),
            distribution,
            draws,
            order,
        }
    }

    /// The value of a sample.
    fn value(&self, sample: u64) -> AxisValue {
        let u = uniform(self.draws.seed, &format!("{} {sample}", self.key));
        let interval = usize::try_from(sample).ok();
        // At most 1e8 samples.
        let u = match interval.and_then(|sample| self.order.get(sample)) {
            Some(interval) => (f64::from(*interval) + u) / self.draws.count as f64,
            None => u,
        };
        quantile(self.distribution, u)
    }

    /// The samples with the least and the largest value.
    fn extremes(&self) -> [u64; 2] {
        let number = |sample: u64| match self.value(sample) {
            // For an order alone.
            AxisValue::Whole(whole) => whole as f64,
            AxisValue::Number(number) => number,
            _ => f64::NAN,
        };
        let (mut least, mut largest) = ((0, f64::INFINITY), (0, f64::NEG_INFINITY));
        for next in (0..self.draws.count).map(|sample| (sample, number(sample))) {
            least = if next.1 < least.1 { next } else { least };
            largest = if next.1 > largest.1 { next } else { largest };
        }
        [least.0, largest.0]
    }
}

/// A random permutation of 0 to count - 1.
fn shuffled(key: &str, draws: Draws) -> Vec<u32> {
    // Study files have at most 1e8 samples.
    let count = u32::try_from(draws.count).unwrap_or(u32::MAX);
    let mut stream = Stream::new(draws.seed, &format!("{key} order"));
    let mut order: Vec<u32> = (0..count).collect();
    // Fisher and Yates.
    for i in (1..order.len()).rev() {
        // A random index from 0 to i.
        let j = (stream.uniform() * (i + 1) as f64) as usize;
        order.swap(i, j.min(i));
    }
    order
}

/// Above 0 and below 1.
fn uniform(seed: u64, name: &str) -> f64 {
    const LEAST: f64 = 1.0 / (1_u64 << 54) as f64;
    Stream::new(seed, name).uniform().max(LEAST)
}

/// The value below which a share `u` of a distribution lies. `libm`, so that all machines compute
/// the same bits.
fn quantile(distribution: Distribution, u: f64) -> AxisValue {
    AxisValue::Number(match distribution {
        Distribution::Uniform(low, high) => low + (high - low) * u,
        Distribution::LogUniform(low, high) => {
            let (low_log, high_log) = (libm::log(low), libm::log(high));
            libm::exp(low_log + (high_log - low_log) * u)
                .max(low)
                .min(high)
        }
        Distribution::Normal(mean, sigma) => mean + sigma * standard_normal(u),
        Distribution::Whole(first, last) => {
            // Below 2^63; beyond 2^53 some numbers are never drawn.
            let step = ((last - first) as f64 * u + u).floor() as i64;
            return AxisValue::Whole(first.saturating_add(step).min(last));
        }
    })
}

/// Inverse of the distribution function of N(0, 1), by bisection: to the last bits, for `u` between
/// 1e-17 and 1 - 1e-16.
fn standard_normal(u: f64) -> f64 {
    let below = |x: f64| 0.5 * libm::erfc(-x / std::f64::consts::SQRT_2);
    let (mut low, mut high) = (-9.0, 9.0);
    // 18 / 2^60 is below the distance of two doubles near 1.
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if below(middle) < u {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
}

#[cfg(test)]
mod tests {
    use super::*;
    use robhaz_scene::FileError;
    use std::collections::HashSet;

    fn plan(axes: &str) -> Result<Plan, FileError> {
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
    fn a_grid_has_every_combination_once() -> Result<(), FileError> {
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
    fn runs_of_one_truth_differ_in_what_leaves_it() -> Result<(), FileError> {
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
    fn samples_are_the_same_everywhere() -> Result<(), FileError> {
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

    fn numbers(distribution: Distribution, method: DrawMethod, count: u64) -> Vec<f64> {
        let draws = Draws {
            count,
            seed: 3,
            method,
        };
        let samples = Samples::new("drive.kp", distribution, draws);
        let number = |sample| match samples.value(sample) {
            AxisValue::Number(number) => number,
            AxisValue::Whole(whole) => f64::from(i32::try_from(whole).expect("small")),
            other => panic!("{other}"),
        };
        (0..count).map(number).collect()
    }

    /// Closed form: quantiles of N(0, 1) of Abramowitz and Stegun, table 26.1.
    #[test]
    fn normal_quantiles() {
        assert!(standard_normal(0.5).abs() < 1e-15);
        assert!((standard_normal(0.975) - 1.959_963_984_540_054).abs() < 1e-14);
        assert!((standard_normal(0.001) + 3.090_232_306_167_813).abs() < 1e-13);
    }

    /// Property: a Latin hypercube has one sample in each interval; its mean error falls with
    /// 1/n^1.5, far below 1/sqrt(n).
    #[test]
    fn a_latin_hypercube_fills_every_interval() {
        let mut found = numbers(
            Distribution::Uniform(2.0, 3.0),
            DrawMethod::LatinHypercube,
            100,
        );
        assert!(!found.is_sorted());
        found.sort_by(f64::total_cmp);
        for (i, value) in (0_u32..).zip(&found) {
            let from = 2.0 + f64::from(i) / 100.0;
            assert!((from..=from + 0.01).contains(value), "{i}: {value}");
        }
    }

    /// Moments within four standard errors; whole numbers reach both ends and no others.
    #[test]
    fn draws_have_their_distribution() {
        let found = numbers(Distribution::Normal(5.0, 2.0), DrawMethod::Random, 4000);
        let mean = found.iter().sum::<f64>() / 4000.0;
        assert!((mean - 5.0).abs() < 4.0 * 2.0 / 4000_f64.sqrt(), "{mean}");
        let found = numbers(
            Distribution::LogUniform(0.1, 10.0),
            DrawMethod::Random,
            4000,
        );
        let below_one = found.iter().filter(|v| **v < 1.0).count();
        // Half of them, within four standard deviations of a binomial distribution: 4 * sqrt(1000).
        assert!(below_one.abs_diff(2000) < 127, "{below_one}");
        assert!(found.iter().all(|v| (0.1..=10.0).contains(v)));
        let found = numbers(Distribution::Whole(2, 5), DrawMethod::Random, 400);
        assert!([2.0, 3.0, 4.0, 5.0].iter().all(|v| found.contains(v)));
        assert!(found.iter().all(|v| (2.0..=5.0).contains(v)));
    }

    /// Independent draws do not change when there are more of them.
    #[test]
    fn more_samples_keep_the_first() {
        let few = numbers(Distribution::Uniform(0.0, 1.0), DrawMethod::Random, 10);
        let many = numbers(Distribution::Uniform(0.0, 1.0), DrawMethod::Random, 20);
        assert_eq!(few[..], many[..10]);
    }
}
