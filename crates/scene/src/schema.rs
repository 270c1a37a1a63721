//! JSON Schema of the files that people write: an editor completes and checks them by it.

use crate::load::SCENE;
use crate::log::{LOG, LogChoice};
use crate::robot::{GEOMETRY, MASSES};
use crate::scene::Scene;
use crate::study::STUDY;
use crate::terrain::Terrain;
use robhaz_keys::prelude::*;
use serde_json::{Value, json};

/// A kind of file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SchemaKind {
    /// A scene.
    Scene,
    /// A study.
    Study,
    /// The geometry of a robot.
    Geometry,
    /// The masses of a robot.
    Mass,
    /// The description of a log.
    Sensors,
}

/// JSON Schema (draft 7) of a kind of file, from the declarations by which it is read. It knows
/// names, types, units and ranges of bare numbers, not the rules between keys, nor ranges of texts
/// with units: what it refuses the reader refuses, too.
pub fn schema(kind: SchemaKind) -> Value {
    match kind {
        SchemaKind::Scene => {
            let mut scene = key::file_schema("Scene of robhaz", SCENE, Some(&mut Scene::default()));
            scene["definitions"] = json!({"part": Terrain { is_part: true }.rules()});
            scene
        }
        SchemaKind::Study => key::file_schema("Study of robhaz", STUDY, None),
        SchemaKind::Geometry => key::file_schema("Geometry of a robot for robhaz", GEOMETRY, None),
        SchemaKind::Mass => key::file_schema("Masses of a robot for robhaz", MASSES, None),
        SchemaKind::Sensors => {
            let defaults = &mut LogChoice::default();
            key::file_schema("Description of a log for robhaz", LOG, Some(defaults))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::load::reference;
    use robhaz_keys::key::IGNORED;
    use std::collections::BTreeSet;

    /// The keys of a schema, as the reference writes them.
    fn keys(schema: &Value, path: &str, found: &mut BTreeSet<String>) {
        let Some(properties) = schema["properties"].as_object() else {
            found.insert(path.to_owned());
            return;
        };
        for (name, property) in properties {
            let path = robhaz_keys::reader::join(path, name);
            // A table beside a name or a path.
            let inline = property["anyOf"].as_array().into_iter().flatten();
            let table = inline.clone().find(|s| s["properties"].is_object());
            let item = &property["items"];
            if item["properties"].is_object() {
                found.insert(path.clone());
                keys(item, &format!("{path}[]"), found);
            } else if let Some(table) = table {
                found.insert(path.clone());
                keys(table, &path, found);
            } else {
                keys(property, &path, found);
            }
        }
    }

    /// Equivalence: the schema of scenes has the keys of the reference, no more and no fewer.
    #[test]
    fn the_schema_has_the_keys_of_the_reference() {
        let mut found = BTreeSet::new();
        keys(&schema(SchemaKind::Scene), "", &mut found);
        // Lists and tables that the reference names by their keys alone, and what is not read.
        for other in ["estimator", IGNORED] {
            assert!(found.remove(other), "{other}");
        }
        // Tables with a key of their own in the reference.
        found.insert("drive.friction_test".to_owned());
        let expected: BTreeSet<String> = reference().into_iter().map(|r| r.key).collect();
        assert_eq!(found, expected);
    }
}
