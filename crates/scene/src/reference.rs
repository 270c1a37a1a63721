//! Every key that a scene file can have, from the declarations that the reader itself uses.

use crate::key::{Field, Key, SWITCH};
use crate::load::TOP;
use crate::range::short;
use crate::reader::join;
use crate::scene::Scene;
use crate::sections::SECTIONS;
use crate::terrain_keys::{self, Shape};
use crate::{estimators, robot, robot_keys, write};

/// A key of scene files.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct KeyReference {
    /// Full dotted key; `[]` stands for an index.
    pub key: String,
    /// SI unit of a bare number; empty where there is none.
    pub unit: &'static str,
    /// Other units that a text may carry.
    pub other_units: String,
    /// Its default in the SI unit, in words where it is no value; `required` where there is none.
    pub default: String,
    /// What it may hold.
    pub allowed: String,
    /// What it is.
    pub meaning: &'static str,
}

/// Every key that a scene file can have, in the order in which one writes them.
pub fn reference() -> Vec<KeyReference> {
    let mut rows = Vec::new();
    let mut scene = Scene::default();
    let mut robot = scene.robot.robot.clone();
    let mut shape = Shape::default();
    list(&mut rows, TOP, &mut scene, "");
    list(&mut rows, robot::KEYS, &mut (), "robot");
    let path = robot::GEOMETRY_PART.path;
    list(&mut rows, robot_keys::GEOMETRY, &mut robot.geometry, path);
    let path = robot::MASS_PART.path;
    list(&mut rows, robot_keys::MASSES, &mut robot.mass, path);
    for keys in [
        terrain_keys::COMMON,
        terrain_keys::STRETCHES,
        terrain_keys::SHAPE,
    ]
    .iter()
    .chain(terrain_keys::OWN)
    {
        list(&mut rows, keys, &mut shape, terrain_keys::PATH);
    }
    let mut bump = terrain_keys::NO_BUMP;
    list(&mut rows, terrain_keys::BUMP, &mut bump, "terrain.bumps[]");
    let mut stretch = terrain_keys::NO_STRETCH;
    list(
        &mut rows,
        terrain_keys::STRETCH,
        &mut stretch,
        "terrain.stretch[]",
    );
    for section in SECTIONS {
        list(&mut rows, section.keys, &mut scene, section.name);
    }
    let mut keys = estimators::Keys::of(&estimators::settings(0));
    list(&mut rows, estimators::KEYS, &mut keys, "estimator[]");
    rows
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
            // Made of other keys of the same table.
            Field::ThreePoints(..) => "mean of own pins and axles".to_owned(),
            Field::Number(_, at) => short(*at(defaults)),
            Field::Switch(at) => SWITCH[usize::from(*at(defaults))].to_owned(),
            Field::Word(words, get, _) => words[get(defaults)].to_owned(),
            field => write::value(field, defaults).unwrap_or_default(),
        },
        allowed: key.field.allowed_values(),
        meaning: key.meaning,
    }
}
