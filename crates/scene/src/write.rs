//! A TOML file being written: every choice with its unit, from the declarations of the keys.

use crate::key::{IGNORED, Key};
use crate::reader::join;

/// The text of the file.
#[derive(Default)]
pub(crate) struct Out(pub String);

impl Out {
    /// A whole file: a line of comment, the keys, the `version` of the program that writes it, the tables.
    pub fn file<T: 'static>(comment: &str, version: &str, keys: &[Key<T>], of: &mut T) -> String {
        let mut out = Self::default();
        out.line(&format!("# {comment}"));
        out.fields(keys, of);
        out.head(&format!("[{IGNORED}]"), "what wrote this file; not read");
        out.key("version", &quote(version), "");
        out.tables(keys, of, "");
        out.0
    }

    fn line(&mut self, line: &str) {
        self.0.push_str(line);
        self.0.push('\n');
    }

    /// The heading of a table.
    pub fn head(&mut self, head: &str, comment: &str) {
        self.line("");
        self.line(&with_comment(head, comment));
    }

    fn key(&mut self, name: &str, value: &str, comment: &str) {
        self.line(&with_comment(&format!("{name} = {value}"), comment));
    }

    /// The keys of a table whose heading is written, then the tables in it.
    pub fn table<T: 'static>(&mut self, keys: &[Key<T>], of: &mut T, path: &str) {
        self.fields(keys, of);
        self.tables(keys, of, path);
    }

    /// Keys with their units and meanings.
    pub fn fields<'k, T: 'static>(
        &mut self,
        keys: impl IntoIterator<Item = &'k Key<T>>,
        of: &mut T,
    ) {
        for key in keys {
            let Some(value) = key.field.text(of) else {
                continue;
            };
            match key.field.units().first() {
                None => self.key(key.name, &value, key.meaning),
                Some(unit) => self.key(key.name, &value, &format!("{unit}; {}", key.meaning)),
            }
        }
    }

    /// The tables in a table.
    pub fn tables<T>(&mut self, keys: &[Key<T>], of: &mut T, path: &str) {
        for key in keys {
            key.field
                .tables(self, &join(path, key.name), key.meaning, of);
        }
    }
}

fn with_comment(text: &str, comment: &str) -> String {
    match comment {
        "" => text.to_owned(),
        _ => format!("{text} # {comment}"),
    }
}

/// A text in quotes, as TOML writes it.
pub(crate) fn quote(value: &str) -> String {
    toml::Value::String(value.to_owned()).to_string()
}
