//! The columns of every table, each declared once: name, unit, description, and the source of its
//! values.

use robhaz_estimator::Estimate;
use robhaz_estimator::whole::{WholeEstimate, WholeFrame};
use robhaz_model::{Bar, Pin, Suspension};
use robhaz_run::{Frame, RunDescription};
use robhaz_sim::Truth;

/// Adds columns to a table, a line each: name, unit, meaning, value. They share what makes a
/// [`Source`] of the value, the start of their names, and that of their descriptions.
macro_rules! columns {
    ($table:expr, estimate $i:expr; $start:expr, $of:expr; $($name:literal, $unit:literal, $meaning:literal => $get:expr;)*) => {
        $table.columns.extend([$($crate::columns::Column::new(
            [&$start, $name], $unit, [&$of, $meaning], Source::estimate($i, $get),
        )),*])
    };
    ($table:expr, $source:path; $start:expr, $of:expr; $($name:literal, $unit:literal, $meaning:literal => $get:expr;)*) => {
        $table.columns.extend([$($crate::columns::Column::new([&$start, $name], $unit, [&$of, $meaning], $source($get))),*])
    };
}

mod both;
mod estimate;
mod sensors;
mod truth;

/// The values that a column holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// A number in the column's unit.
    Float,
    /// A number that can be missing: a lost reading, no estimate, or one that is not finite.
    Optional,
    /// A count.
    Count,
}

/// The kind of a column's values, and the value of a record; NaN where it is missing. Behind a
/// pointer, so that the columns, which are hundreds, share the code that goes through the records.
struct Source(Kind, Get);
type Get = Box<dyn Fn(&Frame<'_>) -> f64 + Send + Sync>;

impl Source {
    fn record(get: impl Fn(&Frame<'_>) -> f64 + Send + Sync + 'static) -> Self {
        Self(Kind::Float, Box::new(get))
    }

    fn record_or_none(get: impl Fn(&Frame<'_>) -> Option<f64> + Send + Sync + 'static) -> Self {
        let or_nan = move |f: &Frame<'_>| get(f).unwrap_or(f64::NAN);
        Self(Kind::Optional, Box::new(or_nan))
    }

    fn truth(get: impl Fn(&Truth) -> f64 + Send + Sync + 'static) -> Self {
        Self::record(move |f| f.truth.map_or(f64::NAN, &get))
    }

    fn truth_count(get: impl Fn(&Truth) -> u32 + Send + Sync + 'static) -> Self {
        let count = move |f: &Frame<'_>| f64::from(f.truth.map_or(0, &get));
        Self(Kind::Count, Box::new(count))
    }

    /// Of the readings of both sides.
    fn readings(get: impl Fn(&WholeFrame) -> Option<f64> + Send + Sync + 'static) -> Self {
        Self::record_or_none(move |f| get(&f.both?.sides.readings))
    }

    /// Of the estimate of both sides.
    fn both(get: impl Fn(&WholeEstimate) -> Option<f64> + Send + Sync + 'static) -> Self {
        Self::record_or_none(move |f| get(f.both?.estimate?))
    }

    /// Of the run's estimator of this number (from 0).
    fn estimate(
        index: usize,
        get: impl Fn(&Estimate) -> Option<f64> + Send + Sync + 'static,
    ) -> Self {
        Self::record_or_none(move |f| get(f.estimate(index)?))
    }
}

/// A column of a table.
pub struct Column {
    /// Its name, fixed: scripts rely on it.
    pub name: String,
    /// Its unit, SI; `1` where it has none.
    pub unit: &'static str,
    /// Its content, in a few words.
    pub description: String,
    /// The kind of its values.
    pub kind: Kind,
    get: Get,
}

impl Column {
    /// Name and description have two parts.
    fn new(
        name: [&str; 2],
        unit: &'static str,
        description: [&str; 2],
        Source(kind, get): Source,
    ) -> Self {
        Self {
            name: name.concat(),
            unit,
            description: description.concat(),
            kind,
            get,
        }
    }

    /// Adds the values in records; NaN where one is missing.
    pub fn add(&self, frames: &[Frame<'_>], to: &mut Vec<f64>) {
        to.extend(frames.iter().map(&self.get));
    }
}

/// A table: a row for each record of the run.
pub struct Table {
    /// Name, and stem of its file.
    pub name: String,
    /// Its columns, in order; the first is `time`.
    pub columns: Vec<Column>,
}

impl Table {
    /// A table that has the time of the record as its first column.
    fn new(name: impl Into<String>) -> Self {
        let mut table = Self {
            name: name.into(),
            columns: Vec::new(),
        };
        columns! { table, Source::record; "", ""; "time", "s", "time since the start" => |f| f.time; }
        table
    }

    /// All tables of a run: `truth` of a simulation, `sensors`, `commands` of a control that takes
    /// readings, and one for each estimator; of a log of both sides `sensors` and one estimate.
    pub fn all(run: &RunDescription) -> Vec<Self> {
        if let Some(both) = &run.both {
            let sensors = Self::sensors_of_both(both.coupling);
            return vec![sensors, Self::estimate_of_both(&both.label)];
        }
        let truth = run.world.as_ref().map(|_| Self::truth());
        let estimators = run.estimators.iter().enumerate();
        let estimates = estimators.map(|(index, e)| Self::estimate(index, &e.label));
        let tables = truth.into_iter().chain([Self::sensors()]);
        let commands = run.takes_commands().then(Self::commands);
        let mut tables: Vec<Self> = tables.chain(commands).chain(estimates).collect();
        if run.nominal_robot.geometry.suspension != Suspension::FourBar {
            let of_four_bar = |name: &str| {
                let starts = ["link3_", "pin_p_", "pin_r_", "pin_s_", "loop_error"];
                starts.iter().any(|start| name.starts_with(start))
            };
            for table in &mut tables {
                table.columns.retain(|column| !of_four_bar(&column.name));
            }
        }
        tables
    }
}

const WHEEL: [&str; 3] = ["front wheel: ", "middle wheel: ", "rear wheel: "];

fn pin_force_description(pin: Pin) -> String {
    let (receiver, giver) = pin.bars();
    format!(
        "force in pin {} on {} from {}",
        pin.name().to_uppercase(),
        Bar::name(receiver),
        Bar::name(giver)
    )
}
