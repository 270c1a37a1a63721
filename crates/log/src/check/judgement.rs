//! What `kalman` says of a log that is wired in a way.

use crate::check::Stated;
use crate::check::wiring::Wiring;
use robhaz_estimator::{EstimateError, Estimator, Flags, SensorFrame, TorqueScale};
use robhaz_score::{Agreement, tests};

/// Share of the frames with a reading beyond what the robot can do, or without an estimate, that is
/// a fault.
pub const OFTEN: f64 = 0.01;
/// Number of such frames that is no fault in a short log, either.
const FEW: f64 = 3.0;
/// Sum of the mean NIS up to which the readings agree: each of nine mean NIS is 1 for innovations as
/// stated.
pub const AGREE: f64 = 2.0;
/// Sum over that of what is stated below which another wiring, or other gears, are a fault.
pub const BETTER: f64 = 0.7;
/// NIS of a frame without an estimate: far above that of any contradiction.
pub const REFUSED: f64 = 1e3;

/// What `kalman` says of a log.
pub struct Judgement {
    pub agreement: Agreement,
    /// What `kalman` has found of the torques' scale.
    pub scale: Option<TorqueScale>,
    /// Mean over the frames of the sum over the tests of their mean NIS.
    pub nis: f64,
    /// The encoders' part of it.
    pub of_encoders: f64,
    /// Shares of the frames with a reading beyond what the robot can do, and without an estimate; 0
    /// for a few frames.
    pub absurd: f64,
    pub refused: f64,
    /// Why the last of these have none.
    pub why: Option<EstimateError>,
    /// Normalised square of the parity residual of each frame; a NaN without one.
    pub parity: Vec<f64>,
}

impl Judgement {
    pub fn of(frames: &[SensorFrame], stated: &Stated<'_>, wiring: &Wiring) -> Self {
        let mut estimator = Estimator::new(stated.robot, stated.settings);
        let start = frames.first().map_or(0.0, |frame| frame.time);
        let mut found = Self {
            agreement: Agreement::new(start + stated.compare_from),
            parity: Vec::with_capacity(frames.len()),
            scale: None,
            nis: 0.0,
            of_encoders: 0.0,
            absurd: 0.0,
            refused: 0.0,
            why: None,
        };
        for frame in frames {
            found.parity.push(f64::NAN);
            let estimate = match estimator.update(&wiring.of(frame)) {
                Ok(estimate) => estimate,
                Err(error) => {
                    found.refused += 1.0;
                    found.why = Some(error);
                    found.nis += REFUSED;
                    continue;
                }
            };
            found.agreement.add(frame.time, &estimate);
            found.scale = estimate.kalman.and_then(|k| k.torque_scale).or(found.scale);
            if estimate.flags.contains(Flags::SENSOR_ABSURD) {
                found.absurd += 1.0;
                found.nis += REFUSED;
            }
            let Some(kalman) = estimate.kalman else {
                continue;
            };
            if let (Some(parity), Some(square)) = (estimate.parity, found.parity.last_mut()) {
                *square = (parity.value / parity.sigma).powi(2);
            }
            found.of_encoders += kalman.health.encoder.iter().sum::<f64>();
            let tests = tests(&kalman.health).into_iter();
            found.nis += tests.flat_map(|(values, _)| values).sum::<f64>();
        }
        let count = frames.len().max(1) as f64;
        found.nis /= count;
        found.of_encoders /= count;
        for share in [&mut found.absurd, &mut found.refused] {
            *share = if *share > FEW { *share / count } else { 0.0 };
        }
        found
    }
    /// Whether the readings agree as wired.
    pub fn agrees(&self) -> bool {
        self.agreement.first().is_none() && self.refused <= OFTEN
    }
}
