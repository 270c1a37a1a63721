//! The columns of every table, each declared once: name, unit, description, and the source of its
//! values.

use robhaz_estimator::Estimate;
use robhaz_estimator::whole::WholeEstimate;
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

/// Reads a value from a record or a part of it. Behind a pointer, so that the columns, which are
/// hundreds, share the code that goes through the records.
type Get<Value> = Box<dyn Fn(&Frame<'_>) -> Value + Send + Sync>;
type GetTruth<Value> = Box<dyn Fn(&Truth) -> Value + Send + Sync>;
type GetBoth = Box<dyn Fn(&WholeEstimate) -> Option<f64> + Send + Sync>;
type GetEstimate = Box<dyn Fn(&Estimate) -> Option<f64> + Send + Sync>;

/// The source of a column's values.
enum Source {
    Record(Get<f64>),
    RecordOrNone(Get<Option<f64>>),
    Truth(GetTruth<f64>),
    TruthCount(GetTruth<u32>),
    /// Of the estimate of both sides.
    Both(GetBoth),
    /// Of the run's estimator of this number (from 0).
    Estimate(usize, GetEstimate),
}

impl Source {
    fn record(get: impl Fn(&Frame<'_>) -> f64 + Send + Sync + 'static) -> Self {
        Self::Record(Box::new(get))
    }

    fn record_or_none(get: impl Fn(&Frame<'_>) -> Option<f64> + Send + Sync + 'static) -> Self {
        Self::RecordOrNone(Box::new(get))
    }

    fn truth(get: impl Fn(&Truth) -> f64 + Send + Sync + 'static) -> Self {
        Self::Truth(Box::new(get))
    }

    fn truth_count(get: impl Fn(&Truth) -> u32 + Send + Sync + 'static) -> Self {
        Self::TruthCount(Box::new(get))
    }

    fn both(get: impl Fn(&WholeEstimate) -> Option<f64> + Send + Sync + 'static) -> Self {
        Self::Both(Box::new(get))
    }

    fn estimate(
        index: usize,
        get: impl Fn(&Estimate) -> Option<f64> + Send + Sync + 'static,
    ) -> Self {
        Self::Estimate(index, Box::new(get))
    }

    fn kind(&self) -> Kind {
        match self {
            Self::Record(_) | Self::Truth(_) => Kind::Float,
            Self::RecordOrNone(_) | Self::Both(_) | Self::Estimate(..) => Kind::Optional,
            Self::TruthCount(_) => Kind::Count,
        }
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
    source: Source,
}

impl Column {
    /// Name and description have two parts.
    fn new(name: [&str; 2], unit: &'static str, description: [&str; 2], source: Source) -> Self {
        Self {
            name: name.concat(),
            unit,
            description: description.concat(),
            kind: source.kind(),
            source,
        }
    }

    /// Its value of an estimate of both sides; `None` of one that is missing, and of a column of
    /// something else.
    pub fn of_both(&self, estimate: &WholeEstimate) -> Option<f64> {
        match &self.source {
            Source::Both(get) => get(estimate),
            _ => None,
        }
    }

    /// Adds the values in records; NaN where one is missing.
    pub fn add(&self, frames: &[Frame<'_>], to: &mut Vec<f64>) {
        match &self.source {
            Source::Record(get) => to.extend(frames.iter().map(get)),
            Source::RecordOrNone(get) => {
                to.extend(frames.iter().map(|f| get(f).unwrap_or(f64::NAN)))
            }
            Source::Truth(get) => to.extend(frames.iter().map(|f| f.truth.map_or(f64::NAN, get))),
            Source::TruthCount(get) => {
                let counts = frames.iter().map(|f| f.truth.map_or(0, get));
                to.extend(counts.map(f64::from))
            }
            Source::Both(_) => to.extend(frames.iter().map(|f| {
                let estimate = f.both.and_then(|both| both.estimate);
                estimate.and_then(|e| self.of_both(e)).unwrap_or(f64::NAN)
            })),
            Source::Estimate(index, get) => to.extend(frames.iter().map(|f| {
                let estimate = f.estimates.get(*index).and_then(|e| e.as_ref().ok());
                estimate.and_then(get).unwrap_or(f64::NAN)
            })),
        }
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
            return Self::of_both(both);
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
