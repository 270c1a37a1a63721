//! Every key that a scene file can have, from the declarations that the reader uses.

use crate::key::{Field, Key, SWITCH};
use crate::range::short;
use crate::reader::join;
use crate::scene::Scene;
use crate::sections::{SECTIONS, TOP};
use crate::terrain::{self, Parameters, Visitor};
use crate::{control, drive, estimators, robot, robot_keys, write};
use robhaz_control::FrictionTestPlan;
use std::sync::LazyLock;

/// A key of scene files.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct KeyReference {
    /// Full dotted key; `[]` stands for an index.
    pub key: String,
    /// SI unit of a bare number; empty where there is none.
    pub unit: &'static str,
    /// Other units that a text may carry.
    pub other_units: String,
    /// Default in the SI unit, or in words; `required` if there is none.
    pub default: String,
    /// Allowed values.
    pub allowed: String,
    /// Meaning of the key.
    pub meaning: &'static str,
}

/// Every key that a scene file can have, section by section.
pub fn reference() -> Vec<KeyReference> {
    let mut rows = Vec::new();
    let mut scene = Scene::default();
    let mut robot = scene.robot.robot.clone();
    list(&mut rows, TOP, &mut scene, "");
    list(&mut rows, robot::KEYS, &mut (), "robot");
    let path = robot::GEOMETRY_PART.path;
    list(&mut rows, robot_keys::GEOMETRY, &mut robot.geometry, path);
    let path = robot::MASS_PART.path;
    list(&mut rows, robot_keys::MASSES, &mut robot.mass, path);
    list(&mut rows, terrain::COMMON, &mut (), terrain::PATH);
    list(&mut rows, terrain::STRETCHES, &mut (), terrain::PATH);
    for kind in terrain::KINDS {
        Parameters::standard(kind).show(&mut OfKind { rows: &mut rows });
    }
    let mut bump = terrain::NO_BUMP;
    list(&mut rows, terrain::BUMP, &mut bump, "terrain.bumps[]");
    let mut stretch = terrain::NO_STRETCH;
    let path = "terrain.stretch[]";
    list(&mut rows, terrain::STRETCH, &mut stretch, path);
    for section in SECTIONS {
        list(&mut rows, section.keys, &mut scene, section.name);
        if section.name == drive::PATH {
            let mut scaling = drive::NO_SCALING;
            list(&mut rows, drive::SCALINGS, &mut scaling, "drive.scaling[]");
            let mut plan = FrictionTestPlan::default();
            let path = control::FRICTION_TEST_PATH;
            list(&mut rows, control::FRICTION_TESTS, &mut plan, path);
        }
    }
    let mut keys = estimators::Keys::of(&estimators::settings(0));
    list(&mut rows, estimators::KEYS, &mut keys, "estimator[]");
    rows
}

/// Lists the keys of a kind of ground.
struct OfKind<'a> {
    rows: &'a mut Vec<KeyReference>,
}

impl Visitor for OfKind<'_> {
    fn visit<T>(&mut self, keys: &'static [Key<T>], parameters: &mut T) {
        for key in keys {
            let path = join(terrain::PATH, key.name);
            // Several kinds have a start; its declaration and default are the same in all.
            if !self.rows.iter().any(|r| r.key == path) {
                self.rows.push(row(key, parameters, path));
            }
        }
    }
}

fn list<T>(rows: &mut Vec<KeyReference>, keys: &[Key<T>], defaults: &mut T, path: &str) {
    for key in keys {
        let path = join(path, key.name);
        if let Field::Table(keys) = key.field {
            list(rows, keys, defaults, &path);
        } else {
            rows.push(row(key, defaults, path));
        }
    }
}

fn row<T>(key: &Key<T>, defaults: &mut T, path: String) -> KeyReference {
    let number = key.field.number();
    let others = number.map(|n| n.unit.units.iter().skip(1).map(|u| u.name));
    KeyReference {
        key: path,
        unit: key.field.unit(),
        other_units: others.map_or(String::new(), |o| o.collect::<Vec<_>>().join(", ")),
        default: match &key.field {
            _ if key.required => "required".to_owned(),
            Field::Own { default, .. } | Field::OwnWord { default, .. } => (*default).to_owned(),
            // Computed from other keys of the same table.
            Field::ThreePoints(..) => "mean of own pins and axles".to_owned(),
            Field::Point(..) => "from body_cg and wheelbase".to_owned(),
            Field::Number(_, at) => short(*at(defaults)),
            Field::Count(_, get, _) => get(defaults).to_string(),
            Field::Switch(at) => SWITCH[usize::from(*at(defaults))].to_owned(),
            Field::Word(words, get, _) => words[get(defaults)].to_owned(),
            field => write::value(field, defaults).unwrap_or_default(),
        },
        allowed: key.field.allowed_values(),
        meaning: key.meaning,
    }
}

/// The table that has a key of this name, as written in a file.
pub(crate) fn home_of(name: &str) -> Option<String> {
    // Made once: it takes milliseconds.
    static KEYS: LazyLock<Vec<KeyReference>> = LazyLock::new(reference);
    let suffix = format!(".{name}");
    let keys = KEYS.iter().filter(|k| k.key.ends_with(&suffix));
    // A section rather than an item of a list.
    let key = keys.min_by_key(|k| k.key.contains("[]"))?;
    let section = key.key.strip_suffix(&suffix)?;
    Some(match section.strip_suffix("[]") {
        Some(list) => format!("[[{list}]]"),
        None => format!("[{section}]"),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn misplaced_keys_find_their_section() {
        assert_eq!(home_of("mu_s").as_deref(), Some("[contact]"));
        assert_eq!(home_of("observer_pole").as_deref(), Some("[[estimator]]"));
        assert_eq!(home_of("gravity"), None);
    }

    /// Kinds that share a key share its declaration: the reference lists it once.
    #[test]
    fn kinds_agree_on_shared_keys() {
        struct Rows(Vec<KeyReference>);
        impl Visitor for Rows {
            fn visit<T>(&mut self, keys: &'static [Key<T>], parameters: &mut T) {
                let rows = keys.iter().map(|k| row(k, parameters, k.name.to_owned()));
                self.0.extend(rows);
            }
        }
        let mut rows = Rows(Vec::new());
        for kind in terrain::KINDS {
            Parameters::standard(kind).show(&mut rows);
        }
        let rows = rows.0;
        for row in &rows {
            let same: Vec<_> = rows.iter().filter(|r| r.key == row.key).collect();
            assert!(same.iter().all(|r| *r == row), "{same:?}");
        }
        assert_eq!(rows.iter().filter(|r| r.key == "start").count(), 6);
    }
}
