//! `[terrain]`: kinds of ground, each with keys of its own.

use crate::key::{Key, Words};
use crate::range::{above, at_least};
use crate::reader::{Reader, join};
use crate::scene::TerrainChoice;
use crate::source::{Entry, Node, Value};
use crate::units::{ANGLE, LENGTH, NONE};
use robhaz_terrain::{Bump, Profile};

/// Where the terrain is in the file.
pub(crate) const PATH: &str = "terrain";
/// More bumps than this slow every query.
const MOST_BUMPS: usize = 1000;

/// All kinds; the default is [`DEFAULT`].
pub(crate) const KINDS: Words = &[
    "flat", "smooth", "bumps", "cosbump", "ramp", "step", "stairs",
];
pub(crate) const DEFAULT: &str = "smooth";

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
}

/// The key of every kind.
pub(crate) const COMMON: &[Key<Shape>] = &[Key::own_word(
    "kind",
    DEFAULT,
    KINDS,
    "level; the main course (five bumps); bumps of your own; one cosine bump; an incline; one kerb; several",
)];

/// The keys of kind `bumps`.
pub(crate) const BUMPS: &[Key<Shape>] = &[Key::own(
    "bumps",
    "",
    "an array of 1 to 1000 tables {height, centre, width}",
    "kind bumps only: Gaussian bumps that add up",
)
.required()];

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
        "kinds ramp, step and stairs: where the first corner is; the middle wheel starts at 0",
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
];

/// The kinds that take a key of [`SHAPE`].
fn taken_by(key: &str) -> &'static [&'static str] {
    match key {
        "height" | "centre" | "half_width" => &["cosbump"],
        "angle" | "length" => &["ramp"],
        "start" => &["ramp", "step", "stairs"],
        "kerb" => &["step"],
        "rise" | "run" | "count" => &["stairs"],
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
        };
        for (kind, course) in [
            ("cosbump", Profile::cosbump()),
            ("ramp", Profile::ramp()),
            ("step", Profile::step()),
            ("stairs", Profile::stairs()),
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
            Profile::Flat | Profile::Bumps(_) => {}
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
            "stairs" => {
                #[expect(
                    clippy::cast_possible_truncation,
                    clippy::cast_sign_loss,
                    reason = "read as 1 to 1000"
                )]
                let count = self.count.round() as u32;
                stairs(self.rise, self.run, count)
            }
            _ => Profile::smooth(),
        }
    }
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
    }
}

/// Reads the section.
pub(crate) fn read(reader: &mut Reader, root: &Node) -> TerrainChoice {
    let Some(node) = root.get(PATH) else {
        return default();
    };
    let chosen = node.get("kind");
    let kind = match chosen {
        None => DEFAULT,
        Some(chosen) => match reader.word(KINDS, chosen, "terrain.kind") {
            Some(index) => KINDS[index],
            // Which keys belong to it is then unknown.
            None => return default(),
        },
    };
    let mark = reader.mark();
    // An override of the kind leaves behind what the file says of its own kind.
    let forgiving = chosen.is_some_and(|c| c.origin.is_override());
    let mut shape = Shape::default();
    for entry in reader.entries(node, PATH) {
        let left_behind = forgiving && !entry.origin.is_override();
        let owners = owners(&entry.key);
        if entry.key == COMMON[0].name {
        } else if owners.is_empty() {
            unknown(reader, entry, kind);
        } else if owners.contains(&kind) {
            let keys = if kind == "bumps" { BUMPS } else { SHAPE };
            reader.entry(keys, entry, PATH, &mut shape);
        } else if !left_behind {
            foreign(reader, entry, kind, owners);
        }
    }
    if kind == "bumps" {
        reader.require(BUMPS, node, PATH);
    }
    if let (true, Some(count)) = (kind == "stairs", node.get("count"))
        && shape.count.fract() != 0.0
    {
        reader.refuse(count, "terrain.count", "a whole number from 1 to 1000");
    }
    let profile = match (kind, node.get("bumps")) {
        ("flat", _) => Profile::Flat,
        ("bumps", Some(bumps)) => Profile::Bumps(read_bumps(reader, bumps)),
        _ => shape.profile(kind),
    };
    if let (true, Err(error)) = (reader.mark() == mark, profile.check()) {
        reader.refuse(node, PATH, &error.to_string());
    }
    TerrainChoice { kind, profile }
}

/// The kinds that a key belongs to.
fn owners(name: &str) -> &'static [&'static str] {
    if BUMPS.iter().any(|k| k.name == name) {
        &["bumps"]
    } else {
        taken_by(name)
    }
}

fn foreign(reader: &mut Reader, entry: &Entry, kind: &str, owners: &[&str]) {
    let allowed = match allowed_in(kind).as_slice() {
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
    reader.refuse(&key, &join(PATH, &entry.key), &allowed);
}

fn unknown(reader: &mut Reader, entry: &Entry, kind: &str) {
    reader.unknown(entry, PATH, &allowed_in(kind));
}

fn allowed_in(kind: &str) -> Vec<&'static str> {
    let bumps = if kind == "bumps" { BUMPS } else { &[] };
    let own = bumps.iter().chain(shape_keys(kind));
    COMMON.iter().chain(own).map(|k| k.name).collect()
}

fn read_bumps(reader: &mut Reader, node: &Node) -> Vec<Bump> {
    let items = match &node.value {
        Value::Array(items) if (1..=MOST_BUMPS).contains(&items.len()) => items.as_slice(),
        _ => {
            reader.refuse(node, "terrain.bumps", &BUMPS[0].field.allowed());
            &[]
        }
    };
    let mut bumps = vec![NO_BUMP; items.len()];
    for (i, (item, bump)) in items.iter().zip(&mut bumps).enumerate() {
        reader.table(BUMP, item, &format!("terrain.bumps[{i}]"), bump);
    }
    bumps
}
