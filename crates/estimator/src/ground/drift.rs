//! The errors of dead reckoning and of the stored heights: one Kalman filter.

use crate::deviation::GATE;
use crate::filters::motion::SLOPE_LENGTH;
use crate::filters::{Kalman, Measurement};

/// Error of the height of Q, m.
const DRIFT: usize = 0;
/// Fluctuating error of the direction of the velocity: of dy/dx.
const SLOPE: usize = 1;
/// Slow part of that error.
const SLOW_SLOPE: usize = 2;
/// Errors of the angles of links 1 and 2, rad.
const LINK_BIAS: usize = 3;
/// Errors of the stored heights at the nodes, m: node `j` is in the state
/// `NODES + j mod NODE_COUNT`.
const NODES: usize = 5;
/// Nodes in memory.
pub const NODE_COUNT: usize = 18;
const COUNT: usize = NODES + NODE_COUNT;

/// Standard deviation of the slow part, as dy/dx: 1.1 deg. Offsets of torques leave such an error
/// in the motion filter for as long as they are not found: 1 N at each wheel of a robot of 14 kg is
/// 1.2 deg.
/// Chosen; held by `crates/run/tests/run/ground.rs`.
const SLOW: f64 = 0.02;
/// Measurements over which the misfit is averaged: two wheels over about 0.2 m.
/// Chosen; sensitive. Held by `crates/run/tests/run/ground.rs`.
const RECENT: f64 = 40.0;

/// The height of a contact relative to Q, and how it errs.
#[derive(Clone, Copy, Debug)]
pub struct Lever {
    /// Link of the wheel, 0 or 1.
    pub link: usize,
    /// Horizontal distance of the axle from Q, m: the derivative of the height with respect to the
    /// link's angle.
    pub arm: f64,
}

/// A place by the node behind it, and its share of the way from there to the next.
pub type Between = (i64, f64);

/// See the module.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drift {
    filter: Kalman<COUNT>,
    /// Mean of the normalised squared innovations of the last [`RECENT`] or so measurements: the
    /// variance factor of adjustment theory.
    misfit: f64,
}

/// State of a node.
fn state_of(node: i64) -> usize {
    // The remainder lies between 0 and NODE_COUNT.
    NODES + node.rem_euclid(NODE_COUNT as i64) as usize
}

impl Drift {
    /// At the start of a section. `bias`: standard deviation of a link angle, rad. The height of
    /// the contact with `origin` is exact: it defines the datum.
    pub fn new(bias: f64, origin: Lever) -> Self {
        let mut filter = Kalman::new([0.0; COUNT], [0.0; COUNT]);
        let variance = bias * bias;
        for state in [LINK_BIAS, LINK_BIAS + 1] {
            filter.p[state][state] = variance;
        }
        let state = LINK_BIAS + origin.link.min(1);
        filter.p[DRIFT][DRIFT] = origin.arm * origin.arm * variance;
        filter.p[DRIFT][state] = -origin.arm * variance;
        filter.p[state][DRIFT] = -origin.arm * variance;
        filter.p[SLOW_SLOPE][SLOW_SLOPE] = SLOW * SLOW;
        Self {
            filter,
            misfit: 1.0,
        }
    }

    /// Advances along the path by `forward` (m, horizontal, negative backwards) over the length
    /// `length` (m). `sigma`: standard deviation of the direction's error.
    pub fn advance(&mut self, forward: f64, length: f64, sigma: f64) {
        let Kalman { x, p } = &mut self.filter;
        x[DRIFT] += forward * (x[SLOPE] + x[SLOW_SLOPE]);
        for k in 0..COUNT {
            p[DRIFT][k] += forward * (p[SLOPE][k] + p[SLOW_SLOPE][k]);
        }
        for k in 0..COUNT {
            p[k][DRIFT] += forward * (p[k][SLOPE] + p[k][SLOW_SLOPE]);
        }
        let keep = libm::exp(-length / SLOPE_LENGTH);
        x[SLOPE] *= keep;
        for k in 0..COUNT {
            p[SLOPE][k] *= keep;
            p[k][SLOPE] *= keep;
        }
        p[SLOPE][SLOPE] += sigma * sigma * (1.0 - keep * keep);
    }

    /// Sets a node as seen by a wheel at a distance of `ahead` (m) behind it:
    /// `z = e + arm beta + ahead s`.
    pub fn open(&mut self, node: i64, lever: Lever, ahead: f64) {
        let h = [
            (DRIFT, 1.0),
            (LINK_BIAS + lever.link.min(1), lever.arm),
            (SLOPE, ahead),
            (SLOW_SLOPE, ahead),
        ];
        let seen = self.filter.project(&h);
        let n = state_of(node);
        let Kalman { x, p } = &mut self.filter;
        if let Some(state) = x.get_mut(n) {
            *state = seen.value;
        }
        for (k, covariance) in seen.ph.iter().enumerate() {
            let covariance = if k == n { seen.variance } else { *covariance };
            for (i, j) in [(n, k), (k, n)] {
                if let Some(entry) = p.get_mut(i).and_then(|row| row.get_mut(j)) {
                    *entry = covariance;
                }
            }
        }
    }

    /// Estimated error of the height of a contact, m.
    pub fn of_contact(&self, lever: Lever) -> f64 {
        let h = [(DRIFT, 1.0), (LINK_BIAS + lever.link.min(1), lever.arm)];
        self.filter.project(&h).value
    }

    /// Estimated error of the direction of the velocity, as dy/dx, and its variance, as the filter
    /// states it: the prior of its slow part, and what the passes show.
    pub fn stated_direction(&self) -> (f64, f64) {
        self.combination(&[(SLOPE, 1.0), (SLOW_SLOPE, 1.0)])
    }

    /// The velocity was corrected: its direction, as dy/dx, has changed by `change`.
    pub fn direction_corrected(&mut self, change: f64) {
        if let Some(error) = self.filter.x.get_mut(SLOW_SLOPE) {
            *error += change;
        }
    }

    /// That error and its variance.
    ///
    /// On even ground the passes agree far better than the stated errors of the velocity let
    /// expect. The variance is therefore that of the filter times the variance factor, at most 1,
    /// plus what no pass shows: the common error of the link angles.
    pub fn direction(&self) -> (f64, f64) {
        let (error, variance) = self.stated_direction();
        let p = &self.filter.p;
        let bias = 0.25
            * (p[LINK_BIAS][LINK_BIAS]
                + 2.0 * p[LINK_BIAS][LINK_BIAS + 1]
                + p[LINK_BIAS + 1][LINK_BIAS + 1])
                .max(0.0);
        (error, self.misfit.min(1.0) * variance + bias)
    }

    fn weights((node, share): Between) -> [(usize, f64); 2] {
        [
            (state_of(node), 1.0 - share),
            (state_of(node.saturating_add(1)), share),
        ]
    }

    /// Error of the stored height at a place, m, and its variance, m^2.
    pub fn at(&self, place: Between) -> (f64, f64) {
        self.combination(&Self::weights(place))
    }

    /// Error of the stored slope dy/dx at a place, for nodes at a distance of `spacing` (m), and
    /// its variance.
    pub fn slope_at(&self, place: Between, spacing: f64) -> (f64, f64) {
        let [(behind, _), (ahead, _)] = Self::weights(place);
        self.combination(&[(behind, -1.0 / spacing), (ahead, 1.0 / spacing)])
    }

    fn combination(&self, h: &[(usize, f64); 2]) -> (f64, f64) {
        let found = self.filter.project(h);
        (found.value, found.variance.max(0.0))
    }

    /// Corrects all errors by a contact on mapped ground: `difference` (m) is its height minus the
    /// stored one, `variance` (m^2) that of the measurement.
    pub fn correct(&mut self, lever: Lever, place: Between, difference: f64, variance: f64) {
        let [(behind, share_behind), (ahead, share_ahead)] = Self::weights(place);
        let bias = LINK_BIAS + lever.link.min(1);
        let h = [
            (DRIFT, 1.0),
            (bias, lever.arm),
            (behind, -share_behind),
            (ahead, -share_ahead),
        ];
        let measurement = Measurement {
            row: h,
            innovation: difference - self.filter.project(&h).value,
            white: variance,
            correlated: [],
            inflation: 0.0,
            gate: GATE,
        };
        let expected = self.filter.expect(&measurement);
        self.filter.correct(&measurement, &expected, 1.0);
        let misfit = expected.innovation.nis().min(GATE);
        self.misfit += (misfit - self.misfit) / RECENT;
    }

    /// Factor by which the variances of what is stored are too small, at least 1: the heights that
    /// the wheels find at the same places contradict each other.
    pub fn contradiction(&self) -> f64 {
        self.misfit.max(1.0)
    }

    /// Whether a number has left the range of sensible ones.
    pub fn is_lost(&self) -> bool {
        /// Guard.
        const LIMIT: f64 = 1e6;
        let Kalman { x, p } = &self.filter;
        let mut numbers = x.iter().chain(p.iter().flatten());
        // Written so that a NaN is lost, too.
        !numbers.all(|number| number.abs() < LIMIT)
    }
}
