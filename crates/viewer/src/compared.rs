//! A run of a comparison, and its entity there.

use robhaz_run::RunDescription;
use std::path::Path;

/// A run to be compared.
#[derive(Clone, Copy, Debug)]
pub struct ComparedRun<'a> {
    /// Name of the run in the comparison.
    pub label: &'a str,
    /// Its description.
    pub description: &'a RunDescription,
    /// Its recording, written by [`crate::RecordingSink`].
    pub recording: &'a Path,
}

/// The entity above those of a run, by the index of the run: `/run1/` for 0.
pub(crate) fn root(index: usize) -> String {
    format!("/run{}/", index + 1)
}
