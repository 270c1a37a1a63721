//! Ramps on made-up estimates: what is commanded when.

use super::*;
use crate::{ControlKind, FrictionTestPlan};
use robhaz_estimator::{
    Estimate, Estimator, EstimatorSettings, KalmanReport, LinkReading, NeededFriction, SensorFrame,
    SlipEvent, WheelFriction,
};
use robhaz_model::Robot;

const IDLE: f64 = 0.3;
const RATE: f64 = 0.5;

fn settings(torque_limit: f64, plan: FrictionTestPlan) -> ControlSettings {
    ControlSettings {
        kind: ControlKind::FrictionTest,
        robot: Robot::default_a(),
        viscous_damping: 0.15,
        kp: 5.0,
        ki: 50.0,
        torque_limit,
        tracking_time: 0.1,
        friction_test: plan,
    }
}

fn plan(wheels: [Option<usize>; 3], both_ways: bool) -> FrictionTestPlan {
    FrictionTestPlan {
        wheels,
        start: 1.0,
        rate: RATE,
        both_ways,
    }
}

fn frame(time: f64) -> SensorFrame {
    let link = LinkReading {
        inclination: Some(0.0),
        rate: Some(0.0),
        rate_error: 0.0,
    };
    SensorFrame {
        time,
        wheel_angle: [Some(0.0); 3],
        motor_torque: [Some(IDLE); 3],
        link1: link,
        link2: link,
        contact_angle: [None; 3],
        ..SensorFrame::default()
    }
}

/// A robot at rest of which one wheel needs T/N = torque less idle over 4.6 N m, and slips beyond
/// 0.5 for as long as that lasts.
struct World {
    estimate: Estimate,
    slips: bool,
}

impl World {
    fn new() -> Option<Self> {
        let settings = EstimatorSettings::kalman_without_angles();
        let mut estimator = Estimator::new(&Robot::default_a(), settings);
        Some(Self {
            estimate: estimator.update(&frame(0.0)).ok()?,
            slips: false,
        })
    }

    fn answer(&mut self, commands: &[WheelCommand; 3]) {
        let mut friction = [WheelFriction {
            needed: Some(NeededFriction::default()),
            ..WheelFriction::default()
        }; 3];
        for (wheel, command) in friction.iter_mut().zip(commands) {
            let WheelCommand::Torque(torque) = command else {
                continue;
            };
            let value = (torque - IDLE) / 4.6;
            let needed = NeededFriction { value, sigma: 0.01 };
            wheel.needed = Some(needed);
            wheel.peak.needed = needed;
            let begins = value.abs() > 0.5 && !self.slips;
            self.slips = value.abs() > 0.5 || (self.slips && value.abs() > 0.2);
            wheel.slid = self.slips.then_some(0.01);
            wheel.slip_event = begins.then_some(SlipEvent {
                mu_max: 0.5,
                sigma: 0.01,
                systematic: 0.0,
                load: 46.0,
                age: 0.0,
                place: None,
            });
        }
        self.estimate.kalman = Some(KalmanReport {
            friction,
            ..KalmanReport::default()
        });
    }
}

/// Commands of `seconds` at 1 kHz.
fn run(
    tests: &mut FrictionTests,
    seconds: u32,
) -> Option<impl Fn(f64, usize) -> Option<f64> + use<>> {
    let mut world = World::new()?;
    let mut all = std::vec::Vec::new();
    for k in 0..1000 * seconds {
        let frame = frame(1e-3 * f64::from(k));
        let commands = tests.update(&ControlInput {
            frame: &frame,
            estimate: Some(&world.estimate),
            set_speed: 2.0,
        });
        world.answer(&commands);
        all.push(commands);
    }
    Some(move |time: f64, wheel: usize| {
        let at = all.get((1000.0 * time).round() as usize)?;
        match at[wheel] {
            WheelCommand::Torque(torque) => Some(torque),
            WheelCommand::Planned | WheelCommand::Speed(_) => None,
        }
    })
}

/// Closed form: the first ramp rises from the present torque with its rate up to 0.3 + 0.5 * 4.6 N
/// m at 5.6 s, falls to idle within 0.3 s, then the second one goes to three quarters of the torque
/// expected within 1 s and on with its rate; the other wheels keep their plans. After a pause of 2
/// s the next wheel follows.
#[test]
fn ramps_follow_each_other() {
    let plan = plan([Some(0), Some(2), None], true);
    let mut tests = FrictionTests::new(&settings(10.0, plan));
    let torque = run(&mut tests, 30).expect("an estimate at rest");
    assert_eq!(torque(0.99, 0), None);
    for time in [1.0, 2.0, 5.5] {
        let expected = IDLE + RATE * (time - 1.0);
        assert!((torque(time, 0).expect("a ramp") - expected).abs() < 1e-9);
        assert_eq!((torque(time, 1), torque(time, 2)), (None, None));
    }
    let end = 1.0 + 0.5 * 4.6 / RATE;
    // The second ramp has just begun.
    assert!((torque(end + 0.31, 0).expect("idle") - IDLE).abs() < 1e-3);
    // The load of the estimate at rest: 43.58 N.
    let first = IDLE - 0.75 * 0.5 * 43.58 * 0.1;
    for time in [1.5, 2.0] {
        let found = torque(end + 0.305 + time, 0).expect("the second ramp");
        let expected = first - RATE * (time - 1.0);
        // A few samples of the sequence.
        assert!((found - expected).abs() < 5e-3, "{found} {expected}");
    }
    let results = tests.results();
    let front = results[0].expect("a result");
    assert_eq!(
        (front.wheel, front.end, front.ramps),
        (0, FrictionTestEnd::Slipped, 2)
    );
    // Within two samples of 0.11/s.
    assert!((front.mu - 0.5).abs() < 3e-4, "{front:?}");
    let rear = results[1].expect("a result");
    assert_eq!((rear.wheel, rear.ramps, results[2]), (2, 2, None));
    // The rear wheel is braked first.
    let start = 1.0 + front.duration + 2.0;
    assert!(torque(start + 2.0, 2).expect("a ramp") < -0.5);
}

/// Continuity: no command jumps by more than the steepest slope of the back-off, 1.875 * 2.5 N
/// m/0.3 s, allows in 1 ms.
#[test]
fn torques_do_not_jump() {
    let plan = plan([Some(1), None, None], true);
    let mut tests = FrictionTests::new(&settings(10.0, plan));
    let torque = run(&mut tests, 20).expect("an estimate at rest");
    let mut last = IDLE;
    for k in 0..20_000 {
        let now = torque(1e-3 * f64::from(k), 1).unwrap_or(IDLE);
        assert!((now - last).abs() < 0.0165, "{k} ms: {last} {now}");
        last = now;
    }
}

/// At the torque limit a ramp ends without slip, and the torque never exceeds it. Tests that have
/// not ended are unfinished.
#[test]
fn the_torque_limit_ends_a_ramp() {
    let mut tests = FrictionTests::new(&settings(1.5, plan([Some(0), Some(1), None], false)));
    let torque = run(&mut tests, 7).expect("an estimate at rest");
    for k in 0..7000 {
        for wheel in 0..3 {
            let found = torque(1e-3 * f64::from(k), wheel).unwrap_or(0.0);
            assert!(found.abs() <= 1.5);
        }
    }
    let ends = tests
        .results()
        .map(|result| result.map(|r| (r.end, r.ramps)));
    let expected = [
        Some((FrictionTestEnd::TorqueLimit, 0)),
        Some((FrictionTestEnd::Unfinished, 0)),
        None,
    ];
    assert_eq!(ends, expected);
}
