//! Encoders, torques and contact angles.

use super::*;

/// Closed form: readings are whole counts, below the truth by less than one count.
#[test]
fn encoders_read_whole_counts() {
    let spec = SensorSpec {
        encoder_counts: ENCODER_COUNTS,
        ..Grade::Ideal.sensors()
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
        ..Grade::Ideal.sensors()
    };
    assert_drawn(0.02, &gain, |d| d.torque_gain[1]);
    let offset = SensorSpec {
        torque_offset: 0.1,
        ..Grade::Ideal.sensors()
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
        ..Grade::Ideal.sensors()
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
        ..Grade::Ideal.sensors()
    };
    for (k, readings) in (0..500).zip(read(&spec, 1, 500, moving)) {
        let found = readings.motor_torque[0].expect("no losses");
        let steps = found / 0.04;
        assert!((steps - steps.round()).abs() < 1e-12);
        assert!((found - moving(k).wheels[0].torque).abs() <= 0.02 + 1e-12);
    }
    let spec = SensorSpec {
        torque_friction: 0.5,
        ..Grade::Ideal.sensors()
    };
    for (omega, friction) in [(2.0, 0.5), (-2.0, -0.5), (0.0, 0.0)] {
        let mut truth = at_rest(0);
        truth.wheels[1].omega = omega;
        truth.wheels[1].torque = 1.0;
        let read = sensors(&spec, 0).read(&truth).motor_torque[1];
        assert_eq!(read, Some(1.0 + friction));
    }
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
        ..Grade::Ideal.sensors()
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
