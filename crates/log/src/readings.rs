//! The readings of a frame by name.

use robhaz_estimator::whole::WholeFrame;
use robhaz_estimator::{LinkReading, SensorFrame};
use robhaz_model::{BodyMount, BodyReading, Coupling, LinkReadings};
use robhaz_scene::{READINGS, is_of_body, is_of_both, is_optional, unit_of};

/// Number of readings of a frame.
pub const COUNT: usize = READINGS.len();

/// Values of all readings, in the order of [`Reading::all`]; `None` where a reading is missing.
pub type Values = [Option<f64>; COUNT];

/// A reading of a frame: its place in [`Values`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Reading(usize);

impl Reading {
    /// All readings, in the order of [`READINGS`].
    pub fn all() -> impl Iterator<Item = Self> {
        (0..COUNT).map(Self)
    }

    /// Those of a frame: of the wheels and of the links.
    pub fn of_frame() -> impl Iterator<Item = Self> {
        Self::all().filter(|r| r.is_of_body() != Some(true) && !r.is_of_both())
    }

    /// Those that a log of both sides can have of a rover with this coupling.
    pub fn of_both(coupling: Coupling) -> impl Iterator<Item = Self> {
        let other = match coupling {
            Coupling::Differential => Self::REAR_BOGIE,
            Coupling::RearBogie => Self::DIFFERENTIAL,
        };
        Self::of_whole().filter(move |r| r.name() != other)
    }

    /// Those that a log of both sides can have of any rover.
    pub fn of_whole() -> impl Iterator<Item = Self> {
        let is_of_body = |name| ["body_inclination", "body_rate"].contains(&name);
        Self::all().filter(move |r| r.is_of_both() || is_of_body(r.name()))
    }

    const DIFFERENTIAL: &str = "differential_angle";
    const REAR_BOGIE: &str = "rear_bogie_angle";

    /// Whether only a log of both sides has it.
    pub fn is_of_both(self) -> bool {
        is_of_both(self.name())
    }

    /// Whether a log may lack it: the steering of a wheel that is not steered, what a rate that follows
    /// from a joint errs by.
    pub fn is_optional(self) -> bool {
        is_optional(self.name())
    }

    /// Whether it is of the links, or of the body and pin Q in their place; `None` of the wheels.
    pub fn is_of_body(self) -> Option<bool> {
        is_of_body(self.name())
    }

    /// Its name.
    pub fn name(self) -> &'static str {
        READINGS[self.0]
    }

    /// Its SI unit.
    pub fn unit(self) -> &'static str {
        unit_of(self.name())
    }

    /// Whether it is a contact angle.
    pub fn is_contact_angle(self) -> bool {
        self.name().ends_with("_contact_angle")
    }

    /// Its index in [`Values`].
    pub fn index(self) -> usize {
        self.0
    }
}

/// The frame of a time (s) and its readings; with a `mount` the links' are made of the body's.
pub fn frame(time: f64, values: &Values, mount: Option<&mut BodyMount>) -> SensorFrame {
    let wheel = |part: usize| [0, 1, 2].map(|i| values[WHEELS + 3 * i + part]);
    let links = match mount {
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
        None => LinkReadings {
            inclination: INCLINATION.map(|i| values[i]),
            rate: RATE.map(|i| values[i]),
            rate_error: RATE_ERROR.map(|i| values[i].unwrap_or(0.0)),
        },
    };
    let [link1, link2] = LinkReading::of(&links);
    SensorFrame {
        time,
        wheel_angle: wheel(0),
        motor_torque: wheel(1),
        link1,
        link2,
        contact_angle: wheel(2),
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

/// The frame of a time (s) of a log of both sides.
pub fn whole_frame(time: f64, values: &Values) -> WholeFrame {
    let wheels = |part: usize| core::array::from_fn(|i| values[BOTH + 3 * i + part]);
    let joint = |k: usize| values[JOINTS + k];
    let [left, right, differential, rear_bogie] = [0, 1, 2, 3].map(joint);
    let [roll, roll_rate, yaw_rate] = [4, 5, 6].map(joint);
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

/// The wheels of one side (0 left, 1 right), without links.
pub fn side_frame(whole: &WholeFrame, side: usize) -> SensorFrame {
    let of = |wheels: &[Option<f64>; 6]| [0, 1, 2].map(|i| wheels[3 * side + i]);
    SensorFrame {
        time: whole.time,
        wheel_angle: of(&whole.wheel_angle),
        motor_torque: of(&whole.motor_torque),
        ..SensorFrame::default()
    }
}
