//! Encoders against each other: signs and counts.

use crate::motion::Motion;
use crate::report::Finding;
use crate::signal::{median, zip};
use robhaz_model::Robot;

/// Difference of the turns of a wheel from those of the others that is a fault, -: more than slip makes, less than any mistake
/// in counts, gear ratios or edges.
const RATIO_ERROR: f64 = 0.08;
/// Parts of the drive: a fault shows in each.
const PARTS: usize = 10;
/// Least number of samples of a part.
const LEAST_SAMPLES: usize = 50;

const TEST: &str = "sign and counts";

/// All findings.
pub fn findings(motion: &Motion, robot: &Robot) -> Vec<Finding> {
    (0..3).map(|i| encoder(motion, robot, i)).collect()
}

fn encoder(motion: &Motion, robot: &Robot, i: usize) -> Finding {
    let channel = format!("encoder {}", i + 1);
    let ratio = zip(&motion.spin[i], &motion.middle_spin, |a, b| a / b);
    let ratio = motion.while_driving(robot, &ratio);
    let windows = windows(&ratio);
    let Some(ratio) = median(ratio).filter(|_| !windows.is_empty()) else {
        let remedy = "record a drive of some metres";
        return Finding::cannot_tell(TEST, channel, "the robot does not drive", remedy);
    };
    let figure = format!(
        "turns {ratio:.3} times as fast as the middle one of the three wheels ({:.2} to {:.2} is right)",
        1.0 - RATIO_ERROR,
        1.0 + RATIO_ERROR
    );
    // A wheel that slips for some time, or a robot that is stuck, does not do so all the time.
    let right = |ratio: f64| (ratio - 1.0).abs() < RATIO_ERROR;
    if right(ratio) || windows.iter().any(|ratio| right(*ratio)) {
        Finding::ok(TEST, channel, figure)
    } else if ratio < 0.0 {
        let remedy = format!("wheel {} counts backwards: state sign = \"-\"", i + 1);
        Finding::fault(TEST, channel, figure, remedy)
    } else {
        let remedy = format!(
            "check counts a turn, gear ratio and radius of wheel {}: counts of the others times {ratio:.3}",
            i + 1
        );
        Finding::fault(TEST, channel, figure, remedy)
    }
}

/// Medians over the parts of the drive.
fn windows(ratio: &[f64]) -> Vec<f64> {
    let driving: Vec<f64> = ratio.iter().copied().filter(|r| r.is_finite()).collect();
    let length = (driving.len() / PARTS).max(LEAST_SAMPLES);
    let parts = driving.chunks_exact(length);
    parts
        .filter_map(|part| median(part.iter().copied()))
        .collect()
}
