//! JSON Schema of `[terrain]` and of a part of a course.

use super::kinds::{DEFAULT, Parameters, Visitor};
use super::read::kinds;
use super::section::{COMMON, PATH, STRETCHES};
use crate::json::{object, properties, required, word};
use crate::key::Key;
use serde_json::{Map, Value, json};

/// The section.
pub(crate) fn section() -> Value {
    at(PATH)
}

/// A part of a course: another kind than level ground or a course, and no stretches.
pub(crate) fn part() -> Value {
    at("")
}

/// All keys of the kinds at a place, and for each kind which of them it takes.
fn at(path: &str) -> Value {
    let mut all = properties(COMMON, None);
    all["kind"]["enum"] = word(kinds(path))["enum"].take();
    if path == PATH {
        all.extend(properties(STRETCHES, None));
    }
    let common: Vec<String> = all.keys().cloned().collect();
    let mut rules = Vec::new();
    for kind in kinds(path) {
        let mut keys = OfKind::default();
        Parameters::standard(kind).show(&mut keys);
        let allowed: Vec<&String> = common.iter().chain(keys.properties.keys()).collect();
        let mut condition = json!({"properties": {"kind": {"const": kind}}});
        if *kind != DEFAULT {
            condition["required"] = json!(["kind"]);
        }
        rules.push(json!({
            "if": condition,
            "then": {"propertyNames": {"enum": allowed}, "required": keys.required},
        }));
        all.extend(keys.properties);
    }
    let mut schema = object(all, &[]);
    schema["allOf"] = json!(rules);
    schema
}

/// The keys of a kind.
#[derive(Default)]
struct OfKind {
    properties: Map<String, Value>,
    required: Vec<&'static str>,
}

impl Visitor for OfKind {
    fn visit<T>(&mut self, keys: &'static [Key<T>], parameters: &mut T) {
        self.properties = properties(keys, Some(parameters));
        self.required = required(keys);
    }
}
