//! The readings of a log by their names, and the frames that they make.

use robhaz_estimator::whole::WholeFrame;
use robhaz_estimator::{LinkReading, SensorFrame};
use robhaz_keys::prelude::{ANGLE, ANGULAR_RATE, Dimension, TORQUE};
use robhaz_model::{BodyMount, BodyReading, Coupling};

/// Names of readings, a line for each sensor or wheel: its name, and what is read of it.
macro_rules! readings {
    ($($of:literal: $($part:literal),*;)*) => { &[$($(concat!($of, "_", $part)),*),*] };
}

/// The readings of a frame, by the columns of the table `sensors`; then those of an IMU in the body
/// and of the angle of pin Q, which may stand in place of those of the links; then those that only a
/// log of both sides has; then what the rates of the links err by where they follow from a joint.
pub(super) const READINGS: &[&str] = readings! {
    "wheel1": "angle", "motor_torque", "contact_angle";
    "wheel2": "angle", "motor_torque", "contact_angle";
    "wheel3": "angle", "motor_torque", "contact_angle";
    "link1": "inclination", "rate";
    "link2": "inclination", "rate";
    "body": "inclination", "rate";
    "pin": "angle";
    "left_wheel1": "angle", "motor_torque", "steering";
    "left_wheel2": "angle", "motor_torque", "steering";
    "left_wheel3": "angle", "motor_torque", "steering";
    "right_wheel1": "angle", "motor_torque", "steering";
    "right_wheel2": "angle", "motor_torque", "steering";
    "right_wheel3": "angle", "motor_torque", "steering";
    "left_pin": "angle";
    "right_pin": "angle";
    "differential": "angle";
    "rear_bogie": "angle";
    "body": "roll", "roll_rate", "yaw_rate";
    "link1": "rate_error";
    "link2": "rate_error";
};

/// A reading of a log, by its place in [`Values`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Reading(usize);

/// Values of all readings, in the order of [`Reading::all`]; `None` where a reading is missing.
pub type Values = [Option<f64>; Reading::COUNT];

impl Reading {
    /// Number of all readings.
    pub const COUNT: usize = READINGS.len();

    /// All readings, those of a frame in the order of its table.
    pub fn all() -> impl Iterator<Item = Self> + Clone {
        (0..Self::COUNT).map(Self)
    }

    /// The reading of a name; `None` where there is none.
    pub fn named(name: &str) -> Option<Self> {
        READINGS.iter().position(|own| *own == name).map(Self)
    }

    /// Those of a frame: of the wheels and of the links.
    pub fn of_frame() -> impl Iterator<Item = Self> + Clone {
        Self::all().filter(|r| r.is_of_body() != Some(true) && !r.is_of_both())
    }

    /// Those that a log of one side needs, with readings of the links, or `of_body` in their place.
    pub fn of_side(of_body: bool) -> impl Iterator<Item = Self> + Clone {
        let has = move |r: &Self| r.is_of_body() != Some(!of_body) && !r.is_of_both();
        Self::all().filter(move |r| has(r) && !r.is_optional())
    }

    /// Those that a log of both sides can have of a rover with this coupling.
    pub fn of_both(coupling: Coupling) -> impl Iterator<Item = Self> + Clone {
        let has = move |r: &Self| !r.is_of_coupling() || r.name() == coupling_angle(coupling);
        Self::of_whole().filter(has)
    }

    /// Those that a log of both sides can have of any rover.
    pub fn of_whole() -> impl Iterator<Item = Self> + Clone {
        Self::all().filter(|r| r.is_of_both() || OF_EITHER.contains(&r.name()))
    }

    /// Its name.
    pub fn name(self) -> &'static str {
        READINGS[self.0]
    }

    /// Its index in [`Values`].
    pub fn index(self) -> usize {
        self.0
    }

    /// Its SI unit.
    pub fn unit(self) -> &'static str {
        self.dimension().0.si()
    }

    /// Its dimension, and the units in which its column may be.
    pub(super) fn dimension(self) -> (&'static Dimension, &'static [&'static str]) {
        const OF_WHEEL: [&str; 7] = ["rad", "deg", "turns", "counts", "rad/s", "deg/s", "rpm"];
        match self.name() {
            name if name.ends_with("_motor_torque") => (TORQUE, &["N m", "mN m", "A", "mA"]),
            name if name.contains("_rate") => (ANGULAR_RATE, &["rad/s", "deg/s"]),
            _ if self.is_wheel_angle() => (ANGLE, &OF_WHEEL),
            _ => (ANGLE, &OF_WHEEL[..4]),
        }
    }

    /// Whether only a log of both sides has it. Inclination and rate of the body belong to either.
    pub fn is_of_both(self) -> bool {
        is_of_both(self.name())
    }

    /// Whether it is of the links, or of the body and pin Q in their place; `None` of the wheels.
    pub fn is_of_body(self) -> Option<bool> {
        is_of_body(self.name())
    }

    /// Whether a log may lack it: the steering of a wheel that is not steered, and what a rate that
    /// follows from a joint errs by.
    pub fn is_optional(self) -> bool {
        self.name().ends_with("_steering") || self.name().ends_with("_rate_error")
    }

    /// Whether it is the angle of what joins both sides, of which a rover has one.
    pub fn is_of_coupling(self) -> bool {
        Coupling::ALL.map(coupling_angle).contains(&self.name())
    }

    /// Whether it is a contact angle.
    pub fn is_contact_angle(self) -> bool {
        self.name().ends_with("_contact_angle")
    }

    /// Whether it is the angle of a wheel, of which a log may have the speed alone.
    pub fn is_wheel_angle(self) -> bool {
        let name = self.name();
        name.contains("wheel") && name.ends_with("_angle") && !self.is_contact_angle()
    }

    /// Whether it is a motor torque.
    pub fn is_torque(self) -> bool {
        self.name().ends_with("_motor_torque")
    }
}

/// The name of the angle of what joins both sides.
pub const fn coupling_angle(coupling: Coupling) -> &'static str {
    match coupling {
        Coupling::Differential => "differential_angle",
        Coupling::RearBogie => "rear_bogie_angle",
    }
}

/// Readings of the body that a log of one side and one of both may have.
const OF_EITHER: [&str; 2] = ["body_inclination", "body_rate"];

/// See [`Reading::is_of_both`]; also of the names of sensors.
pub(super) fn is_of_both(name: &str) -> bool {
    let starts = "left_ right_ differential_ rear_bogie_ body_roll body_yaw";
    starts.split(' ').any(|start| name.starts_with(start))
}

/// See [`Reading::is_of_body`]; also of the names of sensors.
pub(super) fn is_of_body(name: &str) -> Option<bool> {
    let of_body = (name.starts_with("body") || name.starts_with("pin")) && !is_of_both(name);
    (of_body || name.starts_with("link")).then_some(of_body)
}

/// The frame of a time (s) and its readings; with a `mount` the links' are made of the body's.
pub fn frame(time: f64, values: &Values, mount: Option<&mut BodyMount>) -> SensorFrame {
    let wheel = |part: usize| [0, 1, 2].map(|i| values[WHEELS + 3 * i + part]);
    let [link1, link2] = match mount {
        Some(mount) => {
            let [inclination, rate, pin] = BODY.map(|i| values[i]);
            let read = BodyReading {
                inclination,
                rate,
                pin,
                wheels: wheel(0),
            };
            mount.links(time, &read)
        }
        None => [0, 1].map(|i: usize| LinkReading {
            inclination: values[INCLINATION[i]],
            rate: values[RATE[i]],
            rate_error: values[RATE_ERROR[i]].unwrap_or(0.0),
        }),
    };
    SensorFrame {
        time,
        wheel_angle: wheel(0),
        motor_torque: wheel(1),
        link1,
        link2,
        contact_angle: wheel(2),
    }
}

/// The frame of a time (s) of a log of both sides.
pub fn whole_frame(time: f64, values: &Values) -> WholeFrame {
    let wheels = |part: usize| core::array::from_fn(|i| values[BOTH + 3 * i + part]);
    let [left, right, differential, rear_bogie] = [0, 1, 2, 3].map(|k| values[JOINTS + k]);
    let [roll, roll_rate, yaw_rate] = [4, 5, 6].map(|k| values[JOINTS + k]);
    let [inclination, rate, _] = BODY.map(|i| values[i]);
    WholeFrame {
        time,
        wheel_angle: wheels(0),
        motor_torque: wheels(1),
        steering: wheels(2),
        pins: [left, right],
        coupling: differential.or(rear_bogie),
        inclination,
        roll,
        rates: [roll_rate, rate, yaw_rate],
    }
}

/// The place of a reading in [`Values`]. A name that is none does not compile.
const fn place(name: &str) -> usize {
    let (name, mut place) = (name.as_bytes(), 0);
    loop {
        let (found, mut same) = (READINGS[place].as_bytes(), 0);
        while same < name.len() && same < found.len() && found[same] == name[same] {
            same += 1;
        }
        if same == name.len() && same == found.len() {
            return place;
        }
        place += 1;
    }
}

/// Place of the first reading of a wheel, of three each: angle, torque and contact angle.
const WHEELS: usize = place("wheel1_angle");
/// Places of the readings of links 1 and 2.
const INCLINATION: [usize; 2] = [place("link1_inclination"), place("link2_inclination")];
const RATE: [usize; 2] = [place("link1_rate"), place("link2_rate")];
const RATE_ERROR: [usize; 2] = [place("link1_rate_error"), place("link2_rate_error")];
/// Places of inclination and rate of the body, and of the angle of pin Q.
const BODY: [usize; 3] = [
    place("body_inclination"),
    place("body_rate"),
    place("pin_angle"),
];
/// Place of the first reading of both sides: angle, torque and steering of the left front wheel.
const BOTH: usize = place("left_wheel1_angle");
/// Place of the first of its joints and of its body, which `whole_frame` names in their order.
const JOINTS: usize = place("left_pin_angle");
