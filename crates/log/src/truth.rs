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

/// Whether a column belongs to the truth. The contacts of a wheel one by one do not: nothing that a log leaves shows them.
pub fn is_column(name: &str) -> bool {
    equivalent_part(name).is_some() || set(&mut Truth::default(), name, 0.0)
}

/// The truth of a row's cells; `None` where N or T of a wheel is missing: there is nothing to compare with then.
pub fn of_row(columns: &[String], cells: &[Option<f64>]) -> Option<Truth> {
    let mut truth = unknown();
    // N and angle of the equivalent contact of each wheel.
    let mut equivalent = [[f64::NAN; 2]; 3];
    for (name, cell) in columns.iter().zip(cells) {
        let Some(value) = *cell else {
            continue;
        };
        if let Some((wheel, part)) = equivalent_part(name) {
            equivalent[wheel][part] = value;
        } else {
            set(&mut truth, name, value);
        }
    }
    for (wheel, [normal_force, angle]) in truth.wheels.iter_mut().zip(equivalent) {
        if !(wheel.normal_force.is_finite() && wheel.traction.is_finite()) {
            return None;
        }
        // With two contacts and no equivalent one the force stays unknown, and the record is left out.
        let (sin, cos) = angle.sin_cos();
        let (normal, tangent) = (Vec2::new(-sin, cos), Vec2::new(cos, sin));
        wheel.force = normal * normal_force + tangent * wheel.traction;
    }
    Some(truth)
}

/// Wheel and quantity of a column of an equivalent contact: N 0, angle 1.
fn equivalent_part(column: &str) -> Option<(usize, usize)> {
    let (wheel, part) = column.split_once("_equivalent_")?;
    let wheel = ["wheel1", "wheel2", "wheel3"]
        .iter()
        .position(|w| *w == wheel)?;
    let part = ["normal_force", "contact_angle"]
        .iter()
        .position(|p| *p == part)?;
    Some((wheel, part))
}

/// A truth that nothing is known of: not a number, and one contact a wheel.
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
        contacts: 1,
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

/// Sets the quantity that a column of the table `truth` holds; false for another column.
fn set(truth: &mut Truth, column: &str, value: f64) -> bool {
    let place = match column {
        "stop_torque" => Some(&mut truth.stop_torque),
        "loop_error" => Some(&mut truth.loop_error),
        _ => match column.split_once('_') {
            Some(("body", rest)) => of_bar(&mut truth.body, rest, "pitch", "pitch_rate"),
            Some(("link1", rest)) => of_bar(&mut truth.links[0], rest, "angle", "rate"),
            Some(("link2", rest)) => of_bar(&mut truth.links[1], rest, "angle", "rate"),
            Some(("link3", rest)) => of_bar(&mut truth.links[2], rest, "angle", "rate"),
            Some(("wheel1", rest)) => return set_wheel(&mut truth.wheels[0], rest, value),
            Some(("wheel2", rest)) => return set_wheel(&mut truth.wheels[1], rest, value),
            Some(("wheel3", rest)) => return set_wheel(&mut truth.wheels[2], rest, value),
            Some(("pin", rest)) => of_pin(truth, rest),
            _ => None,
        },
    };
    place.map(|place| *place = value).is_some()
}

fn of_bar<'a>(bar: &'a mut BarTruth, part: &str, angle: &str, rate: &str) -> Option<&'a mut f64> {
    match part {
        "x" => Some(&mut bar.position.x),
        "y" => Some(&mut bar.position.y),
        "vx" => Some(&mut bar.velocity.x),
        "vy" => Some(&mut bar.velocity.y),
        part if part == angle => Some(&mut bar.angle),
        part if part == rate => Some(&mut bar.rate),
        _ => None,
    }
}

fn set_wheel(wheel: &mut WheelTruth, part: &str, value: f64) -> bool {
    let place = match part {
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
        "sliding" => {
            wheel.slides = value > 0.0;
            return true;
        }
        "contacts" => {
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "the cast saturates; a count is small and not negative"
            )]
            let count = value as u32;
            wheel.contacts = count;
            return true;
        }
        _ => return false,
    };
    *place = value;
    true
}

fn of_pin<'a>(truth: &'a mut Truth, rest: &str) -> Option<&'a mut f64> {
    let (name, part) = rest.split_once('_')?;
    let index = Pin::ALL.iter().position(|pin| pin.name() == name)?;
    let pin = &mut truth.pins[index];
    match part {
        "x" => Some(&mut pin.position.x),
        "y" => Some(&mut pin.position.y),
        "force_x" => Some(&mut pin.force.x),
        "force_y" => Some(&mut pin.force.y),
        _ => None,
    }
}
