//! The columns of every table, each declared once: name, unit, meaning, and where its value comes from.

use robhaz_estimator::{Estimate, SensorFrame};
use robhaz_model::{Bar, Pin};
use robhaz_run::Frame;
use robhaz_scene::Scene;
use robhaz_sim::Truth;

/// One value of a column.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Value {
    /// A measure in the column's unit.
    Float(f64),
    /// A measure in the column's unit that can be missing: a lost reading, no estimate, or one that is not finite.
    Optional(Option<f64>),
    /// A count.
    Count(u32),
}

/// Which kind of [`Value`] a column holds, always the same.
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

enum Source {
    Float(Get<f64>),
    Optional(Get<Option<f64>>),
    Count(Get<u32>),
}

/// A column of a table.
pub struct Column {
    /// Its name, fixed: scripts rely on it.
    pub name: String,
    /// Its unit, SI; `1` where it has none.
    pub unit: &'static str,
    /// What it holds, in a few words.
    pub description: String,
    source: Source,
}

impl Column {
    /// This column's value in a record.
    pub fn value(&self, frame: &Frame<'_>) -> Value {
        match &self.source {
            Source::Float(get) => Value::Float(get(frame)),
            Source::Optional(get) => Value::Optional(get(frame).filter(|v| v.is_finite())),
            Source::Count(get) => Value::Count(get(frame)),
        }
    }

    /// Which kind of values it holds.
    pub fn kind(&self) -> Kind {
        match self.source {
            Source::Float(_) => Kind::Float,
            Source::Optional(_) => Kind::Optional,
            Source::Count(_) => Kind::Count,
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
    /// All tables of a scene: `truth`, `sensors`, and one for each estimator.
    pub fn all(scene: &Scene) -> Vec<Self> {
        let mut tables = vec![Self::truth(), Self::sensors()];
        for (index, estimator) in scene.estimators.iter().enumerate() {
            tables.push(Self::estimate(index, &estimator.name));
        }
        tables
    }

    /// `truth`: what truly happens.
    pub fn truth() -> Self {
        let mut columns = vec![of_truth("time", "s", "time since the start", |t| t.time)];
        columns.extend(body_truth());
        (0..3).for_each(|i| columns.extend(link_truth(i)));
        (0..3).for_each(|i| columns.extend(wheel_truth(i)));
        Pin::ALL
            .iter()
            .for_each(|&pin| columns.extend(pin_truth(pin)));
        columns.push(of_truth(
            "stop_torque",
            "N m",
            "torque of the end stops in Q on link1",
            |t| t.stop_torque,
        ));
        columns.push(of_truth(
            "loop_error",
            "m",
            "how far the four-bar's loop has drifted open in the simulation",
            |t| t.loop_error,
        ));
        Self {
            name: "truth".to_owned(),
            columns,
        }
    }

    /// `sensors`: what the sensors read, and so all that an estimator sees; empty where a reading was lost.
    pub fn sensors() -> Self {
        let mut columns = vec![column(
            "time",
            "s",
            "time stamp of the sample",
            Source::Float(Box::new(|f| f.sensors.time)),
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

    /// `estimate-NAME`: what the scene's estimator number `index` (from 0) makes of the readings.
    pub fn estimate(index: usize, name: &str) -> Self {
        // The record's own time, so that a row without an estimate still says when.
        let mut columns = vec![of_truth("time", "s", "time since the start", |t| t.time)];
        (0..3).for_each(|wheel| columns.extend(wheel_estimate(index, wheel)));
        columns.extend(linkage_estimate(index));
        columns.extend(residuals(index));
        columns.extend(sureness(index));
        Self {
            name: format!("estimate-{name}"),
            columns,
        }
    }
}

const WHEEL: [&str; 3] = ["front wheel", "middle wheel", "rear wheel"];

fn column(
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

fn of_truth(
    name: impl Into<String>,
    unit: &'static str,
    description: impl Into<String>,
    get: impl Fn(&Truth) -> f64 + Send + Sync + 'static,
) -> Column {
    let source = Source::Float(Box::new(move |f| get(f.truth)));
    column(name, unit, description, source)
}

fn of_sensors(
    name: impl Into<String>,
    unit: &'static str,
    description: impl Into<String>,
    get: impl Fn(&SensorFrame) -> Option<f64> + Send + Sync + 'static,
) -> Column {
    let source = Source::Optional(Box::new(move |f| get(f.sensors)));
    column(name, unit, description, source)
}

fn of_estimate(
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

fn body_truth() -> [Column; 6] {
    [
        of_truth("body_x", "m", "body's centre of mass, forward", |t| {
            t.body.position.x
        }),
        of_truth("body_y", "m", "body's centre of mass, up", |t| {
            t.body.position.y
        }),
        of_truth(
            "body_pitch",
            "rad",
            "body's pitch from the nominal pose, nose up positive",
            |t| t.body.angle,
        ),
        of_truth(
            "body_vx",
            "m/s",
            "velocity of the body's centre of mass, forward",
            |t| t.body.velocity.x,
        ),
        of_truth(
            "body_vy",
            "m/s",
            "velocity of the body's centre of mass, up",
            |t| t.body.velocity.y,
        ),
        of_truth("body_pitch_rate", "rad/s", "body's pitch rate", |t| {
            t.body.rate
        }),
    ]
}

fn link_truth(i: usize) -> [Column; 6] {
    let link = format!("link{}", i + 1);
    let column = |part: &str, unit, description: &str, get: fn(&robhaz_sim::BarTruth) -> f64| {
        of_truth(
            format!("{link}_{part}"),
            unit,
            format!("{link}: {description}"),
            move |t| get(&t.links[i]),
        )
    };
    [
        column(
            "angle",
            "rad",
            "turn from the nominal pose, counter-clockwise",
            |b| b.angle,
        ),
        column("x", "m", "centre of mass, forward", |b| b.position.x),
        column("y", "m", "centre of mass, up", |b| b.position.y),
        column(
            "vx",
            "m/s",
            "velocity of the centre of mass, forward",
            |b| b.velocity.x,
        ),
        column("vy", "m/s", "velocity of the centre of mass, up", |b| {
            b.velocity.y
        }),
        column("rate", "rad/s", "angular rate, counter-clockwise", |b| {
            b.rate
        }),
    ]
}

fn wheel_truth(i: usize) -> Vec<Column> {
    let wheel = format!("wheel{}", i + 1);
    let column = |part: &str, unit, description: &str, get: fn(&robhaz_sim::WheelTruth) -> f64| {
        of_truth(
            format!("{wheel}_{part}"),
            unit,
            format!("{}: {description}", WHEEL[i]),
            move |t| get(&t.wheels[i]),
        )
    };
    let mut columns = vec![
        column("x", "m", "centre, forward", |w| w.position.x),
        column("y", "m", "centre, up", |w| w.position.y),
        column(
            "angle",
            "rad",
            "turn against its link since the start, forward positive",
            |w| w.angle,
        ),
        column(
            "omega",
            "rad/s",
            "speed against its link, forward positive",
            |w| w.omega,
        ),
        column(
            "torque",
            "N m",
            "motor torque at the wheel, forward positive",
            |w| w.torque,
        ),
        column("normal_force", "N", "normal force N", |w| w.normal_force),
        column(
            "traction",
            "N",
            "traction T, driving forward positive",
            |w| w.traction,
        ),
        column(
            "contact_angle",
            "rad",
            "contact angle gamma, slope of the ground at the contact",
            |w| w.contact_angle,
        ),
        column(
            "penetration",
            "m",
            "penetration into the ground; in the air the gap, negative",
            |w| w.penetration,
        ),
        column(
            "slip_speed",
            "m/s",
            "slip speed, positive when the rim outruns the ground",
            |w| w.slip_speed,
        ),
    ];
    columns.push(self::column(
        format!("{wheel}_contacts"),
        "1",
        format!("{}: number of contacts", WHEEL[i]),
        Source::Count(Box::new(move |f| f.truth.wheels[i].contacts)),
    ));
    columns
}

fn pin_truth(pin: Pin) -> [Column; 4] {
    let p = pin.name();
    let letter = p.to_uppercase();
    let force = pin_force_description(pin);
    [
        of_truth(
            format!("pin_{p}_x"),
            "m",
            format!("pin {letter}, forward"),
            move |t| t.pin(pin).position.x,
        ),
        of_truth(
            format!("pin_{p}_y"),
            "m",
            format!("pin {letter}, up"),
            move |t| t.pin(pin).position.y,
        ),
        of_truth(
            format!("pin_{p}_force_x"),
            "N",
            format!("{force}, forward"),
            move |t| t.pin(pin).force.x,
        ),
        of_truth(
            format!("pin_{p}_force_y"),
            "N",
            format!("{force}, up"),
            move |t| t.pin(pin).force.y,
        ),
    ]
}

fn pin_force_description(pin: Pin) -> String {
    let (receiver, giver) = pin.bars();
    format!(
        "force in pin {} on {} from {}",
        pin.name().to_uppercase(),
        Bar::name(receiver),
        Bar::name(giver)
    )
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

fn wheel_estimate(index: usize, i: usize) -> [Column; 3] {
    let (n, wheel) = (i + 1, WHEEL[i]);
    [
        of_estimate(
            index,
            format!("wheel{n}_normal_force"),
            "N",
            format!("{wheel}: normal force N"),
            move |e| Some(e.normal_force[i]),
        ),
        of_estimate(
            index,
            format!("wheel{n}_traction"),
            "N",
            format!("{wheel}: traction T, driving forward positive"),
            move |e| Some(e.traction[i]),
        ),
        of_estimate(
            index,
            format!("wheel{n}_friction_coefficient"),
            "1",
            format!("{wheel}: friction coefficient in use, mu_n = T/N; empty where N <= 0"),
            move |e| (e.normal_force[i] > 0.0).then(|| e.traction[i] / e.normal_force[i]),
        ),
    ]
}

fn linkage_estimate(index: usize) -> Vec<Column> {
    let mut columns = vec![of_estimate(
        index,
        "body_pitch",
        "rad",
        "body's pitch from the nominal pose, nose up positive",
        |e| Some(e.posture.body),
    )];
    for i in 0..3 {
        let link = format!("link{}", i + 1);
        columns.push(of_estimate(
            index,
            format!("{link}_angle"),
            "rad",
            format!("{link}: turn from the nominal pose, counter-clockwise"),
            move |e| Some(e.posture.links[i]),
        ));
    }
    // Q from Q is nothing to tell.
    for (k, pin) in Pin::ALL.into_iter().enumerate() {
        if pin != Pin::Q {
            columns.extend(pin_from_q_estimate(index, k, pin));
        }
    }
    for (k, pin) in Pin::ALL.into_iter().enumerate() {
        columns.extend(pin_force_estimate(index, k, pin));
    }
    columns
}

fn pin_from_q_estimate(index: usize, k: usize, pin: Pin) -> [Column; 2] {
    let p = pin.name();
    let letter = p.to_uppercase();
    [
        of_estimate(
            index,
            format!("pin_{p}_from_q_x"),
            "m",
            format!("pin {letter} from pin Q, forward"),
            move |e| Some(e.pin_from_q[k].x),
        ),
        of_estimate(
            index,
            format!("pin_{p}_from_q_y"),
            "m",
            format!("pin {letter} from pin Q, up"),
            move |e| Some(e.pin_from_q[k].y),
        ),
    ]
}

fn pin_force_estimate(index: usize, k: usize, pin: Pin) -> [Column; 2] {
    let p = pin.name();
    let force = pin_force_description(pin);
    [
        of_estimate(
            index,
            format!("pin_{p}_force_x"),
            "N",
            format!("{force}, forward"),
            move |e| Some(e.pin_force[k].x),
        ),
        of_estimate(
            index,
            format!("pin_{p}_force_y"),
            "N",
            format!("{force}, up"),
            move |e| Some(e.pin_force[k].y),
        ),
    ]
}

fn residuals(index: usize) -> [Column; 4] {
    let column = |row: usize, name: &str, unit, what: &str| {
        of_estimate(
            index,
            name,
            unit,
            format!("what is left of eq. (8): {what}"),
            move |e| Some(e.residual[row]),
        )
    };
    [
        column(0, "residual_force_x", "N", "horizontal force"),
        column(1, "residual_force_y", "N", "vertical force"),
        column(2, "residual_moment_link1", "N m", "moment of link1 about Q"),
        column(3, "residual_moment_link2", "N m", "moment of link2 about Q"),
    ]
}

/// What an estimator knows of its own errors; empty for one that does not.
fn sureness(index: usize) -> Vec<Column> {
    let mut columns = vec![
        of_estimate(
            index,
            "parity",
            "N",
            "the redundancy of eq. (8), zero for consistent forces",
            |e| e.parity.map(|p| p.value),
        ),
        of_estimate(
            index,
            "parity_sigma",
            "N",
            "standard deviation expected of the parity residual; empty without covariance",
            |e| e.parity.filter(|_| e.covariance.is_some()).map(|p| p.sigma),
        ),
        of_estimate(
            index,
            "flags",
            "1",
            "warnings, a bit each: wheels 1 to 3 unloaded 1, 2, 4; linkage at a stop 8; reading missing 16, stale 32, absurd 64; \
             out of the model's range 128",
            |e| Some(f64::from(e.flags.bits())),
        ),
    ];
    for (i, wheel) in WHEEL.into_iter().enumerate() {
        let name = |what: &str| format!("wheel{}_{what}", i + 1);
        columns.push(of_estimate(
            index,
            name("normal_force_sigma"),
            "N",
            format!("{wheel}: standard deviation of N; empty without covariance"),
            move |e| e.sigma_normal(i),
        ));
        columns.push(of_estimate(
            index,
            name("traction_sigma"),
            "N",
            format!("{wheel}: standard deviation of T; empty without covariance"),
            move |e| e.sigma_traction(i),
        ));
        columns.push(of_estimate(
            index,
            name("torque_offset"),
            "N m",
            format!("{wheel}: offset found of the motor torque read; empty without Kalman filters"),
            move |e| e.reading_errors.map(|r| r.torque_offset[i].0),
        ));
        columns.push(of_estimate(
            index,
            name("contact_angle_error"),
            "rad",
            format!(
                "{wheel}: error found of the contact angle given; empty without Kalman filters"
            ),
            move |e| e.reading_errors.map(|r| r.contact_angle[i].0),
        ));
    }
    columns.push(of_estimate(
        index,
        "gear_friction",
        "N m",
        "dry friction found in the gears, common to all; empty without Kalman filters",
        |e| e.reading_errors.map(|r| r.gear_friction.0),
    ));
    columns
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{failed_frame, frame_of, good_estimate};
    use std::collections::HashSet;

    fn names(table: &Table) -> Vec<&str> {
        table.columns.iter().map(|c| c.name.as_str()).collect()
    }

    /// Scripts and notebooks rely on these names and their order.
    #[test]
    fn names_of_the_truth_are_fixed() {
        let mut golden: Vec<String> = [
            "time",
            "body_x",
            "body_y",
            "body_pitch",
            "body_vx",
            "body_vy",
            "body_pitch_rate",
        ]
        .map(String::from)
        .to_vec();
        for n in 1..=3 {
            for part in ["angle", "x", "y", "vx", "vy", "rate"] {
                golden.push(format!("link{n}_{part}"));
            }
        }
        for n in 1..=3 {
            for part in [
                "x",
                "y",
                "angle",
                "omega",
                "torque",
                "normal_force",
                "traction",
                "contact_angle",
                "penetration",
                "slip_speed",
                "contacts",
            ] {
                golden.push(format!("wheel{n}_{part}"));
            }
        }
        for pin in ["p", "q", "r", "s"] {
            for part in ["x", "y", "force_x", "force_y"] {
                golden.push(format!("pin_{pin}_{part}"));
            }
        }
        golden.extend(["stop_torque", "loop_error"].map(String::from));
        assert_eq!(names(&Table::truth()), golden);
    }

    #[test]
    fn names_of_the_readings_are_fixed() {
        let golden = "time wheel1_angle wheel1_motor_torque wheel1_contact_angle wheel2_angle wheel2_motor_torque \
            wheel2_contact_angle wheel3_angle wheel3_motor_torque wheel3_contact_angle link1_inclination link1_rate \
            link2_inclination link2_rate";
        assert_eq!(
            names(&Table::sensors()),
            golden.split_whitespace().collect::<Vec<_>>()
        );
    }

    #[test]
    fn names_of_an_estimate_are_fixed() {
        let golden = "time wheel1_normal_force wheel1_traction wheel1_friction_coefficient wheel2_normal_force \
            wheel2_traction wheel2_friction_coefficient wheel3_normal_force wheel3_traction \
            wheel3_friction_coefficient body_pitch link1_angle link2_angle link3_angle pin_p_from_q_x pin_p_from_q_y \
            pin_r_from_q_x pin_r_from_q_y pin_s_from_q_x pin_s_from_q_y pin_p_force_x pin_p_force_y pin_q_force_x \
            pin_q_force_y pin_r_force_x pin_r_force_y pin_s_force_x pin_s_force_y residual_force_x residual_force_y \
            residual_moment_link1 residual_moment_link2 parity parity_sigma flags \
            wheel1_normal_force_sigma wheel1_traction_sigma wheel1_torque_offset wheel1_contact_angle_error \
            wheel2_normal_force_sigma wheel2_traction_sigma wheel2_torque_offset wheel2_contact_angle_error \
            wheel3_normal_force_sigma wheel3_traction_sigma wheel3_torque_offset wheel3_contact_angle_error gear_friction";
        let table = Table::estimate(0, "paper-body");
        assert_eq!(table.name, "estimate-paper-body");
        assert_eq!(names(&table), golden.split_whitespace().collect::<Vec<_>>());
    }

    /// No name twice, no column without a meaning, only units that are meant.
    #[test]
    fn every_column_is_told_apart_and_explained() {
        let units = ["1", "s", "m", "m/s", "rad", "rad/s", "N", "N m"];
        for table in [Table::truth(), Table::sensors(), Table::estimate(0, "a")] {
            let mut seen = HashSet::new();
            for column in &table.columns {
                assert!(seen.insert(column.name.clone()), "{} twice", column.name);
                assert!(column.description.len() > 3, "{}", column.name);
                assert!(
                    units.contains(&column.unit),
                    "{}: {}",
                    column.name,
                    column.unit
                );
            }
        }
    }

    fn value(table: &Table, name: &str, frame: &Frame<'_>) -> Value {
        let column = table
            .columns
            .iter()
            .find(|c| c.name == name)
            .expect("a column of that name");
        column.value(frame)
    }

    /// Wheels, pins and axes are not swapped on their way into the table.
    #[test]
    fn values_come_from_the_field_that_the_name_says() {
        let record = frame_of(1.0);
        let frame = record.frame();
        let truth = Table::truth();
        let pin_s = record.truth.pins[3];
        for (name, expected) in [
            ("wheel2_normal_force", record.truth.wheels[1].normal_force),
            ("link3_vy", record.truth.links[2].velocity.y),
            ("pin_s_force_x", pin_s.force.x),
            ("pin_s_y", pin_s.position.y),
        ] {
            assert_eq!(
                value(&truth, name, &frame),
                Value::Float(expected),
                "{name}"
            );
        }
        assert_eq!(value(&truth, "wheel3_contacts", &frame), Value::Count(1));
        let estimate = good_estimate(&record.truth, 2.0);
        assert_eq!(
            value(
                &Table::estimate(0, "a"),
                "wheel3_friction_coefficient",
                &frame
            ),
            Value::Optional(Some(estimate.traction[2] / estimate.normal_force[2]))
        );
    }

    /// An estimate that failed leaves gaps, but its row keeps the time.
    #[test]
    fn a_failed_estimate_is_nothing_not_a_number() {
        let record = failed_frame(1.0);
        let frame = record.frame();
        let table = Table::estimate(0, "a");
        assert_eq!(table.columns[0].value(&frame), Value::Float(1.0));
        for column in &table.columns[1..] {
            assert_eq!(
                column.value(&frame),
                Value::Optional(None),
                "{}",
                column.name
            );
        }
    }

    /// A lost reading is a gap in its own column alone.
    #[test]
    fn a_lost_reading_is_nothing_not_a_number() {
        let mut record = frame_of(1.0);
        record.sensors.motor_torque[1] = None;
        let frame = record.frame();
        let table = Table::sensors();
        assert_eq!(value(&table, "time", &frame), Value::Float(1.0));
        for column in &table.columns[1..] {
            let lost = column.value(&frame) == Value::Optional(None);
            assert_eq!(
                lost,
                column.name == "wheel2_motor_torque",
                "{}",
                column.name
            );
        }
    }

    /// T/N has no meaning without a load.
    #[test]
    fn a_wheel_without_load_has_no_friction_coefficient() {
        for load in [0.0, -1.0] {
            let mut record = frame_of(1.0);
            if let Some(Ok(estimate)) = record.estimates.first_mut() {
                estimate.normal_force[0] = load;
            }
            assert_eq!(
                value(
                    &Table::estimate(0, "a"),
                    "wheel1_friction_coefficient",
                    &record.frame()
                ),
                Value::Optional(None)
            );
        }
    }
}
