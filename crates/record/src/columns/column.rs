//! A column and a table: name, unit, description, and the source of the values.

use robhaz_estimator::Estimate;
use robhaz_model::{Bar, Pin};
use robhaz_run::Frame;
use robhaz_sim::Truth;

/// One value of a column.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Value {
    /// A number in the column's unit.
    Float(f64),
    /// A number in the column's unit that can be missing: a lost reading, no estimate, or one that is not finite.
    Optional(Option<f64>),
    /// A count.
    Count(u32),
}

/// The kind of [`Value`] that a column holds. It never changes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// [`Value::Float`]
    Float,
    /// [`Value::Optional`]
    Optional,
    /// [`Value::Count`]
    Count,
}

/// Takes a column's values out of records. Every closure on a record does: several values then cost one dynamic call.
pub(super) trait Get<T>: Send + Sync {
    fn one(&self, frame: &Frame<'_>) -> T;
    fn all(&self, frames: &[Frame<'_>], to: &mut Vec<T>);
}

impl<T, F: Fn(&Frame<'_>) -> T + Send + Sync> Get<T> for F {
    fn one(&self, frame: &Frame<'_>) -> T {
        self(frame)
    }

    fn all(&self, frames: &[Frame<'_>], to: &mut Vec<T>) {
        to.extend(frames.iter().map(self));
    }
}

/// The source of a column's values. Values of the truth that are not there, such as those of a contact, are optional.
pub(super) enum Source {
    Float(Box<dyn Get<f64>>),
    /// NaN where there is none.
    Optional(Box<dyn Get<f64>>),
    Truth(Box<dyn Get<f64>>),
    /// NaN where there is none.
    OptionalOfTruth(Box<dyn Get<f64>>),
    CountOfTruth(Box<dyn Get<u32>>),
}

impl Source {
    pub(super) fn float(get: impl Fn(&Frame<'_>) -> f64 + Send + Sync + 'static) -> Self {
        Self::Float(Box::new(get))
    }

    pub(super) fn optional(
        get: impl Fn(&Frame<'_>) -> Option<f64> + Send + Sync + 'static,
    ) -> Self {
        Self::Optional(Box::new(move |f: &Frame<'_>| get(f).unwrap_or(f64::NAN)))
    }

    fn truth(get: impl Fn(&Truth) -> f64 + Send + Sync + 'static) -> Self {
        Self::Truth(Box::new(move |f: &Frame<'_>| {
            f.truth.map_or(f64::NAN, &get)
        }))
    }

    pub(super) fn optional_of_truth(
        get: impl Fn(&Truth) -> Option<f64> + Send + Sync + 'static,
    ) -> Self {
        let get = move |f: &Frame<'_>| f.truth.and_then(&get).unwrap_or(f64::NAN);
        Self::OptionalOfTruth(Box::new(get))
    }

    pub(super) fn count_of_truth(get: impl Fn(&Truth) -> u32 + Send + Sync + 'static) -> Self {
        Self::CountOfTruth(Box::new(move |f: &Frame<'_>| f.truth.map_or(0, &get)))
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
    source: Source,
}

impl Column {
    /// This column's value in a record. A column of the truth has none, `Value::Optional(None)`, in a record without
    /// truth: tables of the truth have no row for it.
    pub fn value(&self, frame: &Frame<'_>) -> Value {
        if self.is_truth() && frame.truth.is_none() {
            return Value::Optional(None);
        }
        match &self.source {
            Source::Float(get) | Source::Truth(get) => Value::Float(get.one(frame)),
            Source::Optional(get) | Source::OptionalOfTruth(get) => {
                Value::Optional(Some(get.one(frame)).filter(|v| v.is_finite()))
            }
            Source::CountOfTruth(get) => Value::Count(get.one(frame)),
        }
    }

    /// Adds the values of a column of floats in records for which its table has a row. Of [`Kind::Optional`] a value that is
    /// not finite is missing. Nothing is added for another kind.
    pub fn add_floats(&self, frames: &[Frame<'_>], to: &mut Vec<f64>) {
        match &self.source {
            Source::Float(get)
            | Source::Truth(get)
            | Source::Optional(get)
            | Source::OptionalOfTruth(get) => get.all(frames, to),
            Source::CountOfTruth(_) => {}
        }
    }

    /// As [`Self::add_floats`], for a column of counts.
    pub fn add_counts(&self, frames: &[Frame<'_>], to: &mut Vec<u32>) {
        if let Source::CountOfTruth(get) = &self.source {
            get.all(frames, to);
        }
    }

    fn is_truth(&self) -> bool {
        matches!(
            self.source,
            Source::Truth(_) | Source::OptionalOfTruth(_) | Source::CountOfTruth(_)
        )
    }

    /// The kind of its values.
    pub fn kind(&self) -> Kind {
        match self.source {
            Source::Float(_) | Source::Truth(_) => Kind::Float,
            Source::Optional(_) | Source::OptionalOfTruth(_) => Kind::Optional,
            Source::CountOfTruth(_) => Kind::Count,
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
    /// Whether the table has a row for a record: that of the truth needs one.
    pub fn has_row(&self, frame: &Frame<'_>) -> bool {
        frame.truth.is_some() || !self.is_of_truth()
    }

    /// Whether the table is that of the truth, by its first column after the time: this is asked at every record.
    fn is_of_truth(&self) -> bool {
        self.columns.get(1).is_some_and(Column::is_truth)
    }
}

pub(super) const WHEEL: [&str; 3] = ["front wheel", "middle wheel", "rear wheel"];

pub(super) fn column(
    name: impl Into<String>,
    unit: &'static str,
    description: impl Into<String>,
    source: Source,
) -> Column {
    Column {
        name: name.into(),
        unit,
        description: description.into(),
        source,
    }
}

/// The column `time`: the time of the record itself.
pub(super) fn time_of_record() -> Column {
    let source = Source::float(|f| f.time);
    column("time", "s", "time since the start", source)
}

pub(super) fn of_truth(
    name: impl Into<String>,
    unit: &'static str,
    description: impl Into<String>,
    get: impl Fn(&Truth) -> f64 + Send + Sync + 'static,
) -> Column {
    column(name, unit, description, Source::truth(get))
}

pub(super) fn of_estimate(
    index: usize,
    name: impl Into<String>,
    unit: &'static str,
    description: impl Into<String>,
    get: impl Fn(&Estimate) -> Option<f64> + Send + Sync + 'static,
) -> Column {
    let source = Source::optional(move |f| f.estimates.get(index)?.as_ref().ok().and_then(&get));
    column(name, unit, description, source)
}

pub(super) fn pin_force_description(pin: Pin) -> String {
    let (receiver, giver) = pin.bars();
    format!(
        "force in pin {} on {} from {}",
        pin.name().to_uppercase(),
        Bar::name(receiver),
        Bar::name(giver)
    )
}
