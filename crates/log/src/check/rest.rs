//! Zeros and noise while the robot stands, before it moves for the first time.

use crate::check::changes::DEGREE;
use crate::check::{Change, Channel, Finding, Recorded, Recording, Stated, Verdict};
use robhaz_model::Units;
use robhaz_score::signals::{mean, median, rms};
use std::f64::consts::{PI, TAU};

/// Shortest rest that is used, s.
pub const SHORTEST: f64 = 0.3;
/// Turn of a wheel within 50 ms that ends the rest, rad: 0.2 mm at the rim of robot A.
const STILL: f64 = 2e-3;
/// The same in counts of a coarse encoder: at rest it may change between two neighbours.
const STILL_COUNTS: f64 = 1.5;
/// Standard deviations of an offset that are a fault.
pub(super) const OFFSET_GATE: f64 = 5.0;
/// Offset of a gyroscope that does no harm, rad/s: 0.05 deg/s.
pub(super) const SMALL_RATE: f64 = 0.05 * DEGREE;
/// Offset of a torque that does no harm to robot A, N m: 0.02 N m are 0.2 N at the rim.
const SMALL_TORQUE: f64 = 0.02;
/// Standard errors of a mean, and of a deviation, that count as chance: a false alarm in 16 000.
const CHANCE: f64 = 4.0;
/// Deviations from the median beyond which a reading at rest is a single wrong one: in a million readings none
/// is by chance.
const SPIKE: f64 = 5.0;
/// Fewest readings from which the noise is taken.
const LEAST_STEPS: usize = 8;
/// Least figure that is shown in the unit of a channel: less is no noise of a sensor.
pub(super) const SHOWN: f64 = 1e-3;
/// Noise over that of the budget that is a fault.
const NOISE_RATIO: f64 = 2.0;
/// Noise over that of the budget, or the other way round, from which on a wrong unit is the
/// likeliest cause: the smallest factor of a wrong unit is 57.3 (degrees), and no filter of a
/// current takes away as much.
const UNIT_RATIO: f64 = 40.0;
/// The same of the torques of one robot, whose drives are alike: less than the gears of a wheel have.
const MOTOR_RATIO: f64 = 10.0;
/// Noise over that of the budget from which on a wrong unit is one of the causes.
const MUCH: f64 = 10.0;
/// By how much a torque is quieter than others.
const QUIETER: &str = "times as quiet";
/// Inclination up to which a robot stands without torques, rad.
const LEVEL: f64 = 3.0 * DEGREE;
/// Inclination of a link beyond which no robot stands, rad.
const STEEPEST: f64 = 60.0 * DEGREE;
/// Inclination beyond which a sensor hangs upside down, rad: no robot stands within 30 deg of its
/// roof.
pub(super) const UPSIDE_DOWN: f64 = 150.0 * DEGREE;

pub const ZERO: &str = "zero at rest";
pub const NOISE: &str = "noise at rest";

impl Recorded {
    /// The unit in which it is shown, and the factor from SI to it.
    pub const fn shown_in(&self) -> (&'static str, f64) {
        match self.channel {
            Channel::Encoder(_) => ("rad", 1.0),
            Channel::Torque(_) => ("N m", 1.0),
            Channel::Gyro(_) | Channel::BodyRate => ("deg/s", 1.0 / DEGREE),
            _ => ("deg", 1.0 / DEGREE),
        }
    }

    /// Number of readings, at least one.
    fn count(&self) -> f64 {
        self.values.iter().filter(|v| v.is_finite()).count().max(1) as f64
    }

    /// The mean without single wrong readings; of directions that of the direction, which may lie at
    /// 180 deg.
    fn mean(&self) -> f64 {
        let is_small = |v: &f64| v.is_nan() || v.abs() < STEEPEST;
        // Small angles keep their mean.
        if !self.channel.is_inclination() || self.values.iter().all(is_small) {
            return without_spikes(&self.values, self.noise);
        }
        let of = |part: fn(f64) -> f64| {
            let parts: Vec<f64> = self.values.iter().map(|v| part(*v)).collect();
            mean(&parts).unwrap_or(0.0)
        };
        of(f64::sin).atan2(of(f64::cos))
    }

    /// The mean rate of an angle within a time (s), from its first and its last tenth, and the
    /// standard deviation.
    fn turn(&self, time: f64) -> (f64, f64) {
        let tenth = (self.values.len() / 10).max(1);
        let (first, last) = (0..tenth, self.values.len() - tenth..self.values.len());
        let [first, last] = [first, last].map(|part| mean(&self.values[part]).unwrap_or(f64::NAN));
        let between = 0.9 * time;
        let sigma = self.noise * (2.0 / tenth as f64).sqrt();
        ((last - first) / between, sigma / between)
    }

    /// The finding of a mean that may be up to a limit (SI), which chance widens; `judge` says what
    /// to do about a larger one.
    fn zero(&self, limit: f64, judge: impl Fn(Finding, f64) -> Finding) -> Finding {
        // What noise makes of the mean of so few readings.
        let by_chance = CHANCE * self.noise / self.count().sqrt();
        let (mean, limit) = (self.mean(), limit + by_chance);
        let figure = format!("mean {}, at most {}", self.shown(mean), self.shown(limit));
        let (unit, factor) = self.shown_in();
        let finding = Finding::ok(ZERO, self.channel, figure).with("mean", factor * mean, unit);
        if mean.abs() <= limit {
            return finding;
        }
        judge(finding, mean)
    }

    fn shown(&self, value: f64) -> String {
        let (unit, factor) = self.shown_in();
        format!("{:.3} {unit}", factor * value)
    }
}

/// Mean of the readings within [`SPIKE`] deviations of their median: of the white noise that is stated, or
/// that they have by the median of their sizes.
fn without_spikes(values: &[f64], noise: f64) -> f64 {
    /// Standard deviation of normal deviates over the median of their sizes.
    const OF_MEDIAN: f64 = 1.4826;
    let mut known = values.to_vec();
    known.retain(|value| value.is_finite());
    let middle = median(known.clone()).unwrap_or(0.0);
    let away = median(known.iter().map(|value| (value - middle).abs()).collect());
    let most = SPIKE * noise.max(OF_MEDIAN * away.unwrap_or(0.0));
    known.retain(|value| (value - middle).abs() <= most.max(f64::MIN_POSITIVE));
    mean(&known).unwrap_or(middle)
}

/// All findings, of each channel as it was recorded: of a body with an inertial sensor these are
/// its own and that of pin Q.
pub fn findings(recording: &Recording, stated: &Stated<'_>) -> Vec<Finding> {
    let end = rest(recording);
    if end < recording.steps(SHORTEST) {
        let remedy = "record a second at rest on level ground before the drive";
        let of = |test| Finding::ok(test, "all", "the log begins in motion").cannot_tell(remedy);
        return [ZERO, NOISE].map(of).to_vec();
    }
    let mut channels = Recorded::of_recording(recording, end, stated);
    channels.retain(|x| x.values.iter().any(|v| v.is_finite()));
    let rest = Rest {
        channels,
        duration: end as f64 * recording.dt,
        stated,
    };
    let mut findings = rest.zeros_of_gyros();
    findings.extend(rest.angles().map(|angle| rest.zero_of_angle(angle)));
    findings.extend(rest.zeros_of_torques());
    let others = rest.of(Channel::is_rate).chain(rest.angles());
    findings.extend(others.map(|x| noise(x, None)));
    // One that is loud by itself makes no other one quiet.
    let of_torques = rest.torques().map(white).filter(|noise| noise.is_finite());
    let of_torques = median(of_torques.collect());
    findings.extend(rest.torques().map(|x| noise(x, of_torques)));
    findings
}

/// A log before the first motion.
struct Rest<'a> {
    /// Those with readings.
    channels: Vec<Recorded>,
    /// s
    duration: f64,
    stated: &'a Stated<'a>,
}

impl Rest<'_> {
    fn of(&self, is_of: impl Fn(Channel) -> bool) -> impl Iterator<Item = &Recorded> {
        self.channels.iter().filter(move |x| is_of(x.channel))
    }

    fn torques(&self) -> impl Iterator<Item = &Recorded> {
        self.of(Channel::is_torque)
    }

    fn angles(&self) -> impl Iterator<Item = &Recorded> {
        self.of(|channel| !channel.is_torque() && !channel.is_rate())
    }

    fn zeros_of_gyros(&self) -> Vec<Finding> {
        let limit = SMALL_RATE + OFFSET_GATE * self.stated.settings.budget.rate_bias;
        let of_gyro = |(k, gyro): (usize, &Recorded)| {
            // Each gyroscope is followed by its inclinometer.
            let beside = self.channels.get(k + 1);
            let beside = beside.filter(|x| x.channel.is_inclination());
            let (turn, sigma) = beside.map_or((0.0, 0.0), |x| x.turn(self.duration));
            gyro.zero(limit, |finding, mean| {
                // Between the middles of those tenths; a mean of noise has an error of its own.
                let twentieth = gyro.values.len() / 20;
                let inner = &gyro.values[twentieth..gyro.values.len() - twentieth];
                let inner = without_spikes(inner, gyro.noise);
                let sigma = sigma.hypot(gyro.noise / gyro.count().sqrt());
                if (inner - turn).abs() < limit + CHANCE * sigma {
                    let [turn, sigma] = [turn, sigma].map(|x| x / DEGREE);
                    return finding.cannot_tell(format!(
                        "the inclinometer turns by {turn:.2} +- {sigma:.2} deg/s, as when a robot settles: record some seconds at rest"
                    ));
                }
                finding.fault(format!("zero it at rest: state offset = {mean:.5} (rad/s)"))
            })
        };
        let all = self.channels.iter().enumerate();
        let gyros = all.filter(|(_, x)| x.channel.is_rate());
        gyros.map(of_gyro).collect()
    }

    fn zero_of_angle(&self, angle: &Recorded) -> Finding {
        let limit = 3.0 * self.stated.settings.budget.inclination_bias + 1e-4;
        let key = match angle.channel {
            Channel::Inclinometer(_) => "offset".to_owned(),
            of_body => format!("offset of {of_body}"),
        };
        let hangs = angle.channel.is_inclination()
            && angle.mean().abs() > UPSIDE_DOWN
            && !noise(angle, None).is_fault();
        angle.zero(limit, |finding, mean| match hangs {
            true => upside_down(finding, angle.channel),
            false => inclination(finding, mean, &key),
        })
    }

    /// That of each torque and, where each is right, of all together.
    fn zeros_of_torques(&self) -> Vec<Finding> {
        let budget = &self.stated.settings.budget;
        let is_level = self.angles().all(|x| x.mean().abs() < LEVEL);
        let judge = |finding: Finding, mean: f64| {
            if !is_level {
                return finding
                    .cannot_tell("the robot stands on a slope: record a rest on level ground");
            }
            finding.fault(format!("zero it with the motors off: state offset = {mean:.4} (N m), unless the drive held that torque"))
        };
        let small = SMALL_TORQUE * Units::of(self.stated.robot).torque();
        let limit = small + OFFSET_GATE * budget.torque_offset + budget.gear_friction;
        let mut findings: Vec<Finding> = self.torques().map(|x| x.zero(limit, judge)).collect();
        let are_right = findings.iter().all(|f| f.verdict == Verdict::Ok);
        // Of level ground, the wheels' forces have no sum; friction may hold all torques alike.
        let means: Vec<f64> = self.torques().map(Recorded::mean).collect();
        if let ([a, b, c], true, true) = (&means[..], are_right, is_level) {
            let (mean, root) = ((a + b + c) / 3.0, 3.0_f64.sqrt());
            let chances = self.torques().map(|x| x.noise / x.count().sqrt());
            let by_chance = CHANCE * chances.fold(0.0, f64::max);
            let limit = small
                + (OFFSET_GATE * budget.torque_offset + by_chance) / root
                + budget.gear_friction;
            if mean.abs() > limit {
                let figure = format!("mean of all {mean:.3} N m, at most {limit:.3} N m");
                let finding = Finding::ok(ZERO, "torques 1 to 3", figure).with("mean", mean, "N m");
                findings.push(judge(finding, mean));
            }
        }
        findings
    }
}

/// Number of samples before the first motion.
pub fn rest(recording: &Recording) -> usize {
    let step = recording.steps(0.05);
    let wheels = || recording.wheel_angle.iter().zip(recording.count);
    let moves = |i: usize, (a, count): (&Vec<f64>, f64)| {
        (a[i + step] - a[i]).abs() > STILL.max(STILL_COUNTS * count)
    };
    let last = recording.len().saturating_sub(step);
    let first = (0..last).find(|i| wheels().any(|wheel| moves(*i, wheel)));
    first.unwrap_or(last)
}

/// A sensor whose up axis points down. What it shows is then the other way round, and so is its
/// rate.
pub(super) fn upside_down(finding: Finding, channel: Channel) -> Finding {
    let (imu, change) = match channel {
        Channel::Inclinometer(k) => (format!("link{}", k + 1), Some(Change::UpsideDown(k))),
        _ => ("body".to_owned(), None),
    };
    let remedy = format!(
        "it hangs upside down: state up = \"-z\" of imu.{imu} (and forward = \"-x\" if its x axis points to the rear); readings of their own need sign = \"-\", that of the angle offset = \"-180 deg\", too\nor the quaternion of an orientation has the order w, x, y, z: state orientation = [\"orientation.y\", \"orientation.z\", \"orientation.w\", \"orientation.x\"]"
    );
    finding.fault(remedy).change(change)
}

/// An angle at which no robot stands; `zero`: what to do if it is the zero.
pub(super) fn impossible(finding: Finding, zero: &str) -> Finding {
    finding.fault(format!(
        "no robot stands like that: check the unit, and forward and up of the sensor's axes ([imu]); else {zero}"
    ))
}

/// At rest the robot may stand on a slope. `key`: what takes the angle, rad.
fn inclination(finding: Finding, mean: f64, key: &str) -> Finding {
    if mean.abs() > STEEPEST {
        return impossible(finding, &format!("add {mean:.5} (rad) to {key}"));
    }
    finding.cannot_tell(format!(
        "if the robot stood on level ground in its nominal pose, add {mean:.5} (rad) to {key}"
    ))
}

/// Whether it is a fault of a torque's zero or noise at rest.
pub fn is_of_torque(finding: &Finding) -> bool {
    [ZERO, NOISE].contains(&finding.test)
        && finding.verdict == Verdict::Fault
        && finding.channel.starts_with("torque")
}

/// Whether a channel whose name starts so was found suspiciously quiet: it may be in another unit.
pub fn has_quiet(findings: &[Finding], channel: &str) -> bool {
    let is_quiet = |f: &Finding| {
        let is_quiet = f.verdict == Verdict::CannotTell || f.number(QUIETER).is_some();
        f.test == NOISE && is_quiet && f.channel.starts_with(channel)
    };
    findings.iter().any(is_quiet)
}

/// Deviation of white noise at rest, from the differences of neighbours.
fn white(x: &Recorded) -> f64 {
    let turns = |step: f64| match x.channel.is_inclination() && step.abs() > PI {
        true => step - TAU.copysign(step),
        false => step,
    };
    let steps = x.values.windows(2).map(|w| turns(w[1] - w[0]));
    let steps: Vec<f64> = steps.collect();
    // That of the quietest third: a robot that settles shakes its sensors.
    let thirds = steps.chunks_exact((steps.len() / 3).max(LEAST_STEPS).min(steps.len().max(1)));
    thirds.map(rms).fold(f64::INFINITY, f64::min) / std::f64::consts::SQRT_2
}

/// The noise of a channel; `others` is the usual one of its kind, where there are others.
pub fn noise(x: &Recorded, others: Option<f64>) -> Finding {
    let deviation = white(x);
    if !deviation.is_finite() {
        let finding = Finding::ok(NOISE, x.channel, "hardly a reading at rest");
        return finding.cannot_tell("stand for some seconds before the drive");
    }
    let figure = format!("{}, budget {}", x.shown(deviation), x.shown(x.noise));
    let (unit, factor) = x.shown_in();
    let finding = Finding::ok(NOISE, x.channel, figure).with("noise", factor * deviation, unit);
    // The standard error of a deviation from n readings is 1/sqrt(2 n) of it; n is a third of them.
    let limit = NOISE_RATIO * x.noise * (1.0 + CHANCE / (2.0 / 3.0 * x.count()).sqrt());
    // No noise at all is that of an exact sensor.
    let has_noise = deviation > 1e-9;
    let quieter = others.map_or(0.0, |others| others / deviation);
    if has_noise && quieter > MOTOR_RATIO {
        return finding.with(QUIETER, quieter, "-").fault(format!(
            "{quieter:.0} times as quiet as those of other wheels: a torque of the motor's side (state gear_ratio), or a current (torque_constant)"
        ));
    }
    let is_quiet = has_noise && deviation * UNIT_RATIO < x.noise;
    if !is_quiet && deviation <= limit.max(SHOWN / factor) {
        return finding;
    }
    let units = match unit {
        "N m" => "a torque of the motor's side (gear_ratio), a current in A or mA",
        "deg/s" => "rad/s for deg/s or the other way round",
        _ => "rad for deg or the other way round",
    };
    if is_quiet {
        finding.cannot_tell(format!(
            "suspiciously quiet: check the unit ({units}), or state the measured noise"
        ))
    } else if deviation > UNIT_RATIO * x.noise {
        finding.fault(format!("check the unit ({units})"))
    } else if deviation > MUCH * x.noise {
        finding.fault(format!(
            "check the unit ({units}); else state the measured noise in the budget, or find its cause"
        ))
    } else {
        finding.fault("state the measured noise in the budget, or find its cause")
    }
}
