//! A table of keys for each kind of ground. They set the parameters of the terrain crate.

use super::bump::BUMP;
use super::points::{COLUMN, FILE, POINTS};
use crate::json;
use crate::key::{Form, Key, Words};
use crate::range::{above, at_least};
use crate::seed;
use crate::units::{ANGLE, LENGTH};
use robhaz_terrain::{
    CosBump, Ditch, Interpolation, Ramp, RoughClass, RoughSettings, Sine, Stairs,
};
use serde_json::json;

/// Largest number of bumps.
pub(super) const MOST_BUMPS: usize = 1000;
/// Largest number of parts.
pub(super) const MOST_PARTS: usize = 100;

/// Classes of random ground, as [`RoughClass::ALL`].
const CLASSES: Words = &["A", "B", "C", "D", "E", "F", "G", "H"];

/// Interpolations between points, as [`Interpolation::ALL`].
const INTERPOLATIONS: Words = &["monotone", "spline", "corners"];

/// The key of kind `bumps`.
pub(super) const BUMPS: &[Key<()>] = &[Key::own(
    "bumps",
    "",
    Form {
        words: "an array of 1 to 1000 tables {height, centre, width}",
        schema: || json::array(json::table(BUMP, None), 1, MOST_BUMPS),
    },
    "kind bumps only: Gaussian bumps that add up",
)
.required()];

/// The keys of kind `cosbump`.
pub(super) const COSBUMP: &[Key<CosBump>] = &[
    Key::number(
        "height",
        LENGTH,
        at_least(-10.0).at_most(10.0),
        |b| &mut b.height,
        "kind cosbump only: height of the summit; negative for a hollow",
    ),
    Key::number(
        "centre",
        LENGTH,
        at_least(-1000.0).at_most(1000.0),
        |b| &mut b.centre,
        "kind cosbump only: where the summit is",
    ),
    Key::number(
        "half_width",
        LENGTH,
        at_least(0.005).at_most(100.0),
        |b| &mut b.half_width,
        "kind cosbump only: half of the bump's length",
    ),
];

/// The key `start`, the same in every kind that has one.
const fn start<T>(at: fn(&mut T) -> &mut f64) -> Key<T> {
    Key::number(
        "start",
        LENGTH,
        at_least(-1000.0).at_most(1000.0),
        at,
        "kinds ramp, step, stairs, sine, ditch and rough: where the level ground ends; the middle wheel starts at 0",
    )
}

/// The keys of kind `ramp`.
pub(super) const RAMP: &[Key<Ramp>] = &[
    Key::number(
        "angle",
        ANGLE,
        // 80 deg: steeper ground is a riser.
        at_least(-1.396).at_most(1.396),
        |r| &mut r.angle,
        "kind ramp only: slope of the incline; negative downhill",
    ),
    Key::number(
        "length",
        LENGTH,
        above(0.0).at_most(1000.0),
        |r| &mut r.length,
        "kind ramp only: length along the incline",
    ),
    start(|r| &mut r.start),
];

/// The keys of kind `step`: stairs of one riser.
pub(super) const STEP: &[Key<Stairs>] = &[
    start(|s| &mut s.start),
    Key::number(
        "kerb",
        LENGTH,
        at_least(-10.0).at_most(10.0),
        |s| &mut s.rise,
        "kind step only: height of the kerb, other than 0; negative for a kerb down",
    ),
];

/// The keys of kind `stairs`.
pub(super) const STAIRS: &[Key<Stairs>] = &[
    start(|s| &mut s.start),
    Key::number(
        "rise",
        LENGTH,
        at_least(-10.0).at_most(10.0),
        |s| &mut s.rise,
        "kind stairs only: height of each riser, other than 0; negative for stairs down",
    ),
    Key::number(
        "run",
        LENGTH,
        above(0.0).at_most(100.0),
        |s| &mut s.run,
        "kind stairs only: length of each tread",
    ),
    Key::count(
        "count",
        1000,
        |s| s.count,
        |s, n| s.count = n,
        "kind stairs only: number of risers, a whole number",
    ),
];

/// The keys of kind `sine`.
pub(super) const SINE: &[Key<Sine>] = &[
    start(|s| &mut s.start),
    Key::number(
        "amplitude",
        LENGTH,
        at_least(-10.0).at_most(10.0),
        |s| &mut s.amplitude,
        "kind sine only: half of the height from trough to crest; negative for waves below the level ground",
    ),
    Key::number(
        "wavelength",
        LENGTH,
        at_least(0.02).at_most(100.0),
        |s| &mut s.wavelength,
        "kind sine only: from crest to crest",
    ),
    Key::count(
        "periods",
        1000,
        |s| s.periods,
        |s, n| s.periods = n,
        "kind sine only: number of waves, a whole number; at most 1000 m of them",
    ),
];

/// The keys of kind `ditch`.
pub(super) const DITCH: &[Key<Ditch>] = &[
    start(|d| &mut d.start),
    Key::number(
        "depth",
        LENGTH,
        above(0.0).at_most(10.0),
        |d| &mut d.depth,
        "kind ditch only: depth of the bottom",
    ),
    Key::number(
        "width",
        LENGTH,
        above(0.0).at_most(100.0),
        |d| &mut d.width,
        "kind ditch only: from wall to wall",
    ),
];

/// The keys of kind `rough`.
pub(super) const ROUGH: &[Key<RoughSettings>] = &[
    Key::own(
        "seed",
        "the scene's `seed`",
        seed::FORM,
        "kind rough only: seed of the random ground; the same seed makes the same ground",
    ),
    start(|r| &mut r.start),
    Key::word(
        "class",
        CLASSES,
        |r| r.class as usize,
        |r, i| r.class = RoughClass::ALL[i],
        "kind rough only: class of ISO 8608, from very good roads (A) to the roughest ground (H)",
    ),
    Key::number(
        "shortest",
        LENGTH,
        at_least(0.05).at_most(100.0),
        |r| &mut r.shortest,
        "kind rough only: shortest wavelength",
    ),
    Key::number(
        "longest",
        LENGTH,
        above(0.05).at_most(1000.0),
        |r| &mut r.longest,
        "kind rough only: longest wavelength, above shortest",
    ),
    Key::number(
        "extent",
        LENGTH,
        above(0.0).at_most(1000.0),
        |r| &mut r.extent,
        "kind rough only: length along x, both fades included",
    ),
    Key::number(
        "fade",
        LENGTH,
        above(0.0).at_most(500.0),
        |r| &mut r.fade,
        "kind rough only: length over which the height rises from zero at the start and falls to zero at the end, at most half of extent",
    ),
];

/// How the ground goes through its points.
#[derive(Clone, Copy)]
pub(crate) struct Curve {
    pub interpolation: Interpolation,
    /// Wavelength that is halved, m; 0 for no smoothing.
    pub smoothing: f64,
}

/// The keys of kind `heights`.
pub(super) const HEIGHTS: &[Key<Curve>] = &[
    Key::own(
        "points",
        "none",
        POINTS,
        "kind heights only: points that the ground goes through, m; heights count from the first",
    ),
    Key::own(
        "file",
        "none",
        FILE,
        "kind heights only: points from a file, instead of points",
    ),
    Key::own(
        "x_column",
        "by the first line, else the first",
        COLUMN,
        "kind heights with file only: the column of x",
    ),
    Key::own(
        "height_column",
        "by the first line, else the second",
        COLUMN,
        "kind heights with file only: the column of the height",
    ),
    Key::own(
        "sort",
        "off",
        Form {
            words: "\"off\", \"on\"",
            schema: json::switch,
        },
        "kind heights with file only: lines may be in any order; lines of equal x become one point at their mean height",
    ),
    Key::own(
        "file_hash",
        "none",
        Form {
            words: "\"sha256:\" and 64 digits",
            schema: || json!({"type": "string", "pattern": "^sha256:[0-9a-f]{64}$"}),
        },
        "kind heights with file only: hash that the file must have; a resolved scene has it",
    ),
    Key::word(
        "interpolation",
        INTERPOLATIONS,
        |c| c.interpolation as usize,
        |c, i| c.interpolation = Interpolation::ALL[i],
        "kind heights only: a smooth curve that stays between its points, a natural cubic spline, or straight pieces with corners",
    ),
    Key::number(
        "smoothing",
        LENGTH,
        at_least(0.0).at_most(100.0),
        |c| &mut c.smoothing,
        "kind heights only: wavelength whose amplitude is halved; shorter waves are removed; 0 for no smoothing",
    ),
];

/// The key of kind `parts`.
pub(super) const PARTS: &[Key<()>] = &[Key::own(
    "part",
    "",
    Form {
        words: "1 to 100 tables, each headed [[terrain.part]]",
        // A part has the keys of other kinds.
        schema: || json::array(json!({"$ref": "#/definitions/part"}), 1, MOST_PARTS),
    },
    "kind parts only: the parts, each with the keys of [terrain] except stretch, from rear to front",
)
.required()];
