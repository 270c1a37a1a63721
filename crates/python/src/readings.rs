//! Columns of readings, from NumPy arrays or any table of them.
//!
//! The time is a column of numbers in seconds, or one of time stamps: of NumPy, pandas, polars, Arrow, or Python's
//! `datetime`. Stamps become seconds since the first row, as in `robhaz estimate`: a double resolves a date to 0.2 us.

use pyo3::buffer::PyBuffer;
use pyo3::exceptions::{PyKeyError, PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};
use robhaz_run::ChannelReport;
use robhaz_scene::{Reading, Unit, Values};
use robhaz_score::signals::median;

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
                columns.push((reading, source.column(reading)?));
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
        let time = time(readings, &names)?;
        check_rate(&time)?;
        Ok(Self {
            time,
            readings,
            names,
        })
    }

    /// Whether it has a column.
    pub fn has(&self, name: &str) -> bool {
        self.names.iter().any(|n| n == name)
    }

    /// The numbers of a column, as many as the time has.
    pub fn column(&self, reading: Reading) -> PyResult<Vec<f64>> {
        let name = reading.name();
        let column = column(self.readings, &self.names, name, reading.unit())?;
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
/// `columns` of polars. No reading has a name that is no text.
fn names(readings: &Bound<'_, PyAny>) -> PyResult<Vec<String>> {
    let names = if readings.hasattr("column_names")? {
        readings.getattr("column_names")?
    } else if readings.hasattr("keys")? {
        readings.call_method0("keys")?
    } else if readings.hasattr("columns")? {
        readings.getattr("columns")?
    } else {
        return Err(PyTypeError::new_err(format!(
            "readings: found {}, allowed: a dictionary of arrays, or a table of robhaz, pandas, polars or pyarrow",
            readings.get_type().name()?
        )));
    };
    let names: Vec<_> = names.try_iter()?.collect::<PyResult<_>>()?;
    let texts = names.iter().filter_map(|name| name.extract().ok());
    Ok(texts.collect())
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

/// The numbers of a column in this unit.
fn column(
    readings: &Bound<'_, PyAny>,
    names: &[String],
    name: &str,
    unit: &str,
) -> PyResult<Vec<f64>> {
    let item = item(readings, names, name)?;
    if let Some(found) = stated_unit(readings, name).filter(|found| !Unit::is_same(found, unit)) {
        return Err(PyValueError::new_err(format!(
            "readings: column {name:?} has the unit {found}, allowed: {unit}"
        )));
    }
    let array = array_of(&item, name)?;
    let refused = match kind(&array)? {
        'M' | 'm' => "time stamps",
        'b' => "truth values",
        'c' => "complex numbers",
        'U' | 'S' | 'T' => "text",
        _ => {
            let numbers = numbers(&array);
            return numbers.map_err(|error| no_numbers(name, &error));
        }
    };
    Err(PyTypeError::new_err(format!(
        "readings: column {name:?} holds {refused}, allowed: numbers in {unit}"
    )))
}

/// The unit in the metadata of a field of Arrow.
fn stated_unit(readings: &Bound<'_, PyAny>, name: &str) -> Option<String> {
    let schema = readings.getattr("schema").ok()?;
    let field = schema.call_method1("field", (name,)).ok()?;
    let metadata = field.getattr("metadata").ok()?;
    let unit = |key: &str| {
        let key = PyBytes::new(readings.py(), key.as_bytes());
        let unit: Vec<u8> = metadata.get_item(key).ok()?.extract().ok()?;
        String::from_utf8(unit).ok()
    };
    unit("unit").or_else(|| unit("units"))
}

/// Refuses times of which no robot has a row so often or so rarely: they have another unit. A few rows can have a gap.
fn check_rate(times: &[f64]) -> PyResult<()> {
    /// Rows over which bursts are evened out.
    const MANY: usize = 20;
    // A count of rows.
    let step = |rows: usize, w: &[f64]| (w[rows] - w[0]) / rows as f64;
    let over = |rows: usize| {
        times
            .windows(rows + 1)
            .map(move |w| step(rows, w))
            .collect()
    };
    let reports = [1, MANY.min(times.len().saturating_sub(1)).max(1)].map(|rows| ChannelReport {
        period: median(over(rows)).unwrap_or_default(),
        ..ChannelReport::default()
    });
    if !reports.iter().all(ChannelReport::is_of_other_unit) {
        return Ok(());
    }
    let other = reports[0].other_unit();
    let other = other.map_or(String::new(), |(unit, rate)| {
        format!("; as {unit} it is {rate:.1} Hz")
    });
    Err(PyValueError::new_err(format!(
        "readings: column \"time\" has a row every {:.3e} s, and no robot is recorded at such a rate, allowed: numbers in s, or time stamps{other}",
        reports[0].period
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
        _ => return column(readings, names, NAME, "s"),
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
        Some((_, unit)) if item.hasattr("to_numpy")? => item.call_method1("to_numpy", (unit,)),
        _ => numpy.call_method1("asarray", (&without_mask(item)?,)),
    };
    let array = array.map_err(|error| no_numbers(name, &error))?;
    let axes: usize = array.getattr("ndim")?.extract()?;
    if axes != 1 {
        let found = item.get_type().name()?;
        return Err(PyValueError::new_err(format!(
            "readings: column {name:?}, of type {found}, has {axes} axes, allowed: 1"
        )));
    }
    match kind(&array)? {
        'O' => of_objects(&array),
        _ => Ok(array),
    }
}

/// The error of a column that is not made of numbers.
fn no_numbers(name: &str, error: &PyErr) -> PyErr {
    PyTypeError::new_err(format!(
        "readings: column {name:?}: {error}, allowed: numbers"
    ))
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
