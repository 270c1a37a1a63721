//! Truth from a table: N and T of each wheel, and whatever else the table of a run has.

use crate::stamp::Stamp;
use robhaz_model::{Pin, Vec2};
use robhaz_sim::{BarTruth, Truth, WheelTruth};

/// Columns that a table of the truth must have.
pub fn required() -> Vec<String> {
    let wheels =
        (1..=3).flat_map(|i| ["normal_force", "traction"].map(|c| format!("wheel{i}_{c}")));
    wheels.collect()
}

/// Which rows of a table of the truth can be compared with: those with N and T of every wheel.
#[derive(Clone, Debug, PartialEq)]
pub struct TruthRows {
    /// Number of all rows.
    pub rows: u64,
    /// Number of rows with all required columns.
    pub whole: u64,
    /// Stamps of the first and the last of these.
    pub span: Option<(Stamp, Stamp)>,
    /// Cells of the required columns, and number of rows without each.
    empty: Vec<(usize, u64)>,
}

impl TruthRows {
    /// No rows yet of a table with these columns, among them the required ones.
    pub fn new(columns: &[String]) -> Self {
        let required = required();
        let cells = (0..columns.len()).filter(|i| required.contains(&columns[*i]));
        Self {
            rows: 0,
            whole: 0,
            span: None,
            empty: cells.map(|cell| (cell, 0)).collect(),
        }
    }

    /// Adds a row.
    pub fn add(&mut self, stamp: Stamp, cells: &[Option<f64>]) {
        self.rows += 1;
        let mut is_whole = true;
        for (cell, count) in &mut self.empty {
            if cells.get(*cell).is_none_or(Option::is_none) {
                *count += 1;
                is_whole = false;
            }
        }
        if is_whole {
            self.whole += 1;
            let first = self.span.map_or(stamp, |(first, _)| first);
            self.span = Some((first, stamp));
        }
    }

    /// The required columns that are empty somewhere, with the number of rows, in words.
    pub fn lacks(&self, columns: &[String]) -> String {
        let of_column = |(cell, count): &(usize, u64)| {
            let name = columns.get(*cell).filter(|_| *count > 0)?;
            Some(format!("{name} in {count}"))
        };
        let columns: Vec<String> = self.empty.iter().filter_map(of_column).collect();
        format!(
            "of {} rows there is no number for {}",
            self.rows,
            columns.join(", ")
        )
    }
}

/// Whether a column belongs to the truth. The contacts of a wheel one by one do not: nothing that a
/// log leaves shows them.
pub fn is_column(name: &str) -> bool {
    derived(name).is_some() || place(&mut Truth::default(), name).is_some()
}

/// The truth of a row's cells; `None` where N or T of a wheel is missing: there is nothing to
/// compare with then.
pub fn of_row(columns: &[String], cells: &[Option<f64>]) -> Option<Truth> {
    let mut truth = unknown();
    let mut of_wheels = [[f64::NAN, f64::NAN, 0.0, 1.0]; 3];
    for (name, cell) in columns.iter().zip(cells) {
        let Some(value) = *cell else {
            continue;
        };
        if let Some((wheel, part)) = derived(name) {
            of_wheels[wheel][part] = value;
        } else if let Some(place) = place(&mut truth, name) {
            *place = value;
        }
    }
    for (wheel, [normal_force, angle, sliding, contacts]) in truth.wheels.iter_mut().zip(of_wheels)
    {
        if !(wheel.normal_force.is_finite() && wheel.traction.is_finite()) {
            return None;
        }
        // With two contacts and no equivalent one the force stays unknown, and the record is left
        // out.
        let (sin, cos) = angle.sin_cos();
        let (normal, tangent) = (Vec2::new(-sin, cos), Vec2::new(cos, sin));
        wheel.force = normal * normal_force + tangent * wheel.traction;
        wheel.slides = sliding > 0.0;
        // The cast saturates; a count is small and not negative.
        let count = contacts as u32;
        wheel.contacts = count;
    }
    Some(truth)
}

/// Columns of a wheel that are no number of its truth.
const DERIVED: [&str; 4] = [
    "equivalent_normal_force",
    "equivalent_contact_angle",
    "sliding",
    "contacts",
];

/// Index of a wheel and of one of these columns.
fn derived(column: &str) -> Option<(usize, usize)> {
    let (wheel, part) = numbered(column, "wheel")?;
    Some((wheel, DERIVED.iter().position(|d| *d == part)?))
}

/// Index of a wheel or link, and its quantity in a column such as `wheel1_angle`.
fn numbered<'a>(column: &'a str, kind: &str) -> Option<(usize, &'a str)> {
    let (number, part) = column.strip_prefix(kind)?.split_once('_')?;
    let index = ["1", "2", "3"].iter().position(|n| *n == number)?;
    Some((index, part))
}

/// A truth that nothing is known of: not a number.
fn unknown() -> Truth {
    let nan = f64::NAN;
    let point = Vec2::new(nan, nan);
    let bar = BarTruth {
        position: point,
        angle: nan,
        velocity: point,
        rate: nan,
    };
    let wheel = WheelTruth {
        position: point,
        angle: nan,
        omega: nan,
        torque: nan,
        normal_force: nan,
        traction: nan,
        contact_angle: nan,
        penetration: nan,
        slip_speed: nan,
        ..WheelTruth::default()
    };
    let mut truth = Truth {
        time: nan,
        body: bar,
        links: [bar; 3],
        wheels: [wheel; 3],
        stop_torque: nan,
        loop_error: nan,
        ..Truth::default()
    };
    for pin in &mut truth.pins {
        pin.position = point;
        pin.force = point;
    }
    truth
}

/// The number that a column of the table `truth` holds.
fn place<'a>(truth: &'a mut Truth, column: &str) -> Option<&'a mut f64> {
    if let Some((i, part)) = numbered(column, "wheel") {
        return of_wheel(&mut truth.wheels[i], part);
    }
    if let Some((i, part)) = numbered(column, "link") {
        return of_bar(&mut truth.links[i], part);
    }
    if let Some(part) = column.strip_prefix("pin_") {
        return of_pin(truth, part);
    }
    match column {
        "stop_torque" => Some(&mut truth.stop_torque),
        "loop_error" => Some(&mut truth.loop_error),
        "body_pitch" => Some(&mut truth.body.angle),
        "body_pitch_rate" => Some(&mut truth.body.rate),
        _ => of_bar(&mut truth.body, column.strip_prefix("body_")?),
    }
}

fn of_bar<'a>(bar: &'a mut BarTruth, part: &str) -> Option<&'a mut f64> {
    Some(match part {
        "x" => &mut bar.position.x,
        "y" => &mut bar.position.y,
        "vx" => &mut bar.velocity.x,
        "vy" => &mut bar.velocity.y,
        "angle" => &mut bar.angle,
        "rate" => &mut bar.rate,
        _ => return None,
    })
}

fn of_wheel<'a>(wheel: &'a mut WheelTruth, part: &str) -> Option<&'a mut f64> {
    Some(match part {
        "x" => &mut wheel.position.x,
        "y" => &mut wheel.position.y,
        "angle" => &mut wheel.angle,
        "omega" => &mut wheel.omega,
        "torque" => &mut wheel.torque,
        "normal_force" => &mut wheel.normal_force,
        "traction" => &mut wheel.traction,
        "contact_angle" => &mut wheel.contact_angle,
        "penetration" => &mut wheel.penetration,
        "slip_speed" => &mut wheel.slip_speed,
        _ => return None,
    })
}

fn of_pin<'a>(truth: &'a mut Truth, rest: &str) -> Option<&'a mut f64> {
    let (name, part) = rest.split_once('_')?;
    let index = Pin::ALL.iter().position(|pin| pin.name() == name)?;
    let pin = &mut truth.pins[index];
    Some(match part {
        "x" => &mut pin.position.x,
        "y" => &mut pin.position.y,
        "force_x" => &mut pin.force.x,
        "force_y" => &mut pin.force.y,
        _ => return None,
    })
}
