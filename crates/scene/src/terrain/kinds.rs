//! `[terrain]`: the kinds of ground, and the section, whose keys are those of its kind.

use super::ground::{DEFAULT, TerrainChoice};
use super::keys::{
    BUMPS, COSBUMP, DITCH, HEIGHTS, RAMP, ROUGH, SINE, STAIRS, START, STEP, STRETCHES,
};
use super::points;
use robhaz_keys::prelude::*;
use robhaz_terrain::{Ditch, Profile, Ramp, Rough, RoughSettings, Sine, Stairs};
use serde_json::{Value as Json, json};

/// A kind of ground.
struct Kind {
    name: &'static str,
    /// Its own keys, in their order.
    keys: &'static [&'static [Key<TerrainChoice>]],
    /// Makes the profile of the values of these keys, which a table at a path states.
    build: fn(&mut Reader, &Node, &str, &mut TerrainChoice),
}

impl Kind {
    fn own(&self) -> impl Iterator<Item = &'static Key<TerrainChoice>> + Clone + use<> {
        self.keys.iter().copied().flatten()
    }
}

/// The kinds that have a key of this name.
fn owners(name: &str) -> Vec<&'static str> {
    let has = |kind: &&Kind| kind.own().any(|key| key.name == name);
    KINDS.iter().filter(has).map(|kind| kind.name).collect()
}

/// A kind whose values give its profile by themselves.
macro_rules! kind {
    ($name:expr, $keys:expr, |$values:pat_param| $profile:expr) => {
        Kind {
            name: $name,
            keys: $keys,
            build: |_, _, _, it| {
                let $values = &it.values;
                it.profile = $profile;
            },
        }
    };
}

/// A kind whose profile of the same type has the key `start` beside its own.
macro_rules! from_start {
    ($name:literal, $keys:expr, $profile:ident, $field:ident) => {
        kind!($name, &[START, $keys], |it| Profile::$profile($profile {
            start: it.start,
            ..it.$field
        }))
    };
}

/// All kinds of ground, in the order of the reference. The first and the last are no parts of a
/// course.
const KINDS: &[Kind] = &[
    kind!("flat", &[], |_| Profile::Flat),
    kind!(DEFAULT, &[], |it| Profile::Bumps(it.bumps.clone())),
    kind!("bumps", &[BUMPS], |it| Profile::Bumps(it.bumps.clone())),
    kind!("cosbump", &[COSBUMP], |it| Profile::CosBump(it.cosbump)),
    from_start!("ramp", RAMP, Ramp, ramp),
    from_start!("step", STEP, Stairs, stairs),
    from_start!("stairs", STAIRS, Stairs, stairs),
    from_start!("sine", SINE, Sine, sine),
    from_start!("ditch", DITCH, Ditch, ditch),
    kind!("rough", &[START, ROUGH], |it| Profile::Rough(Rough::new(
        RoughSettings {
            start: it.start,
            ..it.rough
        }
    ))),
    Kind {
        name: "heights",
        keys: &[HEIGHTS],
        build: points::build,
    },
    Kind {
        name: "parts",
        keys: &[PARTS],
        build: |_, _, _, it| it.join_parts(),
    },
];

/// The names of all kinds.
const NAMES: [&str; KINDS.len()] = {
    let mut names = [""; KINDS.len()];
    let mut i = 0;
    while i < names.len() {
        names[i] = KINDS[i].name;
        i += 1;
    }
    names
};

keys! {
    /// The key of every kind.
    COMMON: TerrainChoice;

    /// level ground; the main course of five bumps; Gaussian bumps; one cosine bump; an incline;
    /// one kerb; stairs; waves; a trench; random ground; ground through points; a sequence of other
    /// kinds
    kind ("smooth"): word(&NAMES, |kind| kind) => kind;
}

keys! {
    PARTS: TerrainChoice;

    /// kind parts only: the parts, each with the keys of [terrain] except stretch, from rear to
    /// front
    part (required): list(
        Terrain { is_part: true }, "1 to 100 tables, each headed [[terrain.part]]", [1, 100],
        TerrainChoice::default,
    ) => values.parts;
}

/// A ground.
pub(crate) struct Terrain {
    /// Whether it is a part of a course: of another kind than level ground or a course, and without
    /// stretches.
    pub is_part: bool,
}

impl Terrain {
    fn kinds(&self) -> &'static [Kind] {
        match self.is_part {
            true => &KINDS[1..KINDS.len() - 1],
            false => KINDS,
        }
    }

    /// Their names.
    fn names(&self) -> Vec<&'static str> {
        self.kinds().iter().map(|kind| kind.name).collect()
    }

    /// The keys of a ground: those of every kind, those of the kind.
    fn keys(
        &self,
        kind: &Kind,
    ) -> impl Iterator<Item = &'static Key<TerrainChoice>> + Clone + use<> {
        let stretches = if self.is_part { &[] } else { STRETCHES };
        COMMON.iter().chain(stretches).chain(kind.own())
    }

    /// Refuses a key that the kind does not take.
    fn refuse(&self, reader: &mut Reader, entry: &Entry, path: &str, kind: &Kind) {
        let name = entry.key.as_str();
        let (allowed, owners) = (key::names(self.keys(kind)), owners(name));
        if owners.is_empty() {
            return reader.unknown(entry, path, &allowed);
        }
        let allowed = match allowed.as_slice() {
            ["kind"] => "kind alone".to_owned(),
            names => names.join(", "),
        };
        let allowed = format!(
            "with kind = \"{}\": {allowed}; {name} belongs to kind = \"{}\"",
            kind.name,
            owners.join("\", \"")
        );
        // The key is wrong, not its value.
        let key = Node::text(&entry.origin, name);
        reader.refuse(&key, &join(path, name), &allowed);
    }

    /// The schema: all keys of the kinds, and for each kind which of them it takes.
    pub fn rules(&self) -> Json {
        let kinds = self.kinds();
        let mut all = key::properties(COMMON, None);
        all["kind"]["enum"] = json!(self.names());
        let mut rules = Vec::new();
        for kind in kinds {
            let mut condition = json!({"properties": {"kind": {"const": kind.name}}});
            if kind.name != DEFAULT {
                condition["required"] = json!(["kind"]);
            }
            rules.push(json!({
                "if": condition,
                "then": {
                    "propertyNames": {"enum": key::names(self.keys(kind))},
                    "required": key::required(self.keys(kind)),
                },
            }));
            let own = self.keys(kind).skip(COMMON.len());
            let mut ground = TerrainChoice::standard(kind.name);
            all.extend(key::properties(own, Some(&mut ground)));
        }
        let mut schema = object(all, &[]);
        schema["allOf"] = json!(rules);
        schema
    }
}

impl Form for Terrain {
    type Value = TerrainChoice;

    fn read(&self, reader: &mut Reader, node: &Node, path: &str, into: &mut TerrainChoice) {
        let (kinds, chosen) = (self.kinds(), node.get("kind"));
        let index = match chosen {
            None => kinds.iter().position(|kind| kind.name == DEFAULT),
            Some(chosen) => reader.word(&self.names(), chosen, &join(path, "kind")),
        };
        // After a problem the allowed keys are unknown.
        let Some(kind) = index.map(|index| &kinds[index]) else {
            return;
        };
        // Where an override sets the kind, the file's keys of its own kind are ignored.
        let ignores_file = chosen.is_some_and(|c| c.origin.is_override());
        let is_ignored = |entry: &Entry| {
            ignores_file && !entry.origin.is_override() && !owners(&entry.key).is_empty()
        };
        let (mark, mut ground) = (reader.mark(), TerrainChoice::standard(kind.name));
        if kind.name == "rough" {
            ground.values.rough.seed = reader.seed;
        }
        for entry in reader.entries(node, path) {
            match self.keys(kind).find(|key| key.name == entry.key) {
                Some(key) => {
                    let path = join(path, key.name);
                    key.field.read(reader, &entry.node, &path, &mut ground);
                }
                None if is_ignored(entry) => {}
                None => self.refuse(reader, entry, path, kind),
            }
        }
        reader.require(self.keys(kind), node, path);
        (kind.build)(reader, node, path, &mut ground);
        *into = ground;
        if let (true, Err(error)) = (reader.mark() == mark, into.profile.check()) {
            reader.complain(&node.origin, path, || error.to_string());
        }
    }

    fn schema(&self, _defaults: Option<&mut TerrainChoice>) -> Json {
        match self.is_part {
            true => json!({"$ref": "#/definitions/part"}),
            false => self.rules(),
        }
    }

    fn tables(&self, out: &mut Out, head: &str, path: &str, about: &str, of: &mut TerrainChoice) {
        out.head(head, about);
        let kind = KINDS.iter().find(|kind| kind.name == of.kind);
        out.table(self.keys(kind.unwrap_or(&KINDS[0])), of, path);
    }

    fn rows(&self, rows: &mut Vec<KeyReference>, path: &str, _value: &mut TerrainChoice) {
        let mut below = Vec::new();
        // The keys of parts are those of the whole.
        for kind in KINDS.iter().filter(|_| !self.is_part) {
            let mut ground = TerrainChoice::standard(kind.name);
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

#[cfg(test)]
mod tests {
    use super::*;

    /// Kinds that have a key of the same name share its declaration, as `START`: its row and its schema
    /// describe one meaning.
    #[test]
    fn a_name_of_all_kinds_is_one_key() {
        let keys = || KINDS.iter().flat_map(Kind::own);
        for (a, b) in keys().flat_map(|a| keys().map(move |b| (a, b))) {
            assert!(a.name != b.name || a.meaning == b.meaning, "{}", a.name);
        }
    }

    /// The meaning of the key `kind` describes each kind, and each is written as what it reads. None but `flat` is level.
    #[test]
    fn each_kind_is_described_and_written_as_itself() {
        assert_eq!(COMMON[0].meaning.split(';').count(), KINDS.len());
        for kind in KINDS {
            let given = |key: &&Key<TerrainChoice>| matches!(key.absent, key::Absent::Required);
            let mut own = kind.own();
            if own.any(|key| given(&key)) || kind.name == "heights" {
                // Without default; the tests of resolved scenes have these.
                continue;
            }
            let text = format!("terrain.kind = \"{}\"", kind.name);
            let read = |text: &str| crate::Scene::parse(text, "x", std::path::Path::new(""), &[]);
            let scene = read(&text).unwrap();
            assert_eq!(read(&scene.to_toml("x")).unwrap().terrain, scene.terrain);
            assert_eq!(scene.terrain.kind, kind.name);
            // Curves without heights of their own are level.
            let ground = robhaz_terrain::Terrain::new(scene.terrain.profile.clone());
            let mut points = ground.survey(0.0, 6.0, 0.01).into_iter();
            let is_level = points.all(|point| point.height == 0.0);
            assert_eq!(is_level, kind.name == "flat", "{}", kind.name);
        }
    }
}
