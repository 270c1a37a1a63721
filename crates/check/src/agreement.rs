//! The estimator's own judgement: [`robhaz_estimator::Health`] of `best` over the whole log.

use crate::report::Finding;
use robhaz_estimator::{
    Channels, Estimate, Estimator, EstimatorSettings, Flags, SensorFrame, TorqueScale,
};
use robhaz_model::Robot;

const TEST: &str = "agreement of all";
const CHANNEL: &str = "all";
/// Share of the frames with a reading beyond what the robot can do, or without an estimate, that is a fault.
const OFTEN: f64 = 0.01;
/// Number of such frames that is no fault in a short log, either.
const FEW: u32 = 3;

/// The finding, and what `best` has found of the torques' scale. `resolved`: whether the readings follow each other
/// closely enough for the filters.
pub fn finding(
    frames: &[SensorFrame],
    robot: &Robot,
    settings: &EstimatorSettings,
    resolved: bool,
) -> (Finding, Option<TorqueScale>) {
    let (mut run, mut scale) = (Run::default(), None);
    let mut estimator = Estimator::new(robot, *settings);
    for frame in frames {
        let estimate = estimator.update(frame);
        if let Ok(estimate) = &estimate {
            scale = estimate.torque_scale.or(scale);
        }
        run.add(frame.time, estimate.ok().as_ref());
    }
    (run.finding(frames.len(), resolved), scale)
}

/// What is counted over all frames.
#[derive(Default)]
struct Run {
    suspect: Channels,
    first: Option<f64>,
    absurd: u32,
    refused: u32,
    largest: f64,
}

impl Run {
    fn add(&mut self, time: f64, estimate: Option<&Estimate>) {
        let Some(estimate) = estimate else {
            self.refused += 1;
            return;
        };
        self.absurd += u32::from(estimate.flags.contains(Flags::SENSOR_ABSURD));
        let Some(health) = estimate.health else {
            return;
        };
        let wheels = health.encoder.iter().chain(&health.slip);
        let tests = wheels.chain(&health.direction).chain(&health.inclination);
        let means = tests.chain([&health.parity]);
        self.largest = means.fold(self.largest, |a, b| a.max(*b));
        // The torques' scale has a finding of its own.
        let suspect = Channels::from_bits(health.suspect.bits() & !Channels::TORQUE_SCALE.bits());
        if !suspect.is_empty() {
            self.first.get_or_insert(time);
            self.suspect |= suspect;
        }
    }

    fn finding(&self, frames: usize, resolved: bool) -> Finding {
        let largest = self.largest;
        #[expect(clippy::cast_precision_loss, reason = "numbers of frames")]
        let share = |count: u32| f64::from(count) / frames as f64;
        if share(self.absurd) > OFTEN && self.absurd > FEW {
            let figure = format!(
                "{:.1} % of the frames have a reading beyond what the robot can do",
                100.0 * share(self.absurd)
            );
            return Finding::fault(TEST, CHANNEL, figure, "check units and gear ratios");
        }
        if let Some(first) = self.first {
            let names: Vec<&str> = self.suspect.names().collect();
            let figure = format!(
                "readings contradict each other from {first:.1} s on: {} (largest mean NIS {largest:.1}; from 4 on it is a contradiction, below it a sign, a pairing or a delay does not fit)",
                names.join(", ")
            );
            if !resolved {
                let remedy = "record at a higher rate, best at 1 kHz: the filters need wheels that turn by less than 0.02 rad, and less than 20 ms, between readings";
                return Finding::cannot_tell(TEST, CHANNEL, figure, remedy);
            }
            let remedy = "see the faults above and correct them first; without any, check drawings, masses and noise budget";
            return Finding::fault(TEST, CHANNEL, figure, remedy);
        }
        if share(self.refused) > OFTEN && self.refused > FEW {
            let figure = format!(
                "{:.1} % of the frames have no estimate",
                100.0 * share(self.refused)
            );
            let remedy = "check the inclinometers: the four-bar cannot close at such angles";
            return Finding::fault(TEST, CHANNEL, figure, remedy);
        }
        let figure = format!("largest mean NIS {largest:.1} (a contradiction from 4 on)");
        Finding::ok(TEST, CHANNEL, figure)
    }
}
