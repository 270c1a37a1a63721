//! Forms that hold keys: a table, a list of tables.

use crate::form::{Form, KeyReference};
use crate::json::items;
use crate::key::{self, Key};
use crate::reader::Reader;
use crate::source::Node;
use crate::write::Out;
use serde_json::Value as Json;

/// A table.
pub(crate) struct Table<T: 'static> {
    pub keys: &'static [Key<T>],
    /// In words; empty for a section, of which tables of keys list the keys alone.
    pub words: &'static str,
    /// Whether it is not written.
    pub is_hidden: fn(&T) -> bool,
    /// Checks a table whose keys have no problem.
    pub check: fn(&mut Reader, &Node, &T),
}

/// A table of which tables of keys list the keys alone.
pub(crate) const fn section<T>(keys: &'static [Key<T>]) -> Table<T> {
    Table {
        keys,
        words: "",
        is_hidden: |_| false,
        check: |_, _, _| {},
    }
}

impl<T> Form for Table<T> {
    type Value = T;

    fn read(&self, reader: &mut Reader, node: &Node, path: &str, into: &mut T) {
        let mark = reader.mark();
        reader.table(self.keys, node, path, into);
        if reader.mark() == mark {
            (self.check)(reader, node, into);
        }
    }

    fn allowed(&self) -> String {
        match self.words {
            "" => "a table".to_owned(),
            words => words.to_owned(),
        }
    }

    fn schema(&self, defaults: Option<&mut T>) -> Json {
        key::schema(self.keys, defaults)
    }

    fn is_section(&self) -> bool {
        self.words.is_empty()
    }

    fn tables(&self, out: &mut Out, path: &str, meaning: &str, value: &mut T) {
        if !(self.is_hidden)(value) {
            out.head(&format!("[{path}]"), meaning);
            out.table(self.keys, value, path);
        }
    }

    fn rows(&self, rows: &mut Vec<KeyReference>, path: &str, value: &mut T) {
        key::rows(rows, self.keys, path, value);
    }
}

/// Tables, each headed `[[path]]`.
pub(crate) struct List<T: 'static> {
    pub keys: &'static [Key<T>],
    /// In words; empty for a list of which tables of keys list the keys alone.
    pub words: &'static str,
    pub least: usize,
    pub most: usize,
    /// An item before its keys are read.
    pub start: fn() -> T,
    /// Checks an item whose keys have no problem, with those before it.
    pub check: fn(&mut Reader, &Node, &str, &mut T, &[T]),
}

impl<T> Form for List<T> {
    type Value = Vec<T>;

    fn read(&self, reader: &mut Reader, node: &Node, path: &str, into: &mut Vec<T>) {
        into.clear();
        for (item, path) in reader.items(node, path, self.least..=self.most, || self.allowed()) {
            let (mark, mut value) = (reader.mark(), (self.start)());
            reader.table(self.keys, item, &path, &mut value);
            if reader.mark() == mark {
                (self.check)(reader, item, &path, &mut value, into);
                into.push(value);
            }
        }
    }

    fn allowed(&self) -> String {
        self.words.to_owned()
    }

    fn schema(&self, _defaults: Option<&mut Vec<T>>) -> Json {
        items(key::schema(self.keys, None), self.least, self.most)
    }

    fn tables(&self, out: &mut Out, path: &str, _meaning: &str, value: &mut Vec<T>) {
        for item in value {
            out.head(&format!("[[{path}]]"), "");
            out.table(self.keys, item, path);
        }
    }

    fn rows(&self, rows: &mut Vec<KeyReference>, path: &str, _value: &mut Vec<T>) {
        key::rows(rows, self.keys, &format!("{path}[]"), &mut (self.start)());
    }
}
