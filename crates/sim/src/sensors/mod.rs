//! What the robot's sensors read of the truth.
//!
//! | sensor | errors | model |
//! |---|---|---|
//! | encoder, each wheel | quantised | whole counts of the motor's encoder |
//! | motor torque, each wheel | gain, offset, white noise, quantised | from the motor's current |
//! | inclinometer, links 1 and 2 | specific force, low pass, bias, white noise | direction of the specific force |
//! | rate gyro, links 1 and 2 | scale, bias with random walk, white noise | |
//! | contact angle, each wheel | Ornstein-Uhlenbeck | no sensor: the paper assumes that they are known |
//! | all | jitter of the sampling time, lost readings | |
//!
//! The equations stand with the models, in `models.rs`; the parameters are those of a [`SensorSpec`], the named grades
//! those of [`Grade`].

mod models;
mod spec;
#[cfg(test)]
mod tests;

pub use spec::{ENCODER_COUNTS, Grade, SensorSpec};

use crate::truth::Truth;
use models::{Encoder, GivenAngle, Gyro, Inclinometer, Loss, Source, TorqueSensor, White};
use robhaz_model::Vec2;

/// Readings of one instant. `None` is a reading that was lost.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Readings {
    /// Time stamp of the sample, s.
    pub time: f64,
    /// Turn of each wheel relative to its link since the start, rad (motor-side encoder over gear ratio).
    pub wheel_angle: [Option<f64>; 3],
    /// Motor torque at each wheel, N m (from the motor's current), before friction in the gear.
    pub motor_torque: [Option<f64>; 3],
    /// Inclinometers on link 1 and link 2: turn from the nominal pose, rad.
    pub inclination: [Option<f64>; 2],
    /// Rate gyroscopes on link 1 and link 2, rad/s.
    pub rate: [Option<f64>; 2],
    /// Contact angles, rad. No sensor reads them: the paper assumes that they are known.
    pub contact_angle: [Option<f64>; 3],
}

/// The errors that a run's sensors have drawn and keep.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DrawnErrors {
    /// Error of each torque's scale, relative.
    pub torque_gain: [f64; 3],
    /// Offset of each torque, N m.
    pub torque_offset: [f64; 3],
    /// Bias of the inclinometers on links 1 and 2, rad.
    pub inclination_bias: [f64; 2],
    /// Bias of the gyros on links 1 and 2 at the start, rad/s.
    pub rate_bias: [f64; 2],
    /// Error of the gyros' scale, relative.
    pub rate_scale: [f64; 2],
}

/// All sensors of the robot. Pure and deterministic: the same specification, seed and truths give the same bits.
#[derive(Clone, Debug)]
pub struct Sensors {
    wheels: [WheelSensors; 3],
    links: [LinkSensors; 2],
    jitter: White,
    drawn: DrawnErrors,
    /// The truth of the sample before.
    last: Option<Truth>,
}

#[derive(Clone, Debug)]
struct WheelSensors {
    encoder: (Encoder, Loss),
    torque: (TorqueSensor, Loss),
    contact_angle: (GivenAngle, Loss),
}

#[derive(Clone, Debug)]
struct LinkSensors {
    inclinometer: (Inclinometer, Loss),
    gyro: (Gyro, Loss),
}

impl Sensors {
    /// The sensors of a run: what is drawn once comes from the run's seed.
    pub fn new(spec: &SensorSpec, seed: u64) -> Self {
        let wheels = ["wheel1", "wheel2", "wheel3"].map(|name| WheelSensors::new(spec, seed, name));
        let links = ["link1", "link2"].map(|name| LinkSensors::new(spec, seed, name));
        let (torques, gyros) = (
            wheels.each_ref().map(|w| &w.torque.0),
            links.each_ref().map(|l| &l.gyro.0),
        );
        let drawn = DrawnErrors {
            torque_gain: torques.map(|t| t.gain),
            torque_offset: torques.map(|t| t.offset),
            inclination_bias: links.each_ref().map(|l| l.inclinometer.0.bias),
            rate_bias: gyros.map(|g| g.bias),
            rate_scale: gyros.map(|g| g.scale),
        };
        let clock = Source {
            seed,
            sensor: "clock",
        };
        Self {
            wheels,
            links,
            jitter: White::new(clock, "jitter", spec.jitter),
            drawn,
            last: None,
        }
    }

    /// The errors that were drawn for this run.
    pub fn drawn(&self) -> &DrawnErrors {
        &self.drawn
    }

    /// Reads the truth of the next sample; times must increase.
    ///
    /// With jitter the samples are taken late (or early) by sigma w and stamped with the nominal time: what moves is
    /// extrapolated with its rate. Accelerations and the rate of the torque are differences to the sample before (0 at the
    /// first one). Contact angles are given, not sampled: they have no jitter.
    pub fn read(&mut self, truth: &Truth) -> Readings {
        let change = Change::since(self.last.as_ref(), truth);
        self.last = Some(*truth);
        let late = self.jitter.sample();
        let mut readings = Readings {
            time: truth.time,
            wheel_angle: [None; 3],
            motor_torque: [None; 3],
            inclination: [None; 2],
            rate: [None; 2],
            contact_angle: [None; 3],
        };
        for (i, sensors) in self.wheels.iter_mut().enumerate() {
            let wheel = &truth.wheels[i];
            let (encoder, loss) = &mut sensors.encoder;
            readings.wheel_angle[i] = loss.pass(encoder.read(wheel.angle + late * wheel.omega));
            let (torque, loss) = &mut sensors.torque;
            let sampled = wheel.torque + late * change.torque[i];
            readings.motor_torque[i] = loss.pass(torque.read(sampled, wheel.omega));
            let (angle, loss) = &mut sensors.contact_angle;
            readings.contact_angle[i] = loss.pass(angle.read(wheel.contact_angle, change.dt));
        }
        for (i, sensors) in self.links.iter_mut().enumerate() {
            let link = &truth.links[i];
            let (inclinometer, loss) = &mut sensors.inclinometer;
            let angle = link.angle + late * link.rate;
            readings.inclination[i] =
                loss.pass(inclinometer.read(angle, change.velocity[i], change.dt));
            let (gyro, loss) = &mut sensors.gyro;
            let rate = link.rate + late * change.rate[i];
            readings.rate[i] = loss.pass(gyro.read(rate, change.dt));
        }
        readings
    }
}

impl WheelSensors {
    fn new(spec: &SensorSpec, seed: u64, wheel: &str) -> Self {
        let [encoder, torque, angle] =
            ["encoder", "torque", "contact_angle"].map(|sensor| format!("{wheel}/{sensor}"));
        let source = |sensor| Source { seed, sensor };
        let loss = |sensor| Loss::new(source(sensor), spec.dropped);
        Self {
            encoder: (Encoder::new(spec), loss(&encoder)),
            torque: (TorqueSensor::new(spec, source(&torque)), loss(&torque)),
            contact_angle: (GivenAngle::new(spec, source(&angle)), loss(&angle)),
        }
    }
}

impl LinkSensors {
    fn new(spec: &SensorSpec, seed: u64, link: &str) -> Self {
        let [inclinometer, gyro] =
            ["inclinometer", "gyro"].map(|sensor| format!("{link}/{sensor}"));
        let source = |sensor| Source { seed, sensor };
        let loss = |sensor| Loss::new(source(sensor), spec.dropped);
        Self {
            inclinometer: (
                Inclinometer::new(spec, source(&inclinometer)),
                loss(&inclinometer),
            ),
            gyro: (Gyro::new(spec, source(&gyro)), loss(&gyro)),
        }
    }
}

/// Differences to the sample before, over the time between.
#[derive(Default)]
struct Change {
    /// Time between, s; 0 at the first sample.
    dt: f64,
    /// Of each motor torque, N m/s.
    torque: [f64; 3],
    /// Of the angular rates of links 1 and 2, rad/s^2.
    rate: [f64; 2],
    /// Of the velocities of the centres of mass of links 1 and 2, m/s^2.
    velocity: [Vec2; 2],
}

impl Change {
    fn since(last: Option<&Truth>, now: &Truth) -> Self {
        let Some(last) = last.filter(|last| now.time > last.time) else {
            return Self::default();
        };
        let dt = now.time - last.time;
        Self {
            dt,
            torque: [0, 1, 2].map(|i| (now.wheels[i].torque - last.wheels[i].torque) / dt),
            rate: [0, 1].map(|i| (now.links[i].rate - last.links[i].rate) / dt),
            velocity: [0, 1].map(|i| (now.links[i].velocity - last.links[i].velocity) / dt),
        }
    }
}
