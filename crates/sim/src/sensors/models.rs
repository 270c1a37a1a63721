//! One model per sensor: its equation, discrete form and units.
//!
//! dt is the time since the previous sample (s), w a draw from N(0, 1).

use crate::drive::coulomb_sign;
use crate::random::Stream;
use crate::sensors::SensorSpec;
use robhaz_model::{Robot, Vec2, rotate};
use std::f64::consts::TAU;

/// Key of a sensor's random streams: the run's seed and the sensor's name.
#[derive(Clone, Copy)]
pub(super) struct Source<'a> {
    pub seed: u64,
    pub sensor: &'a str,
}

impl Source<'_> {
    fn stream(self, error: &str) -> Stream {
        Stream::new(self.seed, &format!("{}/{error}", self.sensor))
    }

    /// A constant error: sigma w, drawn once.
    pub fn constant(self, error: &str, sigma: f64) -> f64 {
        White::new(self, error, sigma).sample()
    }
}

/// White noise, sigma w. A noise density n (unit/sqrt(Hz)) gives sigma = n sqrt(f/2) at a sampling
/// rate f (Hz).
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

/// Lost readings: each reading is lost with the same probability, independently of all others.
#[derive(Clone, Debug)]
pub(super) struct Loss {
    probability: f64,
    stream: Stream,
}

impl Loss {
    pub fn new(source: Source<'_>, probability: f64) -> Self {
        Self {
            probability,
            stream: source.stream("dropped"),
        }
    }

    /// The reading, unless it is lost.
    pub fn pass(&mut self, reading: f64) -> Option<f64> {
        let lost = self.probability > 0.0 && self.stream.uniform() < self.probability;
        (!lost).then_some(reading)
    }
}

/// Encoder on the motor with n counts per turn of the wheel: counts c = floor(angle n/(2 pi)),
/// reading 2 pi c/n, rad.
#[derive(Clone, Debug)]
pub(super) struct Encoder(pub f64);

impl Encoder {
    pub fn read(&self, angle: f64) -> f64 {
        if self.0 > 0.0 {
            (angle * self.0 / TAU).floor() * (TAU / self.0)
        } else {
            angle
        }
    }
}

/// Motor torque from the motor's current, N m: q round(((1 + gain)(tau + F sign(omega)) + offset +
/// sigma w)/q), with the step q of the reading (N m); no rounding for q = 0.
///
/// F is Coulomb friction in the gear that the reading contains although the plant does not model
/// it: the motor needs more current for the same motion. Friction that the plant models itself is
/// already part of the motor torque tau.
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
        let mut motor = torque;
        if self.friction > 0.0 {
            motor += self.friction * coulomb_sign(omega);
        }
        let read = (1.0 + self.gain) * motor + self.offset + self.noise.sample();
        if self.step > 0.0 {
            (read / self.step).round() * self.step
        } else {
            read
        }
    }
}

/// Inclinometer, rad: the direction of the specific force f = a - g in the link's frame, after a
/// low pass on both components, with bias and white noise.
///
/// `df'/dt = (f - f')/lag`, discrete `f' += (1 - exp(-dt/lag))(f - f')`; the reading is atan2(f'_x,
/// f'_y) + bias + sigma w. Without the low pass that is theta + atan(a_x/(g + a_y)) + bias + sigma
/// w, with a in world axes. If `specific_force` is off, a = 0.
#[derive(Clone, Debug)]
pub(super) struct Inclinometer {
    pub bias: f64,
    noise: White,
    lag: f64,
    specific_force: bool,
    /// Acceleration of free fall, m/s^2.
    gravity: f64,
    /// f', m/s^2; `None` before the first sample.
    filtered: Option<Vec2>,
}

impl Inclinometer {
    pub fn new(spec: &SensorSpec, source: Source<'_>, robot: &Robot) -> Self {
        Self {
            bias: source.constant("bias", spec.inclination_bias),
            noise: White::new(source, "noise", spec.inclination_noise),
            lag: spec.inclination_lag,
            specific_force: spec.specific_force,
            gravity: robot.gravity,
            filtered: None,
        }
    }

    /// Reading at the link's `angle` (rad), with the acceleration of its centre of mass in world
    /// axes (m/s^2).
    pub fn read(&mut self, angle: f64, acceleration: Vec2, dt: f64) -> f64 {
        self.direction(angle, acceleration, dt) + self.bias + self.noise.sample()
    }

    /// Direction of the filtered specific force, rad, without bias and noise.
    fn direction(&mut self, angle: f64, acceleration: Vec2, dt: f64) -> f64 {
        if !self.specific_force && self.lag <= 0.0 {
            return angle;
        }
        let up = Vec2::new(0.0, self.gravity);
        let world = if self.specific_force {
            acceleration + up
        } else {
            up
        };
        let now = rotate(world, -angle);
        let filtered = match self.filtered {
            Some(filtered) if self.lag > 0.0 => {
                filtered + (now - filtered) * -(-dt / self.lag).exp_m1()
            }
            _ => now,
        };
        self.filtered = Some(filtered);
        filtered.x.atan2(filtered.y)
    }
}

/// Rate gyro, rad/s: (1 + scale) rate + b + sigma w. The bias b starts at a drawn value and follows
/// a random walk, `db = walk dW`, discrete `b += walk sqrt(dt) w`.
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

/// Contact angle as given, rad: the true angle plus an Ornstein-Uhlenbeck error,
/// `de = -e/T dt + sigma sqrt(2/T) dW`; exact discrete form `e = p e + sigma sqrt(1 - p^2) w`, p =
/// exp(-dt/T). The first e is drawn from the stationary distribution N(0, sigma^2). For T = 0 the
/// error is white noise.
#[derive(Clone, Debug)]
pub(super) struct GivenAngle {
    draw: White,
    /// Correlation time T, s.
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
