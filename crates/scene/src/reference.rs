//! Every key that a scene file or a log description can have, from the declarations that the reader uses.

use crate::key;
use crate::load::SCENE;
use crate::log::{LOG, LogChoice};
use crate::scene::Scene;
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
    key::rows(&mut rows, SCENE, "", &mut Scene::default());
    rows
}

/// The rows of the tables of keys in `docs/logs.md`: key, SI unit, default, allowed values, meaning. The text
/// explains the keys above all tables; those of `[robot]` and `[[estimator]]` are as in a scene.
pub fn log_reference() -> Vec<[String; 5]> {
    let mut rows = Vec::new();
    key::rows(&mut rows, LOG, "", &mut LogChoice::default());
    let as_in_a_scene = |key: &str| key.starts_with("robot.") || key.starts_with("estimator");
    let own = rows
        .into_iter()
        .filter(|row| row.key.contains('.') && !as_in_a_scene(&row.key));
    own.map(|r| {
        [
            r.key,
            r.unit.to_owned(),
            r.default,
            r.allowed,
            r.meaning.to_owned(),
        ]
    })
    .collect()
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
}
