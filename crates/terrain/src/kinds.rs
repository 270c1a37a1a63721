//! Kinds of ground that a few parameters give: bumps, waves, inclines, kerbs, trenches.

use crate::Vec2;
use crate::shape::{Piece, ProfileError, SPACING, Shape};
use std::f64::consts::{PI, TAU};

/// Value of `((x - centre)/width)^2` beyond which a bump counts as zero: exp(-40) is 4e-18 of its
/// height.
const CUTOFF: f64 = 40.0;
/// Half length of a bump's curve in widths. The cutoff lies at 6.3 widths.
const EXTENT: f64 = 8.0;

/// One Gaussian bump (or hollow) `height exp(-((x - centre)/width)^2)`; m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bump {
    /// Height of the summit, m; negative for a hollow.
    pub height: f64,
    /// x of the summit, m.
    pub centre: f64,
    /// Half width at 1/e of the height, m.
    pub width: f64,
}

impl Bump {
    /// Five bumps: they replace the paper's "relatively smooth geometric profile", which was not
    /// published.
    pub fn smooth() -> Vec<Self> {
        let bump = |(height, centre, width)| Self {
            height,
            centre,
            width,
        };
        let bumps = [
            (0.050, 1.00, 0.22),
            (-0.035, 1.45, 0.20),
            (0.040, 1.90, 0.17),
            (0.060, 2.50, 0.28),
            (-0.030, 2.95, 0.16),
        ];
        bumps.map(bump).to_vec()
    }
}

impl Shape for Vec<Bump> {
    fn eval(&self, x: f64) -> [f64; 3] {
        let mut sum = [0.0; 3];
        for b in self {
            let u = (x - b.centre) / b.width;
            if u * u > CUTOFF {
                continue;
            }
            let e = b.height * (-u * u).exp();
            sum[0] += e;
            sum[1] -= 2.0 * u / b.width * e;
            sum[2] += (4.0 * u * u - 2.0) / (b.width * b.width) * e;
        }
        sum
    }

    fn pieces(&self) -> (Vec2, Vec<Piece>) {
        let (mut from, mut to, mut spacing) = (f64::INFINITY, f64::NEG_INFINITY, SPACING);
        for b in self {
            from = from.min(b.centre - EXTENT * b.width);
            to = to.max(b.centre + EXTENT * b.width);
            spacing = spacing.min(b.width / 10.0);
        }
        if self.is_empty() {
            return (Vec2::zeros(), Vec::new());
        }
        let start = Vec2::new(from, self.eval(from)[0]);
        (start, vec![Piece::Curve(to, spacing)])
    }
}

/// `height/2 (1 + cos(pi (x - centre)/half_width))` for `|x - centre| < half_width`, level
/// elsewhere; m.
///
/// Its curvature jumps where it meets the level ground.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CosBump {
    /// Height of the summit, m; negative for a hollow.
    pub height: f64,
    /// x of the summit, m.
    pub centre: f64,
    /// Half of the bump's length, m.
    pub half_width: f64,
}

impl Shape for CosBump {
    fn eval(&self, x: f64) -> [f64; 3] {
        let u = (x - self.centre) / self.half_width;
        if u.abs() > 1.0 {
            return [0.0; 3];
        }
        let (k, half) = (PI / self.half_width, 0.5 * self.height);
        let (sin, cos) = (PI * u).sin_cos();
        [half * (1.0 + cos), -half * k * sin, -half * k * k * cos]
    }

    fn pieces(&self) -> (Vec2, Vec<Piece>) {
        let start = Vec2::new(self.centre - self.half_width, 0.0);
        let spacing = SPACING.min(self.half_width / 20.0);
        let end = self.centre + self.half_width;
        (start, vec![Piece::Curve(end, spacing)])
    }
}

impl Default for CosBump {
    /// One cosine bump, 60 mm high and 0.70 m long, around x = 1.2 m.
    fn default() -> Self {
        Self {
            height: 0.06,
            centre: 1.2,
            half_width: 0.35,
        }
    }
}

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
        let length = self.length();
        let most = "at most 1000 m in all: periods times wavelength";
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

impl Default for Sine {
    /// 5 waves of 0.5 m, 20 mm from trough to crest, from x = 0.7 m.
    fn default() -> Self {
        Self {
            amplitude: 0.01,
            wavelength: 0.5,
            start: 0.7,
            periods: 5,
        }
    }
}

/// Level ground, an incline, level ground; two corners.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ramp {
    /// Slope of the incline, rad; negative downhill. Within +-80 deg.
    pub angle: f64,
    /// x of the start of the incline, m.
    pub start: f64,
    /// Length along the incline, m.
    pub length: f64,
}

impl Shape for Ramp {
    fn pieces(&self) -> (Vec2, Vec<Piece>) {
        let start = Vec2::new(self.start, 0.0);
        let top = start + Vec2::new(self.angle.cos(), self.angle.sin()) * self.length;
        (start, vec![Piece::Line(top)])
    }
}

impl Default for Ramp {
    /// An incline of 15 deg, 0.8 m long, from x = 0.7 m.
    fn default() -> Self {
        Self {
            angle: 15.0_f64.to_radians(),
            start: 0.7,
            length: 0.8,
        }
    }
}

/// Steps with vertical risers: one is a kerb, several are stairs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stairs {
    /// Height of each riser, m; negative for steps down.
    pub rise: f64,
    /// Length of each tread, m.
    pub run: f64,
    /// Number of risers.
    pub count: u32,
    /// x of the first riser, m.
    pub start: f64,
}

impl Shape for Stairs {
    fn check(&self) -> Result<(), ProfileError> {
        let allowed = "a finite number other than 0";
        ProfileError::unless(self.rise != 0.0, "rise", self.rise, allowed)
    }

    fn pieces(&self) -> (Vec2, Vec<Piece>) {
        let start = Vec2::new(self.start, 0.0);
        let mut at = start;
        let mut pieces = Vec::new();
        for step in 0..self.count {
            if step > 0 {
                at.x += self.run;
                pieces.push(Piece::Line(at));
            }
            at.y += self.rise;
            pieces.push(Piece::Line(at));
        }
        (start, pieces)
    }
}

impl Default for Stairs {
    /// 4 steps of 80 mm, 300 mm apart, from x = 0.7 m.
    fn default() -> Self {
        Self {
            rise: 0.08,
            run: 0.3,
            count: 4,
            start: 0.7,
        }
    }
}

impl Stairs {
    /// A kerb of 50 mm at x = 0.7 m.
    pub fn step() -> Self {
        Self {
            rise: 0.05,
            count: 1,
            ..Self::default()
        }
    }
}

/// A trench with vertical walls and a level bottom.
///
/// If it is narrower than a wheel's diameter and deep enough, the wheel rests on both upper
/// corners.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ditch {
    /// Depth of the bottom below the level ground, m.
    pub depth: f64,
    /// Distance between the walls, m.
    pub width: f64,
    /// x of the rear wall, m.
    pub start: f64,
}

impl Shape for Ditch {
    fn pieces(&self) -> (Vec2, Vec<Piece>) {
        let corner = |(x, y)| Piece::Line(Vec2::new(self.start + x, y));
        let (bottom, width) = (-self.depth, self.width);
        let walls = [(0.0, bottom), (width, bottom), (width, 0.0)];
        (Vec2::new(self.start, 0.0), walls.map(corner).to_vec())
    }
}

impl Default for Ditch {
    /// 50 mm deep and 120 mm wide, at x = 0.7 m.
    fn default() -> Self {
        Self {
            depth: 0.05,
            width: 0.12,
            start: 0.7,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Profile;

    /// Closed form: slope and second derivative against central differences. The bounds cover the
    /// errors of the differences at h = 1e-5 m.
    #[test]
    fn derivatives_match_differences() {
        for profile in [
            Profile::smooth(),
            Profile::CosBump(Default::default()),
            Profile::Sine(crate::Sine::default()),
            Profile::Rough(crate::Rough::new(Default::default())),
        ] {
            for i in 0..400 {
                let x = 0.2 + 0.008_71 * f64::from(i);
                let h = 1e-5;
                let (m, p) = (profile.eval(x - h), profile.eval(x + h));
                let [_, slope, second] = profile.eval(x);
                assert!(
                    (slope - (p[0] - m[0]) / (2.0 * h)).abs() < 1e-7,
                    "slope at {x}"
                );
                assert!(
                    (second - (p[1] - m[1]) / (2.0 * h)).abs() < 1e-5,
                    "second derivative at {x}"
                );
            }
        }
    }

    #[test]
    fn waves_are_two_amplitudes_high_and_end_level() {
        let profile = Profile::Sine(crate::Sine::default());
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
