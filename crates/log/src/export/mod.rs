//! A run or an estimate as a log that other tools open: MCAP with ROS 2 messages, or one CSV table.

mod forces;
mod odometry;
mod readings;
mod sensors;
mod topics;

pub use readings::Exported;

use crate::place::no_table;
use crate::{Channels, LogError, LogPlace, own_names};
use forces::{Forces, forces_in};
use readings::read;
use robhaz_run::Stop;
use robhaz_scene::{LogChoice, Reading};
use std::fs::File;
use std::io::{BufWriter, Write as _};
use std::path::Path;
use topics::write_mcap;

/// What a format holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ExportFormat {
    /// Topics of ROS 2 messages.
    Mcap,
    /// One table of text.
    Csv,
}

/// Writes the folder of a run or of an estimate into a file. MCAP gets the folder's description,
/// too: it reads back with its robot and its noise budget.
///
/// # Errors
///
/// [`LogError`]: a folder without readings, tables that cannot be read, a file that cannot be
/// written, a cause to `stop`.
pub fn export(
    place: &LogPlace,
    format: ExportFormat,
    out: &Path,
    stop: Stop<'_>,
) -> Result<Exported, LogError> {
    let folder = &place.path;
    let table = place.files.first().ok_or_else(|| no_table(folder))?;
    let readings = Channels {
        source: folder.clone(),
        all: vec![own_names::readings(table, &place.choice)?],
    };
    let mut warnings = Vec::new();
    let mut forces = forces_in(folder, readings.is_of_both(), &mut warnings)?;
    stop().map_or(Ok(()), |cause| Err(LogError::Stopped(cause)))?;
    let mut exported = match format {
        ExportFormat::Mcap => write_mcap(&readings, &mut forces, place, out, stop)?,
        ExportFormat::Csv => {
            if place.choice.robot.robot != LogChoice::default().robot.robot {
                let notice = "a CSV file has no place for the robot: `check` and `estimate` take it for robot A without --robot ROBOT.toml; --to mcap keeps it";
                warnings.push(notice.to_owned());
            }
            write_csv(&readings, &mut forces, out, stop)?
        }
    };
    // Those of the forces first.
    exported.warnings.splice(0..0, warnings);
    Ok(exported)
}

fn write_csv(
    readings: &Channels,
    forces: &mut [Forces],
    out: &Path,
    stop: Stop<'_>,
) -> Result<Exported, LogError> {
    let file = File::create(out).map_err(LogError::write(out))?;
    let mut text = BufWriter::new(file);
    let mut names = vec!["time".to_owned()];
    let of_frame: Vec<Reading> = match readings.is_of_both() {
        true => readings.all[0].readings.iter().map(|(r, _)| *r).collect(),
        false => Reading::of_frame().collect(),
    };
    names.extend(of_frame.iter().map(|r| r.name().to_owned()));
    let mut parts = vec!["readings".to_owned()];
    for forces in &*forces {
        let columns = forces.columns.iter();
        names.extend(columns.map(|column| format!("{}.{column}", forces.name)));
        if parts.last() != Some(&forces.name) {
            parts.push(forces.name.clone());
        }
    }
    writeln!(text, "{}", names.join(",")).map_err(LogError::write(out))?;
    let exported = read(readings, parts, stop, |time, values| {
        let mut cells = vec![time];
        let readings = of_frame.iter().map(|r| values[r.index()]);
        cells.extend(readings.map(|value| value.unwrap_or(f64::NAN)));
        for forces in &mut *forces {
            cells.extend(forces.cells(time));
        }
        // The shortest text that reads back as the same number; nothing where there is none.
        let text_of = |v: &f64| match v.is_nan() {
            true => String::new(),
            false => format!("{v:?}"),
        };
        let cells: Vec<String> = cells.iter().map(text_of).collect();
        writeln!(text, "{}", cells.join(",")).map_err(LogError::write(out))
    })?;
    text.flush().map_err(LogError::write(out))?;
    Ok(exported)
}
