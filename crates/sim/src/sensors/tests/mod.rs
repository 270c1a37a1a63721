//! Compares each model with its closed form or its statistics. Bounds on statistics are four
//! standard errors of the sample.

mod links;
mod wheels;

use super::*;
use crate::truth::{BarTruth, WheelTruth};
use robhaz_model::GRAVITY;
use std::f64::consts::TAU;

const DT: f64 = 1e-3;

/// Time of a sample, s.
fn time(k: u32) -> f64 {
    f64::from(k) * DT
}

/// A truth in which every channel changes.
fn moving(k: u32) -> Truth {
    let t = time(k);
    let bar = |phase: f64| BarTruth {
        angle: 0.1 * (t + phase).sin(),
        rate: 0.1 * (t + phase).cos(),
        velocity: Vec2::new(0.2 * t.sin(), 0.1 * t.cos()),
        ..BarTruth::default()
    };
    let wheel = |phase: f64| WheelTruth {
        angle: 2.0 * t + phase * t * t,
        omega: 2.0 + 2.0 * phase * t,
        torque: phase + t.sin(),
        contact_angle: 0.2 * (t + phase).sin(),
        ..WheelTruth::default()
    };
    Truth {
        time: t,
        links: [bar(0.0), bar(1.0), bar(2.0)],
        wheels: [wheel(0.1), wheel(0.2), wheel(0.3)],
        ..Truth::default()
    }
}

fn at_rest(k: u32) -> Truth {
    Truth {
        time: time(k),
        ..Truth::default()
    }
}

fn sensors(spec: &SensorSpec, seed: u64) -> Sensors {
    Sensors::new(spec, seed, &Robot::default_a())
}

fn read(spec: &SensorSpec, seed: u64, samples: u32, truth: fn(u32) -> Truth) -> Vec<SensorFrame> {
    let mut sensors = sensors(spec, seed);
    (0..samples).map(|k| sensors.read(&truth(k))).collect()
}

/// Values of a channel that has no losses.
fn values(readings: &[SensorFrame], channel: fn(&SensorFrame) -> Option<f64>) -> Vec<f64> {
    let values = readings.iter().map(channel);
    values.collect::<Option<_>>().expect("no losses")
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// Mean product of two values `lag` samples apart.
fn correlation(values: &[f64], lag: usize) -> f64 {
    let products = values.iter().zip(&values[lag..]).map(|(a, b)| a * b);
    products.sum::<f64>() / (values.len() - lag) as f64
}

/// Asserts that values are white noise of a given standard deviation: mean, variance (relative
/// standard error sqrt(2/n)) and no correlation.
fn assert_white(values: &[f64], sigma: f64) {
    let bound = 4.0 / (values.len() as f64).sqrt();
    let scaled: Vec<f64> = values.iter().map(|v| v / sigma).collect();
    assert!(mean(&scaled).abs() < bound, "mean {}", mean(&scaled));
    let variance = correlation(&scaled, 0);
    assert!(
        (variance - 1.0).abs() < bound * 2.0_f64.sqrt(),
        "{variance}"
    );
    for lag in [1, 2, 10] {
        let found = correlation(&scaled, lag);
        assert!(found.abs() < bound, "lag {lag}: {found}");
    }
}

/// Asserts the standard deviation of a value that is drawn once per run, over many seeds.
fn assert_drawn(sigma: f64, spec: &SensorSpec, pick: fn(&DrawnErrors) -> f64) {
    let draws = (0..10_000).map(|seed| pick(sensors(spec, seed).drawn()));
    assert_white(&draws.collect::<Vec<_>>(), sigma);
}

/// Equivalence: ideal sensors read the truth, bit for bit.
#[test]
fn ideal_readings_are_the_truth() {
    for (k, readings) in (0..100).zip(read(&Grade::Ideal.sensors(), 3, 100, moving)) {
        let truth = moving(k);
        let link = |i: usize| LinkReading {
            inclination: Some(truth.links[i].angle),
            rate: Some(truth.links[i].rate),
            rate_error: 0.0,
        };
        let expected = SensorFrame {
            time: truth.time,
            wheel_angle: truth.wheels.map(|w| Some(w.angle)),
            motor_torque: truth.wheels.map(|w| Some(w.torque)),
            link1: link(0),
            link2: link(1),
            contact_angle: truth.wheels.map(|w| Some(w.contact_angle)),
        };
        assert_eq!(readings, expected);
    }
}

/// Determinism: the same seed gives the same bits, another seed others.
#[test]
fn the_same_seed_gives_the_same_readings() {
    let poor = Grade::Poor.sensors();
    let run = |seed| read(&poor, seed, 500, moving);
    assert_eq!(run(11), run(11));
    assert_ne!(run(11), run(12));
}

/// Closed form: all channels are sampled at the same instant, which differs from the time stamp by
/// white noise.
#[test]
fn jitter_moves_the_instant_of_sampling() {
    let spec = SensorSpec {
        jitter: 1e-4,
        ..Grade::Ideal.sensors()
    };
    let readings = read(&spec, 1, 20_000, moving);
    let mut delays = Vec::new();
    for (k, readings) in (0..).zip(&readings) {
        let truth = moving(k);
        assert!((readings.time - truth.time).abs() < 1e-15);
        let wheel = &truth.wheels[0];
        let read = readings.wheel_angle[0].expect("no losses");
        let delay = (read - wheel.angle) / wheel.omega;
        delays.push(delay);
        let link = &truth.links[0];
        let read = readings.link1.inclination.expect("no losses");
        // Rounding of the wheel angle of up to 50 rad, divided by its speed.
        assert!((read - (link.angle + delay * link.rate)).abs() < 1e-14);
        // The rates of gyro rate and torque are differences over the last millisecond, so they are
        // half a millisecond old.
        if k > 0 {
            let read = readings.link1.rate.expect("no losses");
            let expected = 0.1 * (truth.time + delay).cos();
            assert!((read - expected).abs() < 0.1 * (0.5 * DT + delay.abs()) * delay.abs() + 1e-14);
            let read = readings.motor_torque[0].expect("no losses");
            let expected = 0.1 + (truth.time + delay).sin();
            assert!((read - expected).abs() < (0.5 * DT + delay.abs()) * delay.abs() + 1e-14);
        }
        assert_eq!(readings.contact_angle[0], Some(wheel.contact_angle));
    }
    assert_white(&delays, 1e-4);
}

/// Statistics: each channel loses its share, independently of the others (binomial: standard error
/// sqrt(p (1 - p)/n)).
#[test]
fn readings_are_lost_independently() {
    const SAMPLES: u32 = 20_000;
    let spec = SensorSpec {
        dropped: 0.1,
        ..Grade::Ideal.sensors()
    };
    let channels = |r: &SensorFrame| {
        let mut all = Vec::new();
        for three in [r.wheel_angle, r.motor_torque, r.contact_angle] {
            all.extend(three.map(|v| v.is_none()));
        }
        for two in [
            [r.link1, r.link2].map(|link| link.inclination),
            [r.link1, r.link2].map(|link| link.rate),
        ] {
            all.extend(two.map(|v| v.is_none()));
        }
        all
    };
    let lost: Vec<Vec<bool>> = read(&spec, 1, SAMPLES, moving)
        .iter()
        .map(channels)
        .collect();
    let n = f64::from(SAMPLES);
    let share = |at: &dyn Fn(&[bool]) -> bool| lost.iter().filter(|l| at(l)).count() as f64 / n;
    let within = |found: f64, p: f64| (found - p).abs() < 4.0 * (p * (1.0 - p) / n).sqrt();
    for i in 0..13 {
        let found = share(&|l| l[i]);
        assert!(within(found, 0.1), "channel {i}: {found}");
        for j in 0..i {
            let found = share(&|l| l[i] && l[j]);
            assert!(within(found, 0.01), "channels {i} and {j}: {found}");
        }
    }
}

/// Independence: the readings of a channel depend on its own parameters alone. When an error of
/// another channel is switched off, they keep their bits.
#[test]
fn switching_one_error_off_changes_no_other_channel() {
    type Parts = fn(&SensorFrame) -> Vec<Option<f64>>;
    let angle: Parts = |r| r.wheel_angle.to_vec();
    let torque: Parts = |r| r.motor_torque.to_vec();
    let inclination: Parts = |r| [r.link1, r.link2].map(|link| link.inclination).to_vec();
    let rate: Parts = |r| [r.link1, r.link2].map(|link| link.rate).to_vec();
    let contact: Parts = |r| r.contact_angle.to_vec();
    let all = [angle, torque, inclination, rate, contact];
    let poor = Grade::Poor.sensors();
    type Change = fn(&mut SensorSpec);
    let changes: [(usize, Change); 12] = [
        (0, |s| s.encoder_counts = 0.0),
        (1, |s| s.torque_gain = 0.0),
        (1, |s| s.torque_offset = 0.0),
        (1, |s| s.torque_noise = 0.0),
        (2, |s| s.inclination_noise = 0.0),
        (2, |s| s.inclination_bias = 0.0),
        (2, |s| s.inclination_lag = 0.0),
        (3, |s| s.rate_noise = 0.0),
        (3, |s| s.rate_bias = 0.0),
        (3, |s| s.rate_walk = 0.0),
        (3, |s| s.rate_scale = 0.0),
        (4, |s| s.contact_angle_error = 0.0),
    ];
    let before = read(&poor, 9, 300, moving);
    for (changed, switch_off) in changes {
        let mut spec = poor;
        switch_off(&mut spec);
        let after = read(&spec, 9, 300, moving);
        for (channel, part) in all.iter().enumerate() {
            let same = before.iter().zip(&after).all(|(a, b)| part(a) == part(b));
            assert_eq!(same, channel != changed, "{spec:?}, channel {channel}");
        }
    }
    // Within a channel, switching one error off does not redraw another: without noise the gain is
    // the same.
    let quiet = SensorSpec {
        torque_noise: 0.0,
        rate_walk: 0.0,
        ..poor
    };
    assert_eq!(sensors(&poor, 9).drawn(), sensors(&quiet, 9).drawn());
}

/// Statistics: the noise of no two channels is correlated.
#[test]
fn channels_are_uncorrelated() {
    const SAMPLES: u32 = 20_000;
    let spec = SensorSpec {
        torque_noise: 1.0,
        inclination_noise: 1.0,
        rate_noise: 1.0,
        contact_angle_error: 1.0,
        contact_angle_time: 0.0,
        ..Grade::Ideal.sensors()
    };
    let readings = read(&spec, 1, SAMPLES, at_rest);
    let channels: [fn(&SensorFrame) -> Option<f64>; 10] = [
        |r| r.motor_torque[0],
        |r| r.motor_torque[1],
        |r| r.motor_torque[2],
        |r| r.link1.inclination,
        |r| r.link2.inclination,
        |r| r.link1.rate,
        |r| r.link2.rate,
        |r| r.contact_angle[0],
        |r| r.contact_angle[1],
        |r| r.contact_angle[2],
    ];
    let noises = channels.map(|c| values(&readings, c));
    let n = f64::from(SAMPLES);
    for (i, a) in noises.iter().enumerate() {
        for b in &noises[..i] {
            let product = a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>() / n;
            assert!(product.abs() < 4.0 / n.sqrt(), "{product}");
        }
    }
}
