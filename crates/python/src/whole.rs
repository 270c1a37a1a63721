//! An estimator of a rover with both sides, for one frame at a time or a whole table.

use crate::error::{Outcome, check_sides, invalid, of_frame, of_scene, warn};
use crate::estimator::{frame, seconds};
use crate::readings::{Readings, Source, known};
use crate::table::Table;

use pyo3::prelude::*;
use robhaz_estimator::SensorFrame;
use robhaz_estimator::whole::{WholeEstimate as Found, WholeFrame};
use robhaz_model::Coupling;
use robhaz_record::Table as Columns;
use robhaz_run::{BothFrame, BothSides, Frame};
use robhaz_scene::{LogChoice, Reading, whole_frame};

use std::path::PathBuf;

type Six = (f64, f64, f64, f64, f64, f64);

/// See the stub `_robhaz.pyi`.
#[pyclass(module = "robhaz")]
pub struct WholeEstimator {
    name: String,
    coupling: Coupling,
    inner: robhaz_estimator::whole::WholeEstimator,
}

#[pymethods]
impl WholeEstimator {
    #[new]
    #[pyo3(signature = (robot, *, sensors=None))]
    fn new(py: Python<'_>, robot: PathBuf, sensors: Option<PathBuf>) -> PyResult<Self> {
        let described = LogChoice::default().described(sensors.as_deref(), Some(&robot));
        let (mut choice, notice) = described.map_err(of_scene)?;
        check_sides(&choice, true)?;
        choice.select(&["kalman".to_owned()]).map_err(invalid)?;
        choice.keep_one_of_both(true).map_err(invalid)?;
        let (Some(rover), Some(kalman)) = (choice.robot.whole_rover(), choice.estimators.first())
        else {
            return Err(invalid(format!(
                "robot: found {} without [robot.across], allowed: a robot file that states what lies across",
                robot.display()
            )));
        };
        let settings = choice.settings(kalman);
        let inner = robhaz_estimator::whole::WholeEstimator::new(&rover, settings, choice.pin);
        if let Some(notice) = notice {
            warn(py, notice)?;
        }
        Ok(Self {
            name: kalman.name.clone(),
            coupling: rover.coupling,
            inner: inner.map_err(invalid)?,
        })
    }

    #[pyo3(signature = (time, wheel_angle, motor_torque, pins, coupling, inclination, roll, rates, steering=None))]
    #[expect(
        clippy::too_many_arguments,
        reason = "the readings of a frame, by name"
    )]
    fn update(
        &mut self,
        time: &Bound<'_, PyAny>,
        wheel_angle: [Option<f64>; 6],
        motor_torque: [Option<f64>; 6],
        pins: [Option<f64>; 2],
        coupling: Option<f64>,
        inclination: Option<f64>,
        roll: Option<f64>,
        rates: [Option<f64>; 3],
        steering: Option<[Option<f64>; 6]>,
    ) -> PyResult<WholeEstimate> {
        let frame = WholeFrame {
            time: seconds(time)?,
            wheel_angle: wheel_angle.map(known),
            motor_torque: motor_torque.map(known),
            steering: steering.unwrap_or_default().map(known),
            pins: pins.map(known),
            coupling: known(coupling),
            inclination: known(inclination),
            roll: known(roll),
            rates: rates.map(known),
        };
        Ok(self.inner.update(&frame).map_err(of_frame)?.into())
    }

    fn estimate(&mut self, py: Python<'_>, readings: &Bound<'_, PyAny>) -> PyResult<Table> {
        let source = Source::of(readings)?;
        let mut columns: Vec<Reading> = Reading::of_both(self.coupling).collect();
        // What one side has, too, comes last: a table without both lacks the others first.
        columns.sort_by_key(|reading| !reading.is_of_both());
        let readings = Readings::of(source, columns, Reading::is_optional)?;
        let inner = &mut self.inner;
        Table::of(Columns::estimate_of_both(&self.name), |rows| {
            py.detach(|| {
                let mut outcome = Outcome::default();
                for row in 0..readings.time.len() {
                    let readings = whole_frame(readings.time[row], &readings.values(row));
                    let found = inner.update(&readings);
                    outcome.take(row, &found)?;
                    let time = readings.time;
                    let sides = BothSides {
                        readings,
                        truth: None,
                    };
                    let both = BothFrame {
                        sides: &sides,
                        estimate: found.as_ref().ok(),
                    };
                    let sensors = SensorFrame {
                        time,
                        ..SensorFrame::default()
                    };
                    rows.push_all(&[Frame {
                        both: Some(both),
                        ..frame(&sensors, &[])
                    }]);
                }
                outcome.end()
            })
        })
    }
}

/// See the stub `_robhaz.pyi`.
#[pyclass(frozen, get_all, module = "robhaz")]
pub struct WholeEstimate {
    time: f64,
    normal_force: Six,
    normal_force_sigma: Six,
    in_plane_normal_force_sigma: Six,
    covariance: [[f64; 6]; 6],
    traction: Six,
    traction_sigma: Six,
    needed_friction: [Option<f64>; 6],
    inclination: f64,
    roll: f64,
    lateral_force: f64,
    axial_share: f64,
    tip_margin: f64,
    tip_line: &'static str,
    dragged: bool,
    misfit: f64,
    flags: Vec<&'static str>,
}

impl From<Found> for WholeEstimate {
    fn from(found: Found) -> Self {
        let six = |sigma: fn(&Found, usize) -> Option<f64>| -> [f64; 6] {
            std::array::from_fn(|i| sigma(&found, i).unwrap_or(f64::NAN))
        };
        Self {
            time: found.time,
            normal_force: found.normal_force.into(),
            normal_force_sigma: six(Found::sigma_normal).into(),
            in_plane_normal_force_sigma: six(Found::sigma_in_plane).into(),
            covariance: found.covariance,
            traction: found.traction.into(),
            traction_sigma: six(Found::sigma_traction).into(),
            needed_friction: std::array::from_fn(|i| found.needed_friction(i)),
            inclination: found.attitude[0],
            roll: found.attitude[1],
            lateral_force: found.lateral_force,
            axial_share: found.axial_share,
            tip_margin: found.tip_margin,
            tip_line: found.tip_line.name(),
            dragged: found.dragged,
            misfit: found.misfit,
            flags: found.flags().names().collect(),
        }
    }
}

#[pymethods]
impl WholeEstimate {
    fn __repr__(&self) -> String {
        let (a, b, c, d, e, f) = self.normal_force;
        let n = [a, b, c, d, e, f].map(|v| format!("{v:.2}")).join(", ");
        format!("<robhaz.WholeEstimate {} s: N = [{n}] N>", self.time)
    }
}
