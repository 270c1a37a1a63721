//! The ground's height over x, described by a few parameters: one kind of ground, or a course of
//! several.
//!
//! [`Profile`] and [`Course`] contain each other and therefore share a module.

use crate::shape::{Piece, ProfileError, Shape};
use crate::{Bump, CosBump, Ditch, Heights, Ramp, Rough, Sine, Stairs, Vec2};

/// Overlap of two parts that counts as rounding, m.
const TOLERANCE: f64 = 1e-9;

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

/// Level ground: no bumps.
static LEVEL: Vec<Bump> = Vec::new();

impl Profile {
    fn shape(&self) -> &dyn Shape {
        match self {
            Self::Flat => &LEVEL,
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

    /// Checks the rules between the parameters. The range of each alone is that of its key in a
    /// scene.
    ///
    /// # Errors
    /// The first [`ProfileError`] found.
    pub fn check(&self) -> Result<(), ProfileError> {
        self.shape().check()
    }

    /// Height (m), slope (-) and second derivative (1/m) at x (m). Zero for ramps, stairs and
    /// ditches, which consist of straight lines only.
    pub fn eval(&self, x: f64) -> [f64; 3] {
        self.shape().eval(x)
    }

    pub(crate) fn pieces(&self) -> (Vec2, Vec<Piece>) {
        self.shape().pieces()
    }

    /// The ground of the scene `smooth`: [`Bump::smooth`].
    pub fn smooth() -> Self {
        Self::Bumps(Bump::smooth())
    }
}

/// Profiles one after the other with level ground between them. Each starts at the height at which
/// the last one ended.
#[derive(Clone, Debug, PartialEq)]
pub struct Course {
    pub(crate) parts: Vec<Part>,
}

/// A profile at its place in a course.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Part {
    pub profile: Profile,
    /// x of its start, m.
    start: f64,
    /// x of its end, m.
    end: f64,
    /// Height of its start, m.
    pub base: f64,
    /// Height of its end, m.
    end_height: f64,
}

impl Part {
    /// A profile that starts at the height `base`, m.
    pub fn new(profile: Profile, base: f64) -> Self {
        let (start, pieces) = profile.pieces();
        let mut end = start;
        for piece in pieces {
            match piece {
                Piece::Line(to) => end = to,
                Piece::Curve(x, _) => end = Vec2::new(x, profile.eval(x)[0]),
            }
        }
        Self {
            start: start.x,
            end: end.x,
            base,
            end_height: base + end.y,
            profile,
        }
    }

    /// Height (m), slope (-) and second derivative (1/m) at x, as [`Profile::eval`].
    pub fn eval(&self, x: f64) -> [f64; 3] {
        let [y, slope, second] = self.profile.eval(x);
        [self.base + y, slope, second]
    }
}

impl Course {
    /// A course of profiles, given from rear to front: none of level ground, none a course itself.
    pub fn new(profiles: Vec<Profile>) -> Self {
        let mut parts: Vec<Part> = Vec::with_capacity(profiles.len());
        for profile in profiles {
            let base = parts.last().map_or(0.0, |p| p.end_height);
            parts.push(Part::new(profile, base));
        }
        Self { parts }
    }

    /// The profiles from rear to front.
    pub fn profiles(&self) -> impl Iterator<Item = &Profile> {
        self.parts.iter().map(|p| &p.profile)
    }
}

impl Shape for Course {
    fn check(&self) -> Result<(), ProfileError> {
        self.parts.iter().try_for_each(|p| p.profile.check())?;
        for (i, pair) in self.parts.windows(2).enumerate() {
            if pair[1].start < pair[0].end - TOLERANCE {
                let (part, start, end) = (i + 1, pair[1].start, pair[0].end);
                return Err(ProfileError(format!(
                    "part {part} starts at {start} m, before the end of the part before, {end} m"
                )));
            }
        }
        Ok(())
    }

    /// Where two parts meet, the front one applies.
    fn eval(&self, x: f64) -> [f64; 3] {
        let next = self.parts.partition_point(|p| p.start <= x);
        match next.checked_sub(1).map(|i| &self.parts[i]) {
            None => [0.0; 3],
            Some(part) if x > part.end => [part.end_height, 0.0, 0.0],
            Some(part) => part.eval(x),
        }
    }

    /// Empty: the chain of a course is built part by part.
    fn pieces(&self) -> (Vec2, Vec<Piece>) {
        (Vec2::zeros(), Vec::new())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Sine;

    fn waves(start: f64) -> Profile {
        Profile::Sine(Sine {
            amplitude: 0.01,
            wavelength: 0.5,
            start,
            periods: 2,
        })
    }

    #[test]
    fn each_part_starts_where_the_last_one_ended() {
        let course = Course::new(vec![
            Profile::Stairs(crate::Stairs::step()),
            waves(1.0),
            waves(2.0),
        ]);
        assert_eq!(course.check(), Ok(()));
        for (x, y) in [
            (0.0, 0.0),
            (0.9, 0.05),
            (1.25, 0.07),
            (2.25, 0.07),
            (9.0, 0.05),
        ] {
            assert!((course.eval(x)[0] - y).abs() < 1e-12, "at {x}");
        }
    }

    #[test]
    fn parts_must_not_overlap() {
        let error = Course::new(vec![waves(1.0), waves(1.5)]).check();
        let expected = "part 1 starts at 1.5 m, before the end of the part before, 2 m";
        assert_eq!(error.map_err(|e| e.to_string()), Err(expected.to_owned()));
    }
}
