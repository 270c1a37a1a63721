//! Values of an option that are words, each with its help and what it stands for.

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};

/// A word, its help, and what it stands for.
pub type Choice<T> = (&'static str, &'static str, T);

/// Words of an option, a line each: word, help, what it stands for.
macro_rules! choices {
    ($($word:literal, $help:literal => $value:expr;)*) => {
        &[$(($word, $help, $value)),*]
    };
}
pub(crate) use choices;

/// Reads one of these words.
pub fn choice<T: Copy + Send + Sync>(
    choices: &'static [Choice<T>],
) -> impl TypedValueParser<Value = T> {
    let known = choices.iter();
    let known = known.map(|(word, help, _)| PossibleValue::new(*word).help(*help));
    PossibleValuesParser::new(known).try_map(|found| {
        let known = choices.iter().find(|(word, ..)| *word == found);
        known.map(|(.., value)| *value).ok_or("no such word")
    })
}
