//! An estimator, for one frame at a time or a whole table.

use crate::error::{Outcome, check_sides, invalid, of_frame, of_scene, warn};
use crate::estimate::Estimate;
use crate::readings::{Readings, Source, known};
use crate::table::Table;
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use robhaz_estimator::{LinkReading, SensorFrame};
use robhaz_record::{BatchBuilder, Table as Columns};
use robhaz_run::{EstimatedTerrain, Frame};
use robhaz_scene::{self as scene, LogChoice, Reading};

use std::path::PathBuf;

/// See the stub `_robhaz.pyi`.
#[pyclass(module = "robhaz")]
pub struct Estimator {
    #[pyo3(get)]
    name: String,
    #[pyo3(get)]
    needs_contact_angles: bool,
    inner: robhaz_estimator::Estimator,
}

impl Estimator {
    /// The estimator of a name, in a description of sensors and robot.
    pub fn of(mut choice: LogChoice, name: &str, angles: Option<&str>) -> PyResult<Self> {
        choice.select(&[name.to_owned()]).map_err(invalid)?;
        match angles {
            None | Some("given") => {}
            Some("none") => {
                choice.without_contact_angles(true).map_err(invalid)?;
            }
            Some(other) => {
                let text = format!("contact_angles: found {other:?}, allowed: \"given\", \"none\"");
                return Err(invalid(text));
            }
        }
        let Some(estimator) = choice.estimators.first() else {
            return Err(invalid(format!("no estimator {name:?}")));
        };
        let settings = choice.settings(estimator);
        Ok(Self {
            name: name.to_owned(),
            needs_contact_angles: settings.needs_contact_angles(),
            inner: robhaz_estimator::Estimator::new(&choice.robot.robot, settings),
        })
    }
}

#[pymethods]
impl Estimator {
    #[new]
    #[pyo3(signature = (name="kalman", *, robot=None, sensors=None, contact_angles=None))]
    fn new(
        py: Python<'_>,
        name: &str,
        robot: Option<PathBuf>,
        sensors: Option<PathBuf>,
        contact_angles: Option<&str>,
    ) -> PyResult<Self> {
        let described = LogChoice::default().described(sensors.as_deref(), robot.as_deref());
        let (choice, notice) = described.map_err(of_scene)?;
        check_sides(&choice, false)?;
        let estimator = Self::of(choice, name, contact_angles)?;
        if let Some(notice) = notice {
            warn(py, format!("{name}: {notice}"))?;
        }
        Ok(estimator)
    }

    #[pyo3(signature = (time, wheel_angle, motor_torque, inclination, rate, contact_angle=None, rate_error=None))]
    #[expect(
        clippy::too_many_arguments,
        reason = "the readings of a frame, by name"
    )]
    fn update(
        &mut self,
        time: &Bound<'_, PyAny>,
        wheel_angle: [Option<f64>; 3],
        motor_torque: [Option<f64>; 3],
        inclination: [Option<f64>; 2],
        rate: [Option<f64>; 2],
        contact_angle: Option<[Option<f64>; 3]>,
        rate_error: Option<[f64; 2]>,
    ) -> PyResult<Estimate> {
        let time = seconds(time)?;
        let link = |i: usize| LinkReading {
            inclination: known(inclination[i]),
            rate: known(rate[i]),
            rate_error: rate_error.map_or(0.0, |errors| errors[i]),
        };
        let frame = SensorFrame {
            time,
            wheel_angle: wheel_angle.map(known),
            motor_torque: motor_torque.map(known),
            link1: link(0),
            link2: link(1),
            contact_angle: contact_angle.unwrap_or_default().map(known),
        };
        Ok(self.inner.update(&frame).map_err(of_frame)?.into())
    }

    fn estimate(&mut self, py: Python<'_>, readings: &Bound<'_, PyAny>) -> PyResult<Table> {
        let needed = self.needs_contact_angles;
        let may_lack = |r: Reading| r.is_optional() || r.is_contact_angle() && !needed;
        let readings = Readings::of(Source::of(readings)?, Reading::of_frame(), may_lack)?;
        let inner = &mut self.inner;
        Table::of(Columns::estimate(0, &self.name), |rows| {
            py.detach(|| estimate_rows(inner, &readings, rows))
        })
    }

    fn __repr__(&self) -> String {
        format!("<robhaz.Estimator {}>", self.name)
    }
}

/// Latest time, s, 317 years: whole numbers of other units are beyond, and a double resolves it to 2 us.
const LATEST: f64 = 1e10;

/// A time in seconds.
pub fn seconds(time: &Bound<'_, PyAny>) -> PyResult<f64> {
    // NumPy makes a number of nanoseconds of a time stamp.
    if time.hasattr("dtype")? {
        let kind: String = time.getattr("dtype")?.getattr("kind")?.extract()?;
        if matches!(kind.as_str(), "M" | "m") {
            return Err(PyTypeError::new_err(
                "time: found a time stamp, allowed: a number, s",
            ));
        }
    }
    let time: f64 = time.extract()?;
    if time.abs() > LATEST {
        return Err(invalid(format!(
            "time: found {time:e}, allowed: a number of s, at most {LATEST:e}"
        )));
    }
    Ok(time)
}

/// Rows that go to their columns at once: they stay in the fast cache of a core.
const ROWS_AT_ONCE: usize = 32;

/// Updates the estimator with every row.
fn estimate_rows(
    estimator: &mut robhaz_estimator::Estimator,
    readings: &Readings,
    rows: &mut BatchBuilder,
) -> PyResult<()> {
    let mut sensors = Vec::with_capacity(ROWS_AT_ONCE);
    let mut estimates = Vec::with_capacity(ROWS_AT_ONCE);
    let mut outcome = Outcome::default();
    for first in (0..readings.time.len()).step_by(ROWS_AT_ONCE) {
        sensors.clear();
        estimates.clear();
        for row in first..readings.time.len().min(first + ROWS_AT_ONCE) {
            let frame = scene::frame(readings.time[row], &readings.values(row), None);
            let found = estimator.update(&frame);
            outcome.take(row, &found)?;
            estimates.push(found);
            sensors.push(frame);
        }
        let rows_made = sensors.iter().zip(estimates.chunks(1));
        let frames: Vec<Frame<'_>> = rows_made.map(|(s, e)| frame(s, e)).collect();
        rows.push_all(&frames);
    }
    outcome.end()
}

/// A record of readings and their estimates.
pub fn frame<'a>(
    sensors: &'a SensorFrame,
    estimates: &'a [Result<robhaz_estimator::Estimate, robhaz_estimator::EstimateError>],
) -> Frame<'a> {
    Frame {
        time: sensors.time,
        truth: None,
        clearances: None,
        commands: None,
        both: None,
        sensors,
        estimates,
        ground: EstimatedTerrain::default(),
    }
}
