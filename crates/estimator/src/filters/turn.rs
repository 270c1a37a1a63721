//! How far wheels of one side run apart in a turn that no reading shows.

use crate::common::OBSTACLES;
use crate::deviation::WITHIN;

/// Means over some seconds of what the speeds of wheels differ by: steered wheels and those of another track run on other
/// radii.
///
/// What creep under the torques' difference and an error of the radius explain is no turn.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct TurnFilter {
    /// Slip of each wheel less that of the mean, m/s.
    slip: [f64; 3],
    /// The part that creep explains, m/s.
    creep: [f64; 3],
    /// Time over which both are means, s.
    time: f64,
}

impl TurnFilter {
    /// Takes the `slip` of the wheels and the part of it that the torques' readings explain (m/s), `dt` (s) after the last.
    pub fn update(&mut self, slip: [f64; 3], creep: [f64; 3], dt: f64) {
        self.time = (self.time + dt).min(OBSTACLES);
        let weight = (dt / self.time).min(1.0);
        for (means, values) in [(&mut self.slip, slip), (&mut self.creep, creep)] {
            let mean = values.iter().sum::<f64>() / 3.0;
            for (at, value) in means.iter_mut().zip(values) {
                *at += weight * (value - mean - *at);
            }
        }
    }

    /// Standard deviation of a wheel's speed by a turn, m/s, where the speeds differ by an error of this standard deviation
    /// (m/s) without one.
    pub fn sigma(&self, error: f64) -> f64 {
        let [apart, explained] = self.squares(error);
        // Of three differences from their mean two are free.
        robhaz_model::sqrt((0.5 * (apart - explained)).max(0.0))
    }

    /// Whether the wheels run apart by more than two standard deviations of what is no turn.
    pub fn turns(&self, error: f64) -> bool {
        let [apart, explained] = self.squares(error);
        apart > WITHIN * WITHIN * explained
    }

    /// Sums of squares over the wheels, m^2/s^2: of the slips less creep, and of the errors of both. Creep is known to a
    /// factor of two: its error is as large.
    fn squares(&self, error: f64) -> [f64; 2] {
        let (mut apart, mut explained) = (0.0, 3.0 * error * error);
        for (slip, creep) in self.slip.iter().zip(self.creep) {
            apart += (slip - creep) * (slip - creep);
            explained += creep * creep;
        }
        [apart, explained]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Closed form: speeds that differ by less than the error, or as creep explains, are no turn; others are.
    #[test]
    fn what_nothing_explains_is_a_turn() {
        let of = |slip: [f64; 3], creep: [f64; 3]| {
            let mut turn = TurnFilter::default();
            for _ in 0..2000 {
                turn.update(slip, creep, 1e-2);
            }
            (turn.sigma(1e-3), turn.turns(1e-3))
        };
        let steered = [4e-3, -8e-3, 4e-3];
        assert_eq!(of([5e-4, -1e-3, 5e-4], [0.0; 3]), (0.0, false));
        assert_eq!(of(steered, [4.1e-3, -8.2e-3, 4.1e-3]), (0.0, false));
        assert!(of(steered, [-2e-3, 4e-3, -2e-3]).1);
        assert!(!of(steered, [2e-3, -4e-3, 2e-3]).1);
        let (sigma, turns) = of(steered, [0.0; 3]);
        let expected = f64::sqrt(0.5 * (96e-6 - 3e-6));
        // Rounding.
        assert!(turns && (sigma / expected - 1.0).abs() < 1e-9, "{sigma}");
    }
}
