//! Drives of a rover for tests.

use crate::check::StatedBoth;
use robhaz_estimator::EstimatorSettings;
use robhaz_estimator::whole::WholeFrame;
use robhaz_model::WholeRover;
use robhaz_scene::RobotChoice;
use std::path::Path;

pub fn rover() -> WholeRover {
    let robots = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../robots");
    let robot = RobotChoice::load(&robots.join("open-source-rover.toml")).expect("a robot");
    robot.whole_rover().expect("what lies across")
}

/// A turn to the left at v = 0.2 m/s with w = 0.2 rad/s about a point beside the middle wheels, each
/// wheel steered along its way; 10 s at 50 Hz.
pub fn turn_left(change: impl Fn(&mut WholeFrame)) -> Vec<WholeFrame> {
    const SPEED: f64 = 0.2;
    const RATE: f64 = 0.2;
    let rover = rover();
    let geometry = &rover.side.geometry;
    let frame = |k: u32| {
        let time = 0.02 * f64::from(k);
        let way = |i: usize| {
            let side = if i < 3 { 1.0 } else { -1.0 };
            let along = SPEED - RATE * side * rover.half_tracks[i % 3];
            let across = RATE * (geometry.axles[i % 3].x - geometry.axles[1].x);
            (along, across)
        };
        let mut frame = WholeFrame {
            time,
            wheel_angle: std::array::from_fn(|i| {
                let (along, across) = way(i);
                Some(along.hypot(across) * time / geometry.wheel_radius)
            }),
            steering: std::array::from_fn(|i| {
                let (along, across) = way(i);
                Some(across.atan2(along)).filter(|_| i % 3 != 1)
            }),
            pins: [Some(0.0); 2],
            coupling: Some(0.0),
            inclination: Some(0.0),
            roll: Some(0.0),
            rates: [Some(0.0), Some(0.0), Some(RATE)],
            ..WholeFrame::default()
        };
        change(&mut frame);
        frame
    };
    (0..500).map(frame).collect()
}

/// What is stated of a rover.
pub fn stated(rover: &WholeRover) -> StatedBoth<'_> {
    StatedBoth {
        rover,
        settings: EstimatorSettings::kalman(),
        joint: [0.002; 2],
        compare_from: 0.0,
    }
}
