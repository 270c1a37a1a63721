//! The columns of `sensors`.

use super::column::{Column, Source, Table, WHEEL, column};
use robhaz_estimator::SensorFrame;

impl Table {
    /// `sensors`: the readings, which are all that an estimator sees; empty where a reading was lost.
    pub fn sensors() -> Self {
        let mut columns = vec![column(
            "time",
            "s",
            "time stamp of the sample",
            Source::float(|f| f.sensors.time),
        )];
        for i in 0..3 {
            columns.extend(wheel_readings(i));
        }
        columns.extend([
            of_sensors(
                "link1_inclination",
                "rad",
                "inclinometer on link1, turn from the nominal pose",
                |s| s.link1.inclination,
            ),
            of_sensors("link1_rate", "rad/s", "rate gyroscope on link1", |s| {
                s.link1.rate
            }),
            of_sensors(
                "link2_inclination",
                "rad",
                "inclinometer on link2, turn from the nominal pose",
                |s| s.link2.inclination,
            ),
            of_sensors("link2_rate", "rad/s", "rate gyroscope on link2", |s| {
                s.link2.rate
            }),
        ]);
        Self {
            name: "sensors".to_owned(),
            columns,
        }
    }
}

fn of_sensors(
    name: impl Into<String>,
    unit: &'static str,
    description: impl Into<String>,
    get: impl Fn(&SensorFrame) -> Option<f64> + Send + Sync + 'static,
) -> Column {
    let source = Source::optional(move |f| get(f.sensors));
    column(name, unit, description, source)
}

fn wheel_readings(i: usize) -> [Column; 3] {
    let (n, wheel) = (i + 1, WHEEL[i]);
    [
        of_sensors(
            format!("wheel{n}_angle"),
            "rad",
            format!("{wheel}: encoder, turn against its link, forward positive"),
            move |s| s.wheel_angle[i],
        ),
        of_sensors(
            format!("wheel{n}_motor_torque"),
            "N m",
            format!("{wheel}: motor torque from its current, after the gear, forward positive"),
            move |s| s.motor_torque[i],
        ),
        of_sensors(
            format!("wheel{n}_contact_angle"),
            "rad",
            format!("{wheel}: contact angle gamma as given to the estimators"),
            move |s| s.contact_angle[i],
        ),
    ]
}
