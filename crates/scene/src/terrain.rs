//! `[terrain]`: kinds of ground, each with keys of its own.

use crate::key::{Key, Words};
use crate::points;
use crate::range::{above, at_least};
use crate::reader::{Reader, join};
use crate::scene::TerrainChoice;
use crate::seed;
use crate::source::{Entry, Node, Value};
use crate::units::{ANGLE, LENGTH, NONE};
use robhaz_sim::friction::Stretch;
use robhaz_terrain::{
    Bump, Course, Heights, Interpolation, Profile, Rough, RoughClass, RoughSettings,
};

/// Where the terrain is in the file.
pub(crate) const PATH: &str = "terrain";
/// More bumps than this slow every query.
const MOST_BUMPS: usize = 1000;
/// More parts than this are a mistake.
const MOST_PARTS: usize = 100;
/// More stretches than this slow every contact.
const MOST_STRETCHES: usize = 1000;

/// All kinds; the default is [`DEFAULT`].
pub(crate) const KINDS: Words = &[
    "flat", "smooth", "bumps", "cosbump", "ramp", "step", "stairs", "sine", "ditch", "rough",
    "heights", "parts",
];
pub(crate) const DEFAULT: &str = "smooth";

/// The classes of random ground, as [`RoughClass::ALL`].
const CLASSES: Words = &["A", "B", "C", "D", "E", "F", "G", "H"];

/// Ways from point to point, as [`Interpolation::ALL`].
const WAYS: Words = &["spline", "corners"];

/// The numbers of all kinds that are described by a few.
#[derive(Clone, Copy)]
pub(crate) struct Shape {
    height: f64,
    centre: f64,
    half_width: f64,
    angle: f64,
    length: f64,
    start: f64,
    kerb: f64,
    rise: f64,
    run: f64,
    count: f64,
    amplitude: f64,
    wavelength: f64,
    periods: f64,
    depth: f64,
    width: f64,
    class: usize,
    shortest: f64,
    longest: f64,
    extent: f64,
    fade: f64,
    seed: u64,
    interpolation: usize,
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
        "kind heights only: a natural cubic spline through the points, or straight pieces with corners",
    ),
];

/// The kinds that take a key.
fn taken_by(key: &str) -> &'static [&'static str] {
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
        "file" | "points" | "interpolation" => &["heights"],
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
            }
            Profile::CosBump {
                height,
                centre,
                half_width,
            } => (self.height, self.centre, self.half_width) = (height, centre, half_width),
            Profile::Ramp {
                angle,
                start,
                length,
            } => (self.angle, self.start, self.length) = (angle, start, length),
            Profile::Stairs { rise, start, .. } if kind == "step" => {
                (self.kerb, self.start) = (rise, start);
            }
            Profile::Stairs {
                rise,
                run,
                count,
                start,
            } => {
                (self.rise, self.run, self.start) = (rise, run, start);
                self.count = f64::from(count);
            }
            Profile::Sine {
                amplitude,
                wavelength,
                start,
                periods,
            } => {
                (self.amplitude, self.wavelength, self.start) = (amplitude, wavelength, start);
                self.periods = f64::from(periods);
            }
            Profile::Ditch {
                depth,
                width,
                start,
            } => (self.depth, self.width, self.start) = (depth, width, start),
            Profile::Flat | Profile::Bumps(_) | Profile::Course(_) => {}
        }
    }

    fn profile(self, kind: &str) -> Profile {
        let stairs = |rise, run, count| Profile::Stairs {
            rise,
            run,
            count,
            start: self.start,
        };
        match kind {
            "cosbump" => Profile::CosBump {
                height: self.height,
                centre: self.centre,
                half_width: self.half_width,
            },
            "ramp" => Profile::Ramp {
                angle: self.angle,
                start: self.start,
                length: self.length,
            },
            "step" => stairs(self.kerb, self.run, 1),
            "stairs" => stairs(self.rise, self.run, whole(self.count)),
            "sine" => Profile::Sine {
                amplitude: self.amplitude,
                wavelength: self.wavelength,
                start: self.start,
                periods: whole(self.periods),
            },
            "rough" => Profile::Rough(Rough::new(RoughSettings {
                class: RoughClass::ALL[self.class],
                shortest: self.shortest,
                longest: self.longest,
                start: self.start,
                extent: self.extent,
                fade: self.fade,
                seed: self.seed,
            })),
            "ditch" => Profile::Ditch {
                depth: self.depth,
                width: self.width,
                start: self.start,
            },
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

/// The default ground.
pub(crate) fn default() -> TerrainChoice {
    TerrainChoice {
        kind: DEFAULT,
        profile: Profile::smooth(),
        stretches: Vec::new(),
    }
}

/// Reads the section; `seed` is the scene's.
pub(crate) fn read(reader: &mut Reader, root: &Node, seed: u64) -> TerrainChoice {
    match root.get(PATH) {
        None => default(),
        Some(node) => {
            let (kind, profile) = ground(reader, node, PATH, seed);
            TerrainChoice {
                kind,
                profile,
                stretches: read_stretches(reader, node),
            }
        }
    }
}

/// Reads a table that describes a ground.
fn ground(reader: &mut Reader, node: &Node, path: &str, seed: u64) -> (&'static str, Profile) {
    let chosen = node.get("kind");
    let kind = match chosen {
        None => DEFAULT,
        Some(chosen) => match reader.word(kinds(path), chosen, &join(path, "kind")) {
            Some(index) => kinds(path)[index],
            // Which keys belong to it is then unknown.
            None => return (DEFAULT, Profile::smooth()),
        },
    };
    let mark = reader.mark();
    // An override of the kind leaves behind what the file says of its own kind.
    let forgiving = chosen.is_some_and(|c| c.origin.is_override());
    let mut shape = Shape {
        seed,
        ..Shape::default()
    };
    for entry in reader.entries(node, path) {
        let left_behind = forgiving && !entry.origin.is_override();
        let owners = taken_by(&entry.key);
        if common(path).any(|k| k.name == entry.key) {
        } else if owners.is_empty() {
            reader.unknown(entry, path, &allowed_in(kind, path));
        } else if owners.contains(&kind) {
            // The others are read by their kinds.
            if SHAPE.iter().any(|k| k.name == entry.key) {
                reader.entry(SHAPE, entry, path, &mut shape);
            }
        } else if !left_behind {
            foreign(reader, entry, path, kind, owners);
        }
    }
    let profile = match kind {
        "flat" => Profile::Flat,
        "bumps" => Profile::Bumps(read_bumps(reader, node, path)),
        "parts" => Profile::Course(Course::new(read_parts(reader, node, path, seed))),
        "heights" => {
            let points = points::read(reader, node, path);
            let way = Interpolation::ALL[shape.interpolation];
            Profile::Heights(Heights::new(points, way))
        }
        _ => {
            whole_numbers(reader, node, path, kind, &shape);
            if let (true, Some(given)) = (kind == "rough", node.get("seed")) {
                let path = join(path, "seed");
                shape.seed = seed::read(reader, given, &path).unwrap_or(seed);
            }
            shape.profile(kind)
        }
    };
    if let (true, Err(error)) = (reader.mark() == mark, profile.check()) {
        reader.refuse(node, path, &error.to_string());
    }
    (kind, profile)
}

/// Complains of counts that are no whole numbers.
fn whole_numbers(reader: &mut Reader, node: &Node, path: &str, kind: &str, shape: &Shape) {
    for (key, value) in [("count", shape.count), ("periods", shape.periods)] {
        if let (true, Some(count)) = (taken_by(key).contains(&kind), node.get(key))
            && value.fract() != 0.0
        {
            reader.refuse(count, &join(path, key), "a whole number from 1 to 1000");
        }
    }
}

fn foreign(reader: &mut Reader, entry: &Entry, path: &str, kind: &str, owners: &[&str]) {
    let allowed = match allowed_in(kind, path).as_slice() {
        ["kind"] => "kind alone".to_owned(),
        names => names.join(", "),
    };
    let allowed = format!(
        "with kind = \"{kind}\": {allowed}; {} belongs to kind = \"{}\"",
        entry.key,
        owners.join("\", \"")
    );
    // The key is what is wrong, not its value.
    let key = Node::text(&entry.origin, &entry.key);
    reader.refuse(&key, &join(path, &entry.key), &allowed);
}

/// The kinds at a place: a part is neither level ground nor made of parts.
fn kinds(path: &str) -> Words {
    match path {
        PATH => KINDS,
        _ => &KINDS[1..KINDS.len() - 1],
    }
}

/// The keys of every kind at a place.
fn common(path: &str) -> impl Iterator<Item = &'static Key<Shape>> {
    let stretches = if path == PATH { STRETCHES } else { &[] };
    COMMON.iter().chain(stretches)
}

fn allowed_in(kind: &str, path: &str) -> Vec<&'static str> {
    let taken = |k: &&Key<Shape>| taken_by(k.name).contains(&kind);
    let own = OWN.iter().copied().flatten().filter(taken);
    let all = common(path).chain(own).chain(shape_keys(kind));
    all.map(|k| k.name).collect()
}

fn read_bumps(reader: &mut Reader, node: &Node, path: &str) -> Vec<Bump> {
    reader.require(BUMPS, node, path);
    let Some(node) = node.get("bumps") else {
        return Vec::new();
    };
    let path = join(path, "bumps");
    let items = match &node.value {
        Value::Array(items) if (1..=MOST_BUMPS).contains(&items.len()) => items.as_slice(),
        _ => {
            reader.refuse(node, &path, &BUMPS[0].field.allowed());
            &[]
        }
    };
    let mut bumps = vec![NO_BUMP; items.len()];
    for (i, (item, bump)) in items.iter().zip(&mut bumps).enumerate() {
        reader.table(BUMP, item, &format!("{path}[{i}]"), bump);
    }
    bumps
}

fn read_parts(reader: &mut Reader, node: &Node, path: &str, seed: u64) -> Vec<Profile> {
    reader.require(PARTS, node, path);
    let Some(node) = node.get("part") else {
        return Vec::new();
    };
    let path = join(path, "part");
    let items = match &node.value {
        Value::Array(items) if (1..=MOST_PARTS).contains(&items.len()) => items.as_slice(),
        _ => {
            reader.refuse(node, &path, &PARTS[0].field.allowed());
            &[]
        }
    };
    let items = items.iter().enumerate();
    items
        .map(|(i, item)| ground(reader, item, &format!("{path}[{i}]"), seed).1)
        .collect()
}

/// The kind that describes a part's shape in full.
pub(crate) fn kind_of(profile: &Profile) -> &'static str {
    match profile {
        Profile::Flat => "flat",
        Profile::Bumps(_) => "bumps",
        Profile::CosBump { .. } => "cosbump",
        Profile::Ramp { .. } => "ramp",
        Profile::Stairs { .. } => "stairs",
        Profile::Sine { .. } => "sine",
        Profile::Ditch { .. } => "ditch",
        Profile::Rough(_) => "rough",
        Profile::Heights(_) => "heights",
        Profile::Course(_) => "parts",
    }
}

fn read_stretches(reader: &mut Reader, node: &Node) -> Vec<Stretch> {
    let Some(node) = node.get("stretch") else {
        return Vec::new();
    };
    let items = match &node.value {
        Value::Array(items) if items.len() <= MOST_STRETCHES => items.as_slice(),
        _ => {
            let path = join(PATH, "stretch");
            reader.refuse(node, &path, &STRETCHES[0].field.allowed());
            &[]
        }
    };
    let mut stretches: Vec<Stretch> = Vec::with_capacity(items.len());
    for (i, item) in items.iter().enumerate() {
        let path = format!("{PATH}.stretch[{i}]");
        let mark = reader.mark();
        let mut stretch = NO_STRETCH;
        reader.table(STRETCH, item, &path, &mut stretch);
        if reader.mark() == mark {
            check_stretch(reader, item, &path, &stretch, stretches.last());
            stretches.push(stretch);
        }
    }
    stretches
}

fn check_stretch(
    reader: &mut Reader,
    node: &Node,
    path: &str,
    stretch: &Stretch,
    before: Option<&Stretch>,
) {
    let mut refuse = |key: &str, rule: String| {
        if let Some(node) = node.get(key) {
            reader.refuse(node, &join(path, key), &rule);
        }
    };
    if stretch.to <= stretch.from {
        refuse("to", format!("above from, {} m", stretch.from));
    }
    if stretch.mu_d > stretch.mu_s {
        refuse("mu_d", format!("not above mu_s, {}", stretch.mu_s));
    }
    if let Some(before) = before.filter(|b| stretch.from < b.to) {
        let rule = format!("not below the end of the stretch before, {} m", before.to);
        refuse("from", rule);
    }
}
