//! The estimator's own judgement: [`robhaz_estimator::Health`] of `best` over the whole log.

use crate::report::Finding;
use robhaz_estimator::{Channels, Estimator, EstimatorSettings, Flags, SensorFrame};
use robhaz_model::Robot;

const TEST: &str = "agreement of all";
const CHANNEL: &str = "all";
/// Share of the frames with a reading beyond what the robot can do, or without an estimate, that is a fault.
const OFTEN: f64 = 0.01;
/// Number of such frames that is no fault in a short log, either.
const FEW: u32 = 3;

/// The finding. `resolved`: whether the readings follow each other closely enough for the filters.
pub fn finding(
    frames: &[SensorFrame],
    robot: &Robot,
    settings: &EstimatorSettings,
    resolved: bool,
) -> Finding {
    let mut estimator = Estimator::new(robot, *settings);
    let (mut suspect, mut first) = (Channels::NONE, None);
    let (mut absurd, mut refused, mut largest) = (0_u32, 0_u32, 0.0_f64);
    for frame in frames {
        match estimator.update(frame) {
            Ok(estimate) => {
                absurd += u32::from(estimate.flags.contains(Flags::SENSOR_ABSURD));
                let Some(health) = estimate.health else {
                    continue;
                };
                let wheels = health.encoder.iter().chain(&health.slip);
                let tests = wheels.chain(&health.direction).chain(&health.inclination);
                largest = tests
                    .chain([&health.parity])
                    .fold(largest, |a, b| a.max(*b));
                if !health.suspect.is_empty() {
                    first.get_or_insert(frame.time);
                    suspect |= health.suspect;
                }
            }
            Err(_) => refused += 1,
        }
    }
    #[expect(clippy::cast_precision_loss, reason = "numbers of frames")]
    let share = |count: u32| f64::from(count) / frames.len() as f64;
    if share(absurd) > OFTEN && absurd > FEW {
        let figure = format!(
            "{:.1} % of the frames have a reading beyond what the robot can do",
            100.0 * share(absurd)
        );
        return Finding::fault(TEST, CHANNEL, figure, "check units and gear ratios");
    }
    if let Some(first) = first {
        let names: Vec<&str> = suspect.names().collect();
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
    if share(refused) > OFTEN && refused > FEW {
        let figure = format!(
            "{:.1} % of the frames have no estimate",
            100.0 * share(refused)
        );
        let remedy = "check the inclinometers: the four-bar cannot close at such angles";
        return Finding::fault(TEST, CHANNEL, figure, remedy);
    }
    let figure = format!("largest mean NIS {largest:.1} (a contradiction from 4 on)");
    Finding::ok(TEST, CHANNEL, figure)
}
