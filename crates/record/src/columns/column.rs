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

/// Takes the values of a column: those of its [`Kind`].
pub trait Cells {
    /// Takes a [`Value::Float`].
    fn float(&mut self, value: f64);
    /// Takes a [`Value::Optional`].
    fn optional(&mut self, value: Option<f64>);
    /// Takes a [`Value::Count`].
    fn count(&mut self, value: u32);
}

impl Cells for Value {
    fn float(&mut self, value: f64) {
        *self = Self::Float(value);
    }

    fn optional(&mut self, value: Option<f64>) {
        *self = Self::Optional(value);
    }

    fn count(&mut self, value: u32) {
        *self = Self::Count(value);
    }
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

type Get<T> = Box<dyn Fn(&Frame<'_>) -> T + Send + Sync>;
pub(super) type GetOptional<S> = Box<dyn Fn(&S) -> Option<f64> + Send + Sync>;

/// The source of a column's values. Values of the truth that are not there, such as those of a contact, are optional.
pub(super) enum Source {
    Float(Get<f64>),
    Optional(Get<Option<f64>>),
    Truth(Box<dyn Fn(&Truth) -> f64 + Send + Sync>),
    OptionalOfTruth(GetOptional<Truth>),
    CountOfTruth(Box<dyn Fn(&Truth) -> u32 + Send + Sync>),
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
        let mut value = Value::Optional(None);
        self.pass(frame, &mut value);
        value
    }

    /// Passes this column's value in a record to `to`, as [`Self::value`], but faster: its kind is asked for once.
    #[inline]
    pub fn pass(&self, frame: &Frame<'_>, to: &mut impl Cells) {
        match (&self.source, frame.truth) {
            (Source::Float(get), _) => to.float(get(frame)),
            (Source::Optional(get), _) => to.optional(get(frame).filter(|v| v.is_finite())),
            (Source::Truth(get), Some(truth)) => to.float(get(truth)),
            (Source::OptionalOfTruth(get), truth) => {
                to.optional(truth.and_then(get).filter(|v| v.is_finite()));
            }
            (Source::CountOfTruth(get), Some(truth)) => to.count(get(truth)),
            (_, None) => to.optional(None),
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
    let source = Source::Float(Box::new(|f| f.time));
    column("time", "s", "time since the start", source)
}

pub(super) fn of_truth(
    name: impl Into<String>,
    unit: &'static str,
    description: impl Into<String>,
    get: impl Fn(&Truth) -> f64 + Send + Sync + 'static,
) -> Column {
    column(name, unit, description, Source::Truth(Box::new(get)))
}

pub(super) fn of_estimate(
    index: usize,
    name: impl Into<String>,
    unit: &'static str,
    description: impl Into<String>,
    get: impl Fn(&Estimate) -> Option<f64> + Send + Sync + 'static,
) -> Column {
    let source = Source::Optional(Box::new(move |f| {
        f.estimates.get(index)?.as_ref().ok().and_then(&get)
    }));
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
