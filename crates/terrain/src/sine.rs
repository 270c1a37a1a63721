//! A row of waves.

use crate::Vec2;
use crate::error::ProfileError;
use crate::shape::{Piece, SPACING, Shape};
use std::f64::consts::TAU;

/// Greatest length of all waves together, m: it bounds the number of edges.
const LONGEST: f64 = 1000.0;

/// Waves on level ground: `amplitude (1 - cos(2 pi (x - start)/wavelength))` over whole periods; m.
///
/// Height and slope are continuous at both ends, the curvature is not. Crests are `2 amplitude`
/// high.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sine {
    /// Half the height from trough to crest, m; negative for waves below the level ground.
    pub amplitude: f64,
    /// Distance from crest to crest, m.
    pub wavelength: f64,
    /// x of the start of the first wave, m.
    pub start: f64,
    /// Number of waves.
    pub periods: u32,
}

impl Sine {
    fn length(&self) -> f64 {
        self.wavelength * f64::from(self.periods)
    }
}

impl Shape for Sine {
    fn check(&self) -> Result<(), ProfileError> {
        let (length, most) = (
            self.length(),
            "at most 1000 m in all: periods times wavelength",
        );
        ProfileError::unless(length <= LONGEST, "the length of the waves", length, most)
    }

    fn eval(&self, x: f64) -> [f64; 3] {
        let u = (x - self.start) / self.wavelength;
        if !(0.0..=f64::from(self.periods)).contains(&u) {
            return [0.0; 3];
        }
        let (a, k) = (self.amplitude, TAU / self.wavelength);
        let (sin, cos) = (TAU * u).sin_cos();
        [a * (1.0 - cos), a * k * sin, a * k * k * cos]
    }

    fn pieces(&self) -> (Vec2, Vec<Piece>) {
        let spacing = SPACING.min(self.wavelength / 40.0);
        let end = Piece::Curve(self.start + self.length(), spacing);
        (Vec2::new(self.start, 0.0), vec![end])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Profile;

    #[test]
    fn waves_are_two_amplitudes_high_and_end_level() {
        let profile = Profile::sine();
        for (x, y) in [
            (0.7, 0.0),
            (0.95, 0.02),
            (1.2, 0.0),
            (2.95, 0.02),
            (3.2, 0.0),
        ] {
            let [height, slope, _] = profile.eval(x);
            assert!((height - y).abs() < 1e-15 && slope.abs() < 1e-12, "at {x}");
        }
    }

    #[test]
    fn impossible_waves_are_refused() {
        let waves = |wavelength, periods| Sine {
            amplitude: 0.1,
            wavelength,
            start: 0.0,
            periods,
        };
        assert!(waves(10.0, 101).check().is_err());
        assert!(waves(10.0, 100).check().is_ok());
    }
}
