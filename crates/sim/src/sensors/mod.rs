//! Models of the robot's sensors: readings from the truth.
//!
//! | sensor | errors | model |
//! |---|---|---|
//! | encoder, each wheel | quantisation | whole counts of the motor's encoder |
//! | motor torque, each wheel | gain, offset, gear friction, white noise, quantisation | from the motor's current |
//! | inclinometer, links 1 and 2 | specific force, low pass, bias, white noise | direction of the specific force |
//! | rate gyro, links 1 and 2 | scale, bias with random walk, white noise | angular rate of the link |
//! | or both in the body, and the angle of pin Q | the same; bias, white noise | [`BodyMount`] makes readings of the links of them |
//! | contact angle, each wheel | Ornstein-Uhlenbeck process | not a sensor: the paper assumes known angles (1) |
//! | all | jitter of the sampling time (not for contact angles), lost readings | |
//!
//! (1) That of the equivalent contact ([`crate::WheelTruth::equivalent_contact`]), with which eq.
//! (8) holds also for a wheel with two contacts. Where no single contact is equivalent,
//! `contact_angle` of the truth.
//!
//! `models.rs` holds the equations, [`SensorSpec`] the parameters, [`Grade`] named sets of
//! parameters.

mod models;
mod spec;
#[cfg(test)]
mod tests;

pub use spec::{ENCODER_COUNTS, Grade, ImuPlace, SensorSpec};

use crate::truth::{BarTruth, Truth};
use models::{Encoder, GivenAngle, Gyro, Inclinometer, Loss, Source, TorqueSensor, White};
use robhaz_model::{Bar, BodyMount, BodyReading, LinkReading, Robot, SensorFrame, Vec2};

/// Errors that are drawn once per run and sensor.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct DrawnErrors {
    /// Relative gain error of each torque reading, -.
    pub torque_gain: [f64; 3],
    /// Offset of each torque reading, N m.
    pub torque_offset: [f64; 3],
    /// Bias of the inclinometers on links 1 and 2, rad.
    pub inclination_bias: [f64; 2],
    /// Bias of the gyros on links 1 and 2 at the start, rad/s.
    pub rate_bias: [f64; 2],
    /// Relative scale error of the gyros, -.
    pub rate_scale: [f64; 2],
}

/// All sensors of the robot. Deterministic: the same specification, seed and truths give the same
/// bits.
#[derive(Clone, Debug)]
pub struct Sensors {
    wheels: [WheelSensors; 3],
    links: [LinkSensors; 2],
    /// In place of inclinometers and gyros of the links.
    body: Option<BodySensors>,
    jitter: White,
    drawn: DrawnErrors,
    /// The truth of the previous sample.
    last: Option<Truth>,
}

#[derive(Clone, Debug)]
struct WheelSensors {
    encoder: (Encoder, Loss),
    torque: (TorqueSensor, Loss),
    contact_angle: (GivenAngle, Loss),
}

#[derive(Clone, Debug)]
struct BodySensors {
    imu: LinkSensors,
    pin: (White, f64, Loss),
    mount: BodyMount,
}

#[derive(Clone, Debug)]
struct LinkSensors {
    inclinometer: (Inclinometer, Loss),
    gyro: (Gyro, Loss),
}

impl Sensors {
    /// The sensors of a run on a robot, under its gravity; those of links 1 and 2 are in its body
    /// if the specification says so. Draws the constant errors from `seed`.
    pub fn new(spec: &SensorSpec, seed: u64, robot: &Robot) -> Self {
        let wheels = ["wheel1", "wheel2", "wheel3"].map(|name| WheelSensors::new(spec, seed, name));
        let links = ["link1", "link2"].map(|name| LinkSensors::new(spec, seed, name, robot));
        let in_body = spec.imu == ImuPlace::Body;
        let body = in_body.then(|| BodySensors::new(spec, seed, robot));
        let torques = wheels.each_ref().map(|w| &w.torque.0);
        let imus = body.as_ref().map_or(links.each_ref(), |b| [&b.imu; 2]);
        let gyros = imus.map(|imu| &imu.gyro.0);
        let drawn = DrawnErrors {
            torque_gain: torques.map(|t| t.gain),
            torque_offset: torques.map(|t| t.offset),
            inclination_bias: imus.map(|imu| imu.inclinometer.0.bias),
            rate_bias: gyros.map(|g| g.bias),
            rate_scale: gyros.map(|g| g.scale),
        };
        let sensor = "clock";
        Self {
            jitter: White::new(Source { seed, sensor }, "jitter", spec.jitter),
            wheels,
            links,
            body,
            drawn,
            last: None,
        }
    }

    /// The errors drawn for this run.
    pub fn drawn(&self) -> &DrawnErrors {
        &self.drawn
    }

    /// Readings of the next sample, those of the links by their own sensors or by those in the body; a
    /// lost reading is missing. Motor torques are from the current: losses in the gear are not
    /// subtracted. The time of the sample must be later than that of the previous one.
    ///
    /// With jitter, a sample is taken at a delay of sigma w (negative: early) but stamped with the
    /// nominal time; its values are extrapolated by their rates. Accelerations and the rate of the
    /// torque are differences from the previous sample over the time between (0 at the first
    /// sample). Contact angles have no jitter.
    pub fn read(&mut self, truth: &Truth) -> SensorFrame {
        let rates = Rates::since(self.last.as_ref(), truth);
        self.last = Some(*truth);
        let delay = self.jitter.sample();
        let (wheels, links) = (&mut self.wheels, &mut self.links);
        let wheel_angle = [0, 1, 2].map(|i| {
            let (encoder, loss) = &mut wheels[i].encoder;
            let wheel = &truth.wheels[i];
            loss.pass(encoder.read(wheel.angle + delay * wheel.omega))
        });
        let [link1, link2] = match &mut self.body {
            Some(body) => body.read(truth, &rates, delay, wheel_angle),
            None => [0, 1].map(|i| links[i].read(&truth.links[i], &rates, i, delay)),
        };
        SensorFrame {
            time: truth.time,
            wheel_angle,
            motor_torque: [0, 1, 2].map(|i| {
                let (sensor, loss) = &mut wheels[i].torque;
                let wheel = &truth.wheels[i];
                let torque = wheel.torque + delay * rates.torque[i];
                loss.pass(sensor.read(torque, wheel.omega))
            }),
            link1,
            link2,
            contact_angle: [0, 1, 2].map(|i| {
                let (angle, loss) = &mut wheels[i].contact_angle;
                let wheel = &truth.wheels[i];
                let known = wheel.equivalent_contact();
                loss.pass(angle.read(known.map_or(wheel.contact_angle, |c| c.angle), rates.dt))
            }),
        }
    }
}

/// A sensor of this name, and the loss of its readings.
fn lossy<S>(
    spec: &SensorSpec,
    seed: u64,
    name: &str,
    sensor: impl FnOnce(&SensorSpec, Source<'_>) -> S,
) -> (S, Loss) {
    let source = Source { seed, sensor: name };
    (sensor(spec, source), Loss::new(source, spec.dropped))
}

impl WheelSensors {
    fn new(spec: &SensorSpec, seed: u64, wheel: &str) -> Self {
        let name = |sensor: &str| format!("{wheel}/{sensor}");
        Self {
            encoder: lossy(spec, seed, &name("encoder"), |spec, _| {
                Encoder(spec.encoder_counts)
            }),
            torque: lossy(spec, seed, &name("torque"), TorqueSensor::new),
            contact_angle: lossy(spec, seed, &name("contact_angle"), GivenAngle::new),
        }
    }
}

impl LinkSensors {
    fn new(spec: &SensorSpec, seed: u64, link: &str, robot: &Robot) -> Self {
        let name = |sensor: &str| format!("{link}/{sensor}");
        let inclinometer = |spec: &_, source: Source<'_>| Inclinometer::new(spec, source, robot);
        Self {
            inclinometer: lossy(spec, seed, &name("inclinometer"), inclinometer),
            gyro: lossy(spec, seed, &name("gyro"), Gyro::new),
        }
    }

    /// Inclination and rate of a bar, which is number `i` of `rates`.
    fn read(&mut self, bar: &BarTruth, rates: &Rates, i: usize, delay: f64) -> LinkReading {
        let (inclinometer, loss) = &mut self.inclinometer;
        let angle = bar.angle + delay * bar.rate;
        let inclination = loss.pass(inclinometer.read(angle, rates.velocity[i], rates.dt));
        let (gyro, loss) = &mut self.gyro;
        LinkReading {
            inclination,
            rate: loss.pass(gyro.read(bar.rate + delay * rates.rate[i], rates.dt)),
            rate_error: 0.0,
        }
    }
}

impl BodySensors {
    fn new(spec: &SensorSpec, seed: u64, robot: &Robot) -> Self {
        let sensor = "pin";
        let source = Source { seed, sensor };
        Self {
            imu: LinkSensors::new(spec, seed, "body", robot),
            pin: (
                White::new(source, "noise", spec.pin_noise),
                source.constant("bias", spec.pin_bias),
                Loss::new(source, spec.dropped),
            ),
            mount: BodyMount::new(&robot.geometry, spec.pin_noise),
        }
    }

    /// What sensors on the links would read.
    fn read(
        &mut self,
        truth: &Truth,
        rates: &Rates,
        delay: f64,
        wheels: [Option<f64>; 3],
    ) -> [LinkReading; 2] {
        let [link1, link2, _] = &truth.links;
        let LinkReading {
            inclination, rate, ..
        } = self.imu.read(&truth.body, rates, 2, delay);
        let (noise, bias, loss) = &mut self.pin;
        let opening = link1.angle - link2.angle + delay * (link1.rate - link2.rate);
        let reading = BodyReading {
            inclination,
            rate,
            pin: loss.pass(opening + *bias + noise.sample()),
            wheels,
        };
        self.mount.links(truth.time, &reading)
    }
}

/// Rates of change since the previous sample: differences over the time between.
#[derive(Default)]
struct Rates {
    /// Time since the previous sample, s; 0 at the first sample.
    dt: f64,
    /// Rate of each motor torque, N m/s.
    torque: [f64; 3],
    /// Angular acceleration of links 1 and 2 and of the body, rad/s^2.
    rate: [f64; 3],
    /// Acceleration of their centres of mass, m/s^2.
    velocity: [Vec2; 3],
}

impl Rates {
    fn since(last: Option<&Truth>, now: &Truth) -> Self {
        let Some(last) = last.filter(|last| now.time > last.time) else {
            return Self::default();
        };
        let dt = now.time - last.time;
        let bars = [Bar::Link1, Bar::Link2, Bar::Body].map(|bar| [now.bar(bar), last.bar(bar)]);
        Self {
            dt,
            torque: [0, 1, 2].map(|i| (now.wheels[i].torque - last.wheels[i].torque) / dt),
            rate: bars.map(|[now, last]| (now.rate - last.rate) / dt),
            velocity: bars.map(|[now, last]| (now.velocity - last.velocity) / dt),
        }
    }
}
