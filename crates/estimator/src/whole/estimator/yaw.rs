//! The rate of yaw, which no side sees, and its bias.

use crate::common::FILTER_TIME;
use crate::deviation::{SIGNIFICANT, root_sum_square};
use crate::settings::NoiseBudget;

/// Time after which a yaw rate is that of a turn, s: ground under one wheel turns the rover to and fro.
/// Chosen; insensitive.
pub const TURN_TIME: f64 = 0.5;

/// What the gyroscope of the yaw shows.
#[derive(Clone, Copy, Debug)]
pub(super) struct Yaw {
    /// The last rate, rad/s.
    pub rate: f64,
    /// Its mean over [`TURN_TIME`], rad/s.
    pub mean: f64,
    /// Derivative of the low-pass filtered rate, rad/s^2.
    pub acceleration: f64,
    smooth: f64,
    /// Bias of the readings, rad/s, and its variance, rad^2/s^2.
    bias: (f64, f64),
    /// Standard deviation of a reading, rad/s.
    noise: f64,
}

impl Yaw {
    pub fn new(budget: &NoiseBudget) -> Self {
        Self {
            rate: 0.0,
            mean: 0.0,
            acceleration: 0.0,
            smooth: 0.0,
            bias: (0.0, budget.rate_bias * budget.rate_bias),
            noise: budget.rate_noise,
        }
    }

    /// Starts at the first reading, rad/s: a log may begin in a turn.
    pub fn start(&mut self, first: f64) {
        (self.rate, self.mean, self.smooth) = (first, first, first);
    }

    /// Takes a reading (rad/s), if there is one, `dt` (s) after the last. A rover that `stands` shows the bias.
    /// `time`: the robot's unit of time, s.
    pub fn take(
        &mut self,
        budget: &NoiseBudget,
        reading: Option<f64>,
        stands: bool,
        [dt, time]: [f64; 2],
    ) {
        let (bias, variance) = &mut self.bias;
        *variance += budget.rate_walk * budget.rate_walk * dt;
        if let Some(error) = reading.map(|rate| rate - *bias).filter(|_| stands) {
            let expected = *variance + self.noise * self.noise;
            // Beyond it the rover is turned by hand.
            if *variance > 0.0 && error * error < SIGNIFICANT * SIGNIFICANT * expected {
                let gain = *variance / expected;
                *bias += gain * error;
                *variance *= 1.0 - gain;
            }
        }
        self.rate = reading.map_or(0.0, |rate| rate - *bias);
        self.mean += robhaz_model::low_pass_share(dt, TURN_TIME * time) * (self.rate - self.mean);
        if dt > 0.0 {
            let weight = robhaz_model::low_pass_share(dt, FILTER_TIME * time);
            let change = weight * (self.rate - self.smooth);
            self.smooth += change;
            self.acceleration += weight * (change / dt - self.acceleration);
        }
    }

    /// Standard deviation of the mean over [`TURN_TIME`] of readings every `dt` (s), rad/s. `time`: see
    /// [`Self::take`].
    pub fn mean_sigma(&self, [dt, time]: [f64; 2]) -> f64 {
        let weight = robhaz_model::low_pass_share(dt, TURN_TIME * time);
        let (_, variance) = self.bias;
        let white = self.noise * robhaz_model::sqrt(weight / (2.0 - weight));
        root_sum_square(white, robhaz_model::sqrt(variance))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Closed form: of n readings at rest the bias is known to sqrt(1/(1/s^2 + n/r^2)), s the stated deviation and r
    /// the noise; a turn by hand is none, and without a stated bias there is none.
    #[test]
    fn the_bias_shows_at_rest() {
        let mut budget = NoiseBudget::typical();
        budget.rate_bias = 0.01;
        let (bias, noise, dt) = (0.008, budget.rate_noise, 0.01);
        let mut yaw = Yaw::new(&budget);
        for k in 0..100 {
            let white = if k % 2 == 0 { noise } else { -noise };
            yaw.take(&budget, Some(bias + white), true, [dt, 1.0]);
        }
        let (found, variance) = yaw.bias;
        let expected = 1.0 / (1e4 + 100.0 / (noise * noise));
        assert!((variance / expected - 1.0).abs() < 1e-9);
        assert!((found - bias).abs() < 3.0 * expected.sqrt(), "{found}");
        yaw.take(&budget, Some(0.5), true, [dt, 1.0]);
        assert_eq!(yaw.bias, (found, variance));
        assert!((yaw.rate - 0.5 + found).abs() < 1e-15);

        let exact = NoiseBudget::typical();
        let mut yaw = Yaw::new(&exact);
        yaw.take(&exact, Some(bias), true, [dt, 1.0]);
        assert!((yaw.rate - bias).abs() < 1e-15);
    }
}
