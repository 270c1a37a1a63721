//! Encoders against each other: signs and counts.

use crate::motion::Motion;
use crate::report::Finding;
use crate::signal::{median, zip};
use robhaz_model::Robot;

/// Difference of the turns of a wheel from those of the others that is a fault, -: more than slip makes, less than any mistake
/// in counts, gear ratios or edges.
const RATIO_ERROR: f64 = 0.08;
/// Least number of samples with driving.
const LEAST_SAMPLES: usize = 100;

const TEST: &str = "sign and counts";

/// All findings.
pub fn findings(motion: &Motion, robot: &Robot) -> Vec<Finding> {
    (0..3).map(|i| encoder(motion, robot, i)).collect()
}

fn encoder(motion: &Motion, robot: &Robot, i: usize) -> Finding {
    let channel = format!("encoder {}", i + 1);
    let ratio = zip(&motion.spin[i], &motion.middle_spin, |a, b| a / b);
    let ratio = motion.while_driving(robot, &ratio);
    let count = ratio.iter().filter(|r| r.is_finite()).count();
    let found = median(ratio).filter(|_| count >= LEAST_SAMPLES);
    let Some(ratio) = found else {
        let remedy = "record a drive of some metres";
        return Finding::cannot_tell(TEST, channel, "the robot does not drive", remedy);
    };
    let figure = format!("turns {ratio:.3} times as fast as the middle one of the three wheels");
    if (ratio - 1.0).abs() < RATIO_ERROR {
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
