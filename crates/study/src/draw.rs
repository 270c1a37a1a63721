//! Drawn values: a function of the study's seed, the key and the sample's index.

use robhaz_scene::{AxisValue, Distribution, DrawMethod, Draws};
use robhaz_sim::random::Stream;

/// The samples of one drawn axis.
#[derive(Clone, Debug)]
pub struct Samples {
    key: String,
    distribution: Distribution,
    draws: Draws,
    /// The interval of each sample in a Latin hypercube; empty for independent draws.
    order: Vec<u32>,
}

impl Samples {
    /// The samples of a key.
    pub fn new(key: &str, distribution: Distribution, draws: Draws) -> Self {
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
    pub fn value(&self, sample: u64) -> AxisValue {
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
    pub fn extremes(&self) -> [u64; 2] {
        let number = |sample: u64| match self.value(sample) {
            // For an order alone.
            AxisValue::Whole(whole) => whole as f64,
            AxisValue::Number(number) => number,
            _ => f64::NAN,
        };
        let numbers = (0..self.draws.count).map(|sample| (sample, number(sample)));
        let (mut least, mut largest) = ((0, f64::INFINITY), (0, f64::NEG_INFINITY));
        for (sample, value) in numbers {
            if value < least.1 {
                least = (sample, value);
            }
            if value > largest.1 {
                largest = (sample, value);
            }
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
