//! `[terrain]`: kinds of ground, each with keys of its own.

use crate::key::{Key, Words};
use crate::range::at_least;
use crate::reader::{Reader, join};
use crate::scene::TerrainChoice;
use crate::source::{Entry, Node, Value};
use crate::units::LENGTH;
use robhaz_terrain::{Bump, Profile};

/// Where the terrain is in the file.
pub(crate) const PATH: &str = "terrain";
/// More bumps than this slow every query.
const MOST_BUMPS: usize = 1000;

/// All kinds; the default is [`DEFAULT`].
pub(crate) const KINDS: Words = &["flat", "smooth", "bumps", "cosbump"];
pub(crate) const DEFAULT: &str = "smooth";

/// The fields of [`Profile::CosBump`].
#[derive(Clone, Copy)]
pub(crate) struct CosBump {
    height: f64,
    centre: f64,
    half_width: f64,
}

/// The key of every kind.
pub(crate) const COMMON: &[Key<CosBump>] = &[Key::own_word(
    "kind",
    DEFAULT,
    KINDS,
    "level; the main course (five bumps); bumps of your own; one cosine bump",
)];

/// The keys of kind `bumps`.
pub(crate) const BUMPS: &[Key<CosBump>] = &[Key::own(
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

/// The keys of kind `cosbump`.
pub(crate) const COSBUMP: &[Key<CosBump>] = &[
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

/// A bump whose fields are to be filled in.
pub(crate) const NO_BUMP: Bump = Bump {
    height: 0.0,
    centre: 0.0,
    width: 1.0,
};

impl CosBump {
    /// The cosine bump of a profile; any other ground has a level one.
    pub(crate) fn of(profile: &Profile) -> Self {
        let (height, centre, half_width) = match *profile {
            Profile::CosBump {
                height,
                centre,
                half_width,
            } => (height, centre, half_width),
            _ => (0.0, 0.0, 1.0),
        };
        Self {
            height,
            centre,
            half_width,
        }
    }

    fn profile(self) -> Profile {
        Profile::CosBump {
            height: self.height,
            centre: self.centre,
            half_width: self.half_width,
        }
    }
}

/// The default ground.
pub(crate) fn default() -> TerrainChoice {
    TerrainChoice {
        kind: DEFAULT,
        profile: Profile::smooth(),
    }
}

fn keys_of(kind: &str) -> &'static [Key<CosBump>] {
    match kind {
        "bumps" => BUMPS,
        "cosbump" => COSBUMP,
        _ => &[],
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
    let mut cosbump = CosBump::of(&Profile::cosbump());
    for entry in reader.entries(node, PATH) {
        let left_behind = forgiving && !entry.origin.is_override();
        match owner(&entry.key) {
            Some(owner) if owner != kind && !has(keys_of(kind), &entry.key) => {
                if !left_behind {
                    foreign(reader, entry, kind, owner);
                }
            }
            _ if has(COMMON, &entry.key) => {}
            Some(_) => reader.entry(keys_of(kind), entry, PATH, &mut cosbump),
            None => unknown(reader, entry, kind),
        }
    }
    reader.require(keys_of(kind), node, PATH);
    let profile = match (kind, node.get("bumps")) {
        ("flat", _) => Profile::Flat,
        ("bumps", Some(bumps)) => Profile::Bumps(read_bumps(reader, bumps)),
        ("cosbump", _) => cosbump.profile(),
        _ => Profile::smooth(),
    };
    if let (true, Err(error)) = (reader.mark() == mark, profile.check()) {
        reader.refuse(node, PATH, &error.to_string());
    }
    TerrainChoice { kind, profile }
}

fn has(keys: &[Key<CosBump>], name: &str) -> bool {
    keys.iter().any(|k| k.name == name)
}

/// The kind that a key belongs to.
fn owner(name: &str) -> Option<&'static str> {
    KINDS.iter().find(|k| has(keys_of(k), name)).copied()
}

fn foreign(reader: &mut Reader, entry: &Entry, kind: &str, owner: &str) {
    let allowed = match allowed_in(kind).as_slice() {
        ["kind"] => "kind alone".to_owned(),
        names => names.join(", "),
    };
    let allowed = format!(
        "with kind = \"{kind}\": {allowed}; {} belongs to kind = \"{owner}\"",
        entry.key
    );
    // The key is what is wrong, not its value.
    let key = Node::text(&entry.origin, &entry.key);
    reader.refuse(&key, &join(PATH, &entry.key), &allowed);
}

fn unknown(reader: &mut Reader, entry: &Entry, kind: &str) {
    reader.unknown(entry, PATH, &allowed_in(kind));
}

fn allowed_in(kind: &str) -> Vec<&'static str> {
    let keys = COMMON.iter().chain(keys_of(kind));
    keys.map(|k| k.name).collect()
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
