//! Ramps on made-up estimates, and results of several ramps.

use super::super::result::testing::limit;
use super::super::together::together;
use super::*;
use robhaz_estimator::{
    Estimator, EstimatorSettings, KalmanReport, LinkReading, NeededFriction, PeakFriction,
    SensorFrame, SlipEvent,
};
use robhaz_model::Robot;

/// An estimate of a robot at rest with the friction of its wheels.
fn estimate(friction: [WheelFriction; 3]) -> Estimate {
    let link = LinkReading {
        inclination: Some(0.0),
        rate: Some(0.0),
        rate_error: 0.0,
    };
    let mut estimator = Estimator::new(
        &Robot::default_a(),
        EstimatorSettings::kalman_without_angles(),
    );
    let frame = SensorFrame {
        time: 0.0,
        wheel_angle: [Some(0.0); 3],
        motor_torque: [Some(0.0); 3],
        link1: link,
        link2: link,
        contact_angle: [None; 3],
        ..SensorFrame::default()
    };
    let mut estimate = estimator.update(&frame).expect("a robot at rest");
    estimate.kalman = Some(KalmanReport {
        friction,
        ..KalmanReport::default()
    });
    estimate
}

/// A wheel that has never needed more.
fn needs(value: f64) -> WheelFriction {
    let needed = NeededFriction { value, sigma: 0.01 };
    WheelFriction {
        needed: Some(needed),
        peak: PeakFriction {
            needed,
            ..PeakFriction::default()
        },
        ..WheelFriction::default()
    }
}

/// Runs a ramp of T/N of 0.1/s on wheel 2; `change` can change the wheels at a time (s).
fn run(change: impl Fn(f64, &mut [WheelFriction; 3])) -> (FrictionTest, f64) {
    let mut test = FrictionTest::new(1, 10.0);
    for k in 1..10_000 {
        let t = 1e-3 * f64::from(k);
        let mut wheels = [needs(-0.05 * t), needs(0.1 * t), needs(-0.05 * t)];
        change(t, &mut wheels);
        if test.update(10.0 + t, Some(&estimate(wheels))) == FrictionTestPhase::Done {
            return (test, t);
        }
    }
    (test, f64::INFINITY)
}

/// The event gives mu_max, place and time; the test is done when the wheel grips, with the distance
/// that it slid.
#[test]
fn a_slip_gives_the_result() {
    let (test, t) = run(|t, wheels| {
        if t > 3.0 && t < 3.4 {
            wheels[1].slid = Some(0.01 * (t - 2.8));
        }
        if (t - 3.001).abs() < 1e-6 {
            wheels[1].slip_event = Some(SlipEvent {
                mu_max: 0.29,
                sigma: 0.01,
                systematic: 0.0,
                load: 40.0,
                age: 0.2,
                place: Some(0.7),
            });
        }
    });
    let result = test.result;
    assert_eq!((result.wheel, result.end), (1, FrictionTestEnd::Slipped));
    assert_eq!(
        (result.mu, result.sigma, result.place),
        (0.29, 0.01, Some(0.7))
    );
    assert!(
        (result.time - 12.801).abs() < 1e-9 && (t - 3.4).abs() < 2e-3,
        "{result:?} {t}"
    );
    assert!((result.slipped_distance - 0.006).abs() < 2e-5, "{result:?}");
    assert!((result.duration - t).abs() < 1e-9);
}

/// Without slip: the lower bound is the largest T/N, and the end says why.
#[test]
fn other_ends_give_a_lower_bound() {
    let (test, t) = run(|t, wheels| {
        if t > 5.0 {
            wheels[2].slid = Some(0.0);
        }
    });
    let result = test.result;
    // It slips at half the friction that the tested one bears: on ground of its own.
    assert_eq!(
        (result.end, result.limits),
        (FrictionTestEnd::OtherWheel(2), [None; 2])
    );
    // Within two samples of 0.1/s.
    assert!(
        (t - 5.0).abs() < 2e-3 && (result.mu - 0.5).abs() < 2e-4,
        "{result:?}"
    );
    // What slipped before the ramp, and slips on, does not end it.
    let (test, t) = run(|t, wheels| {
        wheels[2].slid = Some(0.0);
        if t > 4.0 {
            wheels[1].needed = None;
        }
    });
    assert_eq!(test.result.end, FrictionTestEnd::NotClear);
    assert!((t - 4.5).abs() < 5e-3, "{t}");
    let mut test = FrictionTest::new(0, 0.0);
    assert_eq!(
        test.end(FrictionTestEnd::TorqueLimit),
        FrictionTestPhase::Done
    );
    assert_eq!(test.result.end, FrictionTestEnd::TorqueLimit);
    assert_eq!(test.update(1.0, None), FrictionTestPhase::Done);
}

/// Another wheel slips, which needs `share` of the friction that the tested one needs: more, about
/// as much.
#[test]
fn another_wheel_at_the_limit_tells_mu() {
    let ramp = |share: f64| {
        let (test, _) = run(|t, wheels| {
            wheels[0] = needs(-0.1 * share * t);
            wheels[0].slid = (t > 3.0).then_some(0.0);
        });
        test.result
    };
    // Within two samples of 0.15/s.
    let near = |found: f64, expected: f64| (found - expected).abs() < 3e-4;
    let both = ramp(1.0);
    assert_eq!((both.end, both.ramps), (FrictionTestEnd::EitherWheel(0), 1));
    assert!(near(both.mu, 0.3), "{both:?}");
    let other = ramp(1.5);
    assert_eq!(
        (other.end, other.ramps),
        (FrictionTestEnd::OtherWheel(0), 0)
    );
    let [Some(limit), None] = other.limits else {
        panic!("{other:?}");
    };
    assert!(near(limit.friction(&[0.0; 3]).mu, 0.45), "{limit:?}");
}

/// A result after ramps with the given limits.
fn result(wheel: usize, limits: [Option<RampLimit>; 2]) -> FrictionTestResult {
    FrictionTestResult {
        end: FrictionTestEnd::Slipped,
        ramps: 1,
        limits,
        duration: 8.0,
        slipped_distance: 0.01,
        ..FrictionTest::new(wheel, 0.0).result
    }
}

/// `together` for one result.
fn alone(test: FrictionTestResult) -> FrictionTestResult {
    let [found, _, _] = together(&[Some(test), None, None]);
    found.unwrap_or(test)
}

/// Closed form: one ramp has the offset's deviation, here 1 N of 40 N, which the grid's end at
/// three deviations cuts by 1.3 %. An offset of 2 N takes no part in the mean of two ramps at mu =
/// 0.5 with loads of 30 and 50 N: by the gain of a Kalman filter, 0.1067^2/(0.1067^2 + 0.0141^2),
/// 1.7 % of its 0.067 and 0.04 remain. The t distribution moves that by less than 0.002.
#[test]
fn two_ramps_show_the_offset() {
    let one = alone(result(
        0,
        [Some(limit(0, [0.5, -0.3, -0.2], [40.0; 3], 1.0)), None],
    ));
    assert!((one.mu - 0.5).abs() < 1e-3, "{one:?}");
    assert!((one.systematic - 0.025).abs() < 5e-4, "{one:?}");
    // 2 % of mu and 0.01 for the rest.
    let rest: f64 = 0.01_f64.hypot(0.01);
    assert!((one.sigma - 0.025_f64.hypot(rest)).abs() < 5e-4, "{one:?}");

    let first = limit(
        0,
        [(15.0 + 2.0) / 30.0, -0.2, -0.2],
        [30.0, 50.0, 50.0],
        2.0,
    );
    let second = limit(0, [(-25.0 + 2.0) / 50.0, 0.2, 0.2], [50.0, 40.0, 40.0], 2.0);
    let both = result(0, [Some(first), None]).combined(&result(0, [Some(second), None]));
    assert!((both.duration - 16.0).abs() < 1e-15 && (both.slipped_distance - 0.02).abs() < 1e-15);
    assert_eq!(both.ramps, 2);
    let both = alone(both);
    assert!((both.mu - 0.5).abs() < 0.003, "{both:?}");
    assert!(both.systematic < 0.1 * 2.0 / 30.0, "{both:?}");
}

/// Closed form: three offsets of equal deviation whose sum is known correlate with -1/2. If both
/// ramps of one wheel show that its offset is one deviation, the others' are -1/2 in the mean: mu
/// of a wheel with one ramp changes by half the deviation, 0.0125, times the gain 0.05^2/(0.05^2 +
/// 0.0141^2) = 0.93.
#[test]
fn tests_of_other_wheels_show_offsets_too() {
    let pair = [
        Some(limit(1, [-0.2, 0.525, -0.2], [40.0; 3], 1.0)),
        Some(limit(1, [0.2, -0.475, 0.2], [40.0; 3], 1.0)),
    ];
    let single = result(0, [Some(limit(0, [0.5, -0.2, -0.2], [40.0; 3], 1.0)), None]);
    let [Some(one), Some(other), None] = together(&[Some(single), Some(result(1, pair)), None])
    else {
        panic!("two results");
    };
    assert!((one.mu - 0.5 - 0.93 * 0.0125).abs() < 1e-3, "{one:?}");
    assert!((other.mu - 0.5).abs() < 3e-3, "{other:?}");
    // sqrt(1 - 0.93/4) of the deviation remains.
    assert!((one.systematic - 0.876 * 0.025).abs() < 5e-4, "{one:?}");
}

/// Property: where both other wheels bear the reaction at the limit of friction, their tractions
/// show the tested wheel's offset: mu = 0.3, an offset of 1.5 N on the tested wheel and -0.75 N on
/// both others. Less than half of the error remains. And of ramps that cannot agree, none counts
/// more, and half their difference is within the deviation.
#[test]
fn the_other_wheels_show_the_offset() {
    let first = limit(0, [(12.0 + 1.5) / 40.0, 0.0, 0.0], [40.0; 3], 1.0);
    let second = limit(
        0,
        [(-12.0 + 1.5) / 50.0, 0.2829, 0.2829],
        [50.0, 44.0, 44.0],
        1.0,
    );
    let one = alone(result(0, [Some(first), None]));
    let both = alone(result(0, [Some(first), Some(second)]));
    assert!((one.mu - 0.3).abs() > 0.035, "{one:?}");
    assert!(
        (both.mu - 0.3).abs() < 0.5 * (one.mu - 0.3).abs(),
        "{both:?}"
    );
    assert!(
        both.sigma < one.sigma && (both.mu - 0.3).abs() < both.sigma,
        "{both:?}"
    );
    for (other, middle) in [(0.9, 0.62), (0.05, 0.19)] {
        let elsewhere = limit(0, [-other, 0.0, 0.0], [40.0; 3], 1.0);
        let apart = alone(result(0, [Some(first), Some(elsewhere)]));
        // The offsets can bring the ramps nearer by 0.1.
        assert!((apart.mu - middle).abs() < 0.1, "{apart:?}");
        assert!(apart.sigma > 0.5 * (other - middle).abs(), "{apart:?}");
    }
}

/// A test whose readings hide the slip ends at once, with a lower bound, before the wheel can run
/// away; noise for less than the patience does not count.
#[test]
fn noise_that_hides_slip_ends_a_test() {
    let hidden_from = |from: f64, to: f64| {
        run(move |t, wheels| {
            wheels[1].slip_noise = if t > from && t < to { 1.4 } else { 0.4 };
        })
    };
    let (test, t) = hidden_from(2.0, f64::INFINITY);
    assert_eq!(test.result.end, FrictionTestEnd::Noise);
    assert!((t - 2.0 - FrictionTest::PATIENCE).abs() < 0.01, "{t}");
    assert!(test.result.mu > 0.2 && test.result.ramps == 0);
    assert!((test.result.slip_noise - 1.4).abs() < 1e-12);
    let (test, _) = hidden_from(2.0, 2.3);
    assert_ne!(test.result.end, FrictionTestEnd::Noise);
}
