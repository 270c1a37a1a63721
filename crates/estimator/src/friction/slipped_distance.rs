//! Onset of slip where noise and rate of the readings hide the acceleration of the slip: from the
//! distance that the wheel has slipped.

use crate::common::FILTER_TIME;
use robhaz_model::Units;

/// Page's test (cumulative sum) for a slip speed beyond the usual one: the distance
///
/// ```text
/// D = integral (+-(slip - usual) - ALLOWANCE) dt,  kept above zero
/// ```
///
/// for slip forwards and backwards. Noise of the density S, m^2/s, carries it beyond h with the
/// probability `exp(-2 ALLOWANCE h/S)`: D is then a Brownian motion with a drift, reflected at zero
/// (Siegmund, Sequential Analysis, ch. II). So h = S ln(1/p)/(2 ALLOWANCE) is the distance at which
/// a slip is certain. The time of the last zero is the estimate of the time of the onset.
///
/// S is that of the budget, or what the slip of the gripping wheel shows if that is less: a budget
/// of independent errors counts those of a rate from a differentiated angle in full, of which most
/// cancels over a distance.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct SlippedDistance {
    /// Low-pass filtered slip speed, m/s.
    usual: f64,
    /// Variance of the slip speed about it, m^2/s^2. Zero before the first sample.
    variance: f64,
    /// h, by the variance at the last zero, m.
    certain: f64,
    /// Time since the last restart, s.
    time: f64,
    /// Forwards and backwards.
    sides: [Side; 2],
}

/// Slip in one direction.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Side {
    /// D, m.
    distance: f64,
    /// Samples without a break in which it has grown.
    samples: u32,
}

impl SlippedDistance {
    /// Time constant of the usual slip, s: some samples of the slowest readings.
    /// Chosen; held by `crates/study/tests/study/friction_test`.
    pub(super) const USUAL_TIME: f64 = 0.6;
    /// Slip speed beyond the usual one that a gripping wheel may have, m/s. Under a ramp its slip
    /// accelerates by 0.028 m/s^2 at most, and so is 14 mm/s beyond its low pass.
    /// Chosen; held by `tests/rovers.rs`.
    pub const ALLOWANCE: f64 = 0.02;
    /// ln(1/p) for a false onset once in a million times that D leaves zero.
    /// Definition.
    const CERTAINTY: f64 = 13.8;
    /// Time constant of the variance, s: before the first ramp the robot rolls for longer.
    /// Chosen; insensitive.
    const VARIANCE_TIME: f64 = 3.0;
    /// Standard deviations beyond which a slip speed does not count in the variance.
    /// Guard: an onset of slip is no noise.
    const OUTLIER: f64 = 4.0;
    /// Time over which the noise of a sample lasts in the observers, both ways, s.
    /// Definition.
    const LASTS: f64 = 2.0 * FILTER_TIME;
    /// Samples in which a distance has to grow: one of them can be an outlier.
    /// Definition.
    const SAMPLES: u32 = 2;
    /// Least distance, m: errors of the speed of the robot over some samples.
    /// Chosen; insensitive.
    const LEAST: f64 = 1e-3;
    /// Greatest distance at which slip may be certain, m: half of the wheel's radius. With more the
    /// wheel runs away before it is found.
    /// Definition.
    const GREATEST: f64 = 0.5 * Units::RADIUS;
    /// Longest time between samples, s: the usual slip is a mean of at least three.
    /// Definition.
    const LONGEST_STEP: f64 = Self::USUAL_TIME / 3.0;

    /// The wheel grips at this slip speed, m/s. For a time constant of the usual slip nothing
    /// counts: a wheel that has slipped slows down for some samples.
    pub fn restart(&mut self, slip: f64) {
        (self.usual, self.time, self.sides) = (slip, 0.0, Default::default());
    }

    /// The distance at which slip is certain over the greatest one, or the time between samples
    /// over the longest, whichever is more: above 1 an onset cannot be seen.
    pub fn noise(&self, dt: f64) -> f64 {
        (self.certain / Self::GREATEST).max(dt / Self::LONGEST_STEP)
    }

    /// Takes the slip speed (m/s) over `dt` (s); `density` is S by the budget, m^2/s. Returns the
    /// direction of the slip, 1 or -1, if it is certain.
    pub fn update(&mut self, slip: f64, density: f64, dt: f64) -> Option<f64> {
        let lasts = dt + Self::LASTS;
        let budget = density / lasts;
        if !(self.variance > 0.0) {
            (self.usual, self.variance) = (slip, budget);
        }
        if self.grips() {
            let density = self.variance.min(budget) * lasts;
            self.certain = (Self::CERTAINTY * density / (2.0 * Self::ALLOWANCE)).max(Self::LEAST);
        }
        let change = slip - self.usual;
        self.usual += robhaz_model::low_pass_share(dt, Self::USUAL_TIME) * change;
        let outlier = Self::OUTLIER * Self::OUTLIER * self.variance.max(budget);
        if change * change < outlier {
            let weight = robhaz_model::low_pass_share(dt, Self::VARIANCE_TIME);
            self.variance += weight * (change * change - self.variance);
        }
        self.time += dt;
        if self.time < Self::USUAL_TIME {
            return None;
        }
        let mut found = None;
        for (side, forward) in self.sides.iter_mut().zip([1.0, -1.0]) {
            let beyond = change * forward - Self::ALLOWANCE;
            side.distance = (side.distance + beyond * dt).max(0.0);
            side.samples = if beyond > 0.0 { side.samples + 1 } else { 0 };
            if side.distance > self.certain && side.samples >= Self::SAMPLES {
                found = Some(forward);
            }
        }
        found.filter(|_| self.noise(dt) <= 1.0)
    }

    /// Whether both distances are zero: the wheel grips as far as can be seen.
    pub fn grips(&self) -> bool {
        !self.sides.iter().any(|side| side.distance > 0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::Random;

    /// Time between samples of a rover, s, in units of robot A.
    const DT: f64 = 0.02;

    /// Noise of a standard deviation (m/s) on a wheel that grips with a slip of 10 mm/s.
    fn gripping(noise: f64, budget: f64, samples: u32) -> (SlippedDistance, u32) {
        let mut random = Random::new();
        let mut watch = SlippedDistance::default();
        let mut false_onsets = 0;
        for _ in 0..samples {
            let slip = 0.01 + noise * random.normal();
            let density = budget * budget * (DT + SlippedDistance::LASTS);
            if watch.update(slip, density, DT).is_some() {
                false_onsets += 1;
                watch.restart(slip);
            }
        }
        (watch, false_onsets)
    }

    /// Property: an hour of noise of the budget's size, and of a fifth of it, is no onset.
    #[test]
    fn noise_is_no_onset() {
        for budget in [0.015, 0.075] {
            let (watch, found) = gripping(0.015, budget, 180_000);
            assert!(found == 0 && watch.noise(DT) < 1.0, "{budget}: {found}");
        }
    }

    /// Closed form: a wheel whose slip jumps by 120 mm/s, with noise of 15 mm/s, has slipped
    /// 0.1 m/s times the time beyond the allowance; h is 13.8 (15 mm/s)^2 80 ms/(2 20 mm/s) = 6.2
    /// mm. It takes 62 ms, and two samples more by noise. In either direction.
    #[test]
    fn a_slip_is_found_after_its_distance() {
        for forward in [1.0, -1.0] {
            let (mut watch, _) = gripping(0.015, 0.02, 1000);
            let mut random = Random::new();
            let found = (1..50).find_map(|k| {
                let slip = 0.01 + 0.12 * forward + 0.015 * random.normal();
                let density = 0.02 * 0.02 * (DT + SlippedDistance::LASTS);
                let direction = watch.update(slip, density, DT)?;
                Some((k, direction))
            });
            let (samples, direction) = found.expect("it slips");
            assert!((2..=6).contains(&samples), "{samples}");
            assert!((direction - forward).abs() < 1e-12);
        }
    }

    /// Closed form: noise of 60 mm/s needs 13.8 (60 mm/s)^2 80 ms/(40 mm/s) = 99 mm, more than the
    /// 50 mm that are allowed; samples of 0.25 s are farther apart than 0.2 s. No slip is then
    /// found, however large.
    #[test]
    fn what_noise_and_rate_hide_is_not_found() {
        let (mut watch, _) = gripping(0.06, 0.06, 1000);
        let noise = watch.noise(DT);
        assert!(noise > 1.7 && noise < 2.3, "{noise}");
        let density = 0.06 * 0.06 * (DT + SlippedDistance::LASTS);
        assert!((0..50).all(|_| watch.update(1.0, density, DT).is_none()));
        let mut slow = SlippedDistance::default();
        for k in 0..100 {
            let slip = if k < 50 { 0.0 } else { 1.0 };
            assert_eq!(slow.update(slip, 1e-8, 0.25), None);
        }
        assert!((slow.noise(0.25) - 1.25).abs() < 1e-9);
    }
}
