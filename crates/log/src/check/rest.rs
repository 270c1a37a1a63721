//! Zeros and noise while the robot stands, before it moves for the first time.

use crate::check::readings::Stated;
use crate::check::recording::Recording;
use crate::check::report::{Finding, Verdict};
use crate::check::rewire::{Change, Channel};
use robhaz_estimator::NoiseBudget;
use robhaz_model::Units;
use robhaz_score::signals::{mean, rms, subtract};
use std::f64::consts::{PI, TAU};

/// Shortest rest that is used, s.
const SHORTEST: f64 = 0.3;
/// Turn of a wheel within 50 ms that ends the rest, rad: a few counts of a coarse encoder, 0.2 mm
/// at the rim.
const STILL: f64 = 2e-3;
/// Standard deviations of an offset that are a fault.
const OFFSET_GATE: f64 = 5.0;
/// Offset of a gyroscope that does no harm, rad/s: 0.05 deg/s.
const SMALL_RATE: f64 = 0.05 * DEGREE;
/// Offset of a torque that does no harm to robot A, N m: 0.02 N m are 0.2 N at the rim.
const SMALL_TORQUE: f64 = 0.02;
/// Standard errors of a mean, and of a deviation, that count as chance: a false alarm in 16 000.
const CHANCE: f64 = 4.0;
/// Least figure that is shown in the unit of a channel: less is no noise of a sensor.
const SHOWN: f64 = 1e-3;
/// Noise over that of the budget that is a fault.
const NOISE_RATIO: f64 = 2.0;
/// Noise over that of the budget, or the other way round, from which on a wrong unit is the
/// likeliest cause: the smallest factor of a wrong unit is 57.3 (degrees), and no filter of a
/// current takes away as much.
const UNIT_RATIO: f64 = 40.0;
/// Inclination up to which a robot stands without torques, rad.
const LEVEL: f64 = 3.0 * DEGREE;
/// Inclination of a link beyond which no robot stands, rad.
const STEEPEST: f64 = 60.0 * DEGREE;
/// Inclination beyond which a sensor hangs upside down, rad: no robot stands within 30 deg of its
/// roof.
const UPSIDE_DOWN: f64 = 150.0 * DEGREE;
const DEGREE: f64 = PI / 180.0;

const ZERO: &str = "zero at rest";
const NOISE: &str = "noise at rest";

/// A channel at rest.
struct AtRest<'a> {
    name: String,
    values: &'a [f64],
    unit: &'static str,
    /// From the SI unit to `unit`.
    factor: f64,
    /// White noise of the budget, SI.
    noise: f64,
    /// Whether its values are directions, rad.
    is_direction: bool,
}

impl<'a> AtRest<'a> {
    fn of(channel: Channel, values: &'a [f64], budget: &NoiseBudget) -> Self {
        let (unit, factor) = match channel {
            Channel::Torque(_) => ("N m", 1.0),
            Channel::Gyro(_) => ("deg/s", 1.0 / DEGREE),
            _ => ("deg", 1.0 / DEGREE),
        };
        Self {
            name: channel.to_string(),
            values,
            unit,
            factor,
            noise: channel.noise(budget),
            is_direction: matches!(channel, Channel::Inclinometer(_)),
        }
    }

    /// Number of readings, at least one.
    fn count(&self) -> f64 {
        self.values.iter().filter(|v| v.is_finite()).count().max(1) as f64
    }

    /// The mean; of directions that of the direction, which may lie at 180 deg.
    fn mean(&self) -> f64 {
        if !self.is_direction {
            return mean(self.values).unwrap_or(0.0);
        }
        let of = |part: fn(f64) -> f64| {
            let parts: Vec<f64> = self.values.iter().map(|v| part(*v)).collect();
            mean(&parts).unwrap_or(0.0)
        };
        // Small angles keep their mean.
        match self.values.iter().all(|v| v.is_nan() || v.abs() < STEEPEST) {
            true => mean(self.values).unwrap_or(0.0),
            false => of(f64::sin).atan2(of(f64::cos)),
        }
    }

    /// The finding of a mean that may be up to a limit (SI), which chance widens; `judge` says what
    /// to do about a larger one.
    fn zero(&self, limit: f64, judge: impl Fn(Finding, f64) -> Finding) -> Finding {
        // What noise makes of the mean of so few readings.
        let by_chance = CHANCE * self.noise / self.count().sqrt();
        let (mean, limit) = (self.mean(), limit + by_chance);
        let figure = format!("mean {}, at most {}", self.shown(mean), self.shown(limit));
        let finding = Finding::ok(ZERO, &self.name, figure);
        let finding = finding.with("mean", self.factor * mean, self.unit);
        if mean.abs() <= limit {
            return finding;
        }
        judge(finding, mean)
    }

    fn shown(&self, value: f64) -> String {
        format!("{:.3} {}", self.factor * value, self.unit)
    }
}

/// All findings. The noise of readings of the links that are made of those of the body is not that
/// of a sensor: the rate of pin Q is 0 at rest.
pub fn findings(recording: &Recording, stated: &Stated<'_>) -> Vec<Finding> {
    let budget = &stated.budget;
    let end = rest(recording);
    if end < recording.steps(SHORTEST) {
        let remedy = "record a second at rest on level ground before the drive";
        let of = |test| Finding::ok(test, "all", "the log begins in motion").cannot_tell(remedy);
        return [ZERO, NOISE].map(of).to_vec();
    }
    let [torque, gyro, inclinometer] = [Channel::Torque, Channel::Gyro, Channel::Inclinometer];
    let torques = [0, 1, 2].map(|i| AtRest::of(torque(i), &recording.torque[i][..end], budget));
    let gyros = [0, 1].map(|k| AtRest::of(gyro(k), &recording.rate[k][..end], budget));
    let inclinometers =
        [0, 1].map(|k| AtRest::of(inclinometer(k), &recording.inclination[k][..end], budget));
    let level = inclinometers.iter().all(|x| x.mean().abs() < LEVEL);
    let small_torque = SMALL_TORQUE * Units::of(stated.robot).torque();
    let torque_zero = small_torque + OFFSET_GATE * budget.torque_offset + budget.gear_friction;
    let rate_zero = SMALL_RATE + OFFSET_GATE * budget.rate_bias;
    let level_zero = 3.0 * budget.inclination_bias + 1e-4;
    let of_gyro = |finding: Finding, mean: f64| {
        finding.fault(format!("zero it at rest: state offset = {mean:.5} (rad/s)"))
    };
    let mut findings: Vec<Finding> = gyros.iter().map(|x| x.zero(rate_zero, of_gyro)).collect();
    let [first, second] = inclinometers.each_ref().map(|x| x.values);
    let pin = subtract(first, second);
    let pin = AtRest {
        name: "pin Q".to_owned(),
        ..AtRest::of(inclinometer(0), &pin, budget)
    };
    // Readings of the links that are made of others have the zeros of these.
    let zeros: Vec<(&AtRest<'_>, &str)> = match stated.body_link() {
        Some(body) => vec![
            (&inclinometers[body], "offset of body_inclination"),
            (&pin, "offset of pin_angle"),
        ],
        None => inclinometers.iter().map(|x| (x, "offset")).collect(),
    };
    for (k, (x, key)) in zeros.into_iter().enumerate() {
        let hangs = x.mean().abs() > UPSIDE_DOWN && noise(x).verdict != Verdict::Fault;
        let finding = x.zero(level_zero, |finding, mean| match hangs {
            true => upside_down(finding, k, stated.of_body),
            false => inclination(finding, mean, key),
        });
        findings.push(finding);
    }
    let of_torque = |finding: Finding, mean: f64| {
        if !level {
            let remedy = "the robot stands on a slope: record a rest on level ground";
            return finding.cannot_tell(remedy);
        }
        finding.fault(format!(
            "zero it with the motors off: state offset = {mean:.4} (N m), unless the drive held that torque"
        ))
    };
    findings.extend(torques.iter().map(|x| x.zero(torque_zero, of_torque)));
    let of_links = gyros.iter().chain(&inclinometers);
    let real = of_links.filter(|_| !stated.of_body).chain(&torques);
    findings.extend(real.map(noise));
    findings
}

/// Number of samples before the first motion.
pub fn rest(recording: &Recording) -> usize {
    let step = recording.steps(0.05);
    let moves = |i: usize, a: &Vec<f64>| (a[i + step] - a[i]).abs() > STILL;
    let last = recording.len().saturating_sub(step);
    let first = (0..last).find(|i| recording.wheel_angle.iter().any(|a| moves(*i, a)));
    first.unwrap_or(last)
}

/// A sensor whose up axis points down. What it shows is then the other way round, and so is its
/// rate.
fn upside_down(finding: Finding, k: usize, of_body: bool) -> Finding {
    let imu = match of_body {
        true => "body".to_owned(),
        false => format!("link{}", k + 1),
    };
    let remedy = format!(
        "it hangs upside down: state up = \"-z\" of imu.{imu} (and forward = \"-x\" if its x axis points to the rear); readings of their own need sign = \"-\", that of the angle offset = \"-180 deg\", too"
    );
    let changes = (!of_body).then_some(Change::UpsideDown(k));
    finding.fault(remedy).change(changes)
}

/// At rest the robot may stand on a slope. `key`: what takes the angle, rad.
fn inclination(finding: Finding, mean: f64, key: &str) -> Finding {
    if mean.abs() > STEEPEST {
        return finding.fault(format!(
            "no robot stands like that: check the unit, and forward and up of the sensor's axes ([imu]); else add {mean:.5} (rad) to {key}"
        ));
    }
    finding.cannot_tell(format!(
        "if the robot stood on level ground in its nominal pose, add {mean:.5} (rad) to {key}"
    ))
}

/// Whether a torque was found suspiciously quiet: it may be in another unit.
pub fn has_quiet_torque(findings: &[Finding]) -> bool {
    let is_quiet = |f: &Finding| {
        f.test == NOISE && f.verdict == Verdict::CannotTell && f.channel.starts_with("torque")
    };
    findings.iter().any(is_quiet)
}

fn noise(x: &AtRest<'_>) -> Finding {
    // Of white noise, from the differences of neighbours.
    let turns = |step: f64| match x.is_direction && step.abs() > PI {
        true => step - TAU.copysign(step),
        false => step,
    };
    let steps = x.values.windows(2).map(|w| turns(w[1] - w[0]));
    let steps: Vec<f64> = steps.collect();
    let deviation = rms(&steps) / std::f64::consts::SQRT_2;
    let figure = format!("{}, budget {}", x.shown(deviation), x.shown(x.noise));
    let finding = Finding::ok(NOISE, &x.name, figure).with("noise", x.factor * deviation, x.unit);
    // The standard error of a deviation from n readings is 1/sqrt(2 n) of it.
    let limit = NOISE_RATIO * x.noise * (1.0 + CHANCE / (2.0 * x.count()).sqrt());
    // No noise at all is that of an exact sensor.
    let is_quiet = deviation > 1e-9 && deviation * UNIT_RATIO < x.noise;
    if !is_quiet && deviation <= limit.max(SHOWN / x.factor) {
        return finding;
    }
    let unit = match x.unit {
        "N m" => "a torque of the motor's side (gear_ratio), a current in A or mA",
        "deg/s" => "rad/s for deg/s or the other way round",
        _ => "rad for deg or the other way round",
    };
    if is_quiet {
        finding.cannot_tell(format!(
            "suspiciously quiet: check the unit ({unit}), or state the measured noise"
        ))
    } else if deviation > UNIT_RATIO * x.noise {
        finding.fault(format!("check the unit ({unit})"))
    } else {
        finding.fault("state the measured noise in the budget, or find its cause")
    }
}
