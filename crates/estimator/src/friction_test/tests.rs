//! Ramps on made-up estimates, and results of several ramps.

use super::*;
use crate::friction::{NeededFriction, SlipEvent};
use crate::{Estimator, EstimatorSettings, LinkReading, SensorFrame};
use robhaz_model::Robot;

/// An estimate of a robot at rest with the friction of its wheels.
fn estimate(friction: [WheelFriction; 3]) -> Estimate {
    let link = LinkReading {
        inclination: Some(0.0),
        rate: Some(0.0),
    };
    let mut estimator = Estimator::new(
        &Robot::default_a(),
        EstimatorSettings::best_without_angles(),
    );
    let frame = SensorFrame {
        time: 0.0,
        wheel_angle: [Some(0.0); 3],
        motor_torque: [Some(0.0); 3],
        link1: link,
        link2: link,
        contact_angle: [None; 3],
    };
    let mut estimate = estimator.update(&frame).expect("a robot at rest");
    estimate.friction = Some(friction);
    estimate
}

fn needs(value: f64) -> WheelFriction {
    WheelFriction {
        needed: Some(NeededFriction { value, sigma: 0.01 }),
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

/// The event gives mu_max, place and time; the test is done when the wheel grips, with the distance that it slid.
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
                lasting: 0.0,
                load: 40.0,
                age: 0.2,
                place: Some(0.7),
            });
        }
    });
    let result = test.result();
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

/// Closed form: an error of 2 N on both tractions at mu = 0.5 with loads of 30 and 50 N has no effect on the combined result.
#[test]
fn lasting_errors_cancel() {
    let ramp = |traction: f64, load: f64| FrictionTestResult {
        end: FrictionTestEnd::Slipped,
        mu: traction / load,
        sigma: 0.05,
        lasting: 0.04,
        load,
        ramps: 1,
        slipped_distance: 0.01,
        duration: 8.0,
        ..FrictionTest::new(0, 1.0).result()
    };
    let (first, second) = (ramp(15.0 + 2.0, 30.0), ramp(25.0 - 2.0, 50.0));
    let both = first.combined(&second);
    assert!((both.mu - 0.5).abs() < 1e-15 && both.ramps == 2, "{both:?}");
    assert!((both.sigma - 0.03).abs() < 1e-15);
    assert!(
        (both.duration - 16.0).abs() < 1e-15 && (both.slipped_distance - 0.02).abs() < 1e-15
    );
    let without = FrictionTestResult {
        end: FrictionTestEnd::OtherWheel(1),
        ..second
    };
    let both = first.combined(&without);
    assert_eq!(
        (both.mu, both.sigma, both.ramps),
        (first.mu, first.sigma, 1)
    );
}

/// Without slip: the lower bound is the largest T/N, smoothed over 0.1 s, and the end says why.
#[test]
fn other_ends_give_a_lower_bound() {
    let (test, t) = run(|t, wheels| {
        if t > 5.0 {
            wheels[2].slid = Some(0.0);
        }
    });
    let result = test.result();
    assert_eq!(result.end, FrictionTestEnd::OtherWheel(2));
    // The low pass lags by 0.1 s, 0.01.
    assert!(
        (t - 5.0).abs() < 2e-3 && (result.mu - 0.49).abs() < 1e-3,
        "{result:?}"
    );
    let (test, t) = run(|t, wheels| {
        if t > 4.0 {
            wheels[1].needed = None;
        }
    });
    assert_eq!(test.result().end, FrictionTestEnd::NotClear);
    assert!((t - 4.5).abs() < 5e-3, "{t}");
    let mut test = FrictionTest::new(0, 0.0);
    assert_eq!(
        test.end(FrictionTestEnd::TorqueLimit),
        FrictionTestPhase::Done
    );
    assert_eq!(test.result().end, FrictionTestEnd::TorqueLimit);
    assert_eq!(test.update(1.0, None), FrictionTestPhase::Done);
}
