//! Columns of readings, from NumPy arrays or any table of them.
//!
//! The time is a column of numbers in seconds, or one of time stamps: of NumPy, pandas, polars, Arrow, or Python's
//! `datetime`. Stamps become seconds since the first row, as in `robhaz estimate`: a double resolves a date to 0.2 us.

use pyo3::buffer::PyBuffer;
use pyo3::exceptions::{PyKeyError, PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use robhaz_scene::{Reading, Values};

/// The columns of readings that a table has.
pub struct Readings {
    /// Time of each row, s.
    pub time: Vec<f64>,
    columns: Vec<(Reading, Vec<f64>)>,
}

impl Readings {
    /// Takes these readings out of a table, which may lack some.
    pub fn of(
        source: Source<'_, '_>,
        readings: impl IntoIterator<Item = Reading>,
        may_lack: impl Fn(Reading) -> bool,
    ) -> PyResult<Self> {
        let mut columns = Vec::new();
        for reading in readings {
            if source.has(reading.name()) || !may_lack(reading) {
                columns.push((reading, source.column(reading.name())?));
            }
        }
        let time = source.time;
        Ok(Self { time, columns })
    }

    /// The readings of a row; NaN is a missing reading.
    pub fn values(&self, row: usize) -> Values {
        let mut values = [None; Reading::COUNT];
        for (reading, column) in &self.columns {
            values[reading.index()] = known(Some(column[row]));
        }
        values
    }
}

/// A reading that is there.
pub fn known(value: Option<f64>) -> Option<f64> {
    value.filter(|v| !v.is_nan())
}

/// A table of readings of any library.
pub struct Source<'a, 'py> {
    readings: &'a Bound<'py, PyAny>,
    names: Vec<String>,
    /// Time of each row, s.
    pub time: Vec<f64>,
}

impl<'a, 'py> Source<'a, 'py> {
    /// A dictionary of arrays or a table of robhaz, pandas, polars or pyarrow.
    pub fn of(readings: &'a Bound<'py, PyAny>) -> PyResult<Self> {
        let names = names(readings)?;
        Ok(Self {
            time: time(readings, &names)?,
            readings,
            names,
        })
    }

    /// Whether it has a column.
    pub fn has(&self, name: &str) -> bool {
        self.names.iter().any(|n| n == name)
    }

    /// The numbers of a column, as many as the time has.
    pub fn column(&self, name: &str) -> PyResult<Vec<f64>> {
        let column = column(self.readings, &self.names, name)?;
        let (rows, found) = (self.time.len(), column.len());
        if found != rows {
            return Err(PyValueError::new_err(format!(
                "readings: found column {name:?} of {found} rows, allowed: {rows} as the time has"
            )));
        }
        Ok(column)
    }
}

/// Names of the columns: `column_names` of pyarrow, `keys()` of dictionaries, pandas and robhaz,
/// `columns` of polars.
fn names(readings: &Bound<'_, PyAny>) -> PyResult<Vec<String>> {
    let names = readings.getattr("column_names");
    let names = names.or_else(|_| readings.call_method0("keys"));
    let names = names.or_else(|_| readings.getattr("columns"))?;
    names.try_iter()?.map(|name| name?.extract()).collect()
}

/// A column as it is in the table.
fn item<'py>(
    readings: &Bound<'py, PyAny>,
    names: &[String],
    name: &str,
) -> PyResult<Bound<'py, PyAny>> {
    if names.iter().any(|n| n == name) {
        return readings.get_item(name);
    }
    let names = names.join(", ");
    Err(PyKeyError::new_err(format!(
        "readings: no column {name:?}, found: {names}"
    )))
}

fn column(readings: &Bound<'_, PyAny>, names: &[String], name: &str) -> PyResult<Vec<f64>> {
    let item = item(readings, names, name)?;
    let array = array_of(&item, name)?;
    let refused = match kind(&array)? {
        'M' | 'm' => "time stamps",
        'b' => "truth values",
        'c' => "complex numbers",
        'U' | 'S' | 'T' => "text",
        _ => {
            let numbers = numbers(&array);
            return numbers.map_err(|error| {
                PyTypeError::new_err(format!(
                    "readings: column {name:?}: {error}, allowed: numbers"
                ))
            });
        }
    };
    Err(PyTypeError::new_err(format!(
        "readings: column {name:?} holds {refused}, allowed: numbers in SI units"
    )))
}

/// The time of each row, s: of time stamps that since the first row.
fn time(readings: &Bound<'_, PyAny>, names: &[String]) -> PyResult<Vec<f64>> {
    const NAME: &str = "time";
    let item = item(readings, names, NAME)?;
    let array = array_of(&item, NAME)?;
    let of_type = |unit: &str| -> PyResult<Vec<i64>> {
        let stamps = array.call_method1("astype", (unit,))?;
        PyBuffer::<i64>::get(&stamps.call_method1("view", ("int64",))?)?.to_vec(item.py())
    };
    let stamps = match kind(&array)? {
        'M' => of_type("datetime64[ns]")?,
        'm' => of_type("timedelta64[ns]")?,
        _ => return column(readings, names, NAME),
    };
    // What NumPy writes for a stamp that is missing.
    if let Some(row) = stamps.iter().position(|stamp| *stamp == i64::MIN) {
        return Err(PyValueError::new_err(format!(
            "readings: column {NAME:?} has no time in row {row}, allowed: every row has a time"
        )));
    }
    let first = stamps.first().copied().unwrap_or_default();
    let since = |stamp: &i64| stamp.saturating_sub(first) as f64 / 1e9;
    Ok(stamps.iter().map(since).collect())
}

/// A column as an array of its own type, of stamps with a zone in UTC.
fn array_of<'py>(item: &Bound<'py, PyAny>, name: &str) -> PyResult<Bound<'py, PyAny>> {
    let numpy = item.py().import("numpy")?;
    // A pandas column with a zone, or of Arrow's type, would become an array of objects.
    let dtype = item.getattr("dtype").and_then(|dtype| dtype.str());
    let dtype = dtype.map_or(String::new(), |text| text.to_string());
    let unit = [
        ("datetime64", "datetime64[ns]"),
        ("timestamp[", "datetime64[ns]"),
        ("duration[", "timedelta64[ns]"),
    ];
    let unit = unit.into_iter().find(|(start, _)| dtype.starts_with(start));
    let array = match unit {
        Some((_, unit)) if item.hasattr("to_numpy")? => item.call_method1("to_numpy", (unit,))?,
        _ => numpy.call_method1("asarray", (&without_mask(item)?,))?,
    };
    let array = match kind(&array)? {
        'O' => of_objects(&array)?,
        _ => array,
    };
    match array.getattr("ndim")?.extract()? {
        1_usize => Ok(array),
        axes => Err(PyValueError::new_err(format!(
            "readings: column {name:?} has {axes} axes, allowed: 1"
        ))),
    }
}

/// A masked array of numbers as one in which what is masked is missing.
fn without_mask<'py>(item: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
    let masked = item.py().import("numpy")?.getattr("ma")?;
    let is_masked: bool = masked.call_method1("isMaskedArray", (item,))?.extract()?;
    if !(is_masked && matches!(kind(item)?, 'f' | 'i' | 'u')) {
        return Ok(item.clone());
    }
    let numbers = item.call_method1("astype", ("float64",))?;
    numbers.call_method1("filled", (f64::NAN,))
}

/// An array of objects as one of `datetime64` or `timedelta64`, where these are Python's dates or times; others as
/// they are.
fn of_objects<'py>(array: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
    let datetime = array.py().import("datetime")?;
    let utc = datetime.getattr("timezone")?.getattr("utc")?;
    let (date, span) = (
        datetime.getattr("datetime")?,
        datetime.getattr("timedelta")?,
    );
    let items: Vec<Bound<'_, PyAny>> = array
        .call_method0("tolist")?
        .try_iter()?
        .collect::<PyResult<_>>()?;
    let are = |of: &Bound<'_, PyAny>| -> PyResult<bool> {
        let mut found = items.iter().map(|item| item.is_instance(of));
        found.try_fold(false, |any, is_it| Ok(any | is_it?))
    };
    let numpy = array.py().import("numpy")?;
    if are(&date)? {
        // Stamps without a zone count as UTC, as in the command.
        let no_zone = PyDict::new(array.py());
        no_zone.set_item("tzinfo", array.py().None())?;
        let plain = |item: &Bound<'py, PyAny>| match item.getattr("tzinfo") {
            Ok(zone) if !zone.is_none() => {
                let at = item.call_method1("astimezone", (&utc,))?;
                at.call_method("replace", (), Some(&no_zone))
            }
            _ => Ok(item.clone()),
        };
        let plain: Vec<_> = items.iter().map(plain).collect::<PyResult<_>>()?;
        return numpy.call_method1("array", (plain, "datetime64[ns]"));
    }
    if are(&span)? {
        return numpy.call_method1("array", (items, "timedelta64[ns]"));
    }
    Ok(array.clone())
}

/// The kind of an array's type, a letter of NumPy.
fn kind(array: &Bound<'_, PyAny>) -> PyResult<char> {
    array.getattr("dtype")?.getattr("kind")?.extract()
}

fn numbers(array: &Bound<'_, PyAny>) -> PyResult<Vec<f64>> {
    let numbers = array.call_method1("astype", ("float64",))?;
    PyBuffer::<f64>::get(&numbers)?.to_vec(array.py())
}
