//! Several ramps together: the torque offsets are common to them.

use super::result::{FrictionTestResult, RampFriction};

/// Steps of the grid from the middle to each side, and its reach in standard deviations.
const STEPS: i16 = 24;
const REACH: f64 = 3.0;
/// Degrees of freedom of the t distribution by which two ramps of a wheel may differ: large
/// differences, as on ground that changes between them, then hardly count.
const FREEDOM: f64 = 4.0;

/// The results of up to three tests, each with what the ramps of all of them show of the torque
/// offsets.
///
/// A systematic error of a torque, its offset or friction in the gear, adds to one traction and
/// subtracts from another. The sum of the three is known from the balance of the robot. Their
/// differences have the data sheet's deviation, and make up a plane: on a grid over it, the
/// probability of a point is that of the data sheet times, for each wheel with two ramps, that of
/// the difference between their mu_max at that point ([`RampLimit::friction`](super::RampLimit)).
/// Mean and deviation over the grid are mu_max and its systematic error.
///
/// Results without slip of the tested wheel stay as they are. The work is that of 2401 points: some
/// 0.1 ms.
pub fn together(tests: &[Option<FrictionTestResult>; 3]) -> [Option<FrictionTestResult>; 3] {
    let mut sums = [Sum::default(); 3];
    for i in -STEPS..=STEPS {
        for j in -STEPS..=STEPS {
            let point = |k: i16| REACH * f64::from(k) / f64::from(STEPS);
            add_point(tests, [point(i), point(j)], &mut sums);
        }
    }
    let mut found = *tests;
    for (test, sum) in found.iter_mut().zip(&sums) {
        if let Some(test) = test {
            sum.give(test);
        }
    }
    found
}

/// Adds one point of the plane of offsets, in standard deviations.
fn add_point(tests: &[Option<FrictionTestResult>; 3], [a, b]: [f64; 2], sums: &mut [Sum; 3]) {
    const HALF_ROOT_3: f64 = 0.866_025_403_784_438_6;
    // Each has the deviation 1, and their sum is zero.
    let offsets = [HALF_ROOT_3 * a + 0.5 * b, -HALF_ROOT_3 * a + 0.5 * b, -b];
    let mut weight = libm::exp(-0.5 * (a * a + b * b));
    let mut found = [None; 3];
    for (found, test) in found.iter_mut().zip(tests) {
        let limits = test.as_ref().map_or([None; 2], |test| test.limits);
        let limits = limits.iter().flatten();
        let mut ramps = limits.map(|limit| limit.friction(&offsets));
        let Some(first) = ramps.next() else {
            continue;
        };
        let of_test = match ramps.next() {
            Some(second) => OfTest::both(&first, &second),
            None => OfTest::one(&first),
        };
        weight *= of_test.likelihood;
        *found = Some(of_test);
    }
    for (sum, found) in sums.iter_mut().zip(&found) {
        if let Some(found) = found {
            sum.add(weight, found);
        }
    }
}

/// mu_max of one test at one point.
#[derive(Clone, Copy)]
struct OfTest {
    mu: f64,
    /// Variance of what its ramps do not have in common.
    variance: f64,
    /// Standard deviation of the rest.
    rest: f64,
    /// Probability density of the difference between its ramps.
    likelihood: f64,
}

impl OfTest {
    fn one(ramp: &RampFriction) -> Self {
        Self {
            mu: ramp.mu,
            variance: ramp.own * ramp.own * ramp.mu * ramp.mu,
            rest: ramp.rest,
            likelihood: 1.0,
        }
    }

    /// Mean weighted by the inverse variances, which are parts of the larger mu_max: else the
    /// smaller of two that disagree would count most. Where the ramps differ by more than their
    /// deviations, the variance is that much larger (Birge ratio).
    fn both(first: &RampFriction, second: &RampFriction) -> Self {
        let most = first.mu.max(second.mu);
        let (a, b) = (first.own * most, second.own * most);
        let (a, b) = (a * a, b * b);
        let sum = a + b;
        let difference = first.mu - second.mu;
        let square = difference * difference / sum;
        let spread = 1.0 + square / FREEDOM;
        Self {
            mu: (b * first.mu + a * second.mu) / sum,
            variance: a * b / sum * square.max(1.0),
            rest: (b * first.rest + a * second.rest) / sum,
            likelihood: 1.0 / (robhaz_model::sqrt(sum * spread) * spread * spread),
        }
    }
}

/// Weighted sums over the grid.
#[derive(Clone, Copy, Default)]
struct Sum {
    weight: f64,
    mu: f64,
    square: f64,
    variance: f64,
    rest: f64,
}

impl Sum {
    fn add(&mut self, weight: f64, test: &OfTest) {
        self.weight += weight;
        self.mu += weight * test.mu;
        self.square += weight * test.mu * test.mu;
        self.variance += weight * test.variance;
        self.rest += weight * test.rest;
    }

    fn give(&self, test: &mut FrictionTestResult) {
        if test.ramps == 0 || !(self.weight > 0.0) {
            return;
        }
        let mean = |sum: f64| sum / self.weight;
        let (mu, rest) = (mean(self.mu), mean(self.rest));
        let systematic = (mean(self.square) - mu * mu).max(0.0);
        test.mu = mu;
        test.systematic = robhaz_model::sqrt(systematic);
        test.sigma = robhaz_model::sqrt(systematic + mean(self.variance) + rest * rest);
    }
}
