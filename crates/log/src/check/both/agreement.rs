//! What the estimator of both sides says of the whole log, with the exchanges that were found corrected:
//! whether its readings agree, and the torques with the weight.

use super::frames::{body_turn, values, wheel_turns};
use super::{SIDE_NAMES, STRAIGHT};
use crate::check::agreement::of_scale;
use crate::check::{Channel, Finding, StatedBoth, certain, limits, still};
use crate::frames::side_frame;
use robhaz_estimator::whole::{WholeEstimate, WholeFrame};
use robhaz_estimator::{Channels, TorqueScale};
use robhaz_model::Robot;
use robhaz_score::{Agreement, Excuse};

/// Median of the misfit of the nine equations if all that is stated holds: of chi-square with three degrees of freedom.
const MIDDLE: f64 = 2.366;

/// What the estimator says of the log.
struct Judgement {
    scale: Option<TorqueScale>,
    /// Misfit of the nine equations in each frame; a NaN without an estimate, or while wheels are dragged across.
    misfits: Vec<f64>,
    /// How far the wheels turn in the frames with one, rad.
    rolled: f64,
    /// Of each side.
    agreements: [Agreement; 2],
    /// Mean NIS from which on a contradiction of a side is one: see [`certain`].
    certain: f64,
}

impl Judgement {
    /// `None` of a rover that cannot be estimated.
    fn of(frames: &[WholeFrame], stated: &StatedBoth<'_>) -> Option<Self> {
        let mut estimator = stated.estimator()?;
        let of_left: Vec<_> = frames.iter().map(|frame| side_frame(frame, 0)).collect();
        let start = frames.first().map_or(0.0, |frame| frame.time);
        let mut found = Self {
            scale: None,
            misfits: vec![f64::NAN; frames.len()],
            rolled: 0.0,
            agreements: [Agreement::new(start + stated.compare_from); 2],
            certain: certain(&of_left, &stated.rover.side),
        };
        let mut last = None;
        for (frame, misfit) in frames.iter().zip(&mut found.misfits) {
            let Ok(estimate) = estimator.update(frame) else {
                continue;
            };
            found.scale = Some(estimate.torque_scale);
            for (agreement, side) in found.agreements.iter_mut().zip(&estimate.sides) {
                agreement.add(frame.time, side);
            }
            let now = wheel_turns(frame);
            let step = now.and_then(|now| Some((now - last.replace(now)?).abs() / 6.0));
            if !estimate.dragged {
                *misfit = estimate.misfit;
                found.rolled += step.unwrap_or(0.0);
            }
        }
        Some(found)
    }

    /// The torques against the weight.
    fn torque_scale(&self, stated: &StatedBoth<'_>) -> Option<Finding> {
        let remedies = [
            "drive some metres over slopes, straight on, with little torque of one wheel against another",
            "correct unit, torque_constant, gear_ratio or scale of all torques, or the robot's masses",
        ];
        let names = ["torques 1 to 3 of both sides", "deviation"];
        Some(of_scale(self.scale?, &stated.rover.side, names, remedies))
    }

    /// The torques at a limit.
    fn at_limit(&self, frames: &[WholeFrame], side: &Robot) -> Option<Finding> {
        let torques = (0..6).map(|i| {
            let name = format!("{}: {}", SIDE_NAMES[i / 3], Channel::Torque(i % 3));
            (name, values(frames, |frame| frame.motor_torque[i]))
        });
        let turning = still::turning(frames.iter().map(|f| (f.time, f.wheel_angle)), side);
        // Wheels that are held at a limit are pushed across for as long.
        let correlated = (WholeEstimate::largest_misfit(self.rolled) / 3.0).sqrt();
        let found = limits::finding(torques, &turning, &self.misfits, [MIDDLE, correlated])?;
        // In a turn wheels are dragged across, and torques hardly change.
        Some(match body_turn(frames) < STRAIGHT {
            true => found,
            false => found.cannot_tell("record a drive straight on, too"),
        })
    }

    /// Whether the readings agree. `is_found`: see [`findings`].
    fn agreement(&self, is_found: bool) -> Finding {
        let known = self.misfits.iter().filter(|misfit| misfit.is_finite());
        let mean = known.clone().sum::<f64>() / known.count() as f64;
        let mut figure = format!(
            "misfit of the nine equations {mean:.1} on average, 3 if all that is stated holds"
        );
        // Of each contradiction, whether its readings are too far apart for the filters; edges have none here.
        let is_far_apart = |excuse: Option<Excuse>| excuse == Some(Excuse::FarApart);
        let (mut from, mut channels, mut excused) = (f64::INFINITY, Channels::NONE, Vec::new());
        for side in &self.agreements {
            if let Some((found, first)) = side.contradiction(self.certain).zip(side.first()) {
                (from, channels) = (from.min(first), channels | found.faulty);
                excused.push(is_far_apart(found.excuse));
            }
        }
        if !excused.is_empty() {
            let names = channels.names().collect::<Vec<&str>>().join(", ");
            figure += &format!("; from {from:.1} s on {names} contradict others");
        }
        let wrong = (self.agreements.iter()).filter_map(|side| side.wrong(self.certain));
        let of_forces: Vec<bool> = wrong.map(is_far_apart).collect();
        if !of_forces.is_empty() {
            let [left, right] = self.agreements.map(|side| 100.0 * side.out_of_range());
            figure += &format!(
                "; forces that neither weight nor impacts explain in {left:.1} and {right:.1} % of the frames, left and right"
            );
        }
        excused.extend(of_forces);
        let finding =
            Finding::ok("agreement of both sides", "all", figure).with("misfit", mean, "-");
        // Without a frame that counts the mean is no number, and contradicts nothing.
        let is_beyond = mean > WholeEstimate::largest_misfit(self.rolled);
        if excused.is_empty() && !is_beyond {
            finding
        } else if is_found {
            finding.cannot_tell("correct the faults first")
        } else if !is_beyond && !excused.contains(&false) {
            finding.cannot_tell(Excuse::FarApart.in_words())
        } else {
            finding.fault("readings contradict each other, and no test names the cause: check signs, zeros, scales and the budget of the channels that are named, and turn one wheel after the other by hand")
        }
    }
}

/// All findings. `is_found`: another test has found a fault, which may be the cause.
pub fn findings(frames: &[WholeFrame], stated: &StatedBoth<'_>, is_found: bool) -> Vec<Finding> {
    let Some(found) = Judgement::of(frames, stated) else {
        return Vec::new();
    };
    let mut findings = Vec::from_iter(found.torque_scale(stated));
    findings.extend(found.at_limit(frames, &stated.rover.side));
    findings.push(found.agreement(is_found));
    findings
}
