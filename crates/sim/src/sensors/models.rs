//! One model a sensor: its equation, its discrete form, its units.
//!
//! dt is the time since the sample before (s), w a draw from N(0, 1).

use crate::drive::coulomb_sign;
use crate::random::Stream;
use crate::sensors::SensorSpec;
use robhaz_model::{GRAVITY, Vec2, rotate};
use std::f64::consts::TAU;

/// Where an error is drawn from: the run's seed and the sensor's name.
#[derive(Clone, Copy)]
pub(super) struct Source<'a> {
    pub seed: u64,
    pub sensor: &'a str,
}

impl Source<'_> {
    fn stream(self, error: &str) -> Stream {
        Stream::new(self.seed, &format!("{}/{error}", self.sensor))
    }

    /// An error that stays: sigma w, drawn once.
    fn constant(self, error: &str, sigma: f64) -> f64 {
        White::new(self, error, sigma).sample()
    }
}

/// White noise: sigma w. A noise density n (per square root of Hz) sampled at a rate f is sigma = n sqrt(f/2).
#[derive(Clone, Debug)]
pub(super) struct White {
    sigma: f64,
    stream: Stream,
}

impl White {
    pub fn new(source: Source<'_>, error: &str, sigma: f64) -> Self {
        Self {
            sigma,
            stream: source.stream(error),
        }
    }

    pub fn sample(&mut self) -> f64 {
        if self.sigma > 0.0 {
            self.sigma * self.stream.normal()
        } else {
            0.0
        }
    }
}

/// Lost readings: each one with the same probability, whatever happened before.
#[derive(Clone, Debug)]
pub(super) struct Loss {
    share: f64,
    stream: Stream,
}

impl Loss {
    pub fn new(source: Source<'_>, share: f64) -> Self {
        Self {
            share,
            stream: source.stream("dropped"),
        }
    }

    /// The reading, unless it is lost.
    pub fn pass(&mut self, reading: f64) -> Option<f64> {
        let lost = self.share > 0.0 && self.stream.uniform() < self.share;
        (!lost).then_some(reading)
    }
}

/// Encoder on the motor: whole counts c = floor(angle n/(2 pi)), n counts in a turn of the wheel; reads c 2 pi/n, rad.
#[derive(Clone, Debug)]
pub(super) struct Encoder {
    counts: f64,
}

impl Encoder {
    pub fn new(spec: &SensorSpec) -> Self {
        Self {
            counts: spec.encoder_counts,
        }
    }

    pub fn read(&self, angle: f64) -> f64 {
        if self.counts > 0.0 {
            (angle * self.counts / TAU).floor() * (TAU / self.counts)
        } else {
            angle
        }
    }
}

/// Motor torque from the motor's current, N m: q round(((1 + gain)(tau + F sign(omega)) + offset + sigma w)/q).
///
/// F stands for gear friction that the motor overcomes but the plant does not know of: the same motion then takes that much
/// more current. Where the plant has the friction itself, the motor torque tau holds it already.
#[derive(Clone, Debug)]
pub(super) struct TorqueSensor {
    pub gain: f64,
    pub offset: f64,
    noise: White,
    friction: f64,
    step: f64,
}

impl TorqueSensor {
    pub fn new(spec: &SensorSpec, source: Source<'_>) -> Self {
        Self {
            gain: source.constant("gain", spec.torque_gain),
            offset: source.constant("offset", spec.torque_offset),
            noise: White::new(source, "noise", spec.torque_noise),
            friction: spec.torque_friction,
            step: spec.torque_step,
        }
    }

    pub fn read(&mut self, torque: f64, omega: f64) -> f64 {
        let mut held = torque;
        if self.friction > 0.0 {
            held += self.friction * coulomb_sign(omega);
        }
        let read = (1.0 + self.gain) * held + self.offset + self.noise.sample();
        if self.step > 0.0 {
            (read / self.step).round() * self.step
        } else {
            read
        }
    }
}

/// Inclinometer, rad: the direction of the specific force f = a - g in the link's frame, after a low pass on both of its
/// axes, with bias and white noise.
///
/// `df'/dt = (f - f')/lag`, discrete `f' += (1 - exp(-dt/lag))(f - f')`; reads atan2(f'_x, f'_y) + bias + sigma w. Without lag
/// that is theta + atan(a_x/(g + a_y)) + ..., a in world axes. An inclinometer that is not shaken has a = 0.
#[derive(Clone, Debug)]
pub(super) struct Inclinometer {
    pub bias: f64,
    noise: White,
    lag: f64,
    specific_force: bool,
    /// f', m/s^2.
    passed: Option<Vec2>,
}

impl Inclinometer {
    pub fn new(spec: &SensorSpec, source: Source<'_>) -> Self {
        Self {
            bias: source.constant("bias", spec.inclination_bias),
            noise: White::new(source, "noise", spec.inclination_noise),
            lag: spec.inclination_lag,
            specific_force: spec.specific_force,
            passed: None,
        }
    }

    /// `acceleration` is that of the link's centre of mass in world axes, m/s^2.
    pub fn read(&mut self, angle: f64, acceleration: Vec2, dt: f64) -> f64 {
        self.felt(angle, acceleration, dt) + self.bias + self.noise.sample()
    }

    fn felt(&mut self, angle: f64, acceleration: Vec2, dt: f64) -> f64 {
        if !self.specific_force && self.lag <= 0.0 {
            return angle;
        }
        let up = Vec2::new(0.0, GRAVITY);
        let world = if self.specific_force {
            acceleration + up
        } else {
            up
        };
        let now = rotate(world, -angle);
        let passed = match self.passed {
            Some(passed) if self.lag > 0.0 => passed + (now - passed) * -(-dt / self.lag).exp_m1(),
            _ => now,
        };
        self.passed = Some(passed);
        passed.x.atan2(passed.y)
    }
}

/// Rate gyro, rad/s: (1 + scale) rate + b + sigma w, with a bias b that starts at a drawn value and walks,
/// `db = walk dW`, discrete `b += walk sqrt(dt) w`.
#[derive(Clone, Debug)]
pub(super) struct Gyro {
    pub scale: f64,
    pub bias: f64,
    walk: White,
    noise: White,
}

impl Gyro {
    pub fn new(spec: &SensorSpec, source: Source<'_>) -> Self {
        Self {
            scale: source.constant("scale", spec.rate_scale),
            bias: source.constant("bias", spec.rate_bias),
            walk: White::new(source, "walk", spec.rate_walk),
            noise: White::new(source, "noise", spec.rate_noise),
        }
    }

    pub fn read(&mut self, rate: f64, dt: f64) -> f64 {
        self.bias += self.walk.sample() * dt.sqrt();
        (1.0 + self.scale) * rate + self.bias + self.noise.sample()
    }
}

/// Contact angle as given, rad: the true one and an Ornstein-Uhlenbeck error, `de = -e/T dt + sigma sqrt(2/T) dW`; exact
/// discrete form `e = p e + sigma sqrt(1 - p^2) w`, p = exp(-dt/T). It starts in its stationary distribution N(0, sigma^2).
#[derive(Clone, Debug)]
pub(super) struct GivenAngle {
    draw: White,
    time: f64,
    /// e, rad; `None` before the first sample.
    error: Option<f64>,
}

impl GivenAngle {
    pub fn new(spec: &SensorSpec, source: Source<'_>) -> Self {
        Self {
            draw: White::new(source, "error", spec.contact_angle_error),
            time: spec.contact_angle_time,
            error: None,
        }
    }

    pub fn read(&mut self, angle: f64, dt: f64) -> f64 {
        let draw = self.draw.sample();
        let error = match self.error {
            Some(error) if self.time > 0.0 => {
                let kept = (-dt / self.time).exp();
                kept * error + (1.0 - kept * kept).sqrt() * draw
            }
            _ => draw,
        };
        self.error = Some(error);
        angle + error
    }
}
