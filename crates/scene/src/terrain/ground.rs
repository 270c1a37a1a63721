//! The values of the keys of a ground, and the ground that they give.

use super::TerrainChoice;
use super::points::{PointKeys, Track};
use robhaz_model::Vec2;
use robhaz_sim::friction::Stretch;
use robhaz_terrain::{
    Bump, CosBump, Course, Ditch, Heights, Interpolation, Profile, Ramp, Rough, RoughSettings,
    Sine, Stairs,
};

/// All kinds of ground, in the order of the reference.
pub(super) const KINDS: [&str; 12] = [
    "flat", DEFAULT, "bumps", "cosbump", "ramp", "step", "stairs", "sine", "ditch", "rough",
    "heights", "parts",
];
/// The kind of a scene that names none.
pub(super) const DEFAULT: &str = "smooth";

/// The values of the keys of a ground, those of all kinds: [`Ground::choice`] takes those of its
/// kind. SI.
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

    /// The ground that these values give; `points` are those of kind heights, `seed` is the
    /// scene's.
    pub fn choice(self, points: Vec<Vec2>, track: Option<Track>, seed: u64) -> TerrainChoice {
        let start = self.start;
        let mut tracks: Vec<Track> = track.into_iter().collect();
        let profile = match self.kind {
            "flat" => Profile::Flat,
            "bumps" => Profile::Bumps(self.bumps),
            "cosbump" => Profile::CosBump(self.cosbump),
            "ramp" => Profile::Ramp(Ramp { start, ..self.ramp }),
            "step" => Profile::Stairs(Stairs { start, ..self.step }),
            "stairs" => Profile::Stairs(Stairs {
                start,
                ..self.stairs
            }),
            "sine" => Profile::Sine(Sine { start, ..self.sine }),
            "ditch" => Profile::Ditch(Ditch {
                start,
                ..self.ditch
            }),
            "rough" => Profile::Rough(Rough::new(RoughSettings {
                start,
                seed: self.seed.unwrap_or(seed),
                ..self.rough
            })),
            "heights" => Profile::Heights(Heights::with_smoothing(
                points,
                self.interpolation,
                self.smoothing,
            )),
            "parts" => {
                let profiles = self.parts.into_iter().enumerate().map(|(i, part)| {
                    let of_part = |track| Track {
                        part: Some(i),
                        ..track
                    };
                    tracks.extend(part.tracks.into_iter().map(of_part));
                    part.profile
                });
                Profile::Course(Course::new(profiles.collect()))
            }
            _ => Profile::smooth(),
        };
        TerrainChoice {
            kind: self.kind,
            profile,
            stretches: self.stretches,
            tracks,
        }
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
