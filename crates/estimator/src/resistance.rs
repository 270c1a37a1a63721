//! What resists the spin of all wheels alike, as far as the motor torques show it: dry friction in
//! the gears, and rolling resistance, a moment f r N of the coefficient f.
//!
//! The torques show the sum of both, S at the mean load. In eq. (8) only rolling resistance occurs, as
//! if N acted ahead of the contact by f r. Given S > 0, both are Gaussian with the deviations of the
//! budget, g and m = f r N at the mean load:
//!
//! ```text
//! E(f r N | S) = S m^2/(g^2 + m^2),  var(f r N | S) = g^2 m^2/(g^2 + m^2)
//! ```
//!
//! Gears that are measured, with a small g, leave S to the ground. Where S exceeds [`WITHIN`] deviations
//! of g, either the gears are stiffer or the ground is softer than stated, and no reading says which: m
//! is then at least what lies beyond, and what is left is that of two alternatives. Neither gears nor
//! ground drive a wheel: of S < 0 nothing is rolling resistance, and what the split leaves is at most
//! that of a part anywhere between 0 and S.

use crate::deviation::{WITHIN, root_sum_square};
use crate::settings::NoiseBudget;
use robhaz_model::Units;

/// Gear friction and rolling resistance by their sum.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Resistance {
    /// The sum, N m, and its standard deviation.
    sum: (f64, f64),
    /// Rolling resistance at the mean load over the sum, 0 to 1.
    share: f64,
    /// Derivative of rolling resistance at the mean load by the sum.
    rate: f64,
    /// Standard deviation of the coefficient of rolling resistance that the sum leaves, -.
    pub left: f64,
    /// Standard deviation of that coefficient at a wheel that rests, -.
    pub at_rest: f64,
    /// Standard deviation of the moment that a wheel at rest may hold either way, N m.
    pub held: f64,
}

impl Resistance {
    /// Standard deviation of the sum before any reading, N m, for a budget in the robot's own units.
    pub fn prior(budget: &NoiseBudget) -> f64 {
        let rolling = budget.rolling_resistance * Units::MEAN_MOMENT;
        root_sum_square(budget.gear_friction, rolling)
    }

    /// For the sum that is found, N m, with its standard deviation.
    pub fn new(budget: &NoiseBudget, (sum, sigma): (f64, f64)) -> Self {
        let gears = budget.gear_friction;
        let stated = budget.rolling_resistance * Units::MEAN_MOMENT;
        let beyond = sum - WITHIN * gears;
        let grows = stated > 0.0 && beyond > stated;
        let rolling = if grows { beyond } else { stated };
        let square = gears * gears + rolling * rolling;
        let most = root_sum_square(sum, sigma);
        // Deviation about a `share` of `most` of what may be anything from 0 to it.
        let about =
            |share: f64| most * robhaz_model::sqrt(1.0 / 12.0 + (0.5 - share) * (0.5 - share));
        let (mut share, mut rate, mut left) = (0.0, 0.0, 0.0);
        if square > 0.0 {
            if sum > 0.0 {
                share = rolling * rolling / square;
                rate = share;
            }
            left = about(share).min(gears * rolling / robhaz_model::sqrt(square));
            if grows {
                rate += sum * 2.0 * rolling * gears * gears / (square * square);
                // Either of both may have all of it.
                left = left.max(sum * robhaz_model::sqrt(share * (1.0 - share)));
            }
        }
        let coefficient = share * sum / Units::MEAN_MOMENT;
        let at_rest = budget
            .rolling_resistance
            .min(about(0.0) / Units::MEAN_MOMENT);
        Self {
            sum: (sum, sigma),
            share,
            rate,
            left: left / Units::MEAN_MOMENT,
            at_rest: at_rest.max(coefficient),
            held: Self::prior(budget).max(sum.abs()),
        }
    }

    /// Coefficient of rolling resistance, -.
    pub fn coefficient(&self) -> f64 {
        self.share * self.sum.0 / Units::MEAN_MOMENT
    }

    /// Its derivative by the sum, 1/(N m).
    pub fn coefficient_rate(&self) -> f64 {
        self.rate / Units::MEAN_MOMENT
    }

    /// Gear friction (N m) and coefficient of rolling resistance, each with its standard deviation.
    pub fn parts(&self) -> [(f64, f64); 2] {
        let (sum, sigma) = self.sum;
        let part = |share: f64, rate: f64| {
            let left = self.left * Units::MEAN_MOMENT;
            (share * sum, root_sum_square(rate * sigma, left))
        };
        let (value, sigma) = part(self.share, self.rate);
        let coefficient = (value / Units::MEAN_MOMENT, sigma / Units::MEAN_MOMENT);
        [part(1.0 - self.share, 1.0 - self.rate), coefficient]
    }

    /// Resistance of a wheel over the sum, and its derivative by the sum: rolling resistance grows with
    /// the load, given as that over the mean one.
    pub fn under(&self, load: f64) -> [f64; 2] {
        [self.share, self.rate].map(|part| 1.0 + part * (load - 1.0))
    }

    /// Standard deviation of the resistance of a wheel that the split leaves, N m.
    pub fn left_under(&self, load: f64) -> f64 {
        self.left * Units::MEAN_MOMENT * (load - 1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn budget(gear_friction: f64, rolling_resistance: f64) -> NoiseBudget {
        NoiseBudget {
            gear_friction,
            rolling_resistance,
            ..NoiseBudget::typical()
        }
    }

    const MOMENT: f64 = Units::MEAN_MOMENT;

    /// For a sum whose deviation is that of the budget, which bounds nothing.
    fn at(budget: &NoiseBudget, sum: f64) -> Resistance {
        Resistance::new(budget, (sum, 10.0 * Resistance::prior(budget)))
    }

    fn near(a: f64, b: f64) -> bool {
        (a - b).abs() < 1e-12
    }

    /// Closed forms: without gear friction all is rolling resistance, without rolling resistance all is
    /// gear friction, however large the sum; of equal deviations each has half with a deviation of
    /// 1/sqrt(2) of each; a negative sum has none. Rounding.
    #[test]
    fn the_sum_is_split_by_the_deviations() {
        let free = at(&budget(0.0, 0.05), 0.1);
        assert!(near(free.coefficient(), 0.1 / MOMENT) && near(free.left, 0.0));
        assert!(near(free.under(1.5)[0], 1.5));
        for sum in [0.1, 3.0] {
            let firm = at(&budget(0.3, 0.0), sum);
            assert!(near(firm.coefficient(), 0.0) && near(firm.left, 0.0));
            assert!(near(firm.under(1.5)[0], 1.0) && near(firm.held, sum.max(0.3)));
        }
        let equal = at(&budget(0.05 * MOMENT, 0.05), 0.1);
        assert!(near(equal.coefficient(), 0.05 / MOMENT));
        assert!(near(equal.left, 0.05 * core::f64::consts::FRAC_1_SQRT_2));
        assert!(near(Resistance::prior(&budget(0.3, 0.4 / MOMENT)), 0.5));
        let none = at(&budget(0.0, 0.0), 0.0);
        assert!(near(none.coefficient(), 0.0) && near(none.left, 0.0));
        for sum in [-0.1, -0.9] {
            let driven = at(&budget(0.05 * MOMENT, 0.05), sum);
            assert!(near(driven.coefficient(), 0.0) && near(driven.left, equal.left));
        }
    }

    /// Closed form: a sum that is known to be 0 leaves neither; of a small one that is known, a half each
    /// is uniform from 0 to the sum, with a deviation of its length over the root of 12. Rounding.
    #[test]
    fn a_part_is_at_most_the_sum() {
        let budget = budget(0.05 * MOMENT, 0.05);
        let none = Resistance::new(&budget, (0.0, 0.0));
        assert!(near(none.left, 0.0) && near(none.at_rest, 0.0));
        let sum = 0.01 * MOMENT;
        let small = Resistance::new(&budget, (sum, 0.0));
        assert!(near(small.left, 0.01 / 12.0_f64.sqrt()));
    }

    proptest! {
        /// Property: rolling resistance and the resistance of a wheel change with the sum as their
        /// derivatives say, by central differences at 1e-6, which err by 1e-8; both are continuous, also
        /// where the deviation begins to grow.
        #[test]
        fn rates_are_derivatives(gears in 0.05_f64..0.5, stated in 0.005_f64..0.1, sum in -1.0_f64..2.0, load in 0.0_f64..2.0) {
            let budget = budget(gears, stated);
            let edges = [0.0, 2.0 * gears + stated * MOMENT];
            prop_assume!(edges.iter().all(|edge| (sum - edge).abs() > 1e-4));
            let at = |sum: f64| at(&budget, sum);
            let (h, here) = (1e-6, at(sum));
            let difference = |f: &dyn Fn(f64) -> f64| (f(sum + h) - f(sum - h)) / (2.0 * h);
            let coefficient = difference(&|sum| at(sum).coefficient());
            prop_assert!((coefficient - here.coefficient_rate()).abs() < 1e-6);
            let resisted = difference(&|sum| at(sum).under(load)[0] * sum);
            prop_assert!((resisted - here.under(load)[1]).abs() < 1e-6);
            for edge in edges {
                let [below, above] = [-1e-9, 1e-9].map(|step| at(edge + step).coefficient());
                prop_assert!((below - above).abs() < 1e-6);
            }
        }
    }
}
