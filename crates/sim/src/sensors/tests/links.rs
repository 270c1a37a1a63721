//! Inclinometers and gyroscopes of the links.

use super::*;

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
        ..Grade::Ideal.sensors()
    };
    for (k, readings) in (0..100).zip(read(&spec, 1, 100, accelerating)) {
        let angle = if k == 0 {
            0.0
        } else {
            2.0_f64.atan2(GRAVITY - 1.0)
        };
        let expected = accelerating(k).links[0].angle + angle;
        // Rounding of a difference of velocities over 1 ms.
        let found = readings.link1.inclination.expect("no losses");
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
        ..Grade::Ideal.sensors()
    };
    let found = values(&read(&spec, 1, 100, inclined), |r| r.link2.inclination);
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
        ..Grade::Ideal.sensors()
    };
    assert_drawn(0.002, &bias, |d| d.inclination_bias[0]);
    let spec = SensorSpec {
        inclination_noise: 0.001,
        ..bias
    };
    let bias = sensors(&spec, 2).drawn().inclination_bias[1];
    let found = values(&read(&spec, 2, 50_000, at_rest), |r| r.link2.inclination);
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
        ..Grade::Ideal.sensors()
    };
    assert_drawn(0.01, &spec, |d| d.rate_scale[0]);
    assert_drawn(0.005, &spec, |d| d.rate_bias[1]);
    let drawn = *sensors(&spec, 4).drawn();
    for (k, readings) in (0..50).zip(read(&spec, 4, 50, moving)) {
        let rate = moving(k).links[0].rate;
        let expected = (1.0 + drawn.rate_scale[0]) * rate + drawn.rate_bias[0];
        assert_eq!(readings.link1.rate, Some(expected));
    }
    let noise = SensorSpec {
        rate_noise: 0.002,
        ..Grade::Ideal.sensors()
    };
    let readings = read(&noise, 1, 50_000, at_rest);
    assert_white(&values(&readings, |r| r.link1.rate), 0.002);

    let walk = SensorSpec {
        rate_walk: 0.01,
        ..Grade::Ideal.sensors()
    };
    let bias = values(&read(&walk, 1, 50_000, at_rest), |r| r.link2.rate);
    let steps: Vec<f64> = bias.windows(2).map(|b| b[1] - b[0]).collect();
    assert_white(&steps, 0.01 * DT.sqrt());
}
