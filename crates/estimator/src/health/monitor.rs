//! Means of normalised innovations over the last seconds of driving.

use super::channels::Channels;
use super::smoothing::WheelReadings;
use super::start::RollingRobot;
use super::turning::Turning;
use super::wiring::Wiring;
use crate::frame::Inputs;
use robhaz_model::Carrier;

/// Least speed of a robot that drives, m/s.
/// Chosen; held by the faults and honest logs of `tests/check`.
pub const DRIVING_SPEED: f64 = 0.02;

/// Whether the readings agree with each other and with the robot's model.
///
/// Each number is the mean over the last two seconds of driving of the normalised innovations
/// squared of a test: at most about 1 when readings, nominal parameters and noise budget are right.
/// It stays as it is while the robot stands, and while a wheel slides, has left the ground or is at
/// an edge, where the model of the innovations does not hold.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Health {
    /// Channels whose readings contradict others. None: healthy.
    pub faulty: Channels,
    /// Encoder of each wheel against its torque observer.
    pub encoder: [f64; 3],
    /// Rim speed of each wheel, less the creep of its T/N, against those of the others.
    pub slip: [f64; 3],
    /// Velocity of each wheel's centre against its contact angle.
    pub direction: [f64; 3],
    /// Inclinometer against the gyroscope on links 1 and 2.
    pub inclination: [f64; 2],
    /// Parity residual of eq. (8).
    pub parity: f64,
}

/// Normalised innovations squared of one sample. `None` where a test has no reading.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Innovations {
    pub encoder: [Option<f64>; 3],
    pub slip: [Option<f64>; 3],
    pub direction: [Option<f64>; 3],
    pub inclination: [Option<f64>; 2],
    pub parity: Option<f64>,
}

/// What the monitor takes of one sample.
#[derive(Clone, Copy, Debug)]
pub(crate) struct HealthSample<'a> {
    /// They count while the robot drives and the model holds.
    pub innovations: &'a Innovations,
    /// Motor torques that must change from sample to sample, N m: those that are read now, have
    /// noise, and turn their wheel.
    pub varying_torque: [Option<f64>; 3],
    /// Gyroscope (rad/s) and inclinometer (rad) of links 1 and 2; `None` if one has been missing for long.
    pub links: [Option<(f64, f64)>; 2],
    /// Largest speed of a wheel's rim, m/s.
    pub rim: f64,
    /// Standard deviation of a gyroscope's bias, rad/s.
    pub rate_bias: f64,
    /// Torques and encoders; `None` if one has been missing for long or counts from a new zero.
    pub wheels: Option<WheelReadings>,
    /// Whether the robot drives.
    pub drives: bool,
    /// Whether every wheel rolls on one contact, without an impact.
    pub model_holds: bool,
    /// Time since the last sample, s.
    pub dt: f64,
}

/// Averages the innovations, and says which channels are faulty.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct HealthMonitor {
    encoder: [Mean; 3],
    slip: [Mean; 3],
    direction: [Mean; 3],
    inclination: [Mean; 2],
    parity: Mean,
    torque: [Constancy; 3],
    turning: [Turning; 2],
    /// Largest speed of a rim, which decays, m/s.
    fastest: f64,
    wiring: Wiring,
    /// Time from which on inclinations count again, s from now.
    unsettled: f64,
}

impl HealthMonitor {
    /// Time after a wheel was at an edge or slid from which on inclinations count, s. A wheel that
    /// lands or grips again accelerates the robot, and inclinometers do not count after an impact:
    /// the link angles are off for a moment. [`Turning`] holds meanwhile.
    /// Chosen; held by the faults and honest logs of `tests/check`.
    const SETTLES: f64 = 0.5;
    /// The same after the robot has stood, s.
    /// Chosen; held by the faults and honest logs of `tests/check`.
    const STARTS: f64 = 0.3;

    /// Takes one sample of a `robot`.
    pub fn update(&mut self, sample: &HealthSample<'_>, robot: &RollingRobot) {
        let dt = sample.dt;
        for (constancy, torque) in self.torque.iter_mut().zip(sample.varying_torque) {
            constancy.update(torque, dt);
        }
        self.fastest -= dt / (Mean::WINDOW + dt) * self.fastest;
        self.fastest = self.fastest.max(sample.rim);
        for (turning, readings) in self.turning.iter_mut().zip(sample.links) {
            turning.update(readings, self.fastest, sample.rate_bias, dt);
        }
        self.wiring
            .update(sample.wheels.as_ref(), sample.drives, robot, dt);
        if !sample.model_holds {
            self.unsettled = Self::SETTLES;
        } else if !sample.drives {
            self.unsettled = self.unsettled.max(Self::STARTS);
        }
        if !(sample.drives && sample.model_holds) {
            return;
        }
        self.unsettled = (self.unsettled - dt).max(0.0);
        // One sample after a gap is no fault, either.
        let counted = dt.min(Inputs::STALE_AFTER);
        let weight = counted / (Mean::WINDOW + counted);
        let found = sample.innovations;
        let wheels = self.encoder.iter_mut().zip(&found.encoder);
        let wheels = wheels.chain(self.slip.iter_mut().zip(&found.slip));
        let wheels = wheels.chain(self.direction.iter_mut().zip(&found.direction));
        for (mean, nis) in wheels {
            mean.update(*nis, weight);
        }
        if self.unsettled <= 0.0 {
            for (mean, nis) in self.inclination.iter_mut().zip(&found.inclination) {
                mean.update(*nis, weight);
            }
        }
        self.parity.update(found.parity, weight);
    }

    /// The present state. `carriers` names the link of each wheel.
    pub fn health(&self, carriers: &[Carrier; 3]) -> Health {
        let mut faulty = Channels::NONE;
        let mut link = [false; 2];
        for k in 0..2 {
            link[k] = self.inclination[k].beyond || self.turning[k].apart;
            if link[k] {
                faulty |= Channels::GYROSCOPE[k] | Channels::INCLINOMETER[k];
            }
        }
        for i in 0..3 {
            let explained = link[carriers[i].index()];
            if self.slip[i].beyond && !explained {
                faulty |= Channels::ENCODER[i] | Channels::TORQUE[i];
            }
            if self.encoder[i].beyond {
                faulty |= Channels::ENCODER[i];
            }
            if self.direction[i].beyond && !explained {
                faulty |= Channels::CONTACT_ANGLE[i];
            }
            let stuck = self.torque[i].time > Constancy::LONGEST;
            if stuck || self.wiring.exchanged[i] || self.wiring.start.late {
                faulty |= Channels::TORQUE[i];
            }
        }
        if self.parity.beyond {
            faulty |= Channels::PARITY;
        }
        Health {
            faulty,
            encoder: self.encoder.map(|mean| mean.value),
            slip: self.slip.map(|mean| mean.value),
            direction: self.direction.map(|mean| mean.value),
            inclination: self.inclination.map(|mean| mean.value),
            parity: self.parity.value,
        }
    }
}

/// Mean of the normalised innovations squared of one test.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Mean {
    value: f64,
    /// Whether it is beyond its threshold.
    beyond: bool,
}

impl Mean {
    /// Time constant, s: long against impacts and against the correlation times of the errors,
    /// which are at most 0.5 s; short enough to report a fault within 5 s.
    /// Chosen; held by the faults and honest logs of `tests/check`.
    const WINDOW: f64 = 2.0;
    /// Mean beyond which a test fails: innovations of twice their standard deviation throughout the
    /// window. White innovations have a mean of 1 within some hundredths: only correlated errors
    /// and wrong budgets come near. Chosen; held by the faults and honest logs of `tests/check`.
    const FAILS: f64 = 4.0;
    /// Mean below which it passes again.
    /// Chosen; held by the faults and honest logs of `tests/check`.
    const PASSES: f64 = 2.0;
    /// Largest value of one sample, five standard deviations: a short outlier is no fault.
    /// Definition: the square of the gate.
    const LARGEST: f64 = 25.0;

    fn update(&mut self, nis: Option<f64>, weight: f64) {
        if let Some(nis) = nis {
            // In this order a NaN counts as the largest value.
            let limited = Self::LARGEST.min(nis);
            self.value += weight * (limited - self.value);
            let beyond = self.beyond;
            let threshold = if beyond { Self::PASSES } else { Self::FAILS };
            self.beyond = self.value > threshold;
        }
    }
}

/// How long a torque has been the same to the bit while it should vary.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Constancy {
    /// Last reading, N m.
    last: f64,
    /// s
    time: f64,
}

impl Constancy {
    /// Time from which on a torque is stuck, s. Quantisation alone does not repeat a reading for so
    /// long: the torque of a wheel that rolls on real ground changes.
    /// Chosen; held by the faults and honest logs of `tests/check`.
    const LONGEST: f64 = 1.0;

    fn update(&mut self, torque: Option<f64>, dt: f64) {
        let Some(value) = torque else {
            return;
        };
        if value.to_bits() == self.last.to_bits() {
            self.time = (self.time + dt).min(2.0 * Self::LONGEST);
        } else {
            self.time = 0.0;
        }
        self.last = value;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const DT: f64 = 1e-3;
    const CARRIERS: [Carrier; 3] = [Carrier::Link1, Carrier::Link2, Carrier::Link2];

    /// All tests with the same normalised innovation squared.
    fn all(nis: f64) -> Innovations {
        Innovations {
            encoder: [Some(nis); 3],
            slip: [Some(nis); 3],
            direction: [Some(nis); 3],
            inclination: [Some(nis); 2],
            parity: Some(nis),
        }
    }

    const ROBOT: RollingRobot = RollingRobot {
        inertia: 0.42,
        damping: 0.45,
    };

    fn sample(innovations: &Innovations) -> HealthSample<'_> {
        HealthSample {
            innovations,
            varying_torque: [None; 3],
            links: [None; 2],
            rim: 0.0,
            rate_bias: 0.0,
            wheels: None,
            drives: true,
            model_holds: true,
            dt: DT,
        }
    }

    /// Feeds the same innovations for a time (s).
    fn feed(monitor: &mut HealthMonitor, innovations: &Innovations, count: bool, time: f64) {
        for _ in 0..(time / DT) as u32 {
            let sample = HealthSample {
                model_holds: count,
                ..sample(innovations)
            };
            monitor.update(&sample, &ROBOT);
        }
    }

    /// Closed form: the mean follows 1 - exp(-t/2 s). Innovations of three standard deviations (9)
    /// reach the threshold of 4 after 2 s ln(9/5) = 1.18 s; from there, innovations of 1 fall below
    /// 2 after 2 s ln(3) = 2.2 s.
    #[test]
    fn a_contradiction_is_found_and_its_end_too() {
        let mut monitor = HealthMonitor::default();
        let mut fault = all(1.0);
        fault.slip[1] = Some(9.0);
        feed(&mut monitor, &fault, true, 1.1);
        assert!(monitor.health(&CARRIERS).faulty.is_empty());
        feed(&mut monitor, &fault, true, 0.2);
        let health = monitor.health(&CARRIERS);
        assert_eq!(health.faulty, Channels::ENCODER[1] | Channels::TORQUE[1]);
        // The sampling of 1 ms over the window of 2 s.
        assert!((health.slip[1] - 9.0 * (1.0 - libm::exp(-0.65))).abs() < 5e-3);
        feed(&mut monitor, &all(1.0), true, 2.0);
        assert!(!monitor.health(&CARRIERS).faulty.is_empty());
        feed(&mut monitor, &all(1.0), true, 0.4);
        assert!(monitor.health(&CARRIERS).faulty.is_empty());
    }

    /// Neither an outlier, however large, nor samples that do not count make a channel faulty.
    #[test]
    fn short_outliers_and_other_ground_do_not_count() {
        let mut monitor = HealthMonitor::default();
        feed(&mut monitor, &all(1.0), true, 10.0);
        feed(&mut monitor, &all(1e9), true, 0.1);
        feed(&mut monitor, &all(f64::NAN), true, 0.1);
        feed(&mut monitor, &all(25.0), false, 10.0);
        assert!(monitor.health(&CARRIERS).faulty.is_empty());
        feed(&mut monitor, &Innovations::default(), true, 10.0);
        assert!(monitor.health(&CARRIERS).faulty.is_empty());
    }

    /// A link whose inclination contradicts its gyroscope explains the slip of its wheels; not that
    /// of others.
    #[test]
    fn a_wrong_gyroscope_explains_the_slip_of_its_wheels() {
        let mut monitor = HealthMonitor::default();
        feed(&mut monitor, &all(25.0), true, 10.0);
        let link = |k: usize| Channels::GYROSCOPE[k] | Channels::INCLINOMETER[k];
        let encoders = Channels::ENCODER[0] | Channels::ENCODER[1] | Channels::ENCODER[2];
        let expected = link(0) | link(1) | encoders | Channels::PARITY;
        assert_eq!(monitor.health(&CARRIERS).faulty, expected);
        let mut second = all(0.5);
        second.inclination[1] = Some(25.0);
        (second.slip, second.direction) = ([Some(25.0); 3], [Some(25.0); 3]);
        let mut monitor = HealthMonitor::default();
        feed(&mut monitor, &second, true, 10.0);
        let first = Channels::ENCODER[0] | Channels::TORQUE[0] | Channels::CONTACT_ANGLE[0];
        assert_eq!(monitor.health(&CARRIERS).faulty, link(1) | first);
    }

    /// A torque that repeats its bits for a second is stuck; missing readings and those of a wheel
    /// that stands do not count.
    #[test]
    fn a_constant_torque_is_stuck() {
        let mut monitor = HealthMonitor::default();
        let mut run = |samples: u32, varying_torque: [Option<f64>; 3]| {
            let none = Innovations::default();
            for _ in 0..samples {
                let sample = HealthSample {
                    varying_torque,
                    drives: false,
                    ..sample(&none)
                };
                monitor.update(&sample, &ROBOT);
            }
            monitor.health(&CARRIERS).faulty
        };
        let readings = [None, Some(2.5), None];
        assert!(run(1000, readings).is_empty());
        assert_eq!(run(10, readings), Channels::TORQUE[1]);
        assert!(run(1, [Some(2.6); 3]).is_empty());
    }
}
