//! Range checks of a profile's parameters.

use crate::error::ProfileError;

/// Refuses a value that is not `inside`; `allowed` completes the sentence "it must be ...".
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

/// Refuses NaN and infinity.
pub(crate) fn finite(entry: &'static str, found: f64) -> Result<(), ProfileError> {
    in_range(entry, found, "a finite number", f64::is_finite)
}

/// Refuses what is not a finite number above 0.
pub(crate) fn above_zero(entry: &'static str, found: f64) -> Result<(), ProfileError> {
    in_range(entry, found, "a number above 0", |v| {
        v > 0.0 && v.is_finite()
    })
}
