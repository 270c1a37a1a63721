//! Tables with the column names that a run writes.

use crate::error::LogError;
use crate::formula::Formula;
use crate::plan::{ChannelPlan, TableFormat, TablePlace};
use crate::readings::Reading;
use crate::rows::{ColumnInfo, TimeColumn};
use crate::stamp::TimeUnit;
use crate::truth;
use std::path::Path;

/// Name of the time column.
const TIME: &str = "time";
/// What helps when a table has other columns.
const REMEDY: &str = "rename the columns, or say with --sensors SENSORS.toml which column is which reading and its unit (docs/logs.md)";

/// The channel of a table of readings with the names of a run's table `sensors`. Contact angles may be absent.
///
/// # Errors
/// [`LogError`] with all missing columns and wrong units.
pub fn readings(path: &Path) -> Result<ChannelPlan, LogError> {
    let (format, found) = open(path)?;
    let mut problems = Vec::new();
    let (mut columns, mut formulas) = (Vec::new(), Vec::new());
    for reading in Reading::all() {
        match find(&found, reading.name()) {
            Some(column) => {
                problems.extend(wrong_unit(column, reading.unit()));
                formulas.push((reading, Formula::of_cell(columns.len())));
                columns.push(column.name.clone());
            }
            None if reading.is_contact_angle() => {}
            None => problems.push(format!("has no column {}", reading.name())),
        }
    }
    let time = time(&found, &mut problems);
    check(path, &found, problems)?;
    Ok(ChannelPlan {
        name: stem(path),
        place: TablePlace {
            path: path.to_path_buf(),
            format,
            time,
        },
        offset: 0.0,
        columns,
        readings: formulas,
        is_truth: false,
    })
}

/// The channel of a table of the truth with the names of a run's table `truth`: at least N and T of each wheel.
///
/// # Errors
/// As [`readings`].
pub fn truth(path: &Path) -> Result<ChannelPlan, LogError> {
    let (format, found) = open(path)?;
    let mut problems = Vec::new();
    for name in truth::required() {
        match find(&found, &name) {
            Some(column) => problems.extend(wrong_unit(column, "N")),
            None => problems.push(format!("has no column {name}")),
        }
    }
    let time = time(&found, &mut problems);
    check(path, &found, problems)?;
    let columns = found.into_iter().map(|c| c.name);
    Ok(ChannelPlan {
        name: stem(path),
        place: TablePlace {
            path: path.to_path_buf(),
            format,
            time,
        },
        offset: 0.0,
        columns: columns.filter(|name| truth::is_column(name)).collect(),
        readings: Vec::new(),
        is_truth: true,
    })
}

fn open(path: &Path) -> Result<(TableFormat, Vec<ColumnInfo>), LogError> {
    let format = TableFormat::of(path).ok_or_else(|| TableFormat::refusal(path))?;
    Ok((format, format.columns(path)?))
}

/// A column by its name, with or without a unit in brackets.
fn find<'a>(columns: &'a [ColumnInfo], name: &str) -> Option<&'a ColumnInfo> {
    let bare = |column: &ColumnInfo| {
        let text = column.name.split(['[', '(']).next().unwrap_or_default();
        text.trim() == name
    };
    columns.iter().find(|column| bare(column))
}

fn wrong_unit(column: &ColumnInfo, allowed: &str) -> Option<String> {
    let found = column.unit.as_deref().filter(|unit| *unit != allowed)?;
    let name = &column.name;
    Some(format!(
        "column {name} has the unit {found}, allowed: {allowed}"
    ))
}

fn time(columns: &[ColumnInfo], problems: &mut Vec<String>) -> TimeColumn {
    let found = find(columns, TIME);
    match found {
        Some(column) => problems.extend(wrong_unit(column, "s")),
        None => problems.push(format!("has no column {TIME}")),
    }
    TimeColumn {
        name: found.map_or(TIME, |column| &column.name).to_owned(),
        unit: TimeUnit::SECOND,
    }
}

fn check(path: &Path, found: &[ColumnInfo], problems: Vec<String>) -> Result<(), LogError> {
    if problems.is_empty() {
        return Ok(());
    }
    let message = format!(
        "{}; found {}; {REMEDY}",
        problems.join("; "),
        ColumnInfo::list(found)
    );
    Err(LogError::whole(path, message))
}

/// The name of a table: that of its file without extension.
pub fn stem(path: &Path) -> String {
    path.file_stem()
        .unwrap_or_default()
        .to_string_lossy()
        .into_owned()
}
