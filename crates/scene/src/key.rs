//! Declarations of keys: name, unit, range, meaning and the field that a key sets.
//!
//! Reading, writing, defaults and the reference in `docs/scenes.md` all come from these declarations. Defaults are not
//! declared: they come from the `Default` or a named constructor of the type that holds the field.

use crate::range::{Range, at_least};
use crate::units::{Dimension, NONE};
use robhaz_estimator::statics::{LOAD_PARAMETERS, LoadCovariance};
use robhaz_model::Vec2;
use serde_json::Value;

/// A key of a table that sets a field of `T`.
pub(crate) struct Key<T: 'static> {
    pub name: &'static str,
    pub meaning: &'static str,
    pub field: Field<T>,
    /// Whether it must be given.
    pub required: bool,
}

/// The unit and range of a number.
#[derive(Clone, Copy)]
pub(crate) struct Number {
    pub unit: &'static Dimension,
    pub range: Range,
}

/// Type of a key's value.
pub(crate) enum Field<T: 'static> {
    Number(Number, fn(&mut T) -> &mut f64),
    /// A whole number from 1 on.
    Count(Number, fn(&T) -> u32, fn(&mut T, u32)),
    /// `[a, b, c]`: one for each link.
    Three(Number, fn(&mut T) -> &mut [f64; 3]),
    /// `[x, y]`
    Point(Number, fn(&mut T) -> &mut Vec2),
    /// `[[x, y], [x, y], [x, y]]`
    ThreePoints(Number, fn(&mut T) -> &mut [Vec2; 3]),
    /// `"off"` or `"on"`
    Switch(fn(&mut T) -> &mut bool),
    /// One of a few words, by its index.
    Word(Words, fn(&T) -> usize, fn(&mut T, usize)),
    /// `["word", "word", "word"]`
    ThreeWords(Words, fn(&T) -> [usize; 3], fn(&mut T, [usize; 3])),
    /// Rows of a covariance of the load parameters; not written where there is none.
    LoadCovariance(fn(&mut T) -> &mut Option<LoadCovariance>),
    /// A text of at least one character; empty where it is not given.
    Text(fn(&mut T) -> &mut String),
    /// A table within the table.
    Table(&'static [Key<T>]),
    /// A value that the section reads itself; its default in words.
    Own {
        default: &'static str,
        form: Form,
    },
    /// A word that the section reads itself, since other keys depend on it.
    OwnWord {
        default: &'static str,
        words: Words,
    },
}

/// Allowed values that a section reads itself.
#[derive(Clone, Copy)]
pub(crate) struct Form {
    /// In words.
    pub words: &'static str,
    /// As JSON Schema.
    pub schema: fn() -> Value,
}

/// Off and on.
pub(crate) const SWITCH: Words = &["off", "on"];

/// Words to choose from.
pub(crate) type Words = &'static [&'static str];

impl<T> Key<T> {
    const fn new(name: &'static str, field: Field<T>, meaning: &'static str) -> Self {
        Self {
            name,
            meaning,
            field,
            required: false,
        }
    }

    pub const fn number(
        name: &'static str,
        unit: &'static Dimension,
        range: Range,
        at: fn(&mut T) -> &mut f64,
        meaning: &'static str,
    ) -> Self {
        Self::new(name, Field::Number(Number { unit, range }, at), meaning)
    }

    /// A whole number from 1 to `most`.
    pub const fn count(
        name: &'static str,
        most: u32,
        get: fn(&T) -> u32,
        set: fn(&mut T, u32),
        meaning: &'static str,
    ) -> Self {
        let number = Number {
            unit: NONE,
            range: at_least(1.0).at_most(most as f64),
        };
        Self::new(name, Field::Count(number, get, set), meaning)
    }

    pub const fn switch(
        name: &'static str,
        at: fn(&mut T) -> &mut bool,
        meaning: &'static str,
    ) -> Self {
        Self::new(name, Field::Switch(at), meaning)
    }

    pub const fn three(
        name: &'static str,
        unit: &'static Dimension,
        range: Range,
        at: fn(&mut T) -> &mut [f64; 3],
        meaning: &'static str,
    ) -> Self {
        Self::new(name, Field::Three(Number { unit, range }, at), meaning)
    }

    pub const fn point(
        name: &'static str,
        unit: &'static Dimension,
        range: Range,
        at: fn(&mut T) -> &mut Vec2,
        meaning: &'static str,
    ) -> Self {
        Self::new(name, Field::Point(Number { unit, range }, at), meaning)
    }

    pub const fn three_points(
        name: &'static str,
        unit: &'static Dimension,
        range: Range,
        at: fn(&mut T) -> &mut [Vec2; 3],
        meaning: &'static str,
    ) -> Self {
        let number = Number { unit, range };
        Self::new(name, Field::ThreePoints(number, at), meaning)
    }

    pub const fn word(
        name: &'static str,
        words: Words,
        get: fn(&T) -> usize,
        set: fn(&mut T, usize),
        meaning: &'static str,
    ) -> Self {
        Self::new(name, Field::Word(words, get, set), meaning)
    }

    pub const fn three_words(
        name: &'static str,
        words: Words,
        get: fn(&T) -> [usize; 3],
        set: fn(&mut T, [usize; 3]),
        meaning: &'static str,
    ) -> Self {
        Self::new(name, Field::ThreeWords(words, get, set), meaning)
    }

    pub const fn load_covariance(
        name: &'static str,
        at: fn(&mut T) -> &mut Option<LoadCovariance>,
        meaning: &'static str,
    ) -> Self {
        Self::new(name, Field::LoadCovariance(at), meaning)
    }

    pub const fn text(
        name: &'static str,
        at: fn(&mut T) -> &mut String,
        meaning: &'static str,
    ) -> Self {
        Self::new(name, Field::Text(at), meaning)
    }

    pub const fn table(name: &'static str, keys: &'static [Key<T>], meaning: &'static str) -> Self {
        Self::new(name, Field::Table(keys), meaning)
    }

    pub const fn own(
        name: &'static str,
        default: &'static str,
        form: Form,
        meaning: &'static str,
    ) -> Self {
        Self::new(name, Field::Own { default, form }, meaning)
    }

    pub const fn own_word(
        name: &'static str,
        default: &'static str,
        words: Words,
        meaning: &'static str,
    ) -> Self {
        Self::new(name, Field::OwnWord { default, words }, meaning)
    }

    /// The same key, without a default.
    pub const fn required(self) -> Self {
        Self {
            required: true,
            ..self
        }
    }
}

impl Number {
    /// `a number above 0, in N m`
    pub fn allowed(&self) -> String {
        match self.unit.si() {
            "" => format!("a number {}", self.range),
            si => format!("a number {}, in {si}", self.range),
        }
    }

    /// The same, with the units that a text may have.
    pub fn allowed_in_full(&self) -> String {
        match self.unit.units.len() {
            0 => self.allowed(),
            _ => format!(
                "{}, or a text with a unit ({})",
                self.allowed(),
                self.unit.names()
            ),
        }
    }
}

impl<T> Field<T> {
    /// Allowed values, in words.
    pub fn allowed(&self) -> String {
        let number = self.number().map(Number::allowed_in_full);
        self.in_words(&number.unwrap_or_default())
    }

    /// Allowed values, without units.
    pub fn allowed_values(&self) -> String {
        let range = self.number().map(|n| n.range.to_string());
        self.in_words(range.unwrap_or_default().trim_start_matches("of "))
    }

    fn in_words(&self, number: &str) -> String {
        match self {
            Self::Number(..) | Self::Count(..) => number.to_owned(),
            Self::Three(..) => format!("[a, b, c], each {number}"),
            Self::Point(..) => format!("[x, y], each {number}"),
            Self::ThreePoints(..) => format!("[[x, y], [x, y], [x, y]], each {number}"),
            Self::Switch(_) => quoted(SWITCH),
            Self::Word(words, ..) | Self::OwnWord { words, .. } => quoted(words),
            Self::ThreeWords(words, ..) => format!("three of {}", quoted(words)),
            Self::LoadCovariance(_) => {
                format!("{LOAD_PARAMETERS} rows of {LOAD_PARAMETERS} numbers, a covariance")
            }
            Self::Text(_) => "a text".to_owned(),
            Self::Table(_) => "a table".to_owned(),
            Self::Own { form, .. } => form.words.to_owned(),
        }
    }

    /// Unit and range of a field made of numbers.
    pub fn number(&self) -> Option<&Number> {
        match self {
            Self::Number(n, _)
            | Self::Count(n, ..)
            | Self::Three(n, _)
            | Self::Point(n, _)
            | Self::ThreePoints(n, _) => Some(n),
            _ => None,
        }
    }

    /// The SI unit; empty where there is none.
    pub fn unit(&self) -> &'static str {
        self.number().map_or("", |n| n.unit.si())
    }
}

/// `"one", "two"`
pub(crate) fn quoted(words: &[&str]) -> String {
    let words: Vec<_> = words.iter().map(|w| format!("\"{w}\"")).collect();
    words.join(", ")
}
