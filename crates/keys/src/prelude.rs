//! What a declaration of keys needs, and what reads and checks one: `use robhaz_keys::prelude::*`.

pub use crate::conflict::{Conflict, conflict, floor, named, valued};
pub use crate::error::{FileError, Problem};
pub use crate::form::{
    About, Array, Form, KeyReference, Maybe, Out, Plain, Word, array, dependent, did_you_mean,
    items, object, quote, quoted, read_only, word,
};
pub use crate::key::{self, Key, List, Table, keys, list, section};
pub use crate::overrides::{Overrides, Step, steps};
pub use crate::quantity::*;
pub use crate::reader::{Reader, join, nearest};
pub use crate::source::{self, Entry, Node, Origin, Source, Value};
pub use crate::values::*;
