//! The values of the keys of a ground.

use super::TerrainChoice;
use super::points::PointKeys;
use robhaz_terrain::{Bump, CosBump, Ditch, Interpolation, Ramp, RoughSettings, Sine, Stairs};

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
    pub heights: PointKeys,
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
