//! The values of the keys of a ground, and the ground that they give.

use super::TerrainChoice;
use super::points::{PointKeys, Track};
use robhaz_sim::friction::Stretch;
use robhaz_terrain::{
    Bump, CosBump, Course, Ditch, Interpolation, Profile, Ramp, RoughSettings, Sine, Stairs,
};

/// The kind of a scene that names none.
pub(super) const DEFAULT: &str = "smooth";

/// The values of the keys of a ground, those of all kinds; a ground is made of those of its kind
/// alone. SI.
#[derive(Clone, Default)]
pub(super) struct Ground {
    pub kind: &'static str,
    pub start: f64,
    pub bumps: Vec<Bump>,
    pub cosbump: CosBump,
    pub ramp: Ramp,
    pub step: Stairs,
    pub stairs: Stairs,
    pub sine: Sine,
    pub ditch: Ditch,
    pub rough: RoughSettings,
    pub seed: Option<u64>,
    pub heights: PointKeys,
    pub interpolation: Interpolation,
    pub smoothing: f64,
    pub parts: Vec<TerrainChoice>,
    pub stretches: Vec<Stretch>,
}

impl Ground {
    /// The values before a file changes them: those of the standard profile of a kind.
    pub fn standard(kind: &'static str) -> Self {
        Self {
            kind,
            start: Ramp::default().start,
            step: Stairs::step(),
            ..Self::default()
        }
    }

    /// The values that give a ground.
    pub fn of(choice: &TerrainChoice) -> Self {
        let mut ground = Self::standard(choice.kind);
        ground.stretches.clone_from(&choice.stretches);
        match &choice.profile {
            Profile::Flat => {}
            Profile::Bumps(bumps) => ground.bumps.clone_from(bumps),
            Profile::CosBump(bump) => ground.cosbump = *bump,
            Profile::Ramp(ramp) => (ground.ramp, ground.start) = (*ramp, ramp.start),
            Profile::Stairs(stairs) => {
                (ground.step, ground.stairs, ground.start) = (*stairs, *stairs, stairs.start);
            }
            Profile::Sine(sine) => (ground.sine, ground.start) = (*sine, sine.start),
            Profile::Ditch(ditch) => (ground.ditch, ground.start) = (*ditch, ditch.start),
            Profile::Rough(rough) => {
                let rough = *rough.settings();
                (ground.rough, ground.start, ground.seed) = (rough, rough.start, Some(rough.seed));
            }
            Profile::Heights(heights) => {
                ground.interpolation = heights.interpolation();
                ground.smoothing = heights.smoothing();
                match choice.tracks.first() {
                    None => ground.heights.points = heights.points().to_vec(),
                    Some(track) => {
                        (ground.heights.file, ground.heights.file_hash) =
                            (track.file_name(), track.hash());
                        ground.heights.sort = Some(track.format.sort);
                        ground.heights.columns = track.format.clone();
                    }
                }
            }
            Profile::Course(course) => {
                let parts = course.profiles().enumerate();
                let part = |(i, profile): (usize, &Profile)| TerrainChoice {
                    tracks: (choice.tracks.iter())
                        .filter(|track| track.part == Some(i))
                        .cloned()
                        .collect(),
                    ..TerrainChoice::of(kind_of(profile), profile.clone())
                };
                ground.parts = parts.map(part).collect();
            }
        }
        ground
    }

    /// The parts of a course as one profile, and their tracks.
    pub fn course(&mut self) -> (Profile, Vec<Track>) {
        let (mut profiles, mut tracks) = (Vec::new(), Vec::new());
        for (i, part) in self.parts.drain(..).enumerate() {
            let of_part = |track| Track {
                part: Some(i),
                ..track
            };
            tracks.extend(part.tracks.into_iter().map(of_part));
            profiles.push(part.profile);
        }
        (Profile::Course(Course::new(profiles)), tracks)
    }
}

/// The kind that can describe any profile of a shape: of `step` and `stairs`, `stairs`.
fn kind_of(profile: &Profile) -> &'static str {
    match profile {
        Profile::Flat => "flat",
        Profile::Bumps(_) => "bumps",
        Profile::CosBump(_) => "cosbump",
        Profile::Ramp(_) => "ramp",
        Profile::Stairs(_) => "stairs",
        Profile::Sine(_) => "sine",
        Profile::Ditch(_) => "ditch",
        Profile::Rough(_) => "rough",
        Profile::Heights(_) => "heights",
        Profile::Course(_) => "parts",
    }
}
