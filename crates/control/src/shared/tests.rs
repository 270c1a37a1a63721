use super::*;
use crate::kind::ControlKind;
use robhaz_estimator::{EstimateError, Estimator, EstimatorSettings, LinkReading, SensorFrame};
use robhaz_model::Robot;

fn settings() -> ControlSettings {
    ControlSettings {
        kind: ControlKind::Shared,
        robot: Robot::default_a(),
        viscous_damping: 0.15,
        kp: 5.0,
        ki: 50.0,
        torque_limit: 10.0,
        tracking_time: 0.1,
    }
}

/// Readings of a robot on level ground with these wheel angles (rad).
fn frame(time: f64, wheel_angle: [f64; 3]) -> SensorFrame {
    let link = LinkReading {
        inclination: Some(0.0),
        rate: Some(0.0),
    };
    SensorFrame {
        time,
        wheel_angle: wheel_angle.map(Some),
        motor_torque: [Some(0.0); 3],
        link1: link,
        link2: link,
        contact_angle: [Some(0.0); 3],
    }
}

/// An estimate with these normal forces (N).
fn estimate(normal_force: [f64; 3]) -> Result<Estimate, EstimateError> {
    let mut estimator = Estimator::new(&Robot::default_a(), EstimatorSettings::paper_wheels());
    let estimate = estimator.update(&frame(0.0, [0.0; 3]))?;
    Ok(Estimate {
        normal_force,
        ..estimate
    })
}

/// The last torques of wheels that turn at constant speeds (rad/s) for a time (s).
fn held(shared: &mut Shared, estimate: Option<&Estimate>, speeds: [f64; 3], time: f64) -> [f64; 3] {
    let mut torques = [0.0; 3];
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a small count"
    )]
    let samples = (time * 1e3) as u32;
    for k in 0..=samples {
        let t = shared.time + if k == 0 { 0.0 } else { 1e-3 };
        let frame = frame(t, speeds.map(|speed| speed * t));
        torques = shared.update(&ControlInput {
            frame: &frame,
            estimate,
            set_speed: 2.0,
        });
    }
    torques
}

/// Closed form: torques less losses are to each other as the estimated loads.
#[test]
fn every_wheel_needs_the_same_friction() {
    let loads = [20.0, 45.0, 70.0];
    let estimate = estimate(loads).expect("level ground");
    // 1 s: the loads have settled to exp(-20).
    let torques = held(
        &mut Shared::new(&settings()),
        Some(&estimate),
        [1.9; 3],
        1.0,
    );
    let ratios = [0, 1, 2].map(|i| (torques[i] - 0.15 * 1.9) / loads[i]);
    assert!(ratios[0] > 0.01);
    for ratio in ratios {
        // The filter of the speed settles with exp(-t/5 ms): rounding of the readings remains.
        assert!((ratio / ratios[0] - 1.0).abs() < 1e-6, "{ratios:?}");
    }
}

/// Without an estimate, with stale readings and at an end stop the shares are equal.
#[test]
fn without_a_good_estimate_the_shares_are_equal() {
    let good = estimate([20.0, 45.0, 70.0]).expect("level ground");
    for flags in [Some(Flags::SENSOR_STALE), Some(Flags::AT_STOP), None] {
        let flagged = flags.map(|flags| Estimate { flags, ..good });
        let mut shared = Shared::new(&settings());
        let torques = held(&mut shared, flagged.as_ref(), [1.9; 3], 1.0);
        assert!((torques[0] - torques[1]).abs() + (torques[1] - torques[2]).abs() < 1e-9);
        assert!(torques[0] > 0.1);
    }
}

/// A load with a large standard deviation is drawn to the mean load.
#[test]
fn uncertain_loads_count_less() {
    let mut uncertain = estimate([20.0, 45.0, 70.0]).expect("level ground");
    let mut covariance = [[0.0; 6]; 6];
    for (i, row) in covariance.iter_mut().enumerate() {
        row[i] = 23.0 * 23.0;
    }
    uncertain.covariance = Some(covariance);
    let mut shared = Shared::new(&settings());
    held(&mut shared, Some(&uncertain), [1.9; 3], 1.0);
    let mean = Robot::default_a().mean_wheel_load();
    let spread = 0.25 * mean * mean;
    for (found, load) in shared.loads.iter().zip([20.0, 45.0, 70.0]) {
        let expected = mean + spread / (spread + 23.0 * 23.0) * (load - mean);
        assert!((found - expected).abs() < 1e-6, "{found} {expected}");
    }
}

/// A wheel that spins loses torque, down to none; the others are held to the set speed, which it does not blur.
#[test]
fn a_spinning_wheel_loses_its_torque() {
    let estimate = estimate([45.0; 3]).expect("level ground");
    let torque = |front: f64| {
        held(
            &mut Shared::new(&settings()),
            Some(&estimate),
            [front, 1.5, 1.5],
            0.1,
        )
    };
    let [even, slow, fast] = [1.5, 2.1, 6.0].map(torque);
    assert!(even[0] > 0.5);
    // 2.1 rad/s is within 0.7 rad/s of the median.
    assert!((slow[0] - slow[1] - 0.15 * 0.6).abs() < 1e-6, "{slow:?}");
    assert!(fast[0] == 0.0 && fast[1] > 0.1, "{fast:?}");
    assert!((reference([6.0, 1.9, 1.9], 0.7) - (1.9 + 0.7 / 3.0)).abs() < 1e-12);
}

/// Without load a wheel gets what turns it and a proportional speed control.
#[test]
fn a_wheel_in_the_air_holds_its_speed() {
    let estimate = estimate([0.0, 68.0, 69.0]).expect("level ground");
    let torque = |front: f64| {
        held(
            &mut Shared::new(&settings()),
            Some(&estimate),
            [front, 2.0, 2.0],
            1.0,
        )[0]
    };
    assert!((torque(2.0) - 0.15 * 2.0).abs() < 1e-6);
    // Reference: two thirds of the way from the front wheel to the others.
    let expected = 0.15 * 1.7 + 5.0 * 0.2;
    assert!((torque(1.7) - expected).abs() < 1e-6);
}

/// Blocked wheels: the integral stays bounded, and the torque falls as soon as the wheels turn too fast.
#[test]
fn the_integral_does_not_wind_up() {
    let estimate = estimate([45.0; 3]).expect("level ground");
    let mut shared = Shared::new(&settings());
    let blocked = held(&mut shared, Some(&estimate), [0.0; 3], 20.0);
    for torque in blocked {
        assert!((torque - 10.0).abs() < 1e-9);
    }
    // Back-calculation with T_t = Kp/Ki: Ki I approaches the limit.
    let integral = shared.integral.expect("started");
    assert!((50.0 * integral - 10.0).abs() < 1e-6, "{integral}");
}

/// Missing readings, jumps of encoders and of clocks, and absurd estimates: the torques stay finite and within the limit.
#[test]
fn torques_stay_within_the_limit() {
    let mut absurd = estimate([f64::NAN, f64::INFINITY, -1e9]).expect("level ground");
    let mut shared = Shared::new(&settings());
    for k in 0..2000_u32 {
        let jump = if k % 97 == 0 { 1e6 } else { 0.0 };
        let mut readings = frame(
            1e-3 * f64::from(k) + jump,
            [jump, 0.01 * f64::from(k % 7), 0.0],
        );
        if k % 5 == 0 {
            readings.wheel_angle[2] = None;
            readings.motor_torque = [None; 3];
        }
        if k % 11 == 0 {
            readings.wheel_angle[1] = Some(f64::NAN);
        }
        if k == 1000 {
            absurd.normal_force = [0.0; 3];
        }
        let torques = shared.update(&ControlInput {
            frame: &readings,
            estimate: Some(&absurd),
            set_speed: if k > 1500 { -2.0 } else { 2.0 },
        });
        for torque in torques {
            assert!(torque.abs() <= 10.0, "{k}: {torques:?}");
        }
    }
}
