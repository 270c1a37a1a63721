use super::*;
use crate::input::{ControlKind, FrictionTestPlan};
use robhaz_estimator::{
    ContactEstimate, EstimateError, Estimator, EstimatorSettings, KalmanReport, LinkReading,
    SensorFrame,
};
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
        friction_test: FrictionTestPlan::default(),
    }
}

/// Readings of a robot on level ground with these wheel angles (rad).
fn frame(time: f64, wheel_angle: [f64; 3]) -> SensorFrame {
    let link = LinkReading {
        inclination: Some(0.0),
        rate: Some(0.0),
        rate_error: 0.0,
    };
    SensorFrame {
        time,
        wheel_angle: wheel_angle.map(Some),
        motor_torque: [Some(0.0); 3],
        link1: link,
        link2: link,
        contact_angle: [Some(0.0); 3],
        ..SensorFrame::default()
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
    uncertain.kalman = Some(KalmanReport {
        covariance,
        ..KalmanReport::default()
    });
    let mut shared = Shared::new(&settings());
    held(&mut shared, Some(&uncertain), [1.9; 3], 1.0);
    let mean = Robot::default_a().mean_wheel_load();
    let spread = 0.25 * mean * mean;
    for (found, load) in shared.loads.iter().zip([20.0, 45.0, 70.0]) {
        let expected = mean + spread / (spread + 23.0 * 23.0) * (load - mean);
        assert!((found - expected).abs() < 1e-6, "{found} {expected}");
    }
}

/// Closed form: beyond the allowed difference a wheel that spins gets less and one that stays
/// behind gets more, by Kp times the excess; within it the shares stay equal. A wheel that spins
/// has little influence on the reference.
#[test]
fn a_wheel_that_differs_is_brought_back() {
    let estimate = estimate([45.0; 3]).expect("level ground");
    // 0.15 times 2 rad/s, and 0.05 rad/s.
    let allowed = 0.35;
    for front in [1.6, 1.3, 2.1, 0.9] {
        let speeds = [front, 1.5, 1.5];
        let mut shared = Shared::new(&settings());
        let torques = held(&mut shared, Some(&estimate), speeds, 0.02);
        // The filter of the speeds has come to 1 - exp(-4); the torques are compared at the speeds
        // that it shows.
        let shown = [0, 1].map(|i| shared.speeds[i].update(f64::NAN, None));
        let reference = mean_near_median([shown[0], shown[1], shown[1]], allowed);
        let [front, middle] = shown.map(|speed| beyond(speed - reference, allowed));
        let expected = 0.15 * (shown[0] - shown[1]) - 5.0 * (front - middle);
        assert!((front != 0.0) == (speeds[0] > 2.0 || speeds[0] < 1.0));
        assert!(
            (torques[0] - torques[1] - expected).abs() < 1e-9,
            "{torques:?}"
        );
    }
    assert!((mean_near_median([6.0, 1.9, 1.9], 0.7) - (1.9 + 0.7 / 3.0)).abs() < 1e-12);
}

/// While a wheel slides the pace falls to a quarter; then it recovers within the recovery time.
#[test]
fn the_pace_falls_while_a_wheel_slides() {
    let mut estimate = estimate([45.0; 3]).expect("level ground");
    let mut shared = Shared::new(&settings());
    held(&mut shared, Some(&estimate), [1.9; 3], 0.1);
    assert!((shared.pace - 1.0).abs() < 1e-12);
    let mut contacts = [ContactEstimate::default(); 3];
    contacts[2].sliding = true;
    estimate.kalman = Some(KalmanReport {
        contact: contacts,
        ..KalmanReport::default()
    });
    held(&mut shared, Some(&estimate), [1.9; 3], 2.0);
    // exp(-10) of 0.75.
    assert!((shared.pace - 0.25).abs() < 1e-4, "{}", shared.pace);
    estimate.kalman = None;
    held(&mut shared, Some(&estimate), [1.9; 3], 3.01);
    assert!((shared.pace - 1.0).abs() < 1e-12);
    // So does a wheel that differs by more than twice what is allowed.
    held(&mut shared, Some(&estimate), [4.0, 1.9, 1.9], 2.0);
    assert!((shared.pace - 0.25).abs() < 1e-4, "{}", shared.pace);
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

/// Blocked wheels: the integral stays bounded, and the torque falls as soon as the wheels turn too
/// fast.
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

/// Missing readings, jumps of encoders and of clocks, and absurd estimates: the torques stay finite
/// and within the limit.
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

/// Set speeds and torques that are no finite number: the torques of the samples after them are those of a log in which
/// the last set speed held, and the torque was not read.
#[test]
fn what_is_no_number_does_not_last() {
    let torques = |set: f64, first: Option<f64>| {
        let mut shared = Shared::new(&settings());
        let mut last = [0.0; 3];
        for k in 0..500_u32 {
            let mut readings = frame(1e-3 * f64::from(k), [2e-3 * f64::from(k); 3]);
            if k == 0 {
                readings.motor_torque = [first, Some(0.1), None];
            }
            last = shared.update(&ControlInput {
                frame: &readings,
                estimate: None,
                set_speed: if k == 200 { set } else { 2.0 },
            });
        }
        last.map(f64::to_bits)
    };
    let right = torques(2.0, None);
    for wrong in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        assert_eq!(torques(wrong, Some(wrong)), right, "{wrong}");
    }
}

/// Settings with which there is no control are refused by name, and no others.
#[test]
fn wrong_settings_are_refused_by_name() {
    type Part = fn(&mut ControlSettings) -> &mut f64;
    let parts: [(&str, Part, bool); 6] = [
        ("viscous_damping", |s| &mut s.viscous_damping, true),
        ("kp", |s| &mut s.kp, true),
        ("ki", |s| &mut s.ki, true),
        ("torque_limit", |s| &mut s.torque_limit, false),
        ("tracking_time", |s| &mut s.tracking_time, false),
        ("friction_test.rate", |s| &mut s.friction_test.rate, false),
    ];
    for (name, part, may_be_zero) in parts {
        for wrong in [f64::NAN, f64::INFINITY, -1.0, 0.0] {
            let mut settings = settings();
            *part(&mut settings) = wrong;
            let found = settings.check().map_err(|error| error.field);
            let allowed = wrong.abs() <= 0.0 && may_be_zero;
            assert_eq!(found, if allowed { Ok(()) } else { Err(name) }, "{wrong}");
            settings.kind = ControlKind::Speed;
            assert_eq!(settings.check(), Ok(()));
        }
    }
}

/// Largest speed (rad/s) of three wheels in the air after a step of the set speed from 0 to 1
/// rad/s, and their speed after 2 s, with gains at `factor` times their limits and a sample rate
/// (Hz).
fn step_response(factor: f64, rate: f64) -> (f64, f64) {
    let mut settings = settings();
    let ratio = largest_integral_ratio(rate);
    settings.kp = factor * largest_proportional_gain(&settings.robot, rate);
    settings.ki = ratio * settings.kp;
    settings.tracking_time = 1.0 / ratio;
    settings.torque_limit = 1e9;
    let inertia = settings.robot.mass.wheel_inertia + settings.robot.mass.rotor_inertia;
    let mut shared = Shared::new(&settings);
    let (mut angle, mut speed, mut held, mut largest) = (0.0, 0.0, 0.0, 0.0_f64);
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a small count"
    )]
    let samples = (2.0 * rate) as u32;
    for k in 0..samples {
        let readings = frame(f64::from(k) / rate, [angle; 3]);
        let [torque, _, _] = shared.update(&ControlInput {
            frame: &readings,
            estimate: None,
            set_speed: 1.0,
        });
        // The command acts from the next sample on. Midpoint rule within a sample.
        for _ in 0..10 {
            let dt = 0.1 / rate;
            let acceleration = |speed: f64| (held - 0.15 * speed) / inertia;
            let middle = speed + 0.5 * dt * acceleration(speed);
            angle += dt * middle;
            speed += dt * acceleration(middle);
            largest = largest.max(speed);
        }
        held = torque;
    }
    (largest, speed)
}

/// Stability: at the largest gains wheels in the air settle at their set speed with an overshoot
/// that fits a phase margin of 30 deg (60 % or less); at four times these gains they do not settle.
#[test]
fn the_largest_gains_are_stable() {
    for rate in [20.0, 100.0, 1000.0, 1e4] {
        let (largest, end) = step_response(1.0, rate);
        assert!(largest < 1.6, "{rate} Hz: {largest}");
        // A lag of 80 ms at 20 Hz: 2 s are 25 lags.
        assert!((end - 1.0).abs() < 1e-2, "{rate} Hz: {end}");
        let (largest, _) = step_response(4.0, rate);
        assert!(largest > 2.0, "{rate} Hz: {largest}");
    }
}
