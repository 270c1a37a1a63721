//! Reasons why a profile is refused.

/// Reason why a profile is refused.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum ProfileError {
    /// A part of a course starts before the end of the previous one.
    #[error("part {part} starts at {start} m, before the end of the part before, {end} m")]
    Overlap {
        /// Index of the part, from 0.
        part: usize,
        /// x of its start, m.
        start: f64,
        /// x of the end of the previous part, m.
        end: f64,
    },
    /// A number is out of its range.
    #[error("{entry} is {found}; it must be {allowed}")]
    Range {
        /// Name of the parameter.
        entry: &'static str,
        /// Its value.
        found: f64,
        /// The allowed values; completes the sentence "it must be ...".
        allowed: &'static str,
    },
}

impl ProfileError {
    /// Refuses a value that is not `inside` its range; `allowed` completes the sentence "it must be ...".
    pub(crate) fn unless(
        inside: bool,
        entry: &'static str,
        found: f64,
        allowed: &'static str,
    ) -> Result<(), Self> {
        match inside {
            true => Ok(()),
            false => Err(Self::Range {
                entry,
                found,
                allowed,
            }),
        }
    }
}
