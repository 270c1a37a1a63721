//! Compares each model with its closed form or its statistics. Bounds on statistics are four
//! standard errors of the sample.

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

fn read(spec: &SensorSpec, seed: u64, samples: u32, truth: fn(u32) -> Truth) -> Vec<Readings> {
    let mut sensors = sensors(spec, seed);
    (0..samples).map(|k| sensors.read(&truth(k))).collect()
}

/// Values of a channel that has no losses.
fn values(readings: &[Readings], channel: fn(&Readings) -> Option<f64>) -> Vec<f64> {
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
    for (k, readings) in (0..100).zip(read(&SensorSpec::ideal(), 3, 100, moving)) {
        let truth = moving(k);
        let link = |i: usize| &truth.links[i];
        let expected = Readings {
            time: truth.time,
            wheel_angle: truth.wheels.map(|w| Some(w.angle)),
            motor_torque: truth.wheels.map(|w| Some(w.torque)),
            inclination: [0, 1].map(|i| Some(link(i).angle)),
            rate: [0, 1].map(|i| Some(link(i).rate)),
            rate_error: [0.0; 2],
            contact_angle: truth.wheels.map(|w| Some(w.contact_angle)),
        };
        assert_eq!(readings, expected);
    }
}

/// Determinism: the same seed gives the same bits, another seed others.
#[test]
fn the_same_seed_gives_the_same_readings() {
    let poor = SensorSpec::poor();
    let run = |seed| read(&poor, seed, 500, moving);
    assert_eq!(run(11), run(11));
    assert_ne!(run(11), run(12));
}

/// Closed form: readings are whole counts, below the truth by less than one count.
#[test]
fn encoders_read_whole_counts() {
    let spec = SensorSpec {
        encoder_counts: ENCODER_COUNTS,
        ..SensorSpec::ideal()
    };
    let count = TAU / ENCODER_COUNTS;
    for (k, readings) in (0..2000).zip(read(&spec, 0, 2000, moving)) {
        for (found, wheel) in readings.wheel_angle.iter().zip(&moving(k).wheels) {
            let found = found.expect("no losses");
            // 1e-9 of a count: rounding of angles of some rad.
            let counts = found / count;
            assert!((counts - counts.round()).abs() < 1e-9);
            let rest = (wheel.angle - found) / count;
            assert!((-1e-9..1.0 + 1e-9).contains(&rest), "{rest}");
        }
    }
    // Below zero the count is rounded down, not towards zero.
    let mut sensors = sensors(&spec, 0);
    let mut truth = at_rest(0);
    truth.wheels[0].angle = -0.5 * count;
    assert_eq!(sensors.read(&truth).wheel_angle[0], Some(-count));
}

/// Statistics: gain and offset are constant over a run and drawn with their standard deviation; the
/// noise is white.
#[test]
fn torque_has_gain_offset_and_white_noise() {
    let gain = SensorSpec {
        torque_gain: 0.02,
        ..SensorSpec::ideal()
    };
    assert_drawn(0.02, &gain, |d| d.torque_gain[1]);
    let offset = SensorSpec {
        torque_offset: 0.1,
        ..SensorSpec::ideal()
    };
    assert_drawn(0.1, &offset, |d| d.torque_offset[2]);

    let both = SensorSpec {
        torque_gain: 0.02,
        ..offset
    };
    let drawn = *sensors(&both, 5).drawn();
    for (k, readings) in (0..50).zip(read(&both, 5, 50, moving)) {
        for i in 0..3 {
            let torque = moving(k).wheels[i].torque;
            let expected = (1.0 + drawn.torque_gain[i]) * torque + drawn.torque_offset[i];
            assert_eq!(readings.motor_torque[i], Some(expected));
        }
    }
    let noise = SensorSpec {
        torque_noise: 0.1,
        ..SensorSpec::ideal()
    };
    let readings = read(&noise, 1, 50_000, at_rest);
    assert_white(&values(&readings, |r| r.motor_torque[0]), 0.1);
}

/// Closed form: readings are whole steps, at most half a step from the truth; friction in the
/// reading has the sign of the speed.
#[test]
fn torque_is_quantised_and_contains_friction() {
    let spec = SensorSpec {
        torque_step: 0.04,
        ..SensorSpec::ideal()
    };
    for (k, readings) in (0..500).zip(read(&spec, 1, 500, moving)) {
        let found = readings.motor_torque[0].expect("no losses");
        let steps = found / 0.04;
        assert!((steps - steps.round()).abs() < 1e-12);
        assert!((found - moving(k).wheels[0].torque).abs() <= 0.02 + 1e-12);
    }
    let spec = SensorSpec {
        torque_friction: 0.5,
        ..SensorSpec::ideal()
    };
    for (omega, friction) in [(2.0, 0.5), (-2.0, -0.5), (0.0, 0.0)] {
        let mut truth = at_rest(0);
        truth.wheels[1].omega = omega;
        truth.wheels[1].torque = 1.0;
        let read = sensors(&spec, 0).read(&truth).motor_torque[1];
        assert_eq!(read, Some(1.0 + friction));
    }
}

/// A link that turns at 0.3 rad/s and whose centre of mass accelerates by (2, -1) m/s^2.
fn accelerating(k: u32) -> Truth {
    let t = time(k);
    let bar = BarTruth {
        angle: 0.2 + 0.3 * t,
        velocity: Vec2::new(2.0, -1.0) * t,
        ..BarTruth::default()
    };
    Truth {
        time: t,
        links: [bar; 3],
        ..Truth::default()
    }
}

/// Closed form: theta + atan(a_x/(g + a_y)).
#[test]
fn inclinometers_measure_the_specific_force() {
    let spec = SensorSpec {
        specific_force: true,
        ..SensorSpec::ideal()
    };
    for (k, readings) in (0..100).zip(read(&spec, 1, 100, accelerating)) {
        let angle = if k == 0 {
            0.0
        } else {
            2.0_f64.atan2(GRAVITY - 1.0)
        };
        let expected = accelerating(k).links[0].angle + angle;
        // Rounding of a difference of velocities over 1 ms.
        let found = readings.inclination[0].expect("no losses");
        assert!((found - expected).abs() < 1e-12, "{found} {expected}");
    }
}

/// Closed form: the response to a step of a small angle after the first sample is 1 - exp(-t/lag).
/// The first reading has no lag.
#[test]
fn inclinometers_have_a_low_pass() {
    const ANGLE: f64 = 1e-4;
    fn inclined(k: u32) -> Truth {
        let mut truth = at_rest(k);
        truth.links[1].angle = if k == 0 { 0.0 } else { ANGLE };
        truth
    }
    let spec = SensorSpec {
        inclination_lag: 0.02,
        ..SensorSpec::ideal()
    };
    let found = values(&read(&spec, 1, 100, inclined), |r| r.inclination[1]);
    for (k, found) in (0..100).zip(found) {
        let expected = ANGLE * (1.0 - (-time(k) / 0.02).exp());
        // sin(angle) differs from the angle by 1e-8/6 of it, cos(angle) from 1 by 1e-8/2.
        assert!((found - expected).abs() < 1e-8 * ANGLE, "{k}");
    }
}

/// Statistics: the noise is white and the bias is drawn with its standard deviation.
#[test]
fn inclinometers_have_bias_and_white_noise() {
    let bias = SensorSpec {
        inclination_bias: 0.002,
        ..SensorSpec::ideal()
    };
    assert_drawn(0.002, &bias, |d| d.inclination_bias[0]);
    let spec = SensorSpec {
        inclination_noise: 0.001,
        ..bias
    };
    let bias = sensors(&spec, 2).drawn().inclination_bias[1];
    let found = values(&read(&spec, 2, 50_000, at_rest), |r| r.inclination[1]);
    let noise: Vec<f64> = found.iter().map(|v| v - bias).collect();
    assert_white(&noise, 0.001);
}

/// Statistics and closed form: scale error and first bias are drawn, the noise is white, and the
/// steps of the bias are white with the standard deviation walk sqrt(dt).
#[test]
fn gyros_have_scale_bias_walk_and_white_noise() {
    let spec = SensorSpec {
        rate_scale: 0.01,
        rate_bias: 0.005,
        ..SensorSpec::ideal()
    };
    assert_drawn(0.01, &spec, |d| d.rate_scale[0]);
    assert_drawn(0.005, &spec, |d| d.rate_bias[1]);
    let drawn = *sensors(&spec, 4).drawn();
    for (k, readings) in (0..50).zip(read(&spec, 4, 50, moving)) {
        let rate = moving(k).links[0].rate;
        let expected = (1.0 + drawn.rate_scale[0]) * rate + drawn.rate_bias[0];
        assert_eq!(readings.rate[0], Some(expected));
    }
    let noise = SensorSpec {
        rate_noise: 0.002,
        ..SensorSpec::ideal()
    };
    let readings = read(&noise, 1, 50_000, at_rest);
    assert_white(&values(&readings, |r| r.rate[0]), 0.002);

    let walk = SensorSpec {
        rate_walk: 0.01,
        ..SensorSpec::ideal()
    };
    let bias = values(&read(&walk, 1, 50_000, at_rest), |r| r.rate[1]);
    let steps: Vec<f64> = bias.windows(2).map(|b| b[1] - b[0]).collect();
    assert_white(&steps, 0.01 * DT.sqrt());
}

/// Statistics: the variance is sigma^2 from the first sample, the correlation exp(-lag/T).
///
/// Over a run of length L the variance has the relative standard error sqrt(2 T/L); that of the
/// correlation at any lag is at most as large.
#[test]
fn the_error_of_contact_angles_is_an_ornstein_uhlenbeck_process() {
    const SAMPLES: u32 = 300_000;
    let (sigma, correlated) = (0.035, 0.03);
    let spec = SensorSpec {
        contact_angle_error: sigma,
        contact_angle_time: correlated,
        ..SensorSpec::ideal()
    };
    let errors = values(&read(&spec, 1, SAMPLES, at_rest), |r| r.contact_angle[2]);
    let bound = 4.0 * (2.0 * correlated / time(SAMPLES)).sqrt();
    for lag in [0, 15, 30, 60, 300] {
        let expected = (-(lag as f64) * DT / correlated).exp();
        let found = correlation(&errors, lag) / (sigma * sigma);
        assert!((found - expected).abs() < bound, "lag {lag}: {found}");
    }
    let first = |seed| read(&spec, seed, 1, at_rest)[0].contact_angle[0];
    let starts: Option<Vec<f64>> = (0..10_000).map(first).collect();
    assert_white(&starts.expect("no losses"), sigma);
    let white = SensorSpec {
        contact_angle_time: 0.0,
        ..spec
    };
    let errors = values(&read(&white, 1, 50_000, at_rest), |r| r.contact_angle[2]);
    assert_white(&errors, sigma);
}

/// Closed form: all channels are sampled at the same instant, which differs from the time stamp by
/// white noise.
#[test]
fn jitter_moves_the_instant_of_sampling() {
    let spec = SensorSpec {
        jitter: 1e-4,
        ..SensorSpec::ideal()
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
        let read = readings.inclination[0].expect("no losses");
        // Rounding of the wheel angle of up to 50 rad, divided by its speed.
        assert!((read - (link.angle + delay * link.rate)).abs() < 1e-14);
        // The rates of gyro rate and torque are differences over the last millisecond, so they are
        // half a millisecond old.
        if k > 0 {
            let read = readings.rate[0].expect("no losses");
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
        ..SensorSpec::ideal()
    };
    let channels = |r: &Readings| {
        let mut all = Vec::new();
        for three in [r.wheel_angle, r.motor_torque, r.contact_angle] {
            all.extend(three.map(|v| v.is_none()));
        }
        for two in [r.inclination, r.rate] {
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
    type Parts = fn(&Readings) -> Vec<Option<f64>>;
    let angle: Parts = |r| r.wheel_angle.to_vec();
    let torque: Parts = |r| r.motor_torque.to_vec();
    let inclination: Parts = |r| r.inclination.to_vec();
    let rate: Parts = |r| r.rate.to_vec();
    let contact: Parts = |r| r.contact_angle.to_vec();
    let all = [angle, torque, inclination, rate, contact];
    let poor = SensorSpec::poor();
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
        ..SensorSpec::ideal()
    };
    let readings = read(&spec, 1, SAMPLES, at_rest);
    let channels: [fn(&Readings) -> Option<f64>; 10] = [
        |r| r.motor_torque[0],
        |r| r.motor_torque[1],
        |r| r.motor_torque[2],
        |r| r.inclination[0],
        |r| r.inclination[1],
        |r| r.rate[0],
        |r| r.rate[1],
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
