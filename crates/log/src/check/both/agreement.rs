//! What the estimator of both sides says of the whole log, with the exchanges that were found corrected:
//! whether its readings agree, and the torques with the weight.

use super::{STRAIGHT, across, of_one};
use crate::check::limits::Limits;
use crate::check::report::Finding;
use crate::check::rewire::Channel;
use crate::check::stated::StatedBoth;
use robhaz_estimator::whole::{WholeEstimate, WholeEstimator, WholeFrame};
use robhaz_estimator::{Channels, Confirmation};
use robhaz_score::Agreement;

/// Median of the misfit of the nine equations if all that is stated holds: of chi-square with three degrees of freedom.
const MIDDLE: f64 = 2.366;

/// The torques at a limit.
fn limits(frames: &[WholeFrame]) -> Limits {
    Limits::of((0..6).map(|i| {
        let name = format!("{}: {}", ["left", "right"][i / 3], Channel::Torque(i % 3));
        (name, across::values(frames, |frame| frame.motor_torque[i]))
    }))
}

/// Both findings. `is_found`: another test has found a fault, which may be the cause.
pub fn findings(frames: &[WholeFrame], stated: &StatedBoth<'_>, is_found: bool) -> Vec<Finding> {
    let estimator = WholeEstimator::new(stated.rover, stated.settings, stated.joint);
    let Ok(mut estimator) = estimator else {
        return Vec::new();
    };
    let (mut scale, mut faulty, mut first) = (None, Channels::NONE, None);
    let (mut misfit, mut count, mut rolled) = (0.0, 0.0, 0.0);
    let mut last = None;
    let mut limits = limits(frames);
    let start = frames.first().map_or(0.0, |frame| frame.time);
    let mut agreements = [Agreement::new(start + stated.compare_from); 2];
    for (k, frame) in frames.iter().enumerate() {
        let Ok(estimate) = estimator.update(frame) else {
            continue;
        };
        scale = Some(estimate.torque_scale);
        for (agreement, side) in agreements.iter_mut().zip(&estimate.sides) {
            agreement.add(frame.time, side);
        }
        let step =
            across::turned(frame).and_then(|now| Some((now - last.replace(now)?).abs() / 6.0));
        if !estimate.dragged {
            misfit += estimate.misfit;
            limits.add(k, estimate.misfit);
            count += 1.0;
            rolled += step.unwrap_or(0.0);
        }
        let of_sides = estimate
            .sides
            .iter()
            .filter_map(|s| Some(s.kalman?.health.faulty));
        // The torques' scale has a finding of its own.
        let bits = of_sides.fold(0, |all, channels| all | channels.bits());
        let bits = bits & !Channels::TORQUE_SCALE.bits();
        if bits != 0 {
            first.get_or_insert(frame.time);
            faulty |= Channels::from_bits(bits);
        }
    }
    let mut all = Vec::new();
    if let Some(scale) = scale {
        let words = scale.in_words(stated.rover.side.mass.total()).to_string();
        let channel = "torques 1 to 3 of both sides";
        let finding = Finding::ok(of_one::TORQUE_SCALE, channel, words)
            .with("ratio", scale.ratio, "-")
            .with("deviation", scale.sigma, "-");
        all.push(match scale.confirmation {
            Confirmation::Confirmed => finding,
            Confirmation::Unconfirmed => {
                finding.cannot_tell("drive some metres over slopes, straight on, with little torque of one wheel against another")
            }
            Confirmation::Contradicts => finding.fault(
                "correct unit, torque_constant, gear_ratio or scale of all torques, or the robot's masses",
            ),
        });
    }
    // In a turn wheels are dragged across, and torques hardly change.
    let is_straight = across::turn(frames) < STRAIGHT;
    let of_limit = limits.finding(MIDDLE);
    all.extend(of_limit.map(|found| match is_straight {
        true => found,
        false => found.cannot_tell("record a drive straight on, too"),
    }));
    let mean: f64 = misfit / count;
    let mut figure =
        format!("misfit of the nine equations {mean:.1} on average, 3 if all that is stated holds");
    if let Some(time) = first {
        let names = faulty.names().collect::<Vec<&str>>().join(", ");
        figure += &format!("; from {time:.1} s on {names} contradict others");
    }
    let wrong = agreements.map(|side| side.out_of_range());
    let is_often = |share: &f64| *share > Agreement::FEW_OUT_OF_RANGE;
    let is_wrong = wrong.iter().any(is_often);
    if is_wrong {
        let [left, right] = wrong.map(|share| 100.0 * share);
        figure += &format!(
            "; forces that neither weight nor impacts explain in {left:.1} and {right:.1} % of the frames, left and right"
        );
    }
    let finding = Finding::ok("agreement of both sides", "all", figure).with("misfit", mean, "-");
    // Without a frame that counts the mean is no number, and contradicts nothing.
    let is_beyond = mean > WholeEstimate::largest_misfit(rolled);
    let agrees = first.is_none() && !is_beyond && !is_wrong;
    all.push(match (agrees, is_found) {
        (true, _) => finding,
        (false, true) => finding.cannot_tell("correct the faults above first"),
        (false, false) => finding.fault(
            "readings contradict each other, and no test names the cause: check signs, zeros, scales and the budget of the channels that are named, and turn one wheel after the other by hand",
        ),
    });
    all
}
