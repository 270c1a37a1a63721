//! Rules that the numbers of a profile keep.

use crate::ProfileError;

/// A number that has to be in a range.
pub(crate) fn in_range(
    entry: &'static str,
    found: f64,
    allowed: &'static str,
    inside: impl Fn(f64) -> bool,
) -> Result<(), ProfileError> {
    if inside(found) {
        Ok(())
    } else {
        Err(ProfileError::Range {
            entry,
            found,
            allowed,
        })
    }
}

/// Any number.
pub(crate) fn finite(entry: &'static str, found: f64) -> Result<(), ProfileError> {
    in_range(entry, found, "a finite number", f64::is_finite)
}

/// A length that something must have.
pub(crate) fn above_zero(entry: &'static str, found: f64) -> Result<(), ProfileError> {
    in_range(entry, found, "a number above 0", |v| {
        v > 0.0 && v.is_finite()
    })
}
