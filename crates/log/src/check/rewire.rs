//! Channels of a frame, and changes of their wiring: factors, signs and exchanges.

use crate::check::Stated;
use crate::check::stated::of_body;
use robhaz_estimator::SensorFrame;
use std::f64::consts::PI;
use std::fmt;

/// A channel of the frames; wheels and links count from 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Channel {
    Encoder(usize),
    Torque(usize),
    Gyro(usize),
    Inclinometer(usize),
    /// Rate of the body, of which the readings of both links are made.
    BodyRate,
    /// Its inclination.
    BodyInclination,
    /// The angle of pin Q, which gives the readings of the link without the body.
    Pin,
}

impl Channel {
    /// All channels of a log without contact angles: encoders, torques, links.
    pub fn all() -> Vec<Self> {
        let wheels = [Self::Encoder, Self::Torque].map(|of| [0, 1, 2].map(of));
        let links = [0, 1].map(Self::of_link);
        [wheels.as_flattened(), links.as_flattened()].concat()
    }

    /// Gyroscope and inclinometer of a link.
    pub const fn of_link(k: usize) -> [Self; 2] {
        [Self::Gyro(k), Self::Inclinometer(k)]
    }

    /// The channel of the frames that is made of it: of a body, of link 1.
    pub const fn in_frames(self) -> Self {
        match self {
            Self::BodyRate => Self::Gyro(0),
            Self::BodyInclination | Self::Pin => Self::Inclinometer(0),
            own => own,
        }
    }

    /// Whether it is an angle of an inclinometer, which also shows accelerations.
    pub const fn is_inclination(self) -> bool {
        matches!(self, Self::Inclinometer(_) | Self::BodyInclination)
    }

    /// Whether it is the angle of a wheel.
    pub const fn is_encoder(self) -> bool {
        matches!(self, Self::Encoder(_))
    }

    /// Whether it is a torque.
    pub const fn is_torque(self) -> bool {
        matches!(self, Self::Torque(_))
    }

    /// Whether it is a rate.
    pub const fn is_rate(self) -> bool {
        matches!(self, Self::Gyro(_) | Self::BodyRate)
    }

    /// Its reading in a frame.
    fn of(self, frame: &mut SensorFrame) -> &mut Option<f64> {
        match self {
            Self::Encoder(i) => &mut frame.wheel_angle[i],
            Self::Torque(i) => &mut frame.motor_torque[i],
            Self::Gyro(0) => &mut frame.link1.rate,
            Self::Gyro(_) => &mut frame.link2.rate,
            Self::Inclinometer(0) => &mut frame.link1.inclination,
            Self::Inclinometer(_) => &mut frame.link2.inclination,
            of_body => of_body.in_frames().of(frame),
        }
    }

    /// Its value in a frame.
    pub fn value(self, frame: &SensorFrame) -> Option<f64> {
        *self.of(&mut frame.clone())
    }

    /// Its values in frames, a NaN where there is none.
    pub fn values(self, frames: &[SensorFrame]) -> Vec<f64> {
        let value = |frame: &SensorFrame| self.value(frame).unwrap_or(f64::NAN);
        frames.iter().map(value).collect()
    }

    /// The name of its reading.
    pub fn reading(self) -> String {
        let (name, index, part) = match self {
            Self::Encoder(i) => ("wheel", i, "angle"),
            Self::Torque(i) => ("wheel", i, "motor_torque"),
            Self::Gyro(k) => ("link", k, "rate"),
            Self::Inclinometer(k) => ("link", k, "inclination"),
            of_body => return of_body.to_string(),
        };
        format!("{name}{}_{part}", index + 1)
    }

    /// White noise of a sample by the budget, in the reading's unit; 0 for a channel that may be
    /// constant.
    pub fn noise(self, stated: &Stated<'_>) -> f64 {
        let (budget, body) = (&stated.settings.budget, stated.body.unwrap_or_default());
        match self {
            Self::Encoder(_) => 0.0,
            Self::Torque(_) => budget.torque_noise,
            Self::Gyro(_) => budget.rate_noise,
            Self::Inclinometer(_) => budget.inclination_noise,
            Self::BodyRate => body.rate,
            Self::BodyInclination => body.inclination,
            Self::Pin => body.pin,
        }
    }

    /// The same of the other link.
    fn of_other_link(self) -> Self {
        match self {
            Self::Gyro(k) => Self::Gyro(1 - k),
            Self::Inclinometer(k) => Self::Inclinometer(1 - k),
            other => other,
        }
    }
}

impl fmt::Display for Channel {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (name, index) = match self {
            Self::Encoder(i) => ("encoder", i),
            Self::Torque(i) => ("torque", i),
            Self::Gyro(i) => ("gyro", i),
            Self::Inclinometer(i) => ("inclinometer", i),
            Self::BodyRate => return f.write_str("body_rate"),
            Self::BodyInclination => return f.write_str("body_inclination"),
            Self::Pin => return f.write_str("pin_angle"),
        };
        write!(f, "{name} {}", index + 1)
    }
}

/// The wheels that are not at their own place in an order.
pub fn moved(order: [usize; 3]) -> impl Iterator<Item = usize> {
    (0..3).filter(move |i| order[*i] != *i)
}

/// What else fits, as lines of a remedy.
pub fn as_well(words: impl Iterator<Item = String>) -> String {
    words
        .map(|words| format!("\nfits as well: {words}"))
        .collect()
}

/// The names of channels.
pub fn names(channels: impl Iterator<Item = Channel>) -> Vec<String> {
    channels.map(|channel| channel.to_string()).collect()
}

/// Angle and rate of the link of the body, each with that of the other link, where readings of links are made of those
/// of the body.
fn of_body_and_other(stated: &Stated<'_>) -> impl Iterator<Item = [Channel; 2]> {
    let links = stated.body_link().into_iter();
    let channels = links.flat_map(|body| [Channel::Inclinometer(body), Channel::Gyro(body)]);
    channels.map(|own| [own, own.of_other_link()])
}

/// What is done to the readings of a log before further tests.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Change {
    Factor(Channel, f64),
    Exchange(Channel, Channel),
    /// Takes a channel out.
    Remove(Channel),
    /// The sensor of the body is on the other link than stated.
    OtherBody,
    /// The sensor of a link, from 0, hangs upside down: its axis that points forward does.
    UpsideDown(usize),
}

impl Change {
    /// Changes a frame of a log of what is stated.
    pub fn of(self, frame: &mut SensorFrame, stated: &Stated<'_>) {
        let before = *frame;
        match self {
            Self::Factor(Channel::Pin, factor) => {
                for [own, other] in of_body_and_other(stated) {
                    let turned = own.value(&before).zip(other.value(&before));
                    *other.of(frame) = turned.map(|(body, x)| body + factor * (x - body));
                }
            }
            Self::Factor(channel @ (Channel::BodyRate | Channel::BodyInclination), factor) => {
                let links = [&before.link1, &before.link2];
                let number = |x: Option<f64>| x.unwrap_or(f64::NAN);
                let angles = links.map(|link| number(link.inclination));
                let rates = links.map(|link| number(link.rate));
                let [angle, rate] = of_body(stated, angles, rates);
                let of_body = if channel.is_rate() { rate } else { angle };
                // Both links turn with the body.
                let own = channel.in_frames();
                for channel in [own, own.of_other_link()] {
                    let value = channel.value(&before);
                    *channel.of(frame) = value.map(|v| v + (factor - 1.0) * of_body);
                }
            }
            Self::Factor(channel, factor) => {
                *channel.of(frame) = channel.value(&before).map(|v| factor * v);
            }
            Self::Exchange(a, b) => {
                *a.of(frame) = b.value(&before);
                *b.of(frame) = a.value(&before);
            }
            Self::OtherBody => {
                for [own, other] in of_body_and_other(stated) {
                    let read = own.value(&before);
                    *other.of(frame) = read;
                    let turned = read.zip(other.value(&before));
                    *own.of(frame) = turned.map(|(read, x)| 2.0 * read - x);
                }
            }
            Self::Remove(channel) => *channel.of(frame) = None,
            Self::UpsideDown(k) => {
                let (gyro, inclinometer) = (Channel::Gyro(k), Channel::Inclinometer(k));
                *gyro.of(frame) = gyro.value(&before).map(|v| -v);
                let value = inclinometer.value(&before);
                *inclinometer.of(frame) = value.map(|v| PI.copysign(v) - v);
            }
        }
    }
}
