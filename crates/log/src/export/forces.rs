//! The tables of forces in a folder, a side at a time.

use crate::channel::stem;
use crate::{LogError, TableFormat, mapped};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Start of the names of tables of estimates.
const ESTIMATE: &str = "estimate-";
/// What a table of forces may have of each wheel: what the message has, in its order, and the slip.
/// The first two are required.
const COLUMNS: [&str; 8] = [
    "normal_force",
    "traction",
    "normal_force_sigma",
    "traction_sigma",
    "contact_angle",
    "needed_friction",
    "needed_friction_sigma",
    "slip",
];
/// Contact angle and slip among them.
pub const SLOPE: usize = 4;
pub const SLIP: usize = 7;
/// How many of them the message has.
pub const OF_MESSAGE: usize = 7;
/// Of the rover, in a table of both sides: what its wheels' axial forces are of their N.
const AXIAL_SHARE: &str = "axial_share";
/// The axial force, N, behind [`COLUMNS`].
pub const AXIAL: usize = COLUMNS.len();

/// The numbers of a row: those of three wheels of each of [`COLUMNS`], and their axial force; not a number where one
/// is missing.
pub type Numbers = [[f64; 3]; COLUMNS.len() + 1];

/// Forces of three wheels, of a robot in the plane or of a side: truth or one estimator.
pub struct Forces {
    /// `truth`, or the estimator's name.
    pub name: String,
    /// `left_` or `right_` of a table of both sides, else empty: start of the names of its wheels.
    side: &'static str,
    /// Its columns.
    pub columns: Vec<String>,
    /// Of each its place in [`COLUMNS`], and its wheel.
    places: Vec<[usize; 2]>,
    /// Times, s, and numbers.
    rows: Vec<(f64, Numbers)>,
    /// The first row that is not earlier than the last row of readings.
    next: usize,
}

/// Reads the tables of forces of a folder, in order of their names: the truth and the estimates; of
/// `both` sides the left one first. One that cannot be read is left out, and named in the warnings.
///
/// # Errors
/// [`LogError`] of a folder that cannot be read.
pub fn forces_in(
    folder: &Path,
    both: bool,
    warnings: &mut Vec<String>,
) -> Result<Vec<Forces>, LogError> {
    let sides: &[&str] = if both { &["left_", "right_"] } else { &[""] };
    let mut all = Vec::new();
    for (name, (path, format)) in tables(folder)? {
        let read = |side: &&'static str| Forces::read(&name, side, &path, format);
        match sides.iter().map(read).collect::<Result<Vec<_>, _>>() {
            Ok(read) => {
                warnings.extend(read.iter().find_map(|(_, cut_off)| cut_off.clone()));
                all.extend(read.into_iter().map(|(forces, _)| forces));
            }
            Err(error) => warnings.push(format!("left out: {error}")),
        }
    }
    Ok(all)
}

fn tables(folder: &Path) -> Result<BTreeMap<String, (PathBuf, TableFormat)>, LogError> {
    let mut found = BTreeMap::new();
    let entries = std::fs::read_dir(folder).map_err(LogError::io(folder))?;
    for entry in entries {
        let path = entry.map_err(LogError::io(folder))?.path();
        let stem = stem(&path);
        let name = match stem.strip_prefix(ESTIMATE) {
            Some(name) => name,
            None if stem == "truth" => "truth",
            None => continue,
        };
        // `estimate-kalman.parquet.partial` has another stem and no format.
        if let Some(format) = TableFormat::of(&path) {
            found.entry(name.to_owned()).or_insert((path, format));
        }
    }
    Ok(found)
}

/// That a file ends before its end, and why.
pub fn cut_off(path: &Path, why: &str) -> String {
    format!("{} is cut off at {why}", path.display())
}

impl Forces {
    /// Reads a table, so that a fault in its middle is found before anything is written. Says
    /// whether it is cut off.
    fn read(
        name: &str,
        side: &'static str,
        path: &Path,
        format: TableFormat,
    ) -> Result<(Self, Option<String>), LogError> {
        let found = format.columns(path)?;
        let (mut columns, mut places) = (Vec::new(), Vec::new());
        for (part, name) in COLUMNS.into_iter().enumerate() {
            for wheel in 0..3 {
                let column = format!("{side}wheel{}_{name}", wheel + 1);
                if found.iter().any(|c| c.name == column) {
                    columns.push(column);
                    places.push([part, wheel]);
                } else if part < 2 {
                    return Err(LogError::whole(path, format!("has no column {column}")));
                }
            }
        }
        let has_share = found.iter().any(|c| c.name == AXIAL_SHARE);
        let share = has_share.then(|| AXIAL_SHARE.to_owned());
        let mut rows = Vec::new();
        let read: Vec<String> = columns.iter().cloned().chain(share).collect();
        let why = format.read(path, &mapped::time(None), &read, &mut |row| {
            let mut numbers = [[f64::NAN; 3]; COLUMNS.len() + 1];
            for ([part, wheel], cell) in places.iter().zip(&row.cells) {
                numbers[*part][*wheel] = *cell;
            }
            let share = row.cells.get(places.len()).unwrap_or(&f64::NAN);
            numbers[AXIAL] = numbers[0].map(|normal| share * normal);
            rows.push((row.stamp.seconds(), numbers));
            Ok(())
        })?;
        let forces = Self {
            name: name.to_owned(),
            side,
            columns,
            places,
            rows,
            next: 0,
        };
        Ok((forces, why.map(|why| cut_off(path, &why))))
    }

    /// Its name with that of its side.
    pub fn label(&self) -> String {
        match self.side.strip_suffix('_') {
            Some(side) => format!("{}_{side}", self.name),
            None => self.name.clone(),
        }
    }

    /// Name of a wheel (0 to 2).
    pub fn wheel(&self, i: usize) -> String {
        format!("{}wheel{}", self.side, i + 1)
    }

    /// Whether it states the slip of the wheels.
    pub fn has_slip(&self) -> bool {
        let is_known = |(_, numbers): &(f64, Numbers)| numbers[SLIP].iter().any(|x| x.is_finite());
        self.rows.iter().any(is_known)
    }

    /// The numbers of the row of a time (s); `None` where the table has none.
    pub fn at(&mut self, time: f64) -> Option<&Numbers> {
        // Times of one run are equal to the bit; those of its tables as text too.
        const SAME: f64 = 1e-9;
        let late = self.rows[self.next..].iter();
        self.next += late.take_while(|(at, _)| *at < time - SAME).count();
        let (at, numbers) = self.rows.get(self.next)?;
        (*at <= time + SAME).then_some(numbers)
    }

    /// The cells of that row in the order of the columns.
    pub fn cells(&mut self, time: f64) -> Vec<f64> {
        let none = [[f64::NAN; 3]; COLUMNS.len() + 1];
        let numbers = self.at(time).copied().unwrap_or(none);
        let places = self.places.iter();
        places.map(|[part, wheel]| numbers[*part][*wheel]).collect()
    }
}
