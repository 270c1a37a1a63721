//! Turns: at which samples the constraints correct the states.

use crate::contact::{RollingResiduals, SlipResidual};

/// When the rolling constraints of each wheel and the parity residual last corrected the states, and how uncertain the wheels'
/// residuals were.
///
/// A constraint that corrects the states costs a pass over their covariance. What it measures lasts for tens of milliseconds: slopes,
/// slip, errors of torques. So at 1 kHz one wheel a sample suffices; each corrects every third sample, as a measurement of that
/// longer time. A wheel that shows more than its noise does so at once: `TUNING.early`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Turns {
    /// Time since the last turn of each wheel that carries load, s.
    waited: [f64; 3],
    last: [Uncertainty; 3],
    /// Time since the last turn of the parity residual, s.
    parity_waited: f64,
    /// Its variance from the states then, N^2.
    parity_variance: f64,
}

/// Uncertainty of the residuals of one wheel at a single sample.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Uncertainty {
    /// Standard deviation of the speed away from the ground, m/s.
    away: f64,
    /// Variance of the slip beyond creep, m^2/s^2.
    slip_variance: f64,
    /// The gyroscope's part of its standard deviation, m/s.
    slip_noise: f64,
}

/// Whose turn it is at a sample.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Turn {
    /// Which wheels correct the states, whatever they show.
    pub due: [bool; 3],
    /// Time since the last turn of each wheel, s.
    pub waited: [f64; 3],
}

impl Turns {
    /// Time after which it is a wheel's turn at any rate of the samples, s.
    pub const LONGEST_WAIT: f64 = 0.003;
    /// Rounding of the times between samples, s.
    pub const ROUNDING: f64 = 1e-9;

    /// A sample `dt` seconds after the last. It is the turn of the loaded wheel that has waited longest, and of those that have waited
    /// long enough.
    pub fn next(&mut self, loaded: [bool; 3], dt: f64) -> Turn {
        let mut longest = 0.0_f64;
        for (waited, loaded) in self.waited.iter_mut().zip(loaded) {
            *waited = if loaded { *waited + dt } else { 0.0 };
            longest = longest.max(*waited);
        }
        let mut turn = Turn {
            due: [false; 3],
            waited: self.waited,
        };
        let mut found = false;
        for (due, waited) in turn.due.iter_mut().zip(turn.waited) {
            let first = !found && waited > longest - Self::ROUNDING;
            found |= first;
            *due = first || waited > Self::LONGEST_WAIT - Self::ROUNDING;
        }
        turn
    }

    /// Wheel `i` has corrected the states.
    pub fn taken(&mut self, i: usize, residuals: &RollingResiduals) {
        self.waited[i] = 0.0;
        let last = &mut self.last[i];
        last.away = residuals.away_sigma;
        if let Some(slip) = &residuals.slip {
            (last.slip_variance, last.slip_noise) = (slip.variance, slip.noise);
        }
    }

    /// Residuals of wheel `i` with the uncertainty of its last turn: speed away from the ground, slip beyond creep, and creep, m/s.
    pub fn residuals(&self, i: usize, away: f64, slip: Option<[f64; 2]>) -> RollingResiduals {
        let last = &self.last[i];
        RollingResiduals {
            away,
            away_sigma: last.away,
            slip: slip.map(|[beyond_creep, creep]| SlipResidual {
                beyond_creep,
                creep,
                variance: last.slip_variance,
                noise: last.slip_noise,
            }),
        }
    }

    /// A parity residual `dt` seconds after the last. Returns whether it is its turn.
    pub fn next_parity(&mut self, dt: f64) -> bool {
        self.parity_waited += dt;
        self.parity_waited > Self::LONGEST_WAIT - Self::ROUNDING
    }

    /// The parity residual has corrected the states; it had this variance from them, N^2. Returns the time since it last did, s.
    pub fn parity_taken(&mut self, variance: f64) -> f64 {
        self.parity_variance = variance;
        core::mem::take(&mut self.parity_waited)
    }

    /// Variance of the parity residual from the states at its last turn, N^2.
    pub fn parity_variance(&self) -> f64 {
        self.parity_variance
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ALL: [bool; 3] = [true; 3];

    /// The number of turns of each wheel in 3 s, and the largest number at one sample after the first three.
    fn count(loaded: [bool; 3], dt: f64) -> ([u32; 3], usize) {
        let mut turns = Turns::default();
        let (mut of_wheel, mut at_once) = ([0; 3], 0);
        for k in 0..(3.0_f64 / dt).round() as usize {
            let due = turns.next(loaded, dt).due;
            for i in 0..3 {
                if due[i] {
                    of_wheel[i] += 1;
                    let residuals = turns.residuals(i, 0.0, None);
                    turns.taken(i, &residuals);
                }
            }
            if k > 2 {
                at_once = at_once.max(due.iter().filter(|due| **due).count());
            }
        }
        (of_wheel, at_once)
    }

    /// Closed form: at 1 kHz one wheel a sample, each every third; a wheel without load leaves its turns to the others; from 3 ms on
    /// all wheels at every sample.
    #[test]
    fn wheels_take_turns() {
        assert_eq!(count(ALL, 1e-3), ([1000; 3], 1));
        assert_eq!(count([true, false, true], 1e-3), ([1500, 0, 1500], 1));
        assert_eq!(count([false, true, false], 1e-3), ([0, 3000, 0], 1));
        for dt in [3e-3, 0.01] {
            let all = (3.0_f64 / dt).round() as u32;
            assert_eq!(count(ALL, dt), ([all; 3], 3));
        }
    }

    /// Property: whatever the rate, no wheel waits longer than 3 ms and one sample.
    #[test]
    fn no_wheel_waits_for_long() {
        for dt in [1e-4, 5e-4, 1e-3, 1.4e-3, 2e-3, 2.5e-3, 3e-3, 7e-3] {
            let mut turns = Turns::default();
            for _ in 0..1000 {
                let turn = turns.next(ALL, dt);
                for i in 0..3 {
                    assert!(turn.waited[i] < Turns::LONGEST_WAIT + dt, "{dt}: {turn:?}");
                    if turn.due[i] {
                        let residuals = turns.residuals(i, 0.0, None);
                        turns.taken(i, &residuals);
                    }
                }
            }
        }
    }

    /// Closed form: it is the parity residual's turn at every third sample at 1 kHz, with the time since the last.
    #[test]
    fn the_parity_residual_waits_too() {
        let mut turns = Turns::default();
        for k in 0..30 {
            let due = turns.next_parity(1e-3);
            assert_eq!(due, k % 3 == 2, "{k}");
            if due {
                assert!((turns.parity_taken(2.0) - 3e-3).abs() < 1e-12);
            }
        }
        assert!(turns.parity_variance().to_bits() == 2.0_f64.to_bits());
    }
}
