//! Random ground by the classes of ISO 8608.

use crate::Vec2;
use crate::shape::{Piece, ProfileError, SPACING, Shape};
use rand_distr::{Distribution as _, StandardUniform};
use rand_pcg::Pcg64;
use rand_pcg::rand_core::SeedableRng;
use robhaz_model::named;
use std::f64::consts::TAU;

/// Number of waves in the sum. The band of frequencies is divided into as many parts of equal
/// ratio, one wave in each.
const WAVES: u32 = 64;
/// Reference spatial frequency n0 of ISO 8608, cycles/m.
const N0: f64 = 0.1;

named! {
    /// A class of ISO 8608, from very good roads (A) to ground that no road vehicle crosses (H).
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    #[expect(missing_docs, reason = "ISO 8608 names them by their letters")]
    pub enum RoughClass {
        A = "A",
        B = "B",
        C = "C",
        D = "D",
        E = "E",
        F = "F",
        G = "G",
        H = "H",
    }
}

impl RoughClass {
    /// Gd(n0): the power spectral density of the height at 0.1 cycles/m, m^3. The geometric mean of
    /// the class.
    pub fn density(self) -> f64 {
        16e-6 * 4.0_f64.powi(self as i32)
    }
}

/// Parameters of random ground.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RoughSettings {
    /// Class of roughness.
    pub class: RoughClass,
    /// Shortest wavelength, m.
    pub shortest: f64,
    /// Longest wavelength, m.
    pub longest: f64,
    /// x of its start, m.
    pub start: f64,
    /// Length along x, both fades included, m.
    pub extent: f64,
    /// Length over which the height rises from zero at the start, and falls to zero at the end, m.
    pub fade: f64,
    /// Seed of the waves' phases and frequencies.
    pub seed: u64,
}

impl Default for RoughSettings {
    /// Class C, wavelengths from 0.2 m to 10 m; 10 m long from x = 0.7 m, with fades of 1 m.
    fn default() -> Self {
        Self {
            class: RoughClass::C,
            shortest: 0.2,
            longest: 10.0,
            start: 0.7,
            extent: 10.0,
            fade: 1.0,
            seed: 0,
        }
    }
}

/// Random ground: a sum of waves with random phases, faded into the level ground at both ends.
///
/// Height, slope and curvature are continuous at both ends.
#[derive(Clone, Debug, PartialEq)]
pub struct Rough {
    settings: RoughSettings,
    waves: Vec<Wave>,
}

/// One wave, `amplitude sin(number (x - start) + phase)`.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Wave {
    /// Amplitude, m.
    amplitude: f64,
    /// Wave number, rad/m.
    number: f64,
    /// Phase, rad.
    phase: f64,
}

impl Rough {
    /// Draws the waves. The same settings always give the same ground.
    pub fn new(settings: RoughSettings) -> Self {
        let mut random = Pcg64::seed_from_u64(settings.seed);
        let ratio = settings.longest / settings.shortest;
        let frequency = |part: f64| ratio.powf(part / f64::from(WAVES)) / settings.longest;
        let mut uniform = || -> f64 { StandardUniform.sample(&mut random) };
        let waves = (0..WAVES).map(f64::from).map(|i| {
            // Frequencies are random within their parts: in fixed ratios the ground would repeat
            // itself.
            let number = TAU * frequency(i + uniform());
            let variance = variance(settings.class, frequency(i), frequency(i + 1.0));
            Wave {
                amplitude: (2.0 * variance).sqrt(),
                number,
                phase: TAU * uniform(),
            }
        });
        Self {
            settings,
            waves: waves.collect(),
        }
    }

    /// Sum of the waves at the distance `s` (m) from the start, with first and second derivative.
    fn sum(&self, s: f64) -> [f64; 3] {
        let mut sum = [0.0; 3];
        for wave in &self.waves {
            let (sin, cos) = (wave.number * s + wave.phase).sin_cos();
            sum[0] += wave.amplitude * sin;
            sum[1] += wave.amplitude * wave.number * cos;
            sum[2] -= wave.amplitude * wave.number * wave.number * sin;
        }
        sum
    }
}

impl Shape for Rough {
    fn check(&self) -> Result<(), ProfileError> {
        let s = &self.settings;
        let is_above = s.longest > s.shortest;
        ProfileError::unless(is_above, "longest", s.longest, "above shortest")?;
        let fits = s.fade <= 0.5 * s.extent;
        ProfileError::unless(fits, "fade", s.fade, "at most half of extent")
    }

    fn eval(&self, x: f64) -> [f64; 3] {
        let RoughSettings { extent, fade, .. } = self.settings;
        let s = x - self.settings.start;
        if !(0.0..=extent).contains(&s) {
            return [0.0; 3];
        }
        let [h, dh, ddh] = self.sum(s);
        // A fade is at most half of the extent: each half has one.
        let [w, dw, ddw] = if s < 0.5 * extent {
            smooth_step(s, fade)
        } else {
            let [w, dw, ddw] = smooth_step(extent - s, fade);
            [w, -dw, ddw]
        };
        [w * h, w * dh + dw * h, w * ddh + 2.0 * dw * dh + ddw * h]
    }

    fn pieces(&self) -> (Vec2, Vec<Piece>) {
        let s = &self.settings;
        let spacing = SPACING.min(s.shortest / 20.0);
        let end = Piece::Curve(s.start + s.extent, spacing);
        (Vec2::new(s.start, 0.0), vec![end])
    }
}

/// Variance of the height between the fades, m^2: the integral of the spectral density
/// `Gd(n0) (n/n0)^-2` from frequency `low` to `high` (cycles/m).
fn variance(class: RoughClass, low: f64, high: f64) -> f64 {
    class.density() * N0 * N0 * (1.0 / low - 1.0 / high)
}

/// Quintic step from 0 at `s` = 0 to 1 at `length` (m), with first and second derivative; both are
/// 0 at both ends.
fn smooth_step(s: f64, length: f64) -> [f64; 3] {
    if s >= length {
        return [1.0, 0.0, 0.0];
    }
    let u = s / length;
    [
        u * u * u * (10.0 + u * (6.0 * u - 15.0)),
        30.0 * u * u * (1.0 - u) * (1.0 - u) / length,
        60.0 * u * (1.0 - u) * (1.0 - 2.0 * u) / (length * length),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_pcg::rand_core::Rng as _;

    fn settings(seed: u64) -> RoughSettings {
        RoughSettings {
            class: RoughClass::C,
            shortest: 0.2,
            longest: 10.0,
            start: 1.0,
            extent: 1000.0,
            fade: 1.0,
            seed,
        }
    }

    fn mean_square(ground: &Rough) -> f64 {
        let count = 40_000;
        let sum: f64 = (0..count)
            .map(|i| ground.eval(2.5 + 0.0249 * f64::from(i))[0].powi(2))
            .sum();
        sum / f64::from(count)
    }

    /// Statistics: over 1 km (100 of the longest waves) the mean square differs from the variance
    /// by the cross terms of neighbouring waves, a few percent. The mean over 10 seeds differs by
    /// less.
    #[test]
    fn variance_is_the_integral_of_the_density() {
        let expected = 256e-6 * 0.01 * (10.0 - 0.2);
        let s = settings(0);
        let found = variance(s.class, 1.0 / s.longest, 1.0 / s.shortest);
        assert!((found - expected).abs() < 1e-18);
        let mut mean = 0.0;
        for seed in 0..10 {
            let ratio = mean_square(&Rough::new(settings(seed))) / expected;
            assert!((ratio - 1.0).abs() < 0.1, "seed {seed}: {ratio}");
            mean += 0.1 * ratio;
        }
        assert!((mean - 1.0).abs() < 0.03, "{mean}");
    }

    /// Closed form: an octave from n holds the variance `Gd(n0) n0^2/(2 n)`, so each octave holds
    /// half of the one below.
    #[test]
    fn density_falls_with_the_square_of_the_frequency() {
        let ground = Rough::new(settings(3));
        let share = |low: f64, high: f64| -> f64 {
            let inside = |w: &&Wave| (low..high).contains(&(w.number / TAU));
            let squares = ground.waves.iter().filter(inside);
            squares.map(|w| 0.5 * w.amplitude * w.amplitude).sum()
        };
        for low in [0.2, 0.4, 0.8, 1.6] {
            let expected = 256e-6 * 0.01 / (2.0 * low);
            // An octave holds about 11 waves; one at its border can fall on the other side.
            assert!((share(low, 2.0 * low) / expected - 1.0).abs() < 0.2);
        }
        let density = |c: RoughClass| c.density();
        assert!((density(RoughClass::A) - 16e-6).abs() < 1e-18);
        assert!((density(RoughClass::H) - 262_144e-6).abs() < 1e-12);
    }

    /// Golden: the same bits in every version. Other bits would change every recorded run on random
    /// ground.
    #[test]
    fn the_same_seed_gives_the_same_ground() {
        let heights = |seed| {
            let ground = Rough::new(settings(seed));
            [3.0, 31.4, 500.0].map(|x| ground.eval(x)[0].to_bits())
        };
        assert_eq!(heights(7), heights(7));
        assert_ne!(heights(7), heights(8));
        let mut random = Pcg64::seed_from_u64(7);
        assert_eq!(random.next_u64(), 9_351_779_398_707_215);
    }

    #[test]
    fn height_slope_and_curvature_are_continuous_at_the_fades() {
        let ground = Rough::new(settings(1));
        for x in [1.0, 1001.0] {
            let [height, slope, second] = ground.eval(x);
            assert!(height.abs() < 1e-12 && slope.abs() < 1e-12 && second.abs() < 1e-9);
        }
        for (from, to) in [(1.999_999, 2.000_001), (999.999_999, 1_000.000_001)] {
            assert!((ground.eval(from)[2] - ground.eval(to)[2]).abs() < 1e-3);
        }
    }

    #[test]
    fn impossible_settings_are_refused() {
        let bad = |change: fn(&mut RoughSettings)| {
            let mut s = settings(0);
            change(&mut s);
            Rough::new(s).check().is_err()
        };
        assert!(!bad(|_| {}));
        assert!(bad(|s| s.longest = 0.2));
        assert!(bad(|s| s.fade = 501.0));
    }
}
