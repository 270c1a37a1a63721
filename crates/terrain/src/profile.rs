//! The ground's height over x, described by a few parameters.

use crate::{Bump, CosBump, Course, Ditch, Heights, Ramp, Rough, RoughClass, RoughSettings};
use crate::{Sine, Stairs, Vec2};

/// The shape of the ground.
#[derive(Clone, Debug, PartialEq)]
pub enum Profile {
    /// Level ground at y = 0.
    Flat,
    /// A sum of Gaussian bumps on level ground.
    Bumps(Vec<Bump>),
    /// One cosine bump.
    CosBump(CosBump),
    /// An incline.
    Ramp(Ramp),
    /// One step or several.
    Stairs(Stairs),
    /// A row of waves.
    Sine(Sine),
    /// A trench.
    Ditch(Ditch),
    /// Random ground by a class of ISO 8608.
    Rough(Rough),
    /// Ground through points.
    Heights(Heights),
    /// Several profiles one after the other.
    Course(Course),
}

/// The interface of every kind of ground.
pub(crate) trait Shape {
    /// See [`Profile::check`].
    fn check(&self) -> Result<(), ProfileError>;

    /// See [`Profile::eval`].
    fn eval(&self, _x: f64) -> [f64; 3] {
        [0.0; 3]
    }

    /// End of the level ground before the profile (m), and the pieces from there to the level ground behind it.
    fn pieces(&self) -> (Vec2, Vec<Piece>);
}

/// One piece of the ground. It starts at the end of the last piece.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Piece {
    /// A straight line to a point, m.
    Line(Vec2),
    /// The curve of [`Profile::eval`] to x (first value, m), with knots at most a spacing apart (second value, m). The
    /// spacing must resolve the shape.
    Curve(f64, f64),
}

/// Greatest spacing of knots, m: so small that an edge has at most one point nearest to a wheel's centre.
pub(crate) const SPACING: f64 = 0.01;

/// Reason why a profile is refused.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum ProfileError {
    /// Too few points.
    #[error("found {found} points; there must be at least 2")]
    FewPoints {
        /// Number of points.
        found: usize,
    },
    /// A coordinate of a point is not finite.
    #[error("point {point}: a coordinate is not a finite number")]
    Point {
        /// Index of the point, from 0.
        point: usize,
    },
    /// A point does not lie in front of the previous one.
    #[error("point {point}: x is {found} m; it must be above that of the point before, {before} m")]
    Order {
        /// Index of the point, from 0.
        point: usize,
        /// Its x, m.
        found: f64,
        /// x of the previous point, m.
        before: f64,
    },
    /// A part of a course is level ground, or a course itself.
    #[error("part {part} is level ground or a sequence itself")]
    Part {
        /// Index of the part, from 0.
        part: usize,
    },
    /// A part of a course starts before the end of the previous one.
    #[error("part {part} starts at {start} m, before the end of the part before, {end} m")]
    Overlap {
        /// Index of the part, from 0.
        part: usize,
        /// x of its start, m.
        start: f64,
        /// x of the end of the previous part, m.
        end: f64,
    },
    /// A number is out of its range.
    #[error("{entry} is {found}; it must be {allowed}")]
    Range {
        /// Name of the parameter.
        entry: &'static str,
        /// Its value.
        found: f64,
        /// The allowed values; completes the sentence "it must be ...".
        allowed: &'static str,
    },
}

/// Level ground.
struct Level;

impl Shape for Level {
    fn check(&self) -> Result<(), ProfileError> {
        Ok(())
    }

    fn pieces(&self) -> (Vec2, Vec<Piece>) {
        (Vec2::zeros(), Vec::new())
    }
}

impl Profile {
    /// Profile `smooth`, five bumps: it replaces the paper's "relatively smooth geometric profile", which was not
    /// published.
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
        Self::CosBump(CosBump {
            height: 0.06,
            centre: 1.2,
            half_width: 0.35,
        })
    }

    /// Profile `ramp`: an incline of 15 deg, 0.8 m long, from x = 0.7 m.
    pub fn ramp() -> Self {
        Self::Ramp(Ramp {
            angle: 15.0_f64.to_radians(),
            start: 0.7,
            length: 0.8,
        })
    }

    /// Profile `step`: a kerb of 50 mm at x = 0.7 m.
    pub fn step() -> Self {
        Self::Stairs(Stairs {
            rise: 0.05,
            run: 0.3,
            count: 1,
            start: 0.7,
        })
    }

    /// Profile `stairs`: 4 steps of 80 mm, 300 mm apart, from x = 0.7 m.
    pub fn stairs() -> Self {
        Self::Stairs(Stairs {
            rise: 0.08,
            run: 0.3,
            count: 4,
            start: 0.7,
        })
    }

    /// Profile `sine`: 5 waves of 0.5 m, 20 mm from trough to crest, from x = 0.7 m.
    pub fn sine() -> Self {
        Self::Sine(Sine {
            amplitude: 0.01,
            wavelength: 0.5,
            start: 0.7,
            periods: 5,
        })
    }

    /// Profile `ditch`: 50 mm deep and 120 mm wide, at x = 0.7 m.
    pub fn ditch() -> Self {
        Self::Ditch(Ditch {
            depth: 0.05,
            width: 0.12,
            start: 0.7,
        })
    }

    /// Profile `rough`: class C, wavelengths from 0.2 m to 10 m; 10 m long from x = 0.7 m, with fades of 1 m.
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

    fn shape(&self) -> &dyn Shape {
        match self {
            Self::Flat => &Level,
            Self::Bumps(bumps) => bumps,
            Self::CosBump(bump) => bump,
            Self::Ramp(ramp) => ramp,
            Self::Stairs(stairs) => stairs,
            Self::Sine(sine) => sine,
            Self::Ditch(ditch) => ditch,
            Self::Rough(rough) => rough,
            Self::Heights(heights) => heights,
            Self::Course(course) => course,
        }
    }

    /// Checks the parameters.
    ///
    /// # Errors
    /// The first [`ProfileError`] found.
    pub fn check(&self) -> Result<(), ProfileError> {
        self.shape().check()
    }

    /// Height (m), slope (-) and second derivative (1/m) at x (m). Zero for ramps, stairs and ditches, which consist of
    /// straight lines only.
    pub fn eval(&self, x: f64) -> [f64; 3] {
        self.shape().eval(x)
    }

    pub(crate) fn pieces(&self) -> (Vec2, Vec<Piece>) {
        self.shape().pieces()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Closed form: slope and second derivative against central differences. The bounds cover the errors of the
    /// differences at h = 1e-5 m.
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
}
