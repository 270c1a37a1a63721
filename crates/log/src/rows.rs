//! Rows of a table, whatever its format.

use crate::error::LogError;
use crate::stamp::{Stamp, TimeUnit};

/// One row of a table.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// Where it is, for messages: `row 17`, `line 18`.
    pub place: Place,
    /// Its time stamp.
    pub stamp: Stamp,
    /// The cells of the chosen columns, in their order; `None` where a cell is empty or not a
    /// finite number.
    pub cells: Vec<Option<f64>>,
}

/// The place of a row in its file, from 1: of a line, row or message.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Place(pub &'static str, pub u64);

impl std::fmt::Display for Place {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} {}", self.0, self.1)
    }
}

/// What takes the rows of a table, in the order of the file.
pub type AddRow<'a> = dyn FnMut(Row) -> Result<(), LogError> + 'a;

/// A column of a table.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ColumnInfo {
    /// Its name as in the file.
    pub name: String,
    /// Its unit, where the file states one: in the field metadata, or in brackets after the name.
    pub unit: Option<String>,
}

impl ColumnInfo {
    /// The names of columns for messages, of many the first.
    pub fn list(columns: &[Self]) -> String {
        const SHOWN: usize = 40;
        let names: Vec<&str> = columns
            .iter()
            .map(|c| c.name.as_str())
            .take(SHOWN)
            .collect();
        let more = match columns.len().saturating_sub(SHOWN) {
            0 => String::new(),
            more => format!(" and {more} more"),
        };
        format!("the columns {}{more}", names.join(", "))
    }
}

/// Indices of the first name that is there before, of the earlier and the later one. Columns
/// without a name do not count.
pub fn repeated(names: &[String]) -> Option<(usize, usize)> {
    let before = |i: usize| names[..i].iter().position(|name| *name == names[i]);
    let mut named = (0..names.len()).filter(|i| !names[*i].is_empty());
    named.find_map(|i| Some((before(i)?, i)))
}

/// The time column of a table.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TimeColumn {
    /// Its name as in the file.
    pub name: String,
    /// Unit of its numbers.
    pub unit: TimeUnit,
}
