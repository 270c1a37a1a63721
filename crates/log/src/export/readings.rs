//! The readings of a folder, row by row.

use super::forces::cut_off;
use crate::{Channels, LogError};
use robhaz_run::Stop;
use robhaz_scene::Values;

/// What was written.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Exported {
    /// Number of rows of readings.
    pub rows: u64,
    /// Topics, or tables whose columns were joined.
    pub parts: Vec<String>,
    /// What the user should know, one line each.
    pub warnings: Vec<String>,
}

/// Hands all rows of readings to `add`, until `stop` has a cause: time (s) and numbers. Returns what
/// was written, under the names of its `parts`.
pub fn read(
    readings: &Channels,
    parts: Vec<String>,
    stop: Stop<'_>,
    mut add: impl FnMut(f64, Values) -> Result<(), LogError>,
) -> Result<Exported, LogError> {
    let mut rows = 0;
    let why = readings.read(|channel, row| {
        stop().map_or(Ok(()), |cause| Err(LogError::Stopped(cause)))?;
        rows += 1;
        let values = readings.all[channel].values(&row.cells);
        add(row.stamp.seconds(), values)
    })?;
    let why = why.iter().flatten();
    let warnings = why.map(|why| cut_off(&readings.all[0].path, why));
    Ok(Exported {
        rows,
        parts,
        warnings: warnings.collect(),
    })
}
