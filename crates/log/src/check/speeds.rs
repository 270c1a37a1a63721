//! Are columns of wheels' angles speeds? An angle of a wheel that turns goes on; a speed comes back to where it was.
//!
//! As angles, such columns say that the robot hardly moves, and all wheels pass other ground. As what is integrated, they
//! are a way over which the curve of the front wheels is that of the rear ones ([`crate::check::ground`]), at the
//! distance of the axles: in a wrong unit at another one.

use crate::check::changes::DEGREE;
use crate::check::course::{Course, OWN};
use crate::check::ground::{CERTAIN, EXPLAINED, SCALE_ERROR, passing};
use crate::check::{Finding, Recording, Stated};
use crate::integral::integrate;
use robhaz_estimator::SensorFrame;
use std::f64::consts::TAU;

const TEST: &str = "angle or speed";
/// Units of a speed, rad/s.
const UNITS: [(&str, f64); 3] = [("rad/s", 1.0), ("deg/s", DEGREE), ("rpm", TAU / 60.0)];

/// The finding of angles that are speeds; `None` of others, and where the ground shows nothing.
pub fn finding(frames: &[SensorFrame], stated: &Stated<'_>) -> Option<Finding> {
    let explained = |frames: &[SensorFrame]| {
        let recording = Recording::new(frames, stated.robot)?;
        passing(&Course::of(&recording, stated.robot), &OWN)
    };
    if !comes_back(frames) {
        return None;
    }
    let own = explained(frames).map_or(0.0, |own| own.explained);
    if own > EXPLAINED {
        return None;
    }
    let (name, found) = UNITS.into_iter().find_map(|(name, unit)| {
        let found = explained(&integrated(frames, unit))?;
        let is_right = (found.scale - 1.0).abs() < SCALE_ERROR;
        (is_right && found.explained > CERTAIN).then_some((name, found))
    })?;
    let figure = format!(
        "taken for angles, the curve of the front wheels explains {:.0} % of that of the rear ones; as speeds in {name}, integrated, {:.0} %, with {:.3} of the distance of the axles",
        100.0 * own,
        100.0 * found.explained,
        found.scale
    );
    let finding = Finding::ok(TEST, "encoders 1 to 3", figure);
    Some(finding.explained(own, found.explained).fault(format!(
        "the columns are speeds: state unit = \"{name}\" of wheel1_angle, wheel2_angle and wheel3_angle, and they are integrated"
    )))
}

/// Whether the columns come back as speeds do: of their changes half or less is left at the end.
fn comes_back(frames: &[SensorFrame]) -> bool {
    (0..3).all(|i| {
        let values = frames.iter().filter_map(|frame| frame.wheel_angle[i]);
        let steps = values.clone().zip(values.skip(1)).map(|(a, b)| b - a);
        let [net, gone] = steps.fold([0.0_f64, 0.0], |[net, gone], step| {
            [net + step, gone + step.abs()]
        });
        net.abs() <= 0.5 * gone
    })
}

/// Frames whose angles are the integrals of what they were, in this unit.
fn integrated(frames: &[SensorFrame], unit: f64) -> Vec<SensorFrame> {
    let mut frames = frames.to_vec();
    for i in 0..3 {
        integrate(frames.iter_mut().filter_map(|frame| {
            let speed = frame.wheel_angle[i].as_mut()?;
            *speed *= unit;
            Some((frame.time, speed))
        }));
    }
    frames
}
