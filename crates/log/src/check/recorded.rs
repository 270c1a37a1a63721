//! The channels of the links as they were recorded: gyroscopes and inclinometers of the links, or
//! an inertial sensor in the body and the angle of pin Q, of which readings of links were made.

use crate::check::stated::of_body;
use crate::check::{Channel, Recording, Stated};
use robhaz_estimator::SensorFrame;

/// Change of a reading of the body, as it follows from those of the links, that is rounding: rad,
/// rad/s.
pub const ROUNDING: f64 = 1e-12;

/// A channel as it was recorded.
#[derive(Clone, Debug)]
pub struct Recorded {
    pub channel: Channel,
    /// White noise of a sample by the budget, in its unit; 0 of an encoder.
    pub noise: f64,
    /// Its readings, a NaN where there is none.
    pub values: Vec<f64>,
}

impl Recorded {
    /// Those of the encoders, the torques and the links, or the body, in frames.
    pub fn of_frames(frames: &[SensorFrame], stated: &Stated<'_>) -> Vec<Self> {
        let values = |channel: Channel| channel.values(frames);
        let encoders = [0, 1, 2].map(Channel::Encoder).into_iter();
        let encoders = encoders.map(|channel| Self::new(channel, stated, values(channel)));
        encoders.chain(Self::all(stated, values)).collect()
    }

    /// Those of the torques and the links, or the body, of a recording, at its equal steps, from
    /// sample 0 to `end`. Each gyroscope is followed by its inclinometer.
    pub fn of_recording(recording: &Recording, end: usize, stated: &Stated<'_>) -> Vec<Self> {
        Self::all(stated, |channel| {
            let values = recording.samples(channel);
            values[..end.min(values.len())].to_vec()
        })
    }

    fn new(channel: Channel, stated: &Stated<'_>, values: Vec<f64>) -> Self {
        Self {
            channel,
            noise: channel.noise(stated),
            values,
        }
    }

    fn all(stated: &Stated<'_>, values: impl Fn(Channel) -> Vec<f64>) -> Vec<Self> {
        let of = |channel: Channel| Self::new(channel, stated, values(channel));
        let mut all: Vec<Self> = [0, 1, 2].map(Channel::Torque).map(of).into();
        if stated.body.is_none() {
            let of_links = [0, 1].map(Channel::of_link).into_iter().flatten();
            all.extend(of_links.map(of));
            return all;
        }
        let [inclination, rate] =
            [Channel::Inclinometer, Channel::Gyro].map(|of| [0, 1].map(|k| values(of(k))));
        let channels = [Channel::BodyRate, Channel::BodyInclination, Channel::Pin];
        let values = body(stated, &inclination, &rate);
        let of = |(channel, values)| Self::new(channel, stated, values);
        all.extend(channels.into_iter().zip(values).map(of));
        all
    }
}

/// Rate and inclination of the body and the angle of pin Q, from which [`robhaz_model::BodyMount`] has
/// made those of the links, rad/s, rad.
pub fn body(
    stated: &Stated<'_>,
    inclination: &[Vec<f64>; 2],
    rate: &[Vec<f64>; 2],
) -> [Vec<f64>; 3] {
    let mut found = [const { Vec::new() }; 3];
    for k in 0..inclination[0].len() {
        let angles = inclination.each_ref().map(|x| x[k]);
        let [angle, rate] = of_body(stated, angles, rate.each_ref().map(|x| x[k]));
        let values = [rate, angle, angles[0] - angles[1]];
        found.iter_mut().zip(values).for_each(|(of, x)| of.push(x));
    }
    found
}
