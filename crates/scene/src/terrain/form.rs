//! A ground as the value of a key: read, written and described by the keys of its kind.

use super::TerrainChoice;
use super::ground::{COMMON, Ground, KINDS, Kind, STRETCHES};
use super::points;
use crate::form::{Form, items, object};
use crate::key::{self, Absent, Key, properties, required};
use crate::reader::{Reader, join};
use crate::reference::KeyReference;
use crate::source::{Entry, Node};
use crate::write::Out;
use serde_json::{Value as Json, json};

/// A ground.
pub(crate) struct Terrain {
    /// Whether it is a part of a course: of another kind than level ground or a course, and without stretches.
    pub is_part: bool,
}

impl Terrain {
    fn kinds(&self) -> &'static [Kind] {
        match self.is_part {
            true => &KINDS[1..KINDS.len() - 1],
            false => KINDS,
        }
    }

    /// The tables of its keys: those of every kind, those of the kind.
    fn tables(&self, kind: Kind) -> [&'static [Key<Ground>]; 4] {
        let stretches = if self.is_part { &[] } else { STRETCHES };
        let [start, own] = kind.tables();
        [COMMON, stretches, start, own]
    }

    /// Refuses a key that the kind does not take, unless the keys of other kinds are ignored.
    fn refuse(
        &self,
        reader: &mut Reader,
        entry: &Entry,
        path: &str,
        kind: Kind,
        ignores_others: bool,
    ) {
        let name = entry.key.as_str();
        let tables = self.tables(kind);
        let allowed: Vec<&str> = tables.iter().copied().flatten().map(|k| k.name).collect();
        let owners = KINDS.iter().filter(|k| k.names().any(|n| n == name));
        let owners: Vec<&str> = owners.map(|k| k.name).collect();
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
            "with kind = \"{}\": {allowed}; {name} belongs to kind = \"{}\"",
            kind.name,
            owners.join("\", \"")
        );
        // The key is wrong, not its value.
        let key = Node::text(&entry.origin, name);
        reader.refuse(&key, &join(path, name), &allowed);
    }

    /// Writes its keys, whose heading is written.
    fn write(&self, out: &mut Out, path: &str, choice: &TerrainChoice) {
        let mut ground = Ground::of(choice);
        let tables = self.tables(Kind::named(choice.kind));
        tables
            .iter()
            .for_each(|keys| out.fields(*keys, &mut ground));
        tables
            .iter()
            .for_each(|keys| out.tables(keys, &mut ground, path));
    }
}

impl Form for Terrain {
    type Value = TerrainChoice;

    fn read(&self, reader: &mut Reader, node: &Node, path: &str, into: &mut TerrainChoice) {
        let (kinds, chosen) = (self.kinds(), node.get("kind"));
        let names: Vec<&str> = kinds.iter().map(|k| k.name).collect();
        let kind = match chosen.map(|n| reader.word(&names, n, &join(path, "kind"))) {
            None => Kind::default(),
            Some(Some(index)) => kinds[index],
            // The allowed keys are then unknown.
            Some(None) => return,
        };
        // Where an override sets the kind, the file's keys of its own kind are ignored.
        let ignores_file = chosen.is_some_and(|c| c.origin.is_override());
        let (mark, mut ground) = (reader.mark(), Ground::standard(kind));
        let tables = self.tables(kind);
        for entry in reader.entries(node, path) {
            let name = entry.key.as_str();
            match tables.iter().copied().flatten().find(|k| k.name == name) {
                Some(_) if name == "kind" => {}
                Some(key) => key
                    .field
                    .read(reader, &entry.node, &join(path, name), &mut ground),
                None => {
                    let is_ignored = ignores_file && !entry.origin.is_override();
                    self.refuse(reader, entry, path, kind, is_ignored);
                }
            }
        }
        for key in tables.iter().copied().flatten() {
            if key.absent == Absent::Required && node.get(key.name).is_none() {
                reader.missing(node, &join(path, key.name), &key.field.allowed());
            }
        }
        let (points, track) = match kind.name {
            "heights" => points::resolve(reader, node, path, &ground),
            _ => (Vec::new(), None),
        };
        *into = ground.choice(points, track, reader.seed);
        if let (true, Err(error)) = (reader.mark() == mark, into.profile.check()) {
            reader.refuse(node, path, &error.to_string());
        }
    }

    /// All keys of the kinds, and for each kind which of them it takes.
    fn schema(&self, _defaults: Option<&mut TerrainChoice>) -> Json {
        let kinds = self.kinds();
        let names: Vec<&str> = kinds.iter().map(|k| k.name).collect();
        let mut all = properties(COMMON, None);
        all["kind"]["enum"] = json!(names);
        let mut rules = Vec::new();
        for kind in kinds {
            let (tables, mut ground) = (self.tables(*kind), Ground::standard(*kind));
            let allowed = tables.iter().copied().flatten().map(|k| k.name);
            let needed: Vec<&str> = tables.iter().flat_map(|keys| required(keys)).collect();
            let mut condition = json!({"properties": {"kind": {"const": kind.name}}});
            if kind.name != Kind::default().name {
                condition["required"] = json!(["kind"]);
            }
            rules.push(json!({
                "if": condition,
                "then": {
                    "propertyNames": {"enum": allowed.collect::<Vec<_>>()},
                    "required": needed,
                },
            }));
            for keys in &tables[1..] {
                all.extend(properties(keys, Some(&mut ground)));
            }
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
            let mut ground = Ground::standard(*kind);
            for key in self.tables(*kind).into_iter().flatten() {
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

    fn allowed(&self) -> String {
        "1 to 100 tables, each headed [[terrain.part]]".to_owned()
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

/// JSON Schema of a part, which the schema of scenes defines under `part`.
pub(crate) fn part_schema() -> Json {
    Terrain { is_part: true }.schema(None)
}
