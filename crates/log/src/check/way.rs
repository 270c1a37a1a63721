//! Joints over the way of the robot: their zeros, and whether pin Q turns where the ground asks for it.
//!
//! All wheels pass the same ground, so on a long way the mean of a joint's angle is zero, but for what the ground's slope
//! changes from the first footprint to the last. A link that pitches to and fro within a footprint does so on ground that
//! is uneven there, and on it the pin turns, too: by 1.5 times as much and more on the ground of the shipped rovers. A
//! steady bend of the ground, on which it does not, turns the link evenly.

use crate::check::{Channel, Finding, Readings};
use robhaz_score::extremes;
use robhaz_score::signals::{deviation, fit, residuals, rms, subtract};

/// Error of a joint's zero that is to be found, rad: 2 deg of the differential cost 2 % of N.
const LARGEST_ZERO: f64 = 0.035;
/// Standard deviations of a zero that are a fault.
const GATE: f64 = 3.0;
/// Deviation of pin Q within a footprint, over its noise, up to which it does not turn.
const QUIET: f64 = 1.5;
/// Deviation of the inclination of its link from a steady turn, over that noise, from which on the ground asks for a turn of the
/// pin: of at least ten times what counts as none.
const ASKS: f64 = 10.0;
/// Fewest readings of a footprint that show a deviation.
const LEAST: usize = 20;
/// Angle of the pin, over that of its end stop, from which on it may stay where it is.
const AT_STOP: f64 = 0.9;

pub const ZERO: &str = "zero over the way";

/// The way of a log.
pub struct Way {
    /// What the robot drives between samples, m; a NaN where it is not known.
    pub steps: Vec<f64>,
    /// Distance of the front axle from the rear one, m.
    pub footprint: f64,
    /// Range of the slopes, rad.
    pub slopes: f64,
    /// Constant error of the joint by the budget, rad.
    pub bias: f64,
}

/// The range of a signal; infinite of one without a value, of which nothing is known.
pub fn range(x: &[f64]) -> f64 {
    let (low, high) = extremes(x.iter().copied().filter(|x| x.is_finite()));
    (high - low).abs()
}

/// Mean of a signal over the way of these steps, m; a NaN where nothing of it is known.
pub fn mean_over(steps: &[f64], x: &[f64]) -> f64 {
    let all = steps.iter().zip(x);
    let known = all.filter(|(step, x)| (*step * *x).is_finite());
    let (sum, all) = known.fold((0.0, 0.0), |(sum, all), (step, x)| {
        (sum + step * x, all + step)
    });
    sum / all
}

impl Way {
    /// Of a recording of one side.
    fn of(log: &Readings<'_>) -> Self {
        let (recording, geometry) = (&log.recording, &log.stated.robot.geometry);
        let turns = recording.while_driving(&recording.middle_spin);
        let length = |spin: &f64| (geometry.wheel_radius * spin * recording.dt).abs();
        Self {
            steps: turns.iter().map(length).collect(),
            footprint: geometry.wheelbase(),
            slopes: range(&recording.slope),
            bias: log.stated.settings.budget.inclination_bias,
        }
    }

    /// The zero of a joint of these angles, rad.
    pub fn zero(&self, channel: &str, angles: &[f64]) -> Finding {
        let known = self.steps.iter().filter(|step| step.is_finite());
        let length = known.sum::<f64>();
        let allowed = GATE * self.bias + 0.5 * self.footprint * self.slopes / length;
        let mean = mean_over(&self.steps, angles);
        let [shown, at_most] = [mean, allowed].map(f64::to_degrees);
        let figure = format!("mean over {length:.1} m {shown:.2} deg, at most {at_most:.2} deg");
        let finding = Finding::ok(ZERO, channel, figure).with("mean", shown, "deg");
        // The rear wheels have not come to where the front ones stood.
        if length < self.footprint {
            finding.cannot_tell(
                "drive some metres: on so short a way the wheels stand on other ground throughout",
            )
        } else if mean.abs() > allowed {
            finding.fault(format!(
                "add {mean:.4} (rad) to offset of {channel}, or set its zero on level ground"
            ))
        } else if allowed < LARGEST_ZERO {
            finding
        } else {
            finding.cannot_tell("drive some metres more over ground that is less uneven")
        }
    }
}

/// What the way of one side shows of the angle of pin Q, for right signs and units; nothing of sensors on the links.
pub fn findings(log: &Readings<'_>) -> Vec<Finding> {
    let Some(body) = log.stated.body_link() else {
        return Vec::new();
    };
    // One cause of one pin: noise, spikes and units have findings of their own.
    let is_of_pin = |f: &Finding| f.channel == Channel::Pin.to_string();
    let mut faults = log.findings.iter().filter(|f| f.is_fault());
    if faults.any(is_of_pin) {
        return Vec::new();
    }
    let way = Way::of(log);
    let [first, second] = &log.recording.inclination;
    let pin = subtract(first, second);
    let hanging = hangs(log, &way, body, &pin);
    match hanging {
        Some(finding) => vec![finding],
        None => vec![way.zero(&Channel::Pin.to_string(), &pin)],
    }
}

/// An angle of the pin that stays within its noise where its link, the one of the body, pitches to and fro.
fn hangs(log: &Readings<'_>, way: &Way, body: usize, pin: &[f64]) -> Option<Finding> {
    let noise = Channel::Pin.noise(log.stated);
    let stop = &log.stated.robot.geometry.stop;
    let most = AT_STOP * stop.lower.abs().min(stop.upper.abs());
    let (inclination, _) = log.recording.turned(body);
    let (mut begin, mut driven) = (0, 0.0);
    let (mut length, mut largest, mut at) = (0.0, 0.0_f64, None);
    for (k, step) in way.steps.iter().enumerate() {
        driven += if step.is_finite() { *step } else { 0.0 };
        if driven < way.footprint {
            continue;
        }
        let pin = &pin[begin..=k];
        let pitching = uneven(&inclination[begin..=k]);
        let is_free = pin.iter().all(|x| x.abs() < most);
        let is_read = pin.len() >= LEAST && pin.iter().all(|x| x.is_finite());
        if is_read && is_free && deviation(pin) <= QUIET * noise && pitching >= ASKS * noise {
            length += driven;
            largest = largest.max(pitching);
            at.get_or_insert(begin);
        }
        (begin, driven) = (k + 1, 0.0);
    }
    // A number of samples.
    let since = at? as f64 * log.recording.dt;
    let largest = largest.to_degrees();
    let figure = format!(
        "stays within its noise on {length:.2} m of ground, first after {since:.1} s of driving, where its link pitches to and fro by {largest:.2} deg RMS"
    );
    let finding = Finding::ok("turns with the ground", Channel::Pin, figure);
    Some(finding.with("way", length, "m").fault(
        "it hangs: look at the shaft of its sensor, the plug and the wiper, and leave what follows out of the log",
    ))
}

/// Deviation of an angle from a steady turn, rad; 0 of one with gaps.
fn uneven(angle: &[f64]) -> f64 {
    // Numbers of samples.
    let times: Vec<f64> = (0..angle.len()).map(|k| k as f64).collect();
    let regressors: [&[f64]; 2] = [&vec![1.0; angle.len()], &times];
    let found = fit(angle, &regressors).filter(|found| found.count == angle.len());
    found.map_or(0.0, |found| rms(&residuals(angle, &regressors, &found)))
}
