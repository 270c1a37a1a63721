//! What resists the spin of all wheels alike, as far as the motor torques show it: dry friction in
//! the gears, and rolling resistance, a moment f r N of the coefficient f.
//!
//! Both look alike in the torques: the filters find their sum at the mean load. In eq. (8) only the
//! second one occurs, as if N acted ahead of the contact by f r. Given the sum S, both are Gaussian
//! with the deviations of the budget, g and m = f r N at the mean load:
//!
//! ```text
//! E(f r N | S) = S m^2/(g^2 + m^2),  var(f r N | S) = g^2 m^2/(g^2 + m^2)
//! ```
//!
//! Gears that are measured, with a small g, leave S to the ground. A sum beyond [`WITHIN`] deviations
//! of g is no longer the gears': m is then at least what lies beyond.

use crate::deviation::{WITHIN, root_sum_square};
use crate::settings::NoiseBudget;
use robhaz_model::Units;

/// Gear friction and rolling resistance by their sum.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Resistance {
    /// Share of the sum that is rolling resistance, 0 to 1.
    share: f64,
    /// Standard deviation of the coefficient of rolling resistance that the sum leaves, -.
    pub left: f64,
}

impl Resistance {
    /// Standard deviation of the sum before any reading, N m, for a budget in the robot's own units.
    pub fn prior(budget: &NoiseBudget) -> f64 {
        let rolling = budget.rolling_resistance * Units::MEAN_MOMENT;
        root_sum_square(budget.gear_friction, rolling)
    }

    /// For the sum that is found, N m.
    pub fn new(budget: &NoiseBudget, sum: f64) -> Self {
        let gears = budget.gear_friction;
        let stated = budget.rolling_resistance * Units::MEAN_MOMENT;
        let beyond = sum * sum - WITHIN * WITHIN * gears * gears;
        let rolling = robhaz_model::sqrt(beyond.max(stated * stated));
        let both = root_sum_square(gears, rolling);
        if !(both > 0.0) {
            return Self {
                share: 0.0,
                left: 0.0,
            };
        }
        Self {
            share: (rolling / both) * (rolling / both),
            left: gears * rolling / both / Units::MEAN_MOMENT,
        }
    }

    /// Coefficient of rolling resistance for a sum of 1 N m, 1/(N m).
    pub fn coefficient(&self) -> f64 {
        self.share / Units::MEAN_MOMENT
    }

    /// Gear friction (N m) and coefficient of rolling resistance, each with its standard deviation, for
    /// the sum (N m) with its own.
    pub fn parts(&self, (sum, sigma): (f64, f64)) -> [(f64, f64); 2] {
        let part = |share: f64| {
            let left = self.left * Units::MEAN_MOMENT;
            (share * sum, root_sum_square(share * sigma, left))
        };
        let (value, sigma) = part(self.share);
        let coefficient = (value / Units::MEAN_MOMENT, sigma / Units::MEAN_MOMENT);
        [part(1.0 - self.share), coefficient]
    }

    /// Resistance of a wheel over the sum, which is that at the mean load: rolling resistance grows
    /// with the load, given as that over the mean one.
    pub fn under(&self, load: f64) -> f64 {
        1.0 + self.share * (load - 1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn budget(gear_friction: f64, rolling_resistance: f64) -> NoiseBudget {
        NoiseBudget {
            gear_friction,
            rolling_resistance,
            ..NoiseBudget::typical()
        }
    }

    /// Closed forms: without gear friction all is rolling resistance, without that all is gear
    /// friction, of equal deviations each has half with a deviation of 1/sqrt(2) of each; the variances
    /// of the sum and of what it leaves are those of two Gaussians. Rounding.
    #[test]
    fn the_sum_is_split_by_the_deviations() {
        let (moment, near) = (Units::MEAN_MOMENT, |a: f64, b: f64| (a - b).abs() < 1e-12);
        let free = Resistance::new(&budget(0.0, 0.05), 0.1);
        assert!(near(free.coefficient(), 1.0 / moment) && near(free.left, 0.0));
        assert!(near(free.under(1.5), 1.5));
        let firm = Resistance::new(&budget(0.3, 0.0), 0.1);
        assert!(
            near(firm.coefficient(), 0.0) && near(firm.left, 0.0) && near(firm.under(1.5), 1.0)
        );
        let equal = Resistance::new(&budget(0.05 * moment, 0.05), 0.1);
        assert!(near(equal.coefficient(), 0.5 / moment));
        assert!(near(equal.left, 0.05 * core::f64::consts::FRAC_1_SQRT_2));
        assert!(near(Resistance::prior(&budget(0.3, 0.4 / moment)), 0.5));
        let none = Resistance::new(&budget(0.0, 0.0), 0.0);
        assert!(near(none.coefficient(), 0.0) && near(none.left, 0.0));
    }

    /// A sum that gears of the budget do not have is the ground's: three times their friction is three
    /// quarters and more rolling resistance, twice it is still theirs.
    #[test]
    fn what_gears_do_not_have_is_the_ground() {
        let of = |sum: f64| Resistance::new(&budget(0.3, 0.01), sum);
        assert!(of(0.6).coefficient() * Units::MEAN_MOMENT < 0.03);
        let loose = of(-0.9);
        assert!(loose.coefficient() * Units::MEAN_MOMENT > 0.75);
        assert!(loose.left * Units::MEAN_MOMENT < 0.3);
    }
}
