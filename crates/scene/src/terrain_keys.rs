//! `[terrain]`: the kinds of ground and the keys of each, declared.

use crate::key::{Key, Words};
use crate::points;
use crate::range::{above, at_least};
use crate::seed;
use crate::units::{ANGLE, LENGTH, NONE};
use robhaz_sim::friction::Stretch;
use robhaz_terrain::{
    Bump, CosBump, Ditch, Profile, Ramp, Rough, RoughClass, RoughSettings, Sine, Stairs,
};

/// Where the terrain is in the file.
pub(crate) const PATH: &str = "terrain";

/// All kinds; the default is [`DEFAULT`].
pub(crate) const KINDS: Words = &[
    "flat", "smooth", "bumps", "cosbump", "ramp", "step", "stairs", "sine", "ditch", "rough",
    "heights", "parts",
];
pub(crate) const DEFAULT: &str = "smooth";

/// The classes of random ground, as [`RoughClass::ALL`].
const CLASSES: Words = &["A", "B", "C", "D", "E", "F", "G", "H"];

/// Ways from point to point, as [`Interpolation::ALL`].
const WAYS: Words = &["monotone", "spline", "corners"];

/// The numbers of all kinds that are described by a few.
#[derive(Clone, Copy)]
pub(crate) struct Shape {
    pub height: f64,
    pub centre: f64,
    pub half_width: f64,
    pub angle: f64,
    pub length: f64,
    pub start: f64,
    pub kerb: f64,
    pub rise: f64,
    pub run: f64,
    pub count: f64,
    pub amplitude: f64,
    pub wavelength: f64,
    pub periods: f64,
    pub depth: f64,
    pub width: f64,
    pub class: usize,
    pub shortest: f64,
    pub longest: f64,
    pub extent: f64,
    pub fade: f64,
    pub seed: u64,
    pub interpolation: usize,
    pub smoothing: f64,
}

/// The key of every kind.
pub(crate) const COMMON: &[Key<Shape>] = &[Key::own_word(
    "kind",
    DEFAULT,
    KINDS,
    "level; the main course (five bumps); bumps of your own; one cosine bump; an incline; one kerb; several; waves; a trench; random ground; through points; several one after the other",
)];

/// The key of every kind that stands in the section itself only.
pub(crate) const STRETCHES: &[Key<Shape>] = &[Key::own(
    "stretch",
    "none",
    "up to 1000 tables, each headed [[terrain.stretch]]",
    "stretches with friction coefficients of their own, from rear to front; they do not overlap",
)];

/// The keys of a stretch.
pub(crate) const STRETCH: &[Key<Stretch>] = &[
    Key::<Stretch>::number(
        "from",
        LENGTH,
        at_least(-1000.0).at_most(10_000.0),
        |s| &mut s.from,
        "x at which it starts; the contact's x counts",
    )
    .required(),
    Key::<Stretch>::number(
        "to",
        LENGTH,
        at_least(-1000.0).at_most(10_000.0),
        |s| &mut s.to,
        "x at which it ends, above from",
    )
    .required(),
    Key::<Stretch>::number(
        "mu_s",
        NONE,
        at_least(0.0).at_most(10.0),
        |s| &mut s.mu_s,
        "static friction coefficient there",
    )
    .required(),
    Key::<Stretch>::number(
        "mu_d",
        NONE,
        at_least(0.0).at_most(10.0),
        |s| &mut s.mu_d,
        "dynamic friction coefficient there, not above mu_s",
    )
    .required(),
];

/// A stretch whose fields are to be filled in.
pub(crate) const NO_STRETCH: Stretch = Stretch {
    from: 0.0,
    to: 0.0,
    mu_s: 0.0,
    mu_d: 0.0,
};

/// The keys of kind `bumps`.
pub(crate) const BUMPS: &[Key<Shape>] = &[Key::own(
    "bumps",
    "",
    "an array of 1 to 1000 tables {height, centre, width}",
    "kind bumps only: Gaussian bumps that add up",
)
.required()];

/// The key of kind `rough` that is no float.
pub(crate) const SEED: &[Key<Shape>] = &[Key::own(
    "seed",
    "the scene's `seed`",
    seed::ALLOWED,
    "kind rough only: seed of the random ground; the same seed makes the same ground",
)];

/// The key of kind `parts`.
pub(crate) const PARTS: &[Key<Shape>] = &[Key::own(
    "part",
    "",
    "1 to 100 tables, each headed [[terrain.part]]",
    "kind parts only: one table for each, with the keys of [terrain] but stretch; from rear to front",
)
.required()];

/// All keys that their kinds read themselves.
pub(crate) const OWN: &[&[Key<Shape>]] = &[BUMPS, SEED, points::KEYS, PARTS];

/// The keys of one bump of kind `bumps`.
pub(crate) const BUMP: &[Key<Bump>] = &[
    Key::<Bump>::number(
        "height",
        LENGTH,
        at_least(-10.0).at_most(10.0),
        |b| &mut b.height,
        "height of the summit; negative for a hollow",
    )
    .required(),
    Key::<Bump>::number(
        "centre",
        LENGTH,
        at_least(-1000.0).at_most(1000.0),
        |b| &mut b.centre,
        "where the summit is; the middle wheel starts at 0",
    )
    .required(),
    Key::<Bump>::number(
        "width",
        LENGTH,
        // The ground is cut into pieces of a tenth of the narrowest width.
        at_least(0.005).at_most(10.0),
        |b| &mut b.width,
        "half width at 1/e of the height",
    )
    .required(),
];

/// The keys of a [`Shape`]; which kind takes which is told by [`taken_by`].
pub(crate) const SHAPE: &[Key<Shape>] = &[
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
    Key::number(
        "angle",
        ANGLE,
        // 80 deg: steeper ground is a riser.
        at_least(-1.396).at_most(1.396),
        |b| &mut b.angle,
        "kind ramp only: slope of the incline; negative downhill",
    ),
    Key::number(
        "length",
        LENGTH,
        above(0.0).at_most(1000.0),
        |b| &mut b.length,
        "kind ramp only: length along the incline",
    ),
    Key::number(
        "start",
        LENGTH,
        at_least(-1000.0).at_most(1000.0),
        |b| &mut b.start,
        "kinds ramp, step, stairs, sine, ditch and rough: where the level ground ends; the middle wheel starts at 0",
    ),
    Key::number(
        "kerb",
        LENGTH,
        at_least(-10.0).at_most(10.0),
        |b| &mut b.kerb,
        "kind step only: height of the kerb, other than 0; negative for a kerb down",
    ),
    Key::number(
        "rise",
        LENGTH,
        at_least(-10.0).at_most(10.0),
        |b| &mut b.rise,
        "kind stairs only: height of each riser, other than 0; negative for stairs down",
    ),
    Key::number(
        "run",
        LENGTH,
        above(0.0).at_most(100.0),
        |b| &mut b.run,
        "kind stairs only: length of each tread",
    ),
    Key::number(
        "count",
        NONE,
        at_least(1.0).at_most(1000.0),
        |b| &mut b.count,
        "kind stairs only: number of risers, a whole number",
    ),
    Key::number(
        "amplitude",
        LENGTH,
        at_least(-10.0).at_most(10.0),
        |b| &mut b.amplitude,
        "kind sine only: half of the height from trough to crest; negative for waves below the level ground",
    ),
    Key::number(
        "wavelength",
        LENGTH,
        at_least(0.02).at_most(100.0),
        |b| &mut b.wavelength,
        "kind sine only: from crest to crest",
    ),
    Key::number(
        "periods",
        NONE,
        at_least(1.0).at_most(1000.0),
        |b| &mut b.periods,
        "kind sine only: number of waves, a whole number; at most 1000 m of them",
    ),
    Key::number(
        "depth",
        LENGTH,
        above(0.0).at_most(10.0),
        |b| &mut b.depth,
        "kind ditch only: depth of the bottom",
    ),
    Key::number(
        "width",
        LENGTH,
        above(0.0).at_most(100.0),
        |b| &mut b.width,
        "kind ditch only: from wall to wall",
    ),
    Key::word(
        "class",
        CLASSES,
        |b| b.class,
        |b, i| b.class = i,
        "kind rough only: class of ISO 8608, from very good roads (A) to the roughest ground (H)",
    ),
    Key::number(
        "shortest",
        LENGTH,
        at_least(0.05).at_most(100.0),
        |b| &mut b.shortest,
        "kind rough only: shortest wavelength",
    ),
    Key::number(
        "longest",
        LENGTH,
        above(0.05).at_most(1000.0),
        |b| &mut b.longest,
        "kind rough only: longest wavelength, above shortest",
    ),
    Key::number(
        "extent",
        LENGTH,
        above(0.0).at_most(1000.0),
        |b| &mut b.extent,
        "kind rough only: length along x, both fades included",
    ),
    Key::number(
        "fade",
        LENGTH,
        above(0.0).at_most(500.0),
        |b| &mut b.fade,
        "kind rough only: length over which it grows out of the level ground and shrinks back, at most half of extent",
    ),
    Key::word(
        "interpolation",
        WAYS,
        |b| b.interpolation,
        |b, i| b.interpolation = i,
        "kind heights only: a smooth curve that stays between its points, a natural cubic spline, or straight pieces with corners",
    ),
    Key::number(
        "smoothing",
        LENGTH,
        at_least(0.0).at_most(100.0),
        |b| &mut b.smoothing,
        "kind heights only: waves of this length are halved, shorter ones taken out; 0 for none",
    ),
];

/// The kinds that take a key.
pub(crate) fn taken_by(key: &str) -> &'static [&'static str] {
    match key {
        "height" | "centre" | "half_width" => &["cosbump"],
        "angle" | "length" => &["ramp"],
        "start" => &["ramp", "step", "stairs", "sine", "ditch", "rough"],
        "kerb" => &["step"],
        "rise" | "run" | "count" => &["stairs"],
        "amplitude" | "wavelength" | "periods" => &["sine"],
        "depth" | "width" => &["ditch"],
        "class" | "shortest" | "longest" | "extent" | "fade" | "seed" => &["rough"],
        "bumps" => &["bumps"],
        "part" => &["parts"],
        "interpolation" | "smoothing" => &["heights"],
        key if points::KEYS.iter().any(|k| k.name == key) => &["heights"],
        _ => &[],
    }
}

/// A bump whose fields are to be filled in.
pub(crate) const NO_BUMP: Bump = Bump {
    height: 0.0,
    centre: 0.0,
    width: 1.0,
};

impl Default for Shape {
    /// The contract's courses.
    fn default() -> Self {
        let mut shape = Self {
            height: 0.0,
            centre: 0.0,
            half_width: 0.0,
            angle: 0.0,
            length: 0.0,
            start: 0.0,
            kerb: 0.0,
            rise: 0.0,
            run: 0.0,
            count: 1.0,
            amplitude: 0.0,
            wavelength: 1.0,
            periods: 1.0,
            depth: 0.0,
            width: 0.0,
            class: 0,
            shortest: 0.0,
            longest: 0.0,
            extent: 0.0,
            fade: 0.0,
            seed: 0,
            interpolation: 0,
            smoothing: 0.0,
        };
        for (kind, course) in [
            ("cosbump", Profile::cosbump()),
            ("ramp", Profile::ramp()),
            ("step", Profile::step()),
            ("stairs", Profile::stairs()),
            ("sine", Profile::sine()),
            ("ditch", Profile::ditch()),
            ("rough", Profile::rough(0)),
        ] {
            shape.take(kind, &course);
        }
        shape
    }
}

impl Shape {
    /// The numbers of a profile of a kind; those of other kinds at their defaults.
    pub(crate) fn of(kind: &str, profile: &Profile) -> Self {
        let mut shape = Self::default();
        shape.take(kind, profile);
        shape
    }

    fn take(&mut self, kind: &str, profile: &Profile) {
        match *profile {
            Profile::Rough(ref rough) => {
                let s = rough.settings();
                self.class = s.class as usize;
                (self.shortest, self.longest, self.start) = (s.shortest, s.longest, s.start);
                (self.extent, self.fade, self.seed) = (s.extent, s.fade, s.seed);
            }
            Profile::Heights(ref heights) => {
                self.interpolation = heights.interpolation() as usize;
                self.smoothing = heights.smoothing();
            }
            Profile::CosBump(b) => {
                (self.height, self.centre, self.half_width) = (b.height, b.centre, b.half_width);
            }
            Profile::Ramp(r) => {
                (self.angle, self.start, self.length) = (r.angle, r.start, r.length);
            }
            Profile::Stairs(s) if kind == "step" => (self.kerb, self.start) = (s.rise, s.start),
            Profile::Stairs(s) => {
                (self.rise, self.run, self.start) = (s.rise, s.run, s.start);
                self.count = f64::from(s.count);
            }
            Profile::Sine(s) => {
                (self.amplitude, self.wavelength) = (s.amplitude, s.wavelength);
                (self.start, self.periods) = (s.start, f64::from(s.periods));
            }
            Profile::Ditch(d) => {
                (self.depth, self.width, self.start) = (d.depth, d.width, d.start);
            }
            Profile::Flat | Profile::Bumps(_) | Profile::Course(_) => {}
        }
    }

    pub(crate) fn profile(self, kind: &str) -> Profile {
        let start = self.start;
        let stairs = |rise, run, count| {
            Profile::Stairs(Stairs {
                rise,
                run,
                count,
                start,
            })
        };
        match kind {
            "cosbump" => Profile::CosBump(CosBump {
                height: self.height,
                centre: self.centre,
                half_width: self.half_width,
            }),
            "ramp" => Profile::Ramp(Ramp {
                angle: self.angle,
                start,
                length: self.length,
            }),
            "step" => stairs(self.kerb, self.run, 1),
            "stairs" => stairs(self.rise, self.run, whole(self.count)),
            "sine" => Profile::Sine(Sine {
                amplitude: self.amplitude,
                wavelength: self.wavelength,
                start,
                periods: whole(self.periods),
            }),
            "rough" => Profile::Rough(Rough::new(RoughSettings {
                class: RoughClass::ALL[self.class],
                shortest: self.shortest,
                longest: self.longest,
                start,
                extent: self.extent,
                fade: self.fade,
                seed: self.seed,
            })),
            "ditch" => Profile::Ditch(Ditch {
                depth: self.depth,
                width: self.width,
                start,
            }),
            _ => Profile::smooth(),
        }
    }
}

#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "read as 1 to 1000"
)]
fn whole(count: f64) -> u32 {
    count.round() as u32
}

/// The keys of [`SHAPE`] that a kind takes.
pub(crate) fn shape_keys(kind: &str) -> impl Iterator<Item = &'static Key<Shape>> {
    SHAPE
        .iter()
        .filter(move |k| taken_by(k.name).contains(&kind))
}

/// The kinds at a place: a part is neither level ground nor made of parts.
pub(crate) fn kinds(path: &str) -> Words {
    match path {
        PATH => KINDS,
        _ => &KINDS[1..KINDS.len() - 1],
    }
}

/// The keys of every kind at a place.
pub(crate) fn common(path: &str) -> impl Iterator<Item = &'static Key<Shape>> {
    let stretches = if path == PATH { STRETCHES } else { &[] };
    COMMON.iter().chain(stretches)
}

/// All keys that a kind takes at a place.
pub(crate) fn allowed_in(kind: &str, path: &str) -> Vec<&'static str> {
    let taken = |k: &&Key<Shape>| taken_by(k.name).contains(&kind);
    let own = OWN.iter().copied().flatten().filter(taken);
    let all = common(path).chain(own).chain(shape_keys(kind));
    all.map(|k| k.name).collect()
}

/// The kind that describes a part's shape in full.
pub(crate) fn kind_of(profile: &Profile) -> &'static str {
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
