//! The channels of the links as they were recorded: gyroscopes and inclinometers of the links, or
//! an inertial sensor in the body and the angle of pin Q, of which readings of the links were made.

use crate::check::recording::Recording;
use crate::check::rewire::Channel;
use crate::check::stated::{BodyNoise, Stated, of_body};
use robhaz_estimator::SensorFrame;

/// Change of a reading of the body, as it follows from those of the links, that is rounding: rad,
/// rad/s.
pub const ROUNDING: f64 = 1e-12;

/// What a channel measures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// The angle of a wheel, rad.
    Encoder,
    /// An angle of an inclinometer, which also shows accelerations, rad.
    Inclination,
    /// A rate, rad/s.
    Rate,
    /// The angle between the links at pin Q, rad.
    Pin,
    /// A torque, N m.
    Torque,
}

/// A channel: its readings, a NaN where there is none.
#[derive(Clone, Debug)]
pub struct Recorded {
    /// Name of the channel, or of the reading.
    pub name: String,
    /// The channel; of a reading of the body or of pin Q one that is made of it.
    pub channel: Channel,
    pub kind: Kind,
    /// White noise of a sample by the budget, in its unit; 0 of an encoder.
    pub noise: f64,
    pub values: Vec<f64>,
}

/// Readings of the body.
#[derive(Clone, Debug, Default)]
pub struct OfBody {
    /// Its inclination, rad.
    pub inclination: Vec<f64>,
    /// Its rate, rad/s.
    pub rate: Vec<f64>,
    /// Angle of pin Q, rad.
    pub pin: Vec<f64>,
}

impl OfBody {
    /// The readings of the body from which [`robhaz_model::BodyMount`] has made those of the links.
    fn new(stated: &Stated<'_>, inclination: &[Vec<f64>; 2], rate: &[Vec<f64>; 2]) -> Self {
        let mut found = Self::default();
        for k in 0..inclination[0].len() {
            let angles = inclination.each_ref().map(|x| x[k]);
            let [angle, rate] = of_body(stated, angles, rate.each_ref().map(|x| x[k]));
            found.inclination.push(angle);
            found.rate.push(rate);
            found.pin.push(angles[0] - angles[1]);
        }
        found
    }

    /// Those of a recording.
    pub fn of(recording: &Recording, stated: &Stated<'_>) -> Self {
        Self::new(stated, &recording.inclination, &recording.rate)
    }

    fn into_recorded(self, noise: BodyNoise) -> Vec<Recorded> {
        let (rate, angle) = (Channel::Gyro(0), Channel::Inclinometer(0));
        let of = |name: &str, channel, kind, noise, values| Recorded {
            name: name.to_owned(),
            channel,
            kind,
            noise,
            values,
        };
        let (inclination, of_angle) = (Kind::Inclination, noise.inclination);
        vec![
            of("body_rate", rate, Kind::Rate, noise.rate, self.rate),
            of(
                "body_inclination",
                angle,
                inclination,
                of_angle,
                self.inclination,
            ),
            of("pin_angle", angle, Kind::Pin, noise.pin, self.pin),
        ]
    }
}

/// The channels of the links of a log, or of the body, by samples that `values` gives.
fn channels(stated: &Stated<'_>, values: impl Fn(Channel) -> Vec<f64>) -> Vec<Recorded> {
    let [gyro, inclinometer] = [Channel::Gyro, Channel::Inclinometer];
    if let Some(noise) = stated.body {
        let inclination = [0, 1].map(|k| values(inclinometer(k)));
        let rate = [0, 1].map(|k| values(gyro(k)));
        return OfBody::new(stated, &inclination, &rate).into_recorded(noise);
    }
    let of_link = |k: usize| [gyro(k), inclinometer(k)];
    let all = [of_link(0), of_link(1)].into_iter().flatten();
    all.map(|channel| of_channel(channel, stated, values(channel)))
        .collect()
}

fn of_channel(channel: Channel, stated: &Stated<'_>, values: Vec<f64>) -> Recorded {
    Recorded {
        name: channel.to_string(),
        channel,
        kind: match channel {
            Channel::Encoder(_) => Kind::Encoder,
            Channel::Torque(_) => Kind::Torque,
            Channel::Gyro(_) => Kind::Rate,
            Channel::Inclinometer(_) => Kind::Inclination,
        },
        noise: channel.noise(&stated.budget),
        values,
    }
}

impl Recorded {
    /// Those of the encoders, the torques and the links, or the body, in frames.
    pub fn of_frames(frames: &[SensorFrame], stated: &Stated<'_>) -> Vec<Self> {
        let values = |channel: Channel| {
            let value = |f: &SensorFrame| channel.value(f).unwrap_or(f64::NAN);
            frames.iter().map(value).collect::<Vec<f64>>()
        };
        let encoders = [0, 1, 2].map(Channel::Encoder).into_iter();
        let encoders = encoders.map(|channel| of_channel(channel, stated, values(channel)));
        encoders.chain(Self::all(stated, values)).collect()
    }

    /// Those of the torques and the links, or the body, of a recording, at its equal steps, from
    /// sample 0 to `end`.
    pub fn of_recording(recording: &Recording, end: usize, stated: &Stated<'_>) -> Vec<Self> {
        let values = |channel: Channel| {
            let values = match channel {
                Channel::Encoder(i) => &recording.wheel_angle[i],
                Channel::Torque(i) => &recording.torque[i],
                Channel::Gyro(k) => &recording.rate[k],
                Channel::Inclinometer(k) => &recording.inclination[k],
            };
            values[..end.min(values.len())].to_vec()
        };
        Self::all(stated, values)
    }

    fn all(stated: &Stated<'_>, values: impl Fn(Channel) -> Vec<f64>) -> Vec<Self> {
        let torque = |i: usize| of_channel(Channel::Torque(i), stated, values(Channel::Torque(i)));
        let torques = [0, 1, 2].map(torque);
        torques
            .into_iter()
            .chain(channels(stated, &values))
            .collect()
    }
}
