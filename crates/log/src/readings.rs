//! The readings of a frame by name.

use robhaz_estimator::{LinkReading, SensorFrame};
use robhaz_model::{BodyMount, BodyReading, LinkReadings};
use robhaz_scene::{READINGS, is_of_body};

/// Number of readings of a frame.
pub const COUNT: usize = READINGS.len();

/// Values of all readings, in the order of [`Reading::all`]; `None` where a reading is missing.
pub type Values = [Option<f64>; COUNT];

/// A reading of a frame: its place in [`Values`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Reading(usize);

impl Reading {
    /// All readings, in the order of the table `sensors`.
    pub fn all() -> impl Iterator<Item = Self> {
        (0..COUNT).map(Self)
    }

    /// Those of a frame: of the wheels and of the links.
    pub fn of_frame() -> impl Iterator<Item = Self> {
        Self::all().filter(|reading| reading.is_of_body() != Some(true))
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
        match self.name() {
            name if name.ends_with("_motor_torque") => "N m",
            name if name.ends_with("_rate") => "rad/s",
            _ => "rad",
        }
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
    let wheel = |part: usize| [0, 1, 2].map(|i| values[3 * i + part]);
    let links = match mount {
        Some(mount) => {
            let [.., inclination, rate, pin] = *values;
            let wheels = wheel(0);
            mount.links(
                time,
                &BodyReading {
                    inclination,
                    rate,
                    pin,
                    wheels,
                },
            )
        }
        None => LinkReadings {
            inclination: [values[9], values[11]],
            rate: [values[10], values[12]],
        },
    };
    let link = |i: usize| LinkReading {
        inclination: links.inclination[i],
        rate: links.rate[i],
    };
    SensorFrame {
        time,
        wheel_angle: wheel(0),
        motor_torque: wheel(1),
        link1: link(0),
        link2: link(1),
        contact_angle: wheel(2),
    }
}
