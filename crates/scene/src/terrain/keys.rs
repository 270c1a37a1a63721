//! `[terrain]`: the keys of each kind of ground.

use super::TerrainChoice;
use super::ground::{DEFAULT, Ground, KINDS};
use super::points::{self, COLUMN, FILE, HASH, Points};
use robhaz_keys::error::Problem;
use robhaz_keys::form::{About, Form, KeyReference, Maybe, Out, items, object, word};
use robhaz_keys::key::{self, Key, List, keys, properties, required};
use robhaz_keys::quantity::{ANGLE, LENGTH, NONE, Number, above, at_least, number};
use robhaz_keys::reader::{Reader, join};
use robhaz_keys::source::{Entry, Node};
use robhaz_keys::values::{COUNT, SEED, SWITCH};
use robhaz_sim::friction::Stretch;
use robhaz_terrain::{Bump, Interpolation, RoughClass, check_risers};
use serde_json::{Value as Json, json};

/// The keys of a kind alone.
fn own_keys(kind: &str) -> impl Iterator<Item = &'static Key<Ground>> + Clone + use<> {
    let (start, own) = match kind {
        "bumps" => (None, BUMPS),
        "cosbump" => (None, COSBUMP),
        "ramp" => (Some(START), RAMP),
        "step" => (Some(START), STEP),
        "stairs" => (Some(START), STAIRS),
        "sine" => (Some(START), SINE),
        "ditch" => (Some(START), DITCH),
        "rough" => (Some(START), ROUGH),
        "heights" => (None, HEIGHTS),
        "parts" => (None, PARTS),
        _ => (None, &[] as &[_]),
    };
    start.into_iter().flatten().chain(own)
}

keys! {
    /// The key of every kind.
    COMMON: Ground;

    /// level ground; the main course of five bumps; Gaussian bumps; one cosine bump; an incline;
    /// one kerb; stairs; waves; a trench; random ground; ground through points; a sequence of other
    /// kinds
    kind ("smooth"): word(&KINDS, |kind| kind) => kind;
}

keys! {
    /// The key of every kind, in the section itself only: parts of a course do not have it.
    STRETCHES: Ground;

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
    BUMPS: Ground;

    /// kind bumps only: Gaussian bumps that add up
    bumps (required): List {
        keys: BUMP,
        words: "an array of 1 to 1000 tables {height, centre, width}",
        least: 1,
        most: 1000,
        start: || Bump { height: 0.0, centre: 0.0, width: 1.0 },
        check: |_, _, _, _, _| {},
    } => bumps;
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
    COSBUMP: Ground;

    /// kind cosbump only: height of the summit; negative for a hollow
    height: HEIGHT => cosbump.height;

    /// kind cosbump only: where the summit is
    centre: PLACE => cosbump.centre;

    /// kind cosbump only: half of the bump's length
    half_width: number(LENGTH, at_least(0.005).at_most(100.0)) => cosbump.half_width;
}

keys! {
    START: Ground;

    /// kinds ramp, step, stairs, sine, ditch and rough: where the level ground ends; the middle
    /// wheel starts at 0
    start: PLACE => start;
}

keys! {
    RAMP: Ground;

    /// kind ramp only: slope of the incline; negative downhill
    // 80 deg: steeper ground is a riser.
    angle: number(ANGLE, at_least(-1.396).at_most(1.396)) => ramp.angle;

    /// kind ramp only: length along the incline
    length: number(LENGTH, above(0.0).at_most(1000.0)) => ramp.length;
}

keys! {
    /// Stairs of one riser.
    STEP: Ground;

    /// kind step only: height of the kerb, other than 0; negative for a kerb down
    kerb: HEIGHT => step.rise;
}

keys! {
    STAIRS: Ground;

    /// kind stairs only: height of each riser, other than 0; negative for stairs down
    rise: HEIGHT => stairs.rise;

    /// kind stairs only: length of each tread
    run: number(LENGTH, above(0.0).at_most(100.0)) => stairs.run;

    /// kind stairs only: number of risers, a whole number
    count: COUNT => stairs.count;
}

keys! {
    SINE: Ground;

    /// kind sine only: half of the height from trough to crest; negative for waves below the level
    /// ground
    amplitude: HEIGHT => sine.amplitude;

    /// kind sine only: from crest to crest
    wavelength: number(LENGTH, at_least(0.02).at_most(100.0)) => sine.wavelength;

    /// kind sine only: number of waves, a whole number; at most 1000 m of them
    periods: COUNT => sine.periods;
}

keys! {
    DITCH: Ground;

    /// kind ditch only: depth of the bottom
    depth: number(LENGTH, above(0.0).at_most(10.0)) => ditch.depth;

    /// kind ditch only: from wall to wall
    width: number(LENGTH, above(0.0).at_most(100.0)) => ditch.width;
}

keys! {
    ROUGH: Ground;

    /// kind rough only: seed of the random ground; the same seed makes the same ground
    seed ("the scene's `seed`"): Maybe(SEED) => seed;

    /// kind rough only: class of ISO 8608, from very good roads (A) to the roughest ground (H)
    class: word(&RoughClass::ALL, RoughClass::name) => rough.class;

    /// kind rough only: shortest wavelength
    shortest: number(LENGTH, at_least(0.05).at_most(100.0)) => rough.shortest;

    /// kind rough only: longest wavelength, above shortest
    longest: number(LENGTH, above(0.05).at_most(1000.0)) => rough.longest;

    /// kind rough only: length along x, both fades included
    extent: number(LENGTH, above(0.0).at_most(1000.0)) => rough.extent;

    /// kind rough only: length over which the height rises from zero at the start and falls to zero
    /// at the end, at most half of extent
    fade: number(LENGTH, above(0.0).at_most(500.0)) => rough.fade;
}

keys! {
    HEIGHTS: Ground;

    /// kind heights only: points that the ground goes through, m; heights count from the first
    points ("none"): Points => heights.points;

    /// kind heights only: points from a file, instead of points
    file ("none"): FILE => heights.file;

    /// kind heights with file only: the column of x
    x_column ("by the first line, else the first"): COLUMN => heights.columns.x;

    /// kind heights with file only: the column of the height
    height_column ("by the first line, else the second"): COLUMN => heights.columns.height;

    /// kind heights with file only: lines may be in any order; two neighbouring lines of equal x are a
    /// riser
    sort ("off"): Maybe(SWITCH) => heights.sort;

    /// kind heights with file only: hash that the file must have; a resolved scene has it
    file_hash ("none"): HASH => heights.file_hash;

    /// kind heights only: a smooth curve that stays between its points, a natural cubic spline, or
    /// straight pieces with corners
    interpolation: word(&Interpolation::ALL, Interpolation::name) => interpolation;

    /// kind heights only: wavelength whose amplitude is halved; shorter waves are removed; 0 for no
    /// smoothing
    smoothing: number(LENGTH, at_least(0.0).at_most(100.0)) => smoothing;
}

keys! {
    PARTS: Ground;

    /// kind parts only: the parts, each with the keys of [terrain] except stretch, from rear to
    /// front
    part (required): Parts => parts;
}

/// `[[terrain.stretch]]`
const STRETCH_LIST: List<Stretch> = List {
    keys: STRETCH,
    words: "up to 1000 tables, each headed [[terrain.stretch]]",
    least: 0,
    // Each contact looks them up.
    most: 1000,
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

/// A ground.
pub(crate) struct Terrain {
    /// Whether it is a part of a course: of another kind than level ground or a course, and without
    /// stretches.
    pub is_part: bool,
}

impl Terrain {
    fn kinds(&self) -> &'static [&'static str] {
        match self.is_part {
            true => &KINDS[1..KINDS.len() - 1],
            false => &KINDS,
        }
    }

    /// Its keys: those of every kind, those of the kind.
    fn keys(&self, kind: &str) -> impl Iterator<Item = &'static Key<Ground>> + Clone + use<> {
        let stretches = if self.is_part { &[] } else { STRETCHES };
        COMMON.iter().chain(stretches).chain(own_keys(kind))
    }

    /// Refuses a key that the kind does not take, unless the keys of other kinds are ignored.
    fn refuse(
        &self,
        reader: &mut Reader,
        entry: &Entry,
        path: &str,
        kind: &str,
        ignores_others: bool,
    ) {
        let name = entry.key.as_str();
        let allowed = key::names(self.keys(kind));
        let has = |kind: &&str| own_keys(kind).any(|key| key.name == name);
        let owners: Vec<&str> = KINDS.into_iter().filter(has).collect();
        if owners.is_empty() {
            return reader.unknown(entry, path, &allowed);
        }
        if ignores_others {
            return;
        }
        let allowed = match allowed.as_slice() {
            ["kind"] => "kind alone".to_owned(),
            names => names.join(", "),
        };
        let allowed = format!(
            "with kind = \"{kind}\": {allowed}; {name} belongs to kind = \"{}\"",
            owners.join("\", \"")
        );
        // The key is wrong, not its value.
        let key = Node::text(&entry.origin, name);
        reader.refuse(&key, &join(path, name), &allowed);
    }

    /// Writes its keys, whose heading is written.
    fn write(&self, out: &mut Out, path: &str, choice: &TerrainChoice) {
        let mut ground = Ground::of(choice);
        out.table(self.keys(ground.kind), &mut ground, path);
    }
}

impl Form for Terrain {
    type Value = TerrainChoice;

    fn read(&self, reader: &mut Reader, node: &Node, path: &str, into: &mut TerrainChoice) {
        let (kinds, chosen) = (self.kinds(), node.get("kind"));
        let kind = match chosen.map(|n| reader.word(kinds, n, &join(path, "kind"))) {
            None => DEFAULT,
            Some(Some(index)) => kinds[index],
            // The allowed keys are then unknown.
            Some(None) => return,
        };
        // Where an override sets the kind, the file's keys of its own kind are ignored.
        let ignores_file = chosen.is_some_and(|c| c.origin.is_override());
        let (mark, mut ground) = (reader.mark(), Ground::standard(kind));
        for entry in reader.entries(node, path) {
            match self.keys(kind).find(|key| key.name == entry.key) {
                Some(key) => {
                    let path = join(path, key.name);
                    key.field.read(reader, &entry.node, &path, &mut ground);
                }
                None => {
                    let is_ignored = ignores_file && !entry.origin.is_override();
                    self.refuse(reader, entry, path, kind, is_ignored);
                }
            }
        }
        reader.require(self.keys(kind), node, path);
        let (mut points, track) = match kind {
            "heights" => points::resolve(reader, node, path, &ground.heights).unwrap_or_default(),
            _ => Default::default(),
        };
        let risers = check_risers(&points, ground.interpolation, ground.smoothing);
        if let Err(error) = risers {
            reader.push(Problem::at(&node.origin, path, error.to_string()).whole());
            points.clear();
        }
        *into = ground.choice(points, track, reader.seed);
        if let (true, Err(error)) = (reader.mark() == mark, into.profile.check()) {
            reader.refuse(node, path, &error.to_string());
        }
    }

    /// All keys of the kinds, and for each kind which of them it takes.
    fn schema(&self, _defaults: Option<&mut TerrainChoice>) -> Json {
        let kinds = self.kinds();
        let mut all = properties(COMMON, None);
        all["kind"]["enum"] = json!(kinds);
        let mut rules = Vec::new();
        for kind in kinds {
            let mut condition = json!({"properties": {"kind": {"const": kind}}});
            if *kind != DEFAULT {
                condition["required"] = json!(["kind"]);
            }
            rules.push(json!({
                "if": condition,
                "then": {
                    "propertyNames": {"enum": key::names(self.keys(kind))},
                    "required": required(self.keys(kind)),
                },
            }));
            let own = self.keys(kind).skip(COMMON.len());
            all.extend(properties(own, Some(&mut Ground::standard(kind))));
        }
        let mut schema = object(all, &[]);
        schema["allOf"] = json!(rules);
        schema
    }

    fn is_section(&self) -> bool {
        true
    }

    fn tables(&self, out: &mut Out, path: &str, meaning: &str, value: &mut TerrainChoice) {
        out.head(&format!("[{path}]"), meaning);
        self.write(out, path, value);
    }

    fn rows(&self, rows: &mut Vec<KeyReference>, path: &str, _value: &mut TerrainChoice) {
        let mut below = Vec::new();
        for kind in KINDS {
            let mut ground = Ground::standard(kind);
            for key in self.keys(kind) {
                // Several kinds have the same key.
                if !rows.iter().any(|r| r.key == join(path, key.name)) {
                    rows.push(key::row(key, path, &mut ground));
                    key.field
                        .rows(&mut below, &join(path, key.name), &mut ground);
                }
            }
        }
        rows.extend(below);
    }
}

/// The parts of a course.
pub(super) struct Parts;

/// Largest number of parts.
const MOST_PARTS: usize = 100;

impl Form for Parts {
    type Value = Vec<TerrainChoice>;

    fn read(&self, reader: &mut Reader, node: &Node, path: &str, into: &mut Self::Value) {
        for (item, path) in reader.items(node, path, 1..=MOST_PARTS, || self.allowed()) {
            let mut part = TerrainChoice::default();
            Terrain { is_part: true }.read(reader, item, &path, &mut part);
            into.push(part);
        }
    }

    fn about(&self) -> About {
        About::new("1 to 100 tables, each headed [[terrain.part]]")
    }

    fn schema(&self, _defaults: Option<&mut Self::Value>) -> Json {
        items(json!({"$ref": "#/definitions/part"}), 1, MOST_PARTS)
    }

    fn tables(&self, out: &mut Out, path: &str, _meaning: &str, value: &mut Self::Value) {
        for part in value {
            out.head(&format!("[[{path}]]"), "");
            Terrain { is_part: true }.write(out, path, part);
        }
    }
}
