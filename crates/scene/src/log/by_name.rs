//! Tables by the names of what they describe.

use crate::form::{Form, KeyReference, object};
use crate::quantity::{Range, at_least};
use crate::reader::{Reader, join};
use crate::source::Node;
use serde_json::Value as Json;

/// Any number that is not absurd.
pub(super) const ANY: Range = at_least(-1e12).at_most(1e12);

/// Tables by the names of what they describe.
pub(super) struct ByName<C> {
    pub names: &'static [&'static str],
    /// Stands for a name in tables of keys.
    pub placeholder: &'static str,
    pub read: fn(&mut Reader, &'static str, &Node, &str) -> C,
    pub schema: fn() -> Json,
    pub rows: fn(&mut Vec<KeyReference>, &str),
}

impl<C> Form for ByName<C> {
    type Value = Vec<C>;

    fn read(&self, reader: &mut Reader, node: &Node, path: &str, into: &mut Vec<C>) {
        for entry in reader.entries(node, path) {
            match self.names.iter().find(|name| **name == entry.key) {
                Some(name) => {
                    let path = join(path, name);
                    into.push((self.read)(reader, name, &entry.node, &path));
                }
                None => reader.unknown(entry, path, self.names),
            }
        }
    }

    fn schema(&self, _defaults: Option<&mut Vec<C>>) -> Json {
        let table = |name: &&str| ((*name).to_owned(), (self.schema)());
        object(self.names.iter().map(table).collect(), &[])
    }

    fn is_section(&self) -> bool {
        true
    }

    fn rows(&self, rows: &mut Vec<KeyReference>, path: &str, _value: &mut Vec<C>) {
        (self.rows)(rows, &join(path, self.placeholder));
    }
}
