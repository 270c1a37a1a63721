//! Every key that a scene file or a log description can have, from the declarations that the reader uses.

use crate::form::KeyReference;
use crate::key;
use crate::load::scene_keys;
use crate::log::{LOG, LogChoice};

/// Every key that a scene file can have, section by section.
pub fn reference() -> Vec<KeyReference> {
    scene_keys()
}

/// The rows of the tables of keys in `docs/logs.md`. The text explains the keys above all tables; those of `[robot]` and
/// `[[estimator]]` are as in a scene.
pub fn log_reference() -> Vec<KeyReference> {
    let mut rows = Vec::new();
    key::rows(&mut rows, LOG, "", &mut LogChoice::default());
    let as_in_a_scene = |key: &str| key.starts_with("robot.") || key.starts_with("estimator");
    rows.retain(|row| row.key.contains('.') && !as_in_a_scene(&row.key));
    rows
}
