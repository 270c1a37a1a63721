//! The ground's height over x, with slope and curvature in closed form.

use crate::Vec2;
use crate::course::Course;
use crate::heights::Heights;
use crate::rough::{Rough, RoughClass, RoughSettings};
use std::f64::consts::PI;

/// One Gaussian bump (or hollow) `height exp(-((x - centre)/width)^2)`; m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bump {
    /// Height of the summit, m; negative for a hollow.
    pub height: f64,
    /// Where the summit is, m.
    pub centre: f64,
    /// Half width at 1/e of the height, m.
    pub width: f64,
}

/// The shape of the ground.
#[derive(Clone, Debug, PartialEq)]
pub enum Profile {
    /// Level ground at y = 0.
    Flat,
    /// A sum of Gaussian bumps on level ground.
    Bumps(Vec<Bump>),
    /// `height/2 (1 + cos(pi (x - centre)/half_width))` for `|x - centre| < half_width`, level elsewhere; m.
    ///
    /// Its curvature jumps where it meets the level ground.
    CosBump {
        /// Height of the summit, m; negative for a hollow.
        height: f64,
        /// Where the summit is, m.
        centre: f64,
        /// Half of the bump's length, m.
        half_width: f64,
    },
    /// Level ground, an incline, level ground; two corners.
    Ramp {
        /// Slope of the incline, rad; negative downhill. Within +-80 deg.
        angle: f64,
        /// Where the incline starts, m.
        start: f64,
        /// Length along the incline, m.
        length: f64,
    },
    /// Kerbs with vertical risers: one is a step, several are stairs.
    Stairs {
        /// Height of each riser, m; negative for a way down.
        rise: f64,
        /// Length of each tread, m.
        run: f64,
        /// Number of risers.
        count: u32,
        /// Where the first riser is, m.
        start: f64,
    },
    /// Waves on level ground: `amplitude (1 - cos(2 pi (x - start)/wavelength))` over whole periods; m.
    ///
    /// Height and slope join the level ground without a jump, the curvature does not. Crests are `2 amplitude` high.
    Sine {
        /// Half of the height from trough to crest, m; negative for waves below the level ground.
        amplitude: f64,
        /// From crest to crest, m.
        wavelength: f64,
        /// Where the first wave starts, m.
        start: f64,
        /// Number of waves.
        periods: u32,
    },
    /// A trench with vertical walls and a level bottom.
    ///
    /// Below two wheel radii of width its upper edges carry the wheel, if it is deep enough.
    Ditch {
        /// Depth of the bottom below the level ground, m.
        depth: f64,
        /// From wall to wall, m.
        width: f64,
        /// Where the first wall is, m.
        start: f64,
    },
    /// Random ground by a class of ISO 8608.
    Rough(Rough),
    /// Ground through points.
    Heights(Heights),
    /// Several profiles one after the other.
    Course(Course),
}

/// One piece of the ground, from where the piece before ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Piece {
    /// Straight on to a point, m.
    Line(Vec2),
    /// Along [`Profile::eval`] to this x, with knots no farther apart than the spacing that no bend slips through; m.
    Curve(f64, f64),
}

/// Why a profile cannot be ground.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum ProfileError {
    /// A number is not finite.
    #[error("bump {bump}: {entry} is not a finite number")]
    NotFinite {
        /// Which bump, from 0.
        bump: usize,
        /// Which of its numbers.
        entry: &'static str,
    },
    /// A width is not above zero.
    #[error("bump {bump}: the width is {found} m; it must be above 0")]
    Width {
        /// Which bump, from 0.
        bump: usize,
        /// What was found, m.
        found: f64,
    },
    /// Too few points.
    #[error("found {found} points; there must be at least 2")]
    FewPoints {
        /// How many.
        found: usize,
    },
    /// A coordinate of a point is not finite.
    #[error("point {point}: a coordinate is not a finite number")]
    Point {
        /// Which point, from 0.
        point: usize,
    },
    /// A point is not in front of the one before.
    #[error("point {point}: x is {found} m; it must be above that of the point before, {before} m")]
    Order {
        /// Which point, from 0.
        point: usize,
        /// Its x, m.
        found: f64,
        /// The x of the point before, m.
        before: f64,
    },
    /// A part of a course is level ground, or a course itself.
    #[error("part {part} is level ground or a sequence itself")]
    Part {
        /// Which part, from 0.
        part: usize,
    },
    /// A part of a course starts before the end of the one before.
    #[error("part {part} starts at {start} m, before the end of the part before, {end} m")]
    Overlap {
        /// Which part, from 0.
        part: usize,
        /// Where it starts, m.
        start: f64,
        /// Where the part before ends, m.
        end: f64,
    },
    /// A number is out of its range.
    #[error("{entry} is {found}; it must be {allowed}")]
    Range {
        /// Which number.
        entry: &'static str,
        /// What was found.
        found: f64,
        /// What it must be.
        allowed: &'static str,
    },
}

/// Knots no farther apart than this, m: fine enough that a wheel's nearest point is alone on its edge.
pub(crate) const SPACING: f64 = 0.01;
/// Longest row of waves, m: longer ones have too many edges.
const LONGEST_WAVES: f64 = 1000.0;
/// Square of the distance from a bump's centre, in widths, beyond which it counts as level ground.
const FADED: f64 = 40.0;

impl Profile {
    /// Profile `smooth`: stands for the paper's "relatively smooth geometric profile", which was not published.
    pub fn smooth() -> Self {
        let bump = |height, centre, width| Bump {
            height,
            centre,
            width,
        };
        Self::Bumps(vec![
            bump(0.050, 1.00, 0.22),
            bump(-0.035, 1.45, 0.20),
            bump(0.040, 1.90, 0.17),
            bump(0.060, 2.50, 0.28),
            bump(-0.030, 2.95, 0.16),
        ])
    }

    /// Profile `cosbump`: one cosine bump, 60 mm high and 0.70 m long, around x = 1.2 m.
    pub fn cosbump() -> Self {
        Self::CosBump {
            height: 0.06,
            centre: 1.2,
            half_width: 0.35,
        }
    }

    /// Profile `ramp`: 15 deg from x = 0.7 m on, 0.8 m long.
    pub fn ramp() -> Self {
        Self::Ramp {
            angle: 15.0_f64.to_radians(),
            start: 0.7,
            length: 0.8,
        }
    }

    /// Profile `step`: a kerb of 50 mm at x = 0.7 m.
    pub fn step() -> Self {
        Self::Stairs {
            rise: 0.05,
            run: 0.3,
            count: 1,
            start: 0.7,
        }
    }

    /// Profile `stairs`: 4 steps of 80 mm, 300 mm apart, from x = 0.7 m on.
    pub fn stairs() -> Self {
        Self::Stairs {
            rise: 0.08,
            run: 0.3,
            count: 4,
            start: 0.7,
        }
    }

    /// Profile `sine`: 5 waves of 0.5 m, 20 mm from trough to crest, from x = 0.7 m on.
    pub fn sine() -> Self {
        Self::Sine {
            amplitude: 0.01,
            wavelength: 0.5,
            start: 0.7,
            periods: 5,
        }
    }

    /// Profile `ditch`: 50 mm deep and 120 mm wide, at x = 0.7 m.
    pub fn ditch() -> Self {
        Self::Ditch {
            depth: 0.05,
            width: 0.12,
            start: 0.7,
        }
    }

    /// Profile `rough`: class C, waves from 0.2 m to 10 m, 10 m of it from x = 0.7 m on, with fades of 1 m.
    pub fn rough(seed: u64) -> Self {
        Self::Rough(Rough::new(RoughSettings {
            class: RoughClass::C,
            shortest: 0.2,
            longest: 10.0,
            start: 0.7,
            extent: 10.0,
            fade: 1.0,
            seed,
        }))
    }

    /// Whether the numbers describe a ground.
    ///
    /// # Errors
    /// The first [`ProfileError`] found.
    pub fn check(&self) -> Result<(), ProfileError> {
        let check = |bump, height: f64, centre: f64, width: f64| {
            for (entry, value) in [("height", height), ("centre", centre), ("width", width)] {
                if !value.is_finite() {
                    return Err(ProfileError::NotFinite { bump, entry });
                }
            }
            if width <= 0.0 {
                return Err(ProfileError::Width { bump, found: width });
            }
            Ok(())
        };
        match self {
            Self::Flat => Ok(()),
            Self::Bumps(bumps) => bumps
                .iter()
                .enumerate()
                .try_for_each(|(i, b)| check(i, b.height, b.centre, b.width)),
            Self::CosBump {
                height,
                centre,
                half_width,
            } => check(0, *height, *centre, *half_width),
            Self::Ramp {
                angle,
                start,
                length,
            } => {
                let steepest = 80.0_f64.to_radians();
                in_range("angle", *angle, "within +-80 deg", |a| a.abs() <= steepest)?;
                in_range("start", *start, "a finite number", f64::is_finite)?;
                in_range("length", *length, "a number above 0", |l| {
                    l > 0.0 && l.is_finite()
                })
            }
            Self::Stairs {
                rise, run, start, ..
            } => {
                in_range("rise", *rise, "a finite number other than 0", |r| {
                    r != 0.0 && r.is_finite()
                })?;
                in_range("start", *start, "a finite number", f64::is_finite)?;
                in_range("run", *run, "a number above 0", |r| {
                    r > 0.0 && r.is_finite()
                })
            }
            Self::Sine {
                amplitude,
                wavelength,
                start,
                periods,
            } => {
                in_range("amplitude", *amplitude, "a finite number", f64::is_finite)?;
                in_range("start", *start, "a finite number", f64::is_finite)?;
                in_range("wavelength", *wavelength, "a number above 0", |w| {
                    w > 0.0 && w.is_finite()
                })?;
                let most = "at most 1000 m in all: periods times wavelength";
                let total = wavelength * f64::from(*periods);
                in_range("the length of the waves", total, most, |l| {
                    l <= LONGEST_WAVES
                })
            }
            Self::Ditch {
                depth,
                width,
                start,
            } => {
                in_range("start", *start, "a finite number", f64::is_finite)?;
                for (entry, value) in [("depth", depth), ("width", width)] {
                    in_range(entry, *value, "a number above 0", |v| {
                        v > 0.0 && v.is_finite()
                    })?;
                }
                Ok(())
            }
            Self::Rough(rough) => rough.settings().check(),
            Self::Heights(heights) => heights.check(),
            Self::Course(course) => course.check(),
        }
    }

    /// Height (m), slope (-) and second derivative (1/m) of a smooth profile at x; level for ramps, stairs and ditches.
    pub fn eval(&self, x: f64) -> [f64; 3] {
        match self {
            Self::Flat | Self::Ramp { .. } | Self::Stairs { .. } | Self::Ditch { .. } => [0.0; 3],
            Self::Bumps(bumps) => {
                let mut sum = [0.0; 3];
                for b in bumps {
                    let u = (x - b.centre) / b.width;
                    // exp(-40) is below the rounding of any height that matters.
                    if u * u > FADED {
                        continue;
                    }
                    let e = b.height * (-u * u).exp();
                    sum[0] += e;
                    sum[1] -= 2.0 * u / b.width * e;
                    sum[2] += (4.0 * u * u - 2.0) / (b.width * b.width) * e;
                }
                sum
            }
            Self::CosBump {
                height,
                centre,
                half_width,
            } => {
                let u = (x - centre) / half_width;
                if u.abs() > 1.0 {
                    return [0.0; 3];
                }
                let (k, half) = (PI / half_width, 0.5 * height);
                let (sin, cos) = (PI * u).sin_cos();
                [half * (1.0 + cos), -half * k * sin, -half * k * k * cos]
            }
            Self::Sine {
                amplitude,
                wavelength,
                start,
                periods,
            } => {
                let u = (x - start) / wavelength;
                if !(0.0..=f64::from(*periods)).contains(&u) {
                    return [0.0; 3];
                }
                let k = 2.0 * PI / wavelength;
                let (sin, cos) = (2.0 * PI * u).sin_cos();
                [
                    amplitude * (1.0 - cos),
                    amplitude * k * sin,
                    amplitude * k * k * cos,
                ]
            }
            Self::Rough(rough) => rough.eval(x),
            Self::Heights(heights) => heights.eval(x),
            Self::Course(course) => course.eval(x),
        }
    }

    /// Where the level ground before the profile ends, and the pieces up to the level ground after it; m.
    pub(crate) fn pieces(&self) -> (Vec2, Vec<Piece>) {
        /// A Gaussian bump has faded long before this many widths from its centre.
        const WIDTHS: f64 = 8.0;
        match self {
            // A course is laid part by part.
            Self::Flat | Self::Course(_) => (Vec2::zeros(), Vec::new()),
            Self::Bumps(bumps) => {
                let (mut from, mut to, mut spacing) = (f64::INFINITY, f64::NEG_INFINITY, SPACING);
                for b in bumps {
                    from = from.min(b.centre - WIDTHS * b.width);
                    to = to.max(b.centre + WIDTHS * b.width);
                    spacing = spacing.min(b.width / 10.0);
                }
                if bumps.is_empty() {
                    return (Vec2::zeros(), Vec::new());
                }
                let start = Vec2::new(from, self.eval(from)[0]);
                (start, vec![Piece::Curve(to, spacing)])
            }
            Self::CosBump {
                centre, half_width, ..
            } => {
                let start = Vec2::new(centre - half_width, 0.0);
                let spacing = SPACING.min(half_width / 20.0);
                (start, vec![Piece::Curve(centre + half_width, spacing)])
            }
            Self::Ramp {
                angle,
                start,
                length,
            } => {
                let start = Vec2::new(*start, 0.0);
                let top = start + Vec2::new(angle.cos(), angle.sin()) * *length;
                (start, vec![Piece::Line(top)])
            }
            Self::Stairs {
                rise,
                run,
                count,
                start,
            } => {
                let start = Vec2::new(*start, 0.0);
                let mut at = start;
                let mut pieces = Vec::new();
                for step in 0..*count {
                    if step > 0 {
                        at.x += run;
                        pieces.push(Piece::Line(at));
                    }
                    at.y += rise;
                    pieces.push(Piece::Line(at));
                }
                (start, pieces)
            }
            Self::Sine {
                wavelength,
                start,
                periods,
                ..
            } => {
                let end = start + wavelength * f64::from(*periods);
                let spacing = SPACING.min(wavelength / 40.0);
                (Vec2::new(*start, 0.0), vec![Piece::Curve(end, spacing)])
            }
            Self::Ditch {
                depth,
                width,
                start,
            } => {
                let corner = |x, y| Piece::Line(Vec2::new(start + x, y));
                let start = Vec2::new(*start, 0.0);
                let walls = [(0.0, -depth), (*width, -depth), (*width, 0.0)];
                (start, walls.map(|(x, y)| corner(x, y)).to_vec())
            }
            Self::Rough(rough) => {
                let s = rough.settings();
                let spacing = SPACING.min(s.shortest / 20.0);
                let end = Piece::Curve(s.start + s.extent, spacing);
                (Vec2::new(s.start, 0.0), vec![end])
            }
            Self::Heights(heights) => heights.pieces(),
        }
    }
}

pub(crate) fn in_range(
    entry: &'static str,
    found: f64,
    allowed: &'static str,
    inside: impl Fn(f64) -> bool,
) -> Result<(), ProfileError> {
    if inside(found) {
        Ok(())
    } else {
        Err(ProfileError::Range {
            entry,
            found,
            allowed,
        })
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test may stop at the first surprise")]
mod tests {
    use super::*;

    /// Closed form against central differences: error of the second difference at h = 1e-5 is below 1e-5 for these bumps.
    #[test]
    fn derivatives_match_differences() {
        for profile in [
            Profile::smooth(),
            Profile::cosbump(),
            Profile::sine(),
            Profile::rough(0),
        ] {
            for i in 0..400 {
                let x = 0.2 + 0.008_71 * f64::from(i);
                let h = 1e-5;
                let (m, p) = (profile.eval(x - h), profile.eval(x + h));
                let [_, slope, bend] = profile.eval(x);
                assert!(
                    (slope - (p[0] - m[0]) / (2.0 * h)).abs() < 1e-7,
                    "slope at {x}"
                );
                assert!(
                    (bend - (p[1] - m[1]) / (2.0 * h)).abs() < 1e-5,
                    "bend at {x}"
                );
            }
        }
    }

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
    fn impossible_waves_and_ditches_are_refused() {
        let waves = |wavelength, periods| Profile::Sine {
            amplitude: 0.1,
            wavelength,
            start: 0.0,
            periods,
        };
        assert!(waves(0.0, 1).check().is_err());
        assert!(waves(10.0, 101).check().is_err());
        assert!(waves(10.0, 100).check().is_ok());
        let ditch = Profile::Ditch {
            depth: 0.0,
            width: 0.1,
            start: 0.0,
        };
        assert_eq!(
            ditch.check().unwrap_err().to_string(),
            "depth is 0; it must be a number above 0"
        );
    }

    #[test]
    fn impossible_bumps_are_refused() {
        let bad = Profile::Bumps(vec![Bump {
            height: 0.1,
            centre: 0.0,
            width: 0.0,
        }]);
        assert_eq!(
            bad.check(),
            Err(ProfileError::Width {
                bump: 0,
                found: 0.0
            })
        );
    }
}
