//! Every key that a log description has beside those of `[robot]` and `[[estimator]]`, which are as in a scene.

use super::choice::LogChoice;
use super::keys::SECTIONS;
use super::mapping;
use super::rows::rows;

/// The rows of the tables of keys in `docs/logs.md`: key, SI unit, default, allowed values, meaning.
pub fn log_reference() -> Vec<[String; 5]> {
    let mut defaults = LogChoice::default();
    let sections = SECTIONS.iter();
    let mut all: Vec<_> = sections
        .flat_map(|section| rows(section.name, section.keys, &mut defaults))
        .collect();
    all.extend(mapping::keys());
    all
}
