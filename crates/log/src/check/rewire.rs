//! Channels of a frame, and changes of their wiring: factors, signs and exchanges.

use crate::check::report::Finding;
use robhaz_estimator::SensorFrame;
use std::fmt;

/// A channel of the frames; wheels and links count from 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Channel {
    Encoder(usize),
    Torque(usize),
    Gyro(usize),
    Inclinometer(usize),
}

impl Channel {
    /// All channels of a log without contact angles.
    pub const ALL: [Self; 10] = [
        Self::Encoder(0),
        Self::Encoder(1),
        Self::Encoder(2),
        Self::Torque(0),
        Self::Torque(1),
        Self::Torque(2),
        Self::Gyro(0),
        Self::Inclinometer(0),
        Self::Gyro(1),
        Self::Inclinometer(1),
    ];

    /// Its reading in a frame.
    pub fn of(self, frame: &mut SensorFrame) -> &mut Option<f64> {
        let [link1, link2] = [&mut frame.link1, &mut frame.link2];
        match self {
            Self::Encoder(i) => &mut frame.wheel_angle[i],
            Self::Torque(i) => &mut frame.motor_torque[i],
            Self::Gyro(0) => &mut link1.rate,
            Self::Gyro(_) => &mut link2.rate,
            Self::Inclinometer(0) => &mut link1.inclination,
            Self::Inclinometer(_) => &mut link2.inclination,
        }
    }

    /// Its value in a frame.
    pub fn value(self, frame: &SensorFrame) -> Option<f64> {
        *self.of(&mut frame.clone())
    }

    /// The same of the other link.
    fn of_other_link(self) -> Self {
        match self {
            Self::Gyro(k) => Self::Gyro(1 - k),
            Self::Inclinometer(k) => Self::Inclinometer(1 - k),
            other => other,
        }
    }

    /// Whether both measure the same quantity.
    pub fn is_like(self, other: Self) -> bool {
        std::mem::discriminant(&self) == std::mem::discriminant(&other)
    }
}

impl fmt::Display for Channel {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (name, index) = match self {
            Self::Encoder(i) => ("encoder", i),
            Self::Torque(i) => ("torque", i),
            Self::Gyro(i) => ("gyro", i),
            Self::Inclinometer(i) => ("inclinometer", i),
        };
        write!(f, "{name} {}", index + 1)
    }
}

/// What is done to the readings of a log before further tests.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Change {
    Factor(Channel, f64),
    Exchange(Channel, Channel),
    /// The sign of one kind of readings of the body, of which those of both links are made. Number of
    /// the link with the body, from 0; the gyroscope or the inclinometer of that link.
    Body(Channel),
    /// The sign of the angle of pin Q, which gives the readings of the link without the body. Number
    /// of the link with the body, from 0.
    Pin(usize),
}

impl Change {
    /// Changes a frame.
    fn of(self, frame: &mut SensorFrame) {
        match self {
            Self::Factor(channel, factor) => {
                let value = channel.of(frame);
                *value = value.map(|v| factor * v);
            }
            Self::Body(channel) => {
                let Some(value) = channel.value(frame) else {
                    return;
                };
                let other = channel.of_other_link().of(frame);
                *other = other.map(|x| x - 2.0 * value);
                *channel.of(frame) = Some(-value);
            }
            Self::Pin(body) => {
                let (body, other) = match body {
                    0 => (frame.link1, &mut frame.link2),
                    _ => (frame.link2, &mut frame.link1),
                };
                let turn = |of_body: Option<f64>, x: &mut Option<f64>| {
                    *x = of_body.zip(*x).map(|(body, x)| 2.0 * body - x);
                };
                turn(body.inclination, &mut other.inclination);
                turn(body.rate, &mut other.rate);
            }
            Self::Exchange(a, b) => {
                let (x, y) = (a.value(frame), b.value(frame));
                *a.of(frame) = y;
                *b.of(frame) = x;
            }
        }
    }

    /// The frames with all changes, one after the other.
    pub fn all(changes: &[Self], frames: &[SensorFrame]) -> Vec<SensorFrame> {
        let mut frames = frames.to_vec();
        for frame in &mut frames {
            changes.iter().for_each(|change| change.of(frame));
        }
        frames
    }
}

impl fmt::Display for Change {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Factor(channel, factor) if *factor < 0.0 => {
                write!(f, "change the sign of {channel}")
            }
            Self::Factor(channel, factor) => write!(f, "{channel} times {factor:.4}"),
            Self::Exchange(a, b) => write!(f, "exchange {a} and {b}"),
            Self::Body(channel) => write!(f, "turn round sign of {channel} of the body"),
            Self::Pin(_) => write!(f, "turn round sign of reading.pin_angle"),
        }
    }
}

/// Findings, and the changes that they ask for: further tests see the readings with them.
#[derive(Default)]
pub struct Tested {
    pub findings: Vec<Finding>,
    pub changes: Vec<Change>,
}

impl Tested {
    /// Adds a finding, with the changes that it asks for.
    pub fn add(&mut self, finding: Finding, changes: impl IntoIterator<Item = Change>) {
        self.findings.push(finding);
        self.changes.extend(changes);
    }
}
