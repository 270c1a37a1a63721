//! Means of normalised innovations over the last seconds of driving, and what they and the tests that need no filter
//! say of each channel.

use super::constancy::Constancy;
use super::smoothing::{WINDOW, WheelReadings};
use super::start::RollingRobot;
use super::turning::Turning;
use super::wiring::Wiring;
use crate::common::DRIVING_SPEED;
use crate::deviation::{GATE, SIGNIFICANT, WITHIN};
use crate::filters::motion::REFERENCE_SPEED;
use crate::flags::Channels;
use robhaz_model::{Carrier, Units};

/// Whether the readings agree with each other and with the robot's model.
///
/// Each number is the mean over the last two seconds of driving of the normalised innovations
/// squared of a test: at most about 1 when readings, nominal parameters and noise budget are right.
/// It stays as it is while the robot stands. Those of slip, direction and inclination stay, too, while a wheel slides,
/// has left the ground or is at an edge, where the model of the innovations does not hold; that of parity while a
/// wheel is in the air or has two contacts, or a reading is stale. Where the wheels turn far between
/// readings, slip and direction count less: half at a tenth of a radian. Below 0.2 m/s (of robot A) the
/// means of slip, direction and parity last for the same way, 0.4 m.
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
    /// They count while the robot drives.
    pub innovations: &'a Innovations,
    /// Motor torques that must change from sample to sample, N m: those that are read now, have
    /// noise, and turn their wheel.
    pub varying_torque: [Option<f64>; 3],
    /// Gyroscope (rad/s) and inclinometer (rad) of links 1 and 2, held; `None` if one has been
    /// missing for long.
    pub links: [Option<(f64, f64)>; 2],
    /// Largest speed of a wheel's rim, m/s.
    pub rim: f64,
    /// Standard deviation of a gyroscope's bias, rad/s.
    pub rate_bias: f64,
    /// Torques and encoders; `None` if one has been missing for long or counts from a new zero.
    pub wheels: Option<WheelReadings>,
    /// Whether the robot drives.
    pub drives: bool,
    /// The lesser of the velocity and the fastest rim, m/s, while every wheel has one contact: wheels that spin make no
    /// way.
    pub touching: Option<f64>,
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
}

impl HealthMonitor {
    /// Way of a wheel between readings at which the variance of slip and direction counts double, m: a
    /// tenth of its radius. What the ground does from reading to reading no filter knows.
    /// Chosen; held by `tests/check/health.rs`.
    const FAR: f64 = 0.1 * Units::RADIUS;

    /// Takes one sample of a `robot`.
    pub fn update(&mut self, sample: &HealthSample<'_>, robot: &RollingRobot) {
        let dt = sample.dt;
        for (constancy, torque) in self.torque.iter_mut().zip(sample.varying_torque) {
            constancy.update(torque, dt);
        }
        self.fastest -= robhaz_model::low_pass_share(dt, WINDOW) * self.fastest;
        self.fastest = self.fastest.max(sample.rim);
        for (turning, readings) in self.turning.iter_mut().zip(sample.links) {
            let readings = readings.filter(|_| self.fastest > DRIVING_SPEED);
            turning.update(readings, self.fastest, sample.rate_bias, dt);
        }
        self.wiring
            .update(sample.wheels.as_ref(), sample.drives, robot, dt);
        if !sample.drives {
            return;
        }
        let Innovations {
            encoder,
            slip,
            direction,
            inclination,
            parity,
        } = sample.innovations;
        let weight = robhaz_model::low_pass_share(dt, WINDOW);
        // What the ground does lasts for a way: of a slow drive it is averaged for longer.
        let of_way = |speed: f64| {
            let pace = (speed / REFERENCE_SPEED).min(1.0);
            robhaz_model::low_pass_share(pace * dt, WINDOW)
        };
        // A wrong encoder or clock looks like one impact after the other, a wrong torque like a wheel that slides.
        for (mean, nis) in self.encoder.iter_mut().zip(encoder) {
            mean.update(*nis, weight);
        }
        if let Some(speed) = sample.touching {
            let limited = parity.map(|nis| Mean::LARGEST_PARITY.min(nis));
            self.parity.update(limited, of_way(speed));
        }
        if !sample.model_holds {
            return;
        }
        let of_way = of_way(sample.rim);
        let apart = sample.rim * dt / Self::FAR;
        let rolling = self.slip.iter_mut().zip(slip);
        for (mean, nis) in rolling.chain(self.direction.iter_mut().zip(direction)) {
            mean.update(nis.map(|nis| nis / (1.0 + apart * apart)), of_way);
        }
        for (mean, nis) in self.inclination.iter_mut().zip(inclination) {
            mean.update(*nis, weight);
        }
    }

    /// Whether each torque repeats itself though its wheel turns.
    pub fn stuck(&self) -> [bool; 3] {
        (self.torque.each_ref()).map(|constancy| constancy.time > Constancy::LONGEST)
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
        let stuck = self.stuck();
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
            if stuck[i] || self.wiring.exchanged[i] || self.wiring.start.late {
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
    /// Mean beyond which a test fails: innovations of twice their standard deviation throughout the
    /// window. White innovations have a mean of 1 within some hundredths: only correlated errors
    /// and wrong budgets come near. Below half of it the test passes again.
    /// Definition.
    const FAILS: f64 = WITHIN * WITHIN;
    /// Largest value of one sample: a short outlier is no fault.
    /// Definition.
    const LARGEST: f64 = GATE * GATE;
    /// The same of the parity residual, which counts in impacts and at edges, too: they last for longer.
    /// Chosen; held by `tests/check/health.rs`.
    const LARGEST_PARITY: f64 = SIGNIFICANT * SIGNIFICANT;

    fn update(&mut self, nis: Option<f64>, weight: f64) {
        if let Some(nis) = nis {
            // In this order a NaN counts as the largest value.
            let limited = Self::LARGEST.min(nis);
            self.value += weight * (limited - self.value);
            let part = if self.beyond { 0.5 } else { 1.0 };
            self.beyond = self.value > part * Self::FAILS;
        }
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
            rim: REFERENCE_SPEED,
            rate_bias: 0.0,
            wheels: None,
            drives: true,
            touching: Some(REFERENCE_SPEED),
            model_holds: true,

            dt: DT,
        }
    }

    /// Feeds the same innovations for a time (s).
    fn feed(monitor: &mut HealthMonitor, innovations: &Innovations, count: bool, time: f64) {
        for _ in 0..(time / DT) as u32 {
            let sample = HealthSample {
                touching: count.then_some(REFERENCE_SPEED),
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

    /// Neither an outlier, however large, nor samples that do not count make a channel faulty. At edges encoders count.
    #[test]
    fn short_outliers_and_other_ground_do_not_count() {
        let mut monitor = HealthMonitor::default();
        feed(&mut monitor, &all(1.0), true, 10.0);
        feed(&mut monitor, &all(1e9), true, 0.1);
        feed(&mut monitor, &all(f64::NAN), true, 0.1);
        let edges = Innovations {
            encoder: [Some(1.0); 3],
            ..all(25.0)
        };
        feed(&mut monitor, &edges, false, 10.0);
        assert!(monitor.health(&CARRIERS).faulty.is_empty());
        feed(&mut monitor, &Innovations::default(), true, 10.0);
        assert!(monitor.health(&CARRIERS).faulty.is_empty());
    }

    /// Closed form: encoders count in impacts, too, and parity where all wheels touch, 9 at most: it passes 4 after
    /// 2 s ln(9/5) = 1.18 s, whatever is beyond 9.
    #[test]
    fn encoders_and_parity_count_in_impacts() {
        let mut monitor = HealthMonitor::default();
        let innovations = Innovations {
            encoder: [Some(9.0), Some(1.0), Some(1.0)],
            parity: Some(1e6),
            ..Innovations::default()
        };
        let mut run = |time: f64| {
            for _ in 0..(time / DT) as u32 {
                let sample = HealthSample {
                    model_holds: false,
                    ..sample(&innovations)
                };
                monitor.update(&sample, &ROBOT);
            }
            monitor.health(&CARRIERS).faulty
        };
        assert!(run(1.1).is_empty());
        assert_eq!(run(0.2), Channels::ENCODER[0] | Channels::PARITY);
    }

    /// Closed form: where wheels turn by a tenth of a radian between readings their slip counts half.
    #[test]
    fn readings_far_apart_count_less() {
        let mut monitor = HealthMonitor::default();
        let innovations = Innovations {
            slip: [Some(7.0); 3],
            ..Innovations::default()
        };
        for _ in 0..1000 {
            let far = HealthSample {
                dt: 0.05,
                rim: 0.2,
                ..sample(&innovations)
            };
            monitor.update(&far, &ROBOT);
        }
        let health = monitor.health(&CARRIERS);
        assert!(health.faulty.is_empty());
        // 50 s are 25 times the window.
        assert!((health.slip[0] - 3.5).abs() < 1e-9);
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
