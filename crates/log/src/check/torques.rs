//! What drivers do to the sign of a torque or current: magnitudes, magnitudes with the sign of the
//! speed, values cut off at zero, negative ones read as unsigned, dead bands, whole numbers.
//!
//! Noise carries a signed reading through zero: of the readings near zero, about half have either sign.
//! A magnitude touches zero and never passes it.

use crate::check::{Change, Channel, Finding, Stated};
use crate::measured::Rounding;
use robhaz_estimator::SensorFrame;
use robhaz_model::{Robot, Units};
use robhaz_score::extremes;
use robhaz_score::signals::median;

/// Number of visits of a reading near zero that shows a lost sign, if no reading of the log is on the
/// other side. A signed one with as many of 1200 has all on one side once in 2000 logs, with a mean of
/// 2.5 times its noise throughout, and hardly ever with another or with a rest.
const NEAR: usize = 20;
/// The same of readings in the direction of the wheel, none of which is near zero on the other side: a
/// signed one whose mean is twice its noise has a quarter of them there, 0.75^60 = 3e-8.
const NEAR_BY_SPEED: usize = 60;
/// The same of visits between turns at zero of [`TOUCHES`], whose lowest readings are on either side, too: 0.75^40 = 1e-5.
const NEAR_AT_TURNS: usize = 40;
/// Deviations of the noise from which a torque in the direction of the wheel comes down to zero, and those of zero within
/// which it turns back. Such torques are looked at together: on waves of one length all turns of one are alike, and it
/// is the noise of [`NEAR_AT_TURNS`] visits that tells.
const AWAY: f64 = 8.0;
const TOUCH: f64 = 2.0;
/// Least number of such turns of all torques, and of each.
const TOUCHES: usize = 12;
const LEAST_TOUCHES: usize = 3;
/// What is near zero, in standard deviations of the noise.
const WINDOW: f64 = 0.5;
/// Spin speed whose sign is certain, rad/s for robot A.
const TURNS: f64 = 0.2;
/// Number of jumps over the range of the values, to and fro, that shows unsigned numbers.
const WRAPS: usize = 4;
/// Share of the range between the values of both signs that is empty if they are read as unsigned.
const EMPTY: f64 = 0.5;
/// How far from the ends of the range, over the range of the values of one sign, a jump of unsigned numbers begins.
const FROM_END: f64 = 0.3;
/// A unit of the readings over their stated noise beyond which the unit is the error: its own is
/// `1/sqrt(12)` of it.
const COARSE: f64 = 4.0;

pub const TEST: &str = "signed";

/// A finding for each torque with a fault, one for all without.
pub fn findings(frames: &[SensorFrame], stated: &Stated<'_>) -> Vec<Finding> {
    let turns = TURNS / Units::of(stated.robot).time;
    let (mut faults, mut visits) = (Vec::new(), [0, 0]);
    let torques = [0, 1, 2].map(|i| Torque::of(frames, i, turns));
    let one_way = torques.iter().map(|torque| &torque.turns_back);
    let one_way: Vec<&TurnsBack> = one_way.filter(|of| of.is_one_way()).collect();
    let sum = |count: fn(&TurnsBack) -> usize| one_way.iter().map(|of| count(of)).sum::<usize>();
    let is_shown = sum(|of| of.touches) >= TOUCHES && sum(|of| of.visits[0]) >= NEAR_AT_TURNS;
    for (i, torque) in torques.iter().enumerate() {
        let channel = Channel::Torque(i);
        match torque.fault(channel, stated.settings.budget.torque_noise, is_shown) {
            None => visits = [0, 1].map(|side| visits[side] + torque.visits[side]),
            Some(fault) => faults.push(fault),
        }
    }
    if faults.is_empty() {
        // Counts of frames.
        let [above, below] = visits.map(|count| count as f64);
        let finding = Finding::ok(TEST, "torques 1 to 3", words(visits));
        faults.push(finding.with("above", above, "-").with("below", below, "-"));
    }
    faults
}

/// Whether torques are left out of the tests, as their signs are lost.
pub fn are_left_out(findings: &[Finding]) -> bool {
    let mut of_signs = findings.iter().filter(|f| f.test == TEST);
    of_signs.any(|f| !f.changes.is_empty())
}

/// What is said of the tests that need them.
pub fn left_out() -> Finding {
    let figure = "they need torques with their signs";
    Finding::ok("tests of the torques", "all", figure).cannot_tell("correct these, and check again")
}

/// Whether all torques are magnitudes, of which no forces follow.
pub fn signs_are_lost(frames: &[SensorFrame], robot: &Robot) -> bool {
    let turns = TURNS / Units::of(robot).time;
    (0..3).all(|i| Torque::of(frames, i, turns).is_magnitude())
}

fn words([above, below]: [usize; 2]) -> String {
    format!("{above} visits just above zero, {below} just below")
}

/// What a torque in the direction of its wheel does at zero, coming down from far above it.
#[derive(Default)]
struct TurnsBack {
    /// How often it turns back there, and how often it goes on to the other side.
    touches: usize,
    passes: usize,
    /// Visits just above zero and just below.
    visits: [usize; 2],
}

impl TurnsBack {
    fn is_one_way(&self) -> bool {
        self.touches >= LEAST_TOUCHES && self.passes == 0 && self.visits[1] == 0
    }
}

/// The readings of a torque.
struct Torque {
    values: Vec<f64>,
    /// Least and greatest, N m.
    range: [f64; 2],
    /// Visits just above zero and just below.
    visits: [usize; 2],
    /// The same in the direction of the wheel, while it turns.
    visits_by_speed: [usize; 2],
    /// What it does at zero in the direction of the wheel.
    turns_back: TurnsBack,
    /// How often a reading becomes exactly zero while the wheel turns.
    zeros: usize,
    /// How often it is zero twice in a row, where no other value is, but for a tenth of that.
    zeros_of_band: usize,
    /// Standard deviation of the noise by the differences of readings in a row, N m. The median is
    /// blind to true changes; of a magnitude it is at most that of the signed reading.
    noise: f64,
}

impl Torque {
    /// Of a wheel whose direction is certain beyond a spin speed, rad/s.
    fn of(frames: &[SensorFrame], wheel: usize, turns: f64) -> Self {
        /// Median of the size of a difference of two readings of white noise, in its standard
        /// deviations.
        const MEDIAN: f64 = 0.953_873;
        let read = frames.iter().zip(speeds(frames, wheel));
        let value = |f: &SensorFrame| f.motor_torque[wheel].filter(|v| v.is_finite());
        let read = read.filter_map(|(f, speed)| Some((value(f)?, speed)));
        let read: Vec<(f64, f64)> = read.collect();
        let values: Vec<f64> = read.iter().map(|(value, _)| *value).collect();
        let steps = values.windows(2).map(|w| (w[1] - w[0]).abs());
        let noise = median(steps.collect()).unwrap_or(0.0) / MEDIAN;
        let is_near = |x: f64| x.abs() <= WINDOW * noise && x.abs() > 0.0;
        // Each visit counts once: readings that stay there are not independent.
        let visits = |signed: &[f64]| {
            let enters = |side: f64| {
                let enters = |w: &&[f64]| is_near(w[1]) && !is_near(w[0]) && w[1] * side > 0.0;
                signed.windows(2).filter(enters).count()
            };
            [enters(1.0), enters(-1.0)]
        };
        let turning = |speed: f64| speed.abs() > turns;
        let of_wheel = |(value, speed): &(f64, f64)| match turning(*speed) {
            true => value * speed.signum(),
            false => 0.0,
        };
        let by_speed: Vec<f64> = read.iter().map(of_wheel).collect();
        let is_zero = |value: f64| value.abs() <= 0.0;
        let stops = |w: &&[(f64, f64)]| !is_zero(w[0].0) && is_zero(w[1].0) && turning(w[1].1);
        let repeats = |w: &&[(f64, f64)]| is_zero(w[1].0 - w[0].0) && turning(w[1].1);
        let (zero, elsewhere): (Vec<_>, Vec<_>) = (read.windows(2))
            .filter(repeats)
            .partition(|w| is_zero(w[0].0));
        let zeros_of_band = match zero.len() > 10 * elsewhere.len() {
            true => zero.len(),
            false => 0,
        };
        Self {
            range: extremes(values.iter().copied()).into(),
            visits: visits(&values),
            visits_by_speed: visits(&by_speed),
            turns_back: turns_back(&read, noise, turning),
            zeros: read.windows(2).filter(stops).count(),
            zeros_of_band,
            noise,
            values,
        }
    }

    fn has_one_sign(&self) -> bool {
        let [least, most] = self.range;
        least >= 0.0 || most <= 0.0
    }

    /// Whether it touches zero and never passes it.
    fn is_magnitude(&self) -> bool {
        self.has_one_sign() && is_on_one_side(self.visits, NEAR)
    }

    /// What is wrong and what to do; where the sign is lost nothing that follows from the torque is right. `noise` is the
    /// stated one, N m; `is_shown`: whether those that turn back at zero show together that they have the sign of the speed.
    fn fault(&self, channel: Channel, noise: f64, is_shown: bool) -> Option<Finding> {
        let rough =
            |[figure, remedy]: [String; 2]| Some(Finding::ok(TEST, channel, figure).fault(remedy));
        let lost = |words| Some(rough(words)?.change([Change::Remove(channel)]));
        if let Some(range) = range_of_overflow(&self.values) {
            return lost([
                format!("jumps to and fro over an empty range, by {range:.3} N m"),
                format!(
                    "negative numbers are read as unsigned: read the field as signed, or take {range:.3} N m off values above half of that"
                ),
            ]);
        }
        let rounding = Rounding::of(&self.values);
        if let Some(Rounding { unit, noise: error }) = rounding
            && unit > COARSE * noise
        {
            return rough([
                format!("whole numbers of {unit:.3} N m; budget.torque_noise is {noise:.3} N m"),
                format!("log more digits, or state budget.torque_noise = {error:.3}"),
            ]);
        }
        let sign = "log the signed current or torque, or the driver's direction with it; the estimators need the sign";
        let has_one_sign = self.has_one_sign();
        if has_one_sign && self.zeros >= NEAR {
            return lost([
                format!("of one sign, and {} times exactly zero", self.zeros),
                format!("torques of the other sign are cut off: {sign}"),
            ]);
        }
        if self.is_magnitude() {
            return lost([
                format!(
                    "{}: it touches zero and never passes it",
                    words(self.visits)
                ),
                format!("the sign is lost: {sign}"),
            ]);
        }
        // Where the torque changes by more than noise between readings, nothing carries it through zero.
        let is_slow = self.noise < COARSE * noise;
        let turns_back = Some(&self.turns_back).filter(|of| is_shown && of.is_one_way());
        let is_one_way =
            is_on_one_side(self.visits_by_speed, NEAR_BY_SPEED) || turns_back.is_some();
        if !has_one_sign && is_slow && is_one_way {
            let visits = match turns_back {
                Some(TurnsBack { touches, .. }) => {
                    format!("comes down to zero and turns back {touches} times, and never goes on,")
                }
                None => words(self.visits_by_speed),
            };
            return lost([
                format!("{visits} in the direction of the wheel: it never brakes"),
                format!("the sign is that of the speed: {sign}"),
            ]);
        }
        let sizes = self.values.iter().map(|v| v.abs()).filter(|v| *v > 0.0);
        let smallest = sizes.fold(f64::INFINITY, f64::min);
        let unit = rounding.map_or(0.0, |rounding| rounding.unit);
        let finer = 3.0 * unit.max(WINDOW * self.noise);
        let figure = if self.zeros >= NEAR && smallest > finer {
            format!("a dead band: nothing between -{smallest:.3} and {smallest:.3} N m but zero")
        } else if self.zeros_of_band >= NEAR {
            format!(
                "a dead band: {} times exactly zero twice in a row, and never so at another value",
                self.zeros_of_band
            )
        } else {
            return None;
        };
        rough([
            figure,
            "switch the driver's dead band off, or add it to budget.torque_offset".to_owned(),
        ])
    }
}

/// What a torque in the direction of its wheel does that comes down from [`AWAY`]. Readings are values and spin speeds;
/// the wheel turns throughout.
fn turns_back(readings: &[(f64, f64)], noise: f64, turning: impl Fn(f64) -> bool) -> TurnsBack {
    let mut found = TurnsBack::default();
    // The least value since it was far above zero, and whether the last one was near zero.
    let (mut least, mut was_near) = (None::<f64>, false);
    for (value, speed) in readings {
        if !turning(*speed) {
            least = None;
            continue;
        }
        let signed = value * speed.signum();
        let is_away = signed > AWAY * noise;
        let has_passed = signed < -AWAY * noise;
        if let Some(lowest) = least.filter(|_| is_away || has_passed) {
            match lowest.min(signed) {
                lowest if lowest < -TOUCH * noise => found.passes += 1,
                lowest if lowest < TOUCH * noise => found.touches += 1,
                _ => {}
            }
        }
        let is_near = signed.abs() <= WINDOW * noise;
        if least.is_some() && is_near && !was_near {
            found.visits[usize::from(signed < 0.0)] += 1;
        }
        was_near = is_near;
        least = match is_away {
            true => Some(signed),
            false => least.map(|least| least.min(signed)).filter(|_| !has_passed),
        };
    }
    found
}

/// Whether visits are on one side of zero alone, and as many as this.
fn is_on_one_side([above, below]: [usize; 2], count: usize) -> bool {
    above.min(below) == 0 && above.max(below) >= count
}

/// Spin speed at each frame, rad/s, over a quarter of a second around it; a NaN where it is not known.
fn speeds(frames: &[SensorFrame], wheel: usize) -> Vec<f64> {
    const HALF: f64 = 0.125;
    let angle = |k: usize| frames[k].wheel_angle[wheel];
    let (mut from, mut to) = (0, 0);
    let speed = |k: usize| {
        let time = frames[k].time;
        while frames[from].time < time - HALF {
            from += 1;
        }
        while to + 1 < frames.len() && frames[to].time < time + HALF {
            to += 1;
        }
        let dt = frames[to].time - frames[from].time;
        let by = angle(to).zip(angle(from)).map(|(b, a)| b - a);
        by.filter(|_| dt > 0.0).map_or(f64::NAN, |by| by / dt)
    };
    (0..frames.len()).map(speed).collect()
}

/// The distance of the ends over which readings jump to and fro, N m, if between them lies nothing: negative numbers that
/// are read as unsigned.
pub fn range_of_overflow(values: &[f64]) -> Option<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let [least, .., most] = sorted[..] else {
        return None;
    };
    let width = |w: &[f64]| w[1] - w[0];
    let gap = (sorted.windows(2)).max_by(|a, b| width(a).total_cmp(&width(b)))?;
    let [below, above] = [gap[0], gap[1]];
    if !(above - below > EMPTY * (most - least) && most > least) {
        return None;
    }
    let passes = |w: &&[f64]| (w[0] <= below) != (w[1] <= below);
    let jumps = values.windows(2).filter(passes);
    let jumps: Vec<f64> = jumps.map(|w| width(w).abs()).collect();
    // Wild values jump as well, but not to the end of a range at which small ones begin.
    let at_ends = jumps.iter().filter(|jump| **jump > 0.8 * (most - least));
    let alike = 10 * at_ends.count() > 9 * jumps.len();
    // What passes zero begins at the ends of both parts; a number that stands for no reading is one, and comes from anywhere.
    let (low, high) = sorted.split_at(sorted.partition_point(|x| *x <= below));
    let (few, many) = if low.len() < high.len() {
        (low, high)
    } else {
        (high, low)
    };
    let width_of = |part: &[f64]| part[part.len() - 1] - part[0];
    let short = median(jumps.iter().map(|jump| most - least - jump).collect()).unwrap_or(0.0);
    if width_of(few) <= 0.0 || short > FROM_END * width_of(many) {
        return None;
    }
    (jumps.len() >= WRAPS && alike).then(|| median(jumps).unwrap_or(most - least))
}
