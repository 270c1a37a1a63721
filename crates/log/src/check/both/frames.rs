//! What the tests of both sides take from the frames.

use super::SIDE_NAMES;
use crate::check::recording::{SMOOTHING, add, driving_spin, slowness, steps};
use crate::check::rest::SHORTEST;
use crate::check::{Finding, in_step};
use robhaz_estimator::NoiseBudget;
use robhaz_estimator::whole::WholeFrame;
use robhaz_model::WholeRover;
use robhaz_scene::coupling_angle;
use robhaz_score::signals::{derivative, median};
use std::borrow::Cow;

/// Longest step between frames over which a rate is integrated, s: the estimators start anew after it.
pub const LONGEST_GAP: f64 = 0.5;

/// A reading of a frame.
pub type Of = fn(&WholeFrame) -> Option<f64>;
/// A reading by its name.
pub type Reading = (&'static str, Of);

/// The name of a reading of wheel `i`, left 1 to 3, then right 1 to 3.
pub fn of_wheel(i: usize, quantity: &str) -> String {
    format!("{}_wheel{}_{quantity}", SIDE_NAMES[i / 3], i % 3 + 1)
}

/// What is read of joints and body.
pub fn readings(rover: &WholeRover) -> [Reading; 8] {
    [
        ("left_pin_angle", |f| f.pins[0]),
        ("right_pin_angle", |f| f.pins[1]),
        (coupling_angle(rover.coupling), |f| f.coupling),
        ("body_inclination", |f| f.inclination),
        ("body_roll", |f| f.roll),
        ("body_roll_rate", |f| f.rates[0]),
        ("body_rate", |f| f.rates[1]),
        ("body_yaw_rate", |f| f.rates[2]),
    ]
}

/// A reading of all frames; a NaN where there is none.
pub fn values(frames: &[WholeFrame], of: impl Fn(&WholeFrame) -> Option<f64>) -> Vec<f64> {
    frames.iter().map(|f| of(f).unwrap_or(f64::NAN)).collect()
}

/// The same; a frame without one has the last value, NaN before the first.
pub fn held(frames: &[WholeFrame], of: impl Fn(&WholeFrame) -> Option<f64>) -> Vec<f64> {
    let mut last = f64::NAN;
    let hold = |frame| {
        last = of(frame).unwrap_or(last);
        last
    };
    frames.iter().map(hold).collect()
}

/// Sum of the angles of all wheels, rad.
pub fn wheel_turns(frame: &WholeFrame) -> Option<f64> {
    frame.wheel_angle.iter().copied().sum()
}

/// Correlation of two signals, whatever is constant in them.
#[derive(Clone, Copy, Debug, Default)]
pub struct Correlation([f64; 6]);

impl Correlation {
    /// Adds a value of each.
    pub fn add(&mut self, a: f64, b: f64) {
        add(&mut self.0, [1.0, a, b, a * a, b * b, a * b]);
    }

    /// That of all values.
    pub fn value(&self) -> f64 {
        let [_, a, b, aa, bb, ab] = self.0.map(|sum| sum / self.0[0]);
        (ab - a * b) / ((aa - a * a) * (bb - b * b)).sqrt()
    }
}

/// How far apart the headings of these frames are, rad: a drive in curves may end as it began.
pub fn body_turn(frames: &[WholeFrame]) -> f64 {
    let (mut heading, mut ends) = (0.0_f64, [0.0_f64; 2]);
    for pair in frames.windows(2) {
        let [_, _, rate] = pair[0].rates;
        heading += rate.unwrap_or(0.0) * (pair[1].time - pair[0].time);
        ends = [ends[0].min(heading), ends[1].max(heading)];
    }
    ends[1] - ends[0]
}

/// The frames until a second and a half after the wheels begin to turn.
pub fn start(frames: &[WholeFrame]) -> &[WholeFrame] {
    const START: f64 = 1.5;
    let mut moved = frames.iter().skip(standing(frames).count());
    let Some(first) = moved.next() else {
        return frames;
    };
    &frames[..frames.partition_point(|f| f.time < first.time + START)]
}

/// The frames of a rest before the first motion; `None` of one that is too short.
pub fn rest(frames: &[WholeFrame]) -> Option<Vec<&WholeFrame>> {
    let rest: Vec<&WholeFrame> = standing(frames).collect();
    let (from, to) = rest.first().zip(rest.last())?;
    (to.time - from.time > SHORTEST).then_some(rest)
}

/// The frames before the wheels turn.
fn standing(frames: &[WholeFrame]) -> impl Iterator<Item = &WholeFrame> {
    /// Turn of a wheel within which the rover stands, rad: two counts of a coarse encoder.
    const STILL: f64 = 0.02;
    let mut first = [None; 6];
    frames.iter().take_while(move |f| {
        let wheels = first.iter_mut().zip(f.wheel_angle);
        let turns = wheels.filter_map(|(first, angle)| Some(angle? - *first.get_or_insert(angle?)));
        turns.fold(0.0_f64, |most, turn| most.max(turn.abs())) < STILL
    })
}

/// Bias of the yaw rate that a rest before the first motion shows, of the size that is stated, and the standard deviation
/// of what is left of it, rad/s.
pub fn yaw_bias(frames: &[WholeFrame], budget: &NoiseBudget) -> [f64; 2] {
    /// Standard deviation of a median over that of the mean: the wheels start before they show it.
    const OF_MEDIAN: f64 = 1.2533;
    let stated = budget.rate_bias;
    let Some(rest) = rest(frames) else {
        return [0.0, stated];
    };
    let rates: Vec<f64> = rest.iter().filter_map(|f| f.rates[2]).collect();
    // A count of readings.
    let noise = OF_MEDIAN * budget.rate_noise / (rates.len() as f64).sqrt();
    match median(rates).filter(|_| stated > 0.0) {
        None => [0.0, stated],
        Some(shown) => {
            let share = stated * stated / (stated * stated + noise * noise);
            [share * shown, stated * (1.0 - share).sqrt()]
        }
    }
}

/// The frames without that bias.
pub fn without_yaw_bias<'a>(
    frames: &'a [WholeFrame],
    budget: &NoiseBudget,
) -> Cow<'a, [WholeFrame]> {
    let mut frames = Cow::Borrowed(frames);
    // Hours of frames are not copied for nothing.
    if budget.rate_bias > 0.0 {
        let [bias, _] = yaw_bias(&frames, budget);
        for frame in frames.to_mut() {
            frame.rates[2] = frame.rates[2].map(|rate| rate - bias);
        }
    }
    frames
}

/// A step between two frames with the angles of all wheels and a yaw rate.
pub struct YawStep<'a> {
    /// The frame at its end.
    pub end: &'a WholeFrame,
    /// Its length, s.
    pub time: f64,
    /// Mean turns of the wheels of left and right, rad.
    pub sides: [f64; 2],
    /// Turn of the body to the left by the wheels, if none slips, rad.
    pub by_wheels: f64,
    /// Yaw rate at its end, rad/s.
    pub rate: f64,
}

/// All such steps of a log.
pub fn yaw_steps<'a>(frames: &'a [WholeFrame], rover: &WholeRover) -> Vec<YawStep<'a>> {
    let radius = rover.side.geometry.wheel_radius;
    let track = rover.mean_half_track();
    let read = |frame: &'a WholeFrame| {
        let [a, b, c, d, e, f] = frame.wheel_angle;
        let (left, right) = (a? + b? + c?, d? + e? + f?);
        let yaw = radius * (right - left) / (6.0 * track);
        Some((frame, [left / 3.0, right / 3.0], yaw, frame.rates[2]?))
    };
    let read: Vec<_> = frames.iter().filter_map(read).collect();
    let steps = read.iter().zip(read.iter().skip(1));
    let steps = steps.map(|((start, from, before, _), (end, to, yaw, rate))| YawStep {
        end,
        time: end.time - start.time,
        sides: [to[0] - from[0], to[1] - from[1]],
        by_wheels: yaw - before,
        rate: *rate,
    });
    steps.collect()
}

/// Median time between frames, s.
pub fn period(frames: &[WholeFrame]) -> Option<f64> {
    let steps = frames.windows(2).map(|w| w[1].time - w[0].time);
    median(steps.collect()).filter(|dt| *dt > 0.0)
}

/// Delay of the wheels of right behind those of left.
pub fn in_step(frames: &[WholeFrame]) -> Option<Finding> {
    let dt = period(frames)?;
    let half = steps(0.5 * SMOOTHING, dt);
    let mean = |side: usize| {
        let turn = |f: &WholeFrame| {
            let [a, b, c] = [0, 1, 2].map(|i| f.wheel_angle[3 * side + i]);
            Some((a? + b? + c?) / 3.0)
        };
        derivative(&values(frames, turn), half, dt)
    };
    Some(in_step::of_sides([&mean(0), &mean(1)], dt))
}

/// How many times as long as an ordinary drive the rover takes for the same way ([`slowness`]).
pub fn pace(frames: &[WholeFrame], rover: &WholeRover) -> f64 {
    /// Time over which a speed is taken, s.
    const APART: f64 = 1.0;
    let least = driving_spin(&rover.side);
    let (mut speeds, mut last) = (Vec::new(), None::<(f64, f64)>);
    for frame in frames {
        let Some(turned) = wheel_turns(frame) else {
            continue;
        };
        let (time, before) = *last.get_or_insert((frame.time, turned));
        if frame.time - time > APART {
            speeds.push((turned - before).abs() / (6.0 * (frame.time - time)));
            last = Some((frame.time, turned));
        }
    }
    speeds.retain(|speed| *speed > least);
    slowness(median(speeds), &rover.side)
}

#[cfg(test)]
mod tests {
    use super::super::testing::turn_left;
    use super::*;

    /// Closed form: a turn to the left for 5 s at 0.2 rad/s and back again turns by 1 rad, though it ends as it began; a start
    /// lasts until 1.5 s after the first motion.
    #[test]
    fn a_drive_in_curves_turns() {
        let frames = turn_left(|f| f.rates[2] = Some(if f.time < 5.0 { 0.2 } else { -0.2 }));
        assert!(
            (body_turn(&frames) - 1.0).abs() < 0.01,
            "{}",
            body_turn(&frames)
        );
        let moves = |f: &mut WholeFrame| f.wheel_angle = [Some((f.time - 2.0).max(0.0)); 6];
        let frames = turn_left(moves);
        let start = start(&frames).last().map_or(0.0, |f| f.time);
        assert!((start - 3.5).abs() < 0.05, "{start}");
    }
}
