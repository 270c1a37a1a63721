//! `[terrain]`: the keys of each kind of ground.

use super::ground::TerrainChoice;
use super::points::{COLUMN, FILE, HASH, Points};
use robhaz_keys::prelude::*;
use robhaz_sim::friction::Stretch;
use robhaz_terrain::{Bump, Interpolation, RoughClass};

keys! {
    /// The key of every kind, in the section itself only: parts of a course do not have it.
    pub(super) STRETCHES: TerrainChoice;

    /// friction stretches, from rear to front; they must not overlap
    stretch ("none"): STRETCH_LIST => stretches;
}

keys! {
    STRETCH: Stretch;

    /// x of its start; compared with the contact's x
    from (required): number(LENGTH, at_least(-1000.0).at_most(10_000.0)) => from;

    /// x of its end, above from
    to (required): number(LENGTH, at_least(-1000.0).at_most(10_000.0)) => to;

    /// static friction coefficient there
    mu_s (required): number(NONE, at_least(0.0).at_most(10.0)) => mu_s;

    /// dynamic friction coefficient there, not above mu_s
    mu_d (required): number(NONE, at_least(0.0).at_most(10.0)) => mu_d;
}

/// A coordinate along the ground.
const PLACE: Number = number(LENGTH, at_least(-1000.0).at_most(1000.0));
/// A height that may be negative.
const HEIGHT: Number = number(LENGTH, at_least(-10.0).at_most(10.0));

keys! {
    pub(super) BUMPS: TerrainChoice;

    /// kind bumps only: Gaussian bumps that add up
    bumps (required): list(
        section(BUMP), "an array of 1 to 1000 tables {height, centre, width}", [1, 1000],
        || Bump { height: 0.0, centre: 0.0, width: 1.0 },
    ) => values.bumps;
}

keys! {
    BUMP: Bump;

    /// height of the summit; negative for a hollow
    height (required): HEIGHT => height;

    /// where the summit is; the middle wheel starts at 0
    centre (required): PLACE => centre;

    /// half width at 1/e of the height
    // Knots of the ground are a tenth of the narrowest width apart.
    width (required): number(LENGTH, at_least(0.005).at_most(10.0)) => width;
}

keys! {
    pub(super) COSBUMP: TerrainChoice;

    /// kind cosbump only: height of the summit; negative for a hollow
    height: HEIGHT => values.cosbump.height;

    /// kind cosbump only: where the summit is
    centre: PLACE => values.cosbump.centre;

    /// kind cosbump only: half of the bump's length
    half_width: number(LENGTH, at_least(0.005).at_most(100.0)) => values.cosbump.half_width;
}

keys! {
    pub(super) START: TerrainChoice;

    /// kinds ramp, step, stairs, sine, ditch and rough: where the level ground ends; the middle
    /// wheel starts at 0
    start: PLACE => values.start;
}

keys! {
    pub(super) RAMP: TerrainChoice;

    /// kind ramp only: slope of the incline; negative downhill
    // 80 deg: steeper ground is a riser.
    angle: number(ANGLE, at_least(-1.396).at_most(1.396)) => values.ramp.angle;

    /// kind ramp only: length along the incline
    length: number(LENGTH, above(0.0).at_most(1000.0)) => values.ramp.length;
}

keys! {
    /// Stairs of one riser.
    pub(super) STEP: TerrainChoice;

    /// kind step only: height of the kerb, other than 0; negative for a kerb down
    kerb: HEIGHT => values.stairs.rise;
}

keys! {
    pub(super) STAIRS: TerrainChoice;

    /// kind stairs only: height of each riser, other than 0; negative for stairs down
    rise: HEIGHT => values.stairs.rise;

    /// kind stairs only: length of each tread
    run: number(LENGTH, above(0.0).at_most(100.0)) => values.stairs.run;

    /// kind stairs only: number of risers, a whole number
    count: COUNT => values.stairs.count;
}

keys! {
    pub(super) SINE: TerrainChoice;

    /// kind sine only: half of the height from trough to crest; negative for waves below the level
    /// ground
    amplitude: HEIGHT => values.sine.amplitude;

    /// kind sine only: from crest to crest
    wavelength: number(LENGTH, at_least(0.02).at_most(100.0)) => values.sine.wavelength;

    /// kind sine only: number of waves, a whole number; at most 1000 m of them
    periods: COUNT => values.sine.periods;
}

keys! {
    pub(super) DITCH: TerrainChoice;

    /// kind ditch only: depth of the bottom
    depth: number(LENGTH, above(0.0).at_most(10.0)) => values.ditch.depth;

    /// kind ditch only: from wall to wall
    width: number(LENGTH, above(0.0).at_most(100.0)) => values.ditch.width;
}

keys! {
    pub(super) ROUGH: TerrainChoice;

    /// kind rough only: seed of the random ground; the same seed makes the same ground
    seed ("the scene's `seed`"): SEED => values.rough.seed;

    /// kind rough only: class of ISO 8608, from very good roads (A) to the roughest ground (H)
    class: word(&RoughClass::ALL, RoughClass::name) => values.rough.class;

    /// kind rough only: shortest wavelength
    shortest: number(LENGTH, at_least(0.05).at_most(100.0)) => values.rough.shortest;

    /// kind rough only: longest wavelength, above shortest
    longest: number(LENGTH, above(0.05).at_most(1000.0)) => values.rough.longest;

    /// kind rough only: length along x, both fades included
    extent: number(LENGTH, above(0.0).at_most(1000.0)) => values.rough.extent;

    /// kind rough only: length over which the height rises from zero at the start and falls to zero
    /// at the end, at most half of extent
    fade: number(LENGTH, above(0.0).at_most(500.0)) => values.rough.fade;
}

keys! {
    pub(super) HEIGHTS: TerrainChoice;

    /// kind heights only: points that the ground goes through, m; heights count from the first
    points ("none"): Points => values.points;

    /// kind heights only: points from a file, instead of points
    file ("none"): FILE => values.file;

    /// kind heights with file only: the column of x
    x_column ("by the first line, else the first"): COLUMN => values.format.x;

    /// kind heights with file only: the column of the height
    height_column ("by the first line, else the second"): COLUMN => values.format.height;

    /// kind heights with file only: lines may be in any order; two neighbouring lines of equal x are a
    /// riser
    sort ("off"): SWITCH => values.format.sort if |it| !it.values.file.is_empty();

    /// kind heights with file only: hash that the file must have; a resolved scene has it
    file_hash ("none"): HASH => values.file_hash;

    /// kind heights only: a smooth curve that stays between its points, a natural cubic spline, or
    /// straight pieces with corners
    interpolation: word(&Interpolation::ALL, Interpolation::name) => values.interpolation;

    /// kind heights only: wavelength whose amplitude is halved; shorter waves are removed; 0 for no
    /// smoothing
    smoothing: number(LENGTH, at_least(0.0).at_most(100.0)) => values.smoothing;
}

/// `[[terrain.stretch]]`
const STRETCH_LIST: List<Table<Stretch>> = List {
    item: section(STRETCH),
    words: "up to 1000 tables, each headed [[terrain.stretch]]",
    // Each contact looks them up.
    count: [0, 1000],
    start: || Stretch {
        from: 0.0,
        to: 0.0,
        mu_s: 0.0,
        mu_d: 0.0,
    },
    check: |reader, node, path, stretch, before| {
        let mut refuse = |key: &str, rule: String| reader.refuse_key(node, path, key, &rule);
        if stretch.to <= stretch.from {
            refuse("to", format!("above from, {} m", stretch.from));
        }
        if stretch.mu_d > stretch.mu_s {
            refuse("mu_d", format!("not above mu_s, {}", stretch.mu_s));
        }
        if let Some(before) = before.last().filter(|b| stretch.from < b.to) {
            let rule = format!("not below the end of the stretch before, {} m", before.to);
            refuse("from", rule);
        }
    },
};
