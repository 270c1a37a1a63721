//! The columns of `truth`.

use super::column::{
    Column, Source, Table, WHEEL, column, of_truth, pin_force_description, time_of_record,
};
use robhaz_model::Pin;
use robhaz_sim::{ContactTruth, WheelTruth};

impl Table {
    /// `truth`: motion and forces of the simulation.
    pub fn truth() -> Self {
        let mut columns = vec![time_of_record()];
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
        columns.push(column(
            "clearance",
            "m",
            "least distance of body and links to the ground; at 0 or below one touches it, and its force is not modelled",
            Source::optional(|f| Some(f.clearances?.least().1)),
        ));
        (0..3).for_each(|i| columns.extend(contacts_truth(i)));
        Self {
            name: "truth".to_owned(),
            columns,
        }
    }
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
        column(
            "normal_force",
            "N",
            "normal force N; two contacts: magnitude of the vector sum of their normal forces",
            |w| w.normal_force,
        ),
        column(
            "traction",
            "N",
            "traction T, driving forward positive; two contacts: the sum",
            |w| w.traction,
        ),
        column(
            "contact_angle",
            "rad",
            "contact angle gamma, slope of the ground at the contact; two contacts: perpendicular to the vector sum of their \
             normal forces",
            |w| w.contact_angle,
        ),
        column(
            "penetration",
            "m",
            "penetration into the ground, the larger one; in the air the gap, negative",
            |w| w.penetration,
        ),
        column(
            "slip_speed",
            "m/s",
            "slip speed, positive when the rim outruns the ground; two contacts: of the deeper one",
            |w| w.slip_speed,
        ),
    ];
    columns.push(super::column::column(
        format!("{wheel}_contacts"),
        "1",
        format!("{}: number of contacts", WHEEL[i]),
        Source::count_of_truth(move |t| t.wheels[i].contacts),
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

/// A column of a wheel's truth that is empty in some records.
fn of_wheel(
    i: usize,
    part: &str,
    unit: &'static str,
    description: &str,
    get: impl Fn(&WheelTruth) -> Option<f64> + Send + Sync + 'static,
) -> Column {
    column(
        format!("wheel{}_{part}", i + 1),
        unit,
        format!("{}: {description}", WHEEL[i]),
        Source::optional_of_truth(move |t| get(&t.wheels[i])),
    )
}

/// The equivalent contact, whether the wheel slides, and its contacts one by one.
fn contacts_truth(i: usize) -> Vec<Column> {
    let mut columns = vec![
        of_wheel(
            i,
            "equivalent_normal_force",
            "N",
            "N of the equivalent contact, which has the same force on the axle and the same T as all contacts together; errors \
             of the estimates refer to it; empty where there is none",
            |w| w.equivalent_contact().map(|c| c.normal_force),
        ),
        of_wheel(
            i,
            "equivalent_contact_angle",
            "rad",
            "contact angle of the equivalent contact; empty where there is none",
            |w| w.equivalent_contact().map(|c| c.angle),
        ),
        column(
            format!("wheel{}_sliding", i + 1),
            "1",
            format!(
                "{}: 1 if it slides: the slip of each of its contacts is beyond the peak of the friction law; otherwise 0",
                WHEEL[i]
            ),
            Source::count_of_truth(move |t| u32::from(t.wheels[i].slides)),
        ),
    ];
    type Part = (
        &'static str,
        &'static str,
        &'static str,
        fn(&ContactTruth) -> f64,
    );
    const PARTS: [Part; 7] = [
        ("x", "m", "point of the ground, forward", |c| c.point.x),
        ("y", "m", "point of the ground, up", |c| c.point.y),
        (
            "angle",
            "rad",
            "slope of its tangent; the normal is 90 deg counter-clockwise from it",
            |c| (-c.normal.x).atan2(c.normal.y),
        ),
        ("normal_force", "N", "normal force", |c| c.normal_force),
        ("traction", "N", "traction, driving forward positive", |c| {
            c.traction
        }),
        ("penetration", "m", "penetration", |c| c.penetration),
        (
            "slip_speed",
            "m/s",
            "slip speed, positive when the rim outruns the ground",
            |c| c.slip_speed,
        ),
    ];
    for (k, which) in ["first (rear) contact", "second (front) contact"]
        .into_iter()
        .enumerate()
    {
        for (part, unit, description, get) in PARTS {
            columns.push(of_wheel(
                i,
                &format!("contact{}_{part}", k + 1),
                unit,
                &format!("{which}: {description}; empty without it"),
                move |w| w.contact_list.get(k).map(get),
            ));
        }
    }
    columns
}
