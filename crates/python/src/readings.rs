//! Columns of readings, from NumPy arrays or any table of them.

use pyo3::buffer::PyBuffer;
use pyo3::exceptions::{PyKeyError, PyValueError};
use pyo3::prelude::*;
use robhaz_estimator::{LinkReading, SensorFrame};

/// The columns of the table `sensors` of a run.
pub struct Readings {
    time: Vec<f64>,
    /// Angle, motor torque and contact angle of each wheel; empty without the column.
    wheels: [[Vec<f64>; 3]; 3],
    /// Inclination and rate of links 1 and 2.
    links: [[Vec<f64>; 2]; 2],
}

impl Readings {
    /// Takes the columns out of a dictionary of arrays or a table of robhaz, pandas, polars or
    /// pyarrow. Contact angles may be missing unless `with_angles`.
    pub fn of(readings: &Bound<'_, PyAny>, with_angles: bool) -> PyResult<Self> {
        let names = names(readings)?;
        let column = |name: String| column(readings, &names, &name);
        let wheel = |i: usize| {
            let angle = format!("wheel{}_contact_angle", i + 1);
            let has_angle = with_angles || names.contains(&angle);
            Ok::<_, PyErr>([
                column(format!("wheel{}_angle", i + 1))?,
                column(format!("wheel{}_motor_torque", i + 1))?,
                has_angle
                    .then(|| column(angle))
                    .transpose()?
                    .unwrap_or_default(),
            ])
        };
        let link = |i: usize| {
            Ok::<_, PyErr>([
                column(format!("link{}_inclination", i + 1))?,
                column(format!("link{}_rate", i + 1))?,
            ])
        };
        let read = Self {
            time: column("time".to_owned())?,
            wheels: [wheel(0)?, wheel(1)?, wheel(2)?],
            links: [link(0)?, link(1)?],
        };
        read.check()?;
        Ok(read)
    }

    /// Number of rows.
    pub fn len(&self) -> usize {
        self.time.len()
    }

    /// The readings of a row; NaN is a missing reading.
    pub fn frame(&self, row: usize) -> SensorFrame {
        let value = |column: &Vec<f64>| column.get(row).copied().filter(|v| !v.is_nan());
        let wheels = |part: usize| [0, 1, 2].map(|i| value(&self.wheels[i][part]));
        let link = |i: usize| LinkReading {
            inclination: value(&self.links[i][0]),
            rate: value(&self.links[i][1]),
        };
        SensorFrame {
            time: self.time.get(row).copied().unwrap_or(f64::NAN),
            wheel_angle: wheels(0),
            motor_torque: wheels(1),
            link1: link(0),
            link2: link(1),
            contact_angle: wheels(2),
        }
    }

    /// All columns have the rows of the time.
    fn check(&self) -> PyResult<()> {
        let rows = self.len();
        let wheels = self.wheels.iter().flatten().filter(|c| !c.is_empty());
        let mut columns = wheels.chain(self.links.iter().flatten());
        match columns.find(|c| c.len() != rows) {
            None => Ok(()),
            Some(column) => Err(PyValueError::new_err(format!(
                "readings: found a column of {} rows, allowed: {rows} as the time has",
                column.len()
            ))),
        }
    }
}

/// Names of the columns: `column_names` of pyarrow, `keys()` of dictionaries, pandas and robhaz,
/// `columns` of polars.
fn names(readings: &Bound<'_, PyAny>) -> PyResult<Vec<String>> {
    let names = if let Ok(names) = readings.getattr("column_names") {
        names
    } else if let Ok(names) = readings.call_method0("keys") {
        names
    } else {
        readings.getattr("columns")?
    };
    names.try_iter()?.map(|name| name?.extract()).collect()
}

fn column(readings: &Bound<'_, PyAny>, names: &[String], name: &str) -> PyResult<Vec<f64>> {
    if !names.iter().any(|n| n == name) {
        let names = names.join(", ");
        return Err(PyKeyError::new_err(format!(
            "readings: no column {name:?}, found: {names}"
        )));
    }
    let numpy = readings.py().import("numpy")?;
    let array = numpy.call_method1("asarray", (readings.get_item(name)?, "float64"))?;
    let axes: usize = array.getattr("ndim")?.extract()?;
    if axes != 1 {
        let text = format!("readings: column {name:?} has {axes} axes, allowed: 1");
        return Err(PyValueError::new_err(text));
    }
    PyBuffer::<f64>::get(&array)?.to_vec(readings.py())
}
