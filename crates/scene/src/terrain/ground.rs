//! A ground: the values of its keys, and the profile that they give.

use robhaz_model::{Robot, Vec2};
use robhaz_sim::friction::Stretch;
use robhaz_terrain::{
    Bump, CosBump, Course, Ditch, Interpolation, Profile, Ramp, RoughSettings, Sine, Stairs,
    Terrain, TrackFormat,
};
use sha2::{Digest as _, Sha256};
use std::sync::Arc;

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
    pub(super) values: Ground,
}

impl TerrainChoice {
    /// The keys of a kind before a file changes them; the profile is not yet made of them.
    pub(super) fn standard(kind: &'static str) -> Self {
        Self {
            kind,
            profile: Profile::Flat,
            stretches: Vec::new(),
            tracks: Vec::new(),
            values: Ground::standard(kind),
        }
    }

    /// The parts of a course become one profile.
    pub(super) fn join_parts(&mut self) {
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
                part.values.file = track.file_name();
            }
            profiles.push(part.profile.clone());
            self.tracks.extend_from_slice(&part.tracks);
        }
        self.profile = Profile::Course(Course::new(profiles));
    }

    /// The ground for a robot: blunt corners are rounded for the radius of its wheels.
    pub fn build(&self, robot: &Robot) -> Terrain {
        Terrain::for_wheels(&self.profile, robot.geometry.wheel_radius)
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

/// A file of points as the scene names it, with its content: the run's folder gets a copy.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Track {
    /// Index of the part of the ground, from 0; `None` for the whole ground.
    pub part: Option<usize>,
    /// The file's content.
    pub bytes: Arc<[u8]>,
}

impl Track {
    /// Name of the copy in a run's folder.
    pub fn file_name(&self) -> String {
        match self.part {
            None => "track.csv".to_owned(),
            Some(part) => format!("track-{part}.csv"),
        }
    }

    /// The hash that the resolved scene states: `sha256:` and 64 digits.
    pub fn hash(&self) -> String {
        format!("sha256:{:x}", Sha256::digest(&self.bytes))
    }
}

/// The kind of a scene that names none.
pub(super) const DEFAULT: &str = "smooth";

/// The values of the keys of a ground, those of all kinds; a ground is made of those of its kind
/// alone. SI.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Ground {
    pub start: f64,
    pub bumps: Vec<Bump>,
    pub cosbump: CosBump,
    pub ramp: Ramp,
    pub stairs: Stairs,
    pub sine: Sine,
    pub ditch: Ditch,
    pub rough: RoughSettings,
    pub points: Vec<Vec2>,
    pub file: String,
    pub file_hash: String,
    pub format: TrackFormat,
    pub interpolation: Interpolation,
    pub smoothing: f64,
    pub parts: Vec<TerrainChoice>,
}

impl Ground {
    /// The values before a file changes them: those of the standard profile of a kind.
    pub fn standard(kind: &str) -> Self {
        Self {
            start: Ramp::default().start,
            bumps: Bump::smooth(),
            stairs: match kind {
                "step" => Stairs::step(),
                _ => Stairs::default(),
            },
            ..Self::default()
        }
    }
}
