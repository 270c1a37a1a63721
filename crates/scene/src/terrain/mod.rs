//! `[terrain]`: kinds of ground, each with keys of its own, and points from tracks.

mod ground;
mod keys;
mod kinds;
mod points;

pub(crate) use kinds::Terrain;
pub use points::Track;

use ground::{DEFAULT, Ground};
use robhaz_model::Robot;
use robhaz_sim::friction::Stretch;
use robhaz_terrain::{Course, Profile, Terrain as Built};

/// The ground, and the name of its kind.
#[derive(Clone, Debug, PartialEq)]
pub struct TerrainChoice {
    /// `flat`, `smooth`, `bumps` and so on, as in scene files.
    pub kind: &'static str,
    /// Its shape, which the values of its keys give.
    pub profile: Profile,
    /// Friction stretches, from rear to front; they do not overlap.
    pub stretches: Vec<Stretch>,
    /// The files of its points: a run's folder gets a copy of each, named [`Track::file_name`].
    pub tracks: Vec<Track>,
    /// The values of its keys.
    values: Ground,
}

impl TerrainChoice {
    /// The keys of a kind before a file changes them; the profile is not yet made of them.
    fn standard(kind: &'static str) -> Self {
        Self {
            kind,
            profile: Profile::Flat,
            stretches: Vec::new(),
            tracks: Vec::new(),
            values: Ground::standard(kind),
        }
    }

    /// The parts of a course become one profile.
    fn join_parts(&mut self) {
        let mut profiles = Vec::new();
        for (i, part) in self.values.parts.iter_mut().enumerate() {
            // Written as the kind that can describe any profile of the shape.
            part.kind = match part.kind {
                "smooth" => "bumps",
                "step" => "stairs",
                other => other,
            };
            for track in &mut part.tracks {
                track.part = Some(i);
                part.values.heights.file = track.file_name();
            }
            profiles.push(part.profile.clone());
            self.tracks.extend_from_slice(&part.tracks);
        }
        self.profile = Profile::Course(Course::new(profiles));
    }

    /// The ground for a robot: blunt corners are rounded for the radius of its wheels.
    pub fn build(&self, robot: &Robot) -> Built {
        Built::for_wheels(&self.profile, robot.geometry.wheel_radius)
    }
}

impl Default for TerrainChoice {
    /// The smooth course.
    fn default() -> Self {
        Self {
            profile: Profile::smooth(),
            ..Self::standard(DEFAULT)
        }
    }
}
