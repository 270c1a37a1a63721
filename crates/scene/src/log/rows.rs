//! What the declarations of all sections share.

use crate::key::{Field, Key};
use crate::range::{Range, at_least};
use crate::reader::join;
use crate::write::value;

/// Any number that is not absurd.
pub(super) const ANY: Range = at_least(-1e12).at_most(1e12);

/// The rows of the keys of a table: key, SI unit, default, allowed values, meaning.
pub(super) fn rows<T>(path: &str, keys: &[Key<T>], defaults: &mut T) -> Vec<[String; 5]> {
    let mut row = |key: &Key<T>| {
        let default = match &key.field {
            _ if key.required => "required".to_owned(),
            Field::Own { default, .. } => (*default).to_owned(),
            field => value(field, defaults).unwrap_or_default(),
        };
        [
            join(path, key.name),
            key.field.unit().to_owned(),
            default.trim_matches('"').to_owned(),
            key.field.allowed_values(),
            key.meaning.to_owned(),
        ]
    };
    keys.iter().map(&mut row).collect()
}
