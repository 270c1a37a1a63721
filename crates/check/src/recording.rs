//! Readings of a log on equal steps of time.

use robhaz_estimator::SensorFrame;

/// Longest time without a reading that is bridged by a straight line, s.
const LONGEST_BRIDGE: f64 = 0.1;

/// All channels of a log at equal steps of time; a NaN where there is no reading.
#[derive(Clone, Debug)]
pub struct Recording {
    /// Step, s: the median of the log's.
    pub dt: f64,
    /// Turn of each wheel relative to its link, rad.
    pub wheel_angle: [Vec<f64>; 3],
    /// Motor torque of each wheel, N m.
    pub torque: [Vec<f64>; 3],
    /// Inclination of links 1 and 2, rad.
    pub inclination: [Vec<f64>; 2],
    /// Rate of links 1 and 2, rad/s.
    pub rate: [Vec<f64>; 2],
}

impl Recording {
    /// The recording of frames with increasing times. `None` with less than three frames, or without a step of time.
    pub fn new(frames: &[SensorFrame]) -> Option<Self> {
        let mut steps: Vec<f64> = frames.windows(2).map(|w| w[1].time - w[0].time).collect();
        steps.retain(|step| *step > 0.0);
        steps.sort_by(f64::total_cmp);
        let dt = *steps.get(steps.len() / 2)?;
        if frames.len() < 3 || !dt.is_finite() {
            return None;
        }
        let channel = |value: &dyn Fn(&SensorFrame) -> Option<f64>| on_steps(frames, dt, value);
        Some(Self {
            dt,
            wheel_angle: [0, 1, 2].map(|i| channel(&|f| f.wheel_angle[i])),
            torque: [0, 1, 2].map(|i| channel(&|f| f.motor_torque[i])),
            inclination: [
                channel(&|f| f.link1.inclination),
                channel(&|f| f.link2.inclination),
            ],
            rate: [channel(&|f| f.link1.rate), channel(&|f| f.link2.rate)],
        })
    }

    /// Number of steps in a time (s), at least one.
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "times of this crate are short and positive"
    )]
    pub fn steps(&self, time: f64) -> usize {
        ((time / self.dt).round() as usize).max(1)
    }

    /// Number of samples.
    pub fn len(&self) -> usize {
        self.torque[0].len()
    }
}

/// A channel at steps of `dt`, between readings on a straight line.
fn on_steps(
    frames: &[SensorFrame],
    dt: f64,
    value: impl Fn(&SensorFrame) -> Option<f64>,
) -> Vec<f64> {
    let start = frames.first().map_or(0.0, |f| f.time);
    let end = frames.last().map_or(0.0, |f| f.time);
    let read = |f: &SensorFrame| {
        let value = value(f).filter(|v| v.is_finite())?;
        Some((f.time - start, value))
    };
    let mut readings = frames.iter().filter_map(read).peekable();
    let mut before: Option<(f64, f64)> = None;
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "the number of samples of a log"
    )]
    let count = ((end - start) / dt + 0.5) as usize + 1;
    let mut samples = Vec::with_capacity(count);
    for k in 0..count {
        #[expect(clippy::cast_precision_loss, reason = "the number of samples of a log")]
        let time = k as f64 * dt;
        // A thousandth of a step: rounding of time stamps.
        while let Some(next) = readings.next_if(|(at, _)| *at <= time + 1e-3 * dt) {
            before = Some(next);
        }
        samples.push(match (before, readings.peek()) {
            (Some((t0, v0)), _) if time - t0 <= 1e-3 * dt => v0,
            (Some((t0, v0)), Some((t1, v1))) if t1 - t0 <= LONGEST_BRIDGE.max(2.0 * dt) => {
                v0 + (v1 - v0) * (time - t0) / (t1 - t0)
            }
            _ => f64::NAN,
        });
    }
    samples
}

#[cfg(test)]
mod tests {
    use super::*;
    use robhaz_estimator::LinkReading;

    fn frame(time: f64, torque: Option<f64>) -> SensorFrame {
        let link = LinkReading {
            inclination: Some(0.0),
            rate: None,
        };
        SensorFrame {
            time,
            wheel_angle: [Some(time); 3],
            motor_torque: [torque; 3],
            link1: link,
            link2: link,
            contact_angle: [None; 3],
        }
    }

    /// Closed form: between readings the recording is a straight line; a lost frame is bridged; a gap of more than 0.1 s and
    /// a channel without readings are missing.
    #[test]
    fn gaps_are_bridged_or_missing() -> Result<(), &'static str> {
        let times = (0..300).filter(|k| *k != 50 && !(100..250).contains(k));
        let frames: Vec<SensorFrame> = times
            .map(|k| 1e-3 * f64::from(k))
            .map(|t| {
                frame(
                    5.0 + t,
                    (t * 1e3).rem_euclid(2.0).lt(&0.5).then_some(2.0 * t),
                )
            })
            .collect();
        let found = Recording::new(&frames).ok_or("recording")?;
        assert!((found.dt - 1e-3).abs() < 1e-12 && found.len() == 300);
        assert_eq!(found.steps(0.01), 10);
        assert!((found.wheel_angle[0][50] - 5.05).abs() < 1e-9);
        assert!((found.torque[1][21] - 0.042).abs() < 1e-9);
        assert!(found.wheel_angle[0][180].is_nan() && found.rate[0][3].is_nan());
        assert!(Recording::new(&frames[..2]).is_none());
        Ok(())
    }
}
