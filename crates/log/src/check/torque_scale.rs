//! The torques against the weight, as `best` has found them: [`robhaz_estimator::TorqueScale`].

use crate::check::report::Finding;
use robhaz_estimator::TorqueScale;
use robhaz_model::Robot;

const TEST: &str = "scale of torques, mass";
const CHANNEL: &str = "torques 1 to 3";

/// The finding; `scale` is `None` where there was no estimate.
pub fn finding(scale: Option<TorqueScale>, robot: &Robot) -> Finding {
    let Some(scale) = scale else {
        return Finding::ok(TEST, CHANNEL, "no estimate").cannot_tell("see the faults above");
    };
    let figure = scale.in_words(robot.mass.total()).to_string();
    let finding = Finding::ok(TEST, CHANNEL, figure)
        .with("ratio", scale.ratio, "-")
        .with("sigma", scale.sigma, "-");
    if scale.contradicts {
        finding.fault(format!(
            "weigh the robot as it drives; if its mass is right, multiply `scale` of the three torques by {:.2}",
            1.0 / scale.ratio
        ))
    } else if scale.is_known() {
        finding
    } else {
        finding
            .cannot_tell("drive gently over a slope of some degrees that is longer than the robot")
    }
}
