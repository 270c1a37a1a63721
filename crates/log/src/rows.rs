//! Rows of a table, whatever its format.

use crate::{LogError, Stamp, TimeUnit};
use robhaz_scene::{Kind, Unit, nearest};

/// One row of a table.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// Where it is, for messages: `row 17`, `line 18`.
    pub place: Place,
    /// Its time stamp.
    pub stamp: Stamp,
    /// The cells of the chosen columns, in their order; not a number where a cell is empty or not
    /// finite.
    pub cells: Vec<f64>,
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
    /// Whether its type is that of time stamps, which have a unit of their own.
    pub is_time_stamp: bool,
}

impl ColumnInfo {
    /// The unit that the table states, in the metadata or in the name, of a column that is taken for a quantity of a kind.
    pub fn stated_unit(&self, taken_for: Kind) -> Option<Unit> {
        let stated = self.unit.as_deref().and_then(Unit::of);
        stated.or_else(|| Unit::in_name(&self.name, taken_for))
    }

    /// The names of columns for messages, of many the first.
    pub fn list(columns: &[Self]) -> String {
        const SHOWN: usize = 40;
        let names = columns.iter().take(SHOWN).map(|c| c.name.as_str());
        let names: Vec<&str> = names.collect();
        let more = match columns.len().saturating_sub(SHOWN) {
            0 => String::new(),
            more => format!(" and {more} more"),
        };
        format!("the columns {}{more}", names.join(", "))
    }

    /// What missing columns may be called in a table, for messages, of the first ones. `read` are those that are read as
    /// another one.
    pub fn meant<'a>(
        missing: impl Iterator<Item = &'a str>,
        found: &[Self],
        read: &[String],
    ) -> String {
        const SHOWN: usize = 3;
        let free = found.iter().filter(|column| !read.contains(&column.name));
        let names: Vec<&str> = free.map(|column| column.name.as_str()).collect();
        let near = missing.filter_map(|name| Some((name, nearest(name, &names)?)));
        let near = near.take(SHOWN);
        near.map(|(name, near)| format!("; is {name} called {near}?"))
            .collect()
    }
}

/// The number of the first column whose name is there before, and what is wrong with it. Columns
/// without a name do not count.
pub fn repeated<'a>(names: impl Iterator<Item = &'a String> + Clone) -> Option<(usize, String)> {
    let before = |i: usize, name| names.clone().take(i).position(|other| other == name);
    names.clone().enumerate().find_map(|(i, name)| {
        let first = before(i, name).filter(|_| !name.is_empty())? + 1;
        let found = format!("found the name {name} again, allowed: each name once");
        Some((i + 1, format!("{found}; column {first} has it, too")))
    })
}

/// The value of a cell that is a finite number, else not a number.
pub fn finite(value: f64) -> f64 {
    if value.is_finite() { value } else { f64::NAN }
}

/// The time column of a table.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TimeColumn {
    /// Its name as in the file.
    pub name: String,
    /// Unit of its numbers.
    pub unit: TimeUnit,
    /// The column of the nanoseconds that are added to its whole seconds; `None` without one.
    pub nanoseconds: Option<String>,
}

/// Names of seconds and nanoseconds in two columns, behind the same start: those of ROS 2 and ROS 1, and usual ones.
const SECONDS: &str = "sec secs seconds second s";
const NANOSECONDS: &str = "nanosec nanosecs nsec nsecs nanoseconds nanosecond nanos ns";

impl TimeColumn {
    /// Takes the column of the nanoseconds where a table has the time in two columns: `header.stamp.sec` and
    /// `header.stamp.nanosec` for the name `header.stamp` or `header.stamp.sec`, or as the only such pair where the
    /// table has no column of the name.
    pub fn resolve(&mut self, found: &[ColumnInfo], is_stated: bool) {
        let has = |name: &str| found.iter().any(|column| column.name == name);
        if self.nanoseconds.is_some() || self.unit != TimeUnit::SECOND {
            return;
        }
        let pairs = found.iter().filter_map(|column| {
            let name = column.name.as_str();
            let start = SECONDS.split(' ').find_map(|end| {
                let start = name.strip_suffix(end)?;
                (start.is_empty() || start.ends_with(['.', '_', '/', ' ', '-'])).then_some(start)
            })?;
            let of_start = |end: &&str| has(&format!("{start}{end}"));
            let nanoseconds = NANOSECONDS.split(' ').find(of_start)?;
            Some((start, name, format!("{start}{nanoseconds}")))
        });
        let pairs: Vec<(&str, &str, String)> = pairs.collect();
        let is_named = |(start, name, _): &&(&str, &str, String)| {
            *name == self.name || start.trim_end_matches(['.', '_', '/', ' ', '-']) == self.name
        };
        let pair = match (pairs.iter().find(is_named), pairs.as_slice()) {
            (Some(pair), _) => pair,
            (None, [only]) if !is_stated && !has(&self.name) => only,
            _ => return,
        };
        self.nanoseconds = Some(pair.2.clone());
        self.name = pair.1.to_owned();
    }

    /// The columns that it is read from.
    pub fn columns(&self) -> impl Iterator<Item = &String> {
        std::iter::once(&self.name).chain(&self.nanoseconds)
    }
}
