//! Readings of a log on equal steps of time, and the motion of the robot that they show.

use crate::check::Channel;
use crate::check::clock::{Clock, length};
use robhaz_estimator::{DRIVING_SPEED, SensorFrame};
use robhaz_model::{Geometry, Robot, Units, rotate};
use robhaz_score::signals::{derivative, integral, median, smooth, subtract};
use robhaz_score::{Agreement, extremes};

/// Longest time without a reading that is bridged by a straight line, s; two periods of a slower
/// channel.
const LONGEST_BRIDGE: f64 = 0.1;
/// A part of two and a half periods is bridged: one lost reading, whose neighbours' stamps are
/// rounded.
const BRIDGED_PERIODS: f64 = 2.5;

/// Largest turn of a wheel between readings with which they show the ground, rad: a quarter of its
/// radius along the path.
pub const LARGEST_TURN: f64 = 0.25;
/// Longest step with which the filters of the estimators hold, s: 50 Hz. The torque of the ground
/// must change smoothly from reading to reading.
pub const LONGEST_STEP: f64 = 0.0205;
/// Largest turn of a wheel between readings with which they hold, rad: 0.2 m/s at 100 Hz, 1 m/s at
/// 500 Hz.
const LARGEST_TURN_OF_FILTERS: f64 = 0.021;
/// Froude number `v^2/(g r)` up to which the filters hold: with 1 a wheel leaves ground that is as
/// curved as itself.
pub const LARGEST_FROUDE: f64 = 0.5;

/// Speed of a drive to which times refer in which a robot passes the ground, m/s for robot A.
const REFERENCE_SPEED: f64 = 0.2;

/// How many times as long a robot with this usual spin speed (rad/s) takes for the same way as at
/// [`REFERENCE_SPEED`], at least 1.
pub fn slowness(usual_spin: Option<f64>, robot: &Robot) -> f64 {
    let reference = REFERENCE_SPEED * Units::of(robot).speed() / robot.geometry.wheel_radius;
    usual_spin.map_or(1.0, |spin| (reference / spin).max(1.0))
}

/// Speed beyond which a robot drives, m/s.
pub fn driving_speed(robot: &Robot) -> f64 {
    DRIVING_SPEED * Units::of(robot).speed()
}

/// Spin speed beyond which a robot drives, rad/s.
pub fn driving_spin(robot: &Robot) -> f64 {
    driving_speed(robot) / robot.geometry.wheel_radius
}

/// Slope of the line from the rear to the front axle with these inclinations of links 1 and 2, rad.
pub fn slope_of(geometry: &Geometry, links: [f64; 2]) -> f64 {
    let axle = |i: usize| {
        let angle = links[geometry.carriers[i].index()];
        rotate(geometry.axles[i] - geometry.pins.q, angle)
    };
    let line = axle(0) - axle(2);
    line.y.atan2(line.x)
}

/// Time over which speeds, angles and torques are averaged, s.
pub const SMOOTHING: f64 = 0.05;

/// The part of a log from a second before the first wheel has turned by more than `least` (rad) on, of a length (s).
/// `of`: time (s) and wheel angles (rad) of a frame.
pub fn part_of_drive<T, const N: usize>(
    frames: &[T],
    of: impl Fn(&T) -> (f64, [Option<f64>; N]),
    least: f64,
    length: f64,
) -> &[T] {
    let start: [_; N] = std::array::from_fn(|i| frames.iter().find_map(|f| of(f).1[i]));
    let moves = |f: &&T| {
        let turns = of(f).1.into_iter().zip(start);
        let mut turns = turns.filter_map(|(a, b)| Some((a? - b?).abs()));
        turns.any(|turn| turn > least)
    };
    let first = frames.first().map_or(0.0, |f| of(f).0);
    let from = (frames.iter().find(moves)).map_or(first, |f| of(f).0 - 1.0);
    let begin = frames.partition_point(|f| of(f).0 < from);
    let end = frames.partition_point(|f| of(f).0 < from + length);
    &frames[begin..end.max(begin)]
}

/// All channels of a log at equal steps of time; a NaN where there is no reading. Between the parts
/// of a log with long gaps lies a pause of fixed length.
#[derive(Clone, Debug)]
pub struct Recording {
    /// Step, s: the median of the log's.
    pub dt: f64,
    /// Turn of each wheel relative to its link, rad.
    pub wheel_angle: [Vec<f64>; 3],
    /// Least change of each encoder between its readings, rad: its count.
    pub count: [f64; 3],
    /// Motor torque of each wheel, N m.
    pub torque: [Vec<f64>; 3],
    /// Inclination of links 1 and 2, rad.
    pub inclination: [Vec<f64>; 2],
    /// Rate of links 1 and 2, rad/s.
    pub rate: [Vec<f64>; 2],
    /// Period of the slowest channel, s.
    pub slowest: f64,
    /// Spin speed of each wheel, rad/s.
    pub spin: [Vec<f64>; 3],
    /// Middle one of the three spin speeds, rad/s.
    pub middle_spin: Vec<f64>,
    /// Slope of the line from the rear to the front axle, rad.
    pub slope: Vec<f64>,
    /// Spin speed beyond which the robot drives, rad/s.
    least_spin: f64,
}

impl Recording {
    /// The recording of the parts of a log between gaps and jumps of its clock. `None` without a part of three frames.
    pub fn new(frames: &[SensorFrame], robot: &Robot) -> Option<Self> {
        let clock = Clock::of(frames);
        let dt = clock.step?;
        let mut slowest = dt;
        let mut samples = |channel: Channel| {
            let of_part = |part: &&[SensorFrame]| Part::of(part, channel);
            let parts: Vec<Part> = clock.parts.iter().map(of_part).collect();
            let period = median(parts.iter().flat_map(Part::steps).collect()).unwrap_or(dt);
            slowest = slowest.max(period);
            let mut samples = Vec::new();
            for (i, part) in parts.iter().enumerate() {
                if i > 0 {
                    let pause = steps(Clock::BREAK, dt);
                    samples.extend(std::iter::repeat_n(f64::NAN, pause));
                }
                part.add_to(&mut samples, dt, period);
            }
            samples
        };
        let wheel_angle = [0, 1, 2].map(|i| samples(Channel::Encoder(i)));
        let count = [0, 1, 2].map(|i| least_change(&clock, Channel::Encoder(i)));
        let inclination = [0, 1].map(|k| samples(Channel::Inclinometer(k)));
        let half = steps(0.5 * SMOOTHING, dt);
        let spin = [0, 1, 2].map(|i| derivative(&wheel_angle[i], half, dt));
        let middle = |k: usize| median(spin.iter().map(|s| s[k]).collect()).unwrap_or(f64::NAN);
        let geometry = &robot.geometry;
        let smoothed = inclination.each_ref().map(|x| smooth(x, half));
        let slope = |k: usize| slope_of(geometry, [smoothed[0][k], smoothed[1][k]]);
        let samples_of_all = 0..wheel_angle[0].len();
        Some(Self {
            dt,
            count,
            torque: [0, 1, 2].map(|i| samples(Channel::Torque(i))),
            rate: [0, 1].map(|k| samples(Channel::Gyro(k))),
            slowest,
            middle_spin: samples_of_all.clone().map(middle).collect(),
            slope: samples_of_all.map(slope).collect(),
            least_spin: driving_spin(robot),
            wheel_angle,
            inclination,
            spin,
        })
    }

    /// Number of steps in a time (s), at least one.
    pub fn steps(&self, time: f64) -> usize {
        steps(time, self.dt)
    }

    /// Integral of the rate of link k (from 0), and the inclination less it, both rad.
    pub fn turned(&self, k: usize) -> (Vec<f64>, Vec<f64>) {
        let turned = integral(&self.rate[k], self.dt);
        let drift = subtract(&self.inclination[k], &turned);
        (turned, drift)
    }

    /// Derivative of a channel, averaged as the spin speeds are.
    pub fn derivative(&self, x: &[f64]) -> Vec<f64> {
        derivative(x, self.steps(0.5 * SMOOTHING), self.dt)
    }

    /// A signal where the robot drives, at rest a NaN.
    pub fn while_driving(&self, x: &[f64]) -> Vec<f64> {
        let drives = |spin: f64| spin.abs() > self.least_spin;
        let samples = x.iter().zip(&self.middle_spin);
        let driven = samples.map(|(x, spin)| if drives(*spin) { *x } else { f64::NAN });
        driven.collect()
    }

    /// Usual size of the middle one of the spin speeds while the robot drives, rad/s; `None` where it
    /// does not.
    pub fn usual_spin(&self) -> Option<f64> {
        let spin = self.while_driving(&self.middle_spin);
        median(spin.iter().map(|spin| spin.abs()).collect())
    }

    /// The turn of the middle wheel between readings of the slowest channel, rad; 0 at rest.
    pub fn turn(&self) -> f64 {
        self.usual_spin().unwrap_or(0.0) * self.slowest
    }

    /// Mean NIS from which on a contradiction between the readings is one: see
    /// [`robhaz_score::Agreement::contradiction`].
    pub fn certain(&self, robot: &Robot) -> f64 {
        let turn = self.turn();
        let spin = turn / self.slowest;
        let froude = spin * spin * robot.geometry.wheel_radius / robot.gravity;
        let is_slow = turn < LARGEST_TURN_OF_FILTERS && froude < LARGEST_FROUDE;
        match self.slowest < LONGEST_STEP && is_slow {
            true => 0.0,
            false if turn > LARGEST_TURN => f64::INFINITY,
            false => Agreement::FAR_APART,
        }
    }

    /// The samples of a channel of the frames.
    pub fn samples(&self, channel: Channel) -> &[f64] {
        match channel.in_frames() {
            Channel::Encoder(i) => &self.wheel_angle[i],
            Channel::Torque(i) => &self.torque[i],
            Channel::Gyro(k) => &self.rate[k],
            Channel::Inclinometer(k) => &self.inclination[k],
            _ => &[],
        }
    }

    /// Number of samples.
    pub fn len(&self) -> usize {
        self.torque[0].len()
    }
}

/// Least change of a channel between two readings in a row, or of such changes, more than rounding: of counts one count,
/// also where the wheels turn throughout. 0 of one that does not change.
fn least_change(clock: &Clock<'_>, channel: Channel) -> f64 {
    /// That of an angle of a million turns, rad.
    const ROUNDING: f64 = 1e-9;
    let mut least = f64::INFINITY;
    for part in &clock.parts {
        let readings = Part::of(part, channel).readings;
        let changes: Vec<f64> = readings.windows(2).map(|w| w[1].1 - w[0].1).collect();
        let second = changes.windows(2).map(|w| w[1] - w[0]);
        let all = changes.iter().copied().chain(second).map(f64::abs);
        least = all.filter(|c| *c > ROUNDING).fold(least, f64::min);
    }
    if least.is_finite() { least } else { 0.0 }
}

/// The samples within `near` of one at which the wheels turn at less than half of a `usual` spin speed: they start or stop.
pub fn starts(spin: &[f64], usual: f64, near: usize) -> Vec<bool> {
    let mut until = 0;
    let mut found = vec![false; spin.len()];
    for (k, x) in spin.iter().enumerate() {
        if x.abs() < 0.5 * usual {
            let from = k.saturating_sub(near).max(until);
            until = (k + near + 1).min(spin.len());
            found[from..until].fill(true);
        }
    }
    found
}

/// Difference of the greatest and the least value of a signal that are there; 0 without one.
pub fn range(x: &[f64]) -> f64 {
    let (low, high) = extremes(x.iter().copied().filter(|x| x.is_finite()));
    (high - low).max(0.0)
}

/// Adds to each sum what is its.
pub fn add<const N: usize>(sums: &mut [f64; N], values: [f64; N]) {
    for (sum, x) in sums.iter_mut().zip(values) {
        *sum += x;
    }
}

/// Number of steps of `dt` in a time (s), at least one.
pub fn steps(time: f64, dt: f64) -> usize {
    ((time / dt).round() as usize).max(1)
}

/// The readings of one channel in a part of a log.
struct Part {
    /// Length of the part, s.
    length: f64,
    /// Time since the start of the part (s), and value.
    readings: Vec<(f64, f64)>,
}

impl Part {
    fn of(part: &[SensorFrame], channel: Channel) -> Self {
        let start = part.first().map_or(0.0, |f| f.time);
        let read = |f: &SensorFrame| {
            let value = channel.value(f).filter(|v| v.is_finite())?;
            Some((f.time - start, value))
        };
        Self {
            length: length(part),
            readings: part.iter().filter_map(read).collect(),
        }
    }

    /// Times between readings, s.
    fn steps(&self) -> impl Iterator<Item = f64> + '_ {
        self.readings.windows(2).map(|w| w[1].0 - w[0].0)
    }

    /// Adds its samples at steps of `dt`: between readings, which have a period (s), on a straight
    /// line.
    fn add_to(&self, samples: &mut Vec<f64>, dt: f64, period: f64) {
        let bridged = LONGEST_BRIDGE.max(BRIDGED_PERIODS * period);
        let mut readings = self.readings.iter().copied().peekable();
        let mut before: Option<(f64, f64)> = None;
        let count = (self.length / dt + 0.5) as usize + 1;
        for k in 0..count {
            let time = k as f64 * dt;
            // A thousandth of a step: rounding of time stamps.
            while let Some(next) = readings.next_if(|(at, _)| *at <= time + 1e-3 * dt) {
                before = Some(next);
            }
            samples.push(match (before, readings.peek()) {
                (Some((t0, v0)), _) if time - t0 <= 1e-3 * dt => v0,
                (Some((t0, v0)), Some((t1, v1))) if t1 - t0 <= bridged => {
                    v0 + (v1 - v0) * (time - t0) / (t1 - t0)
                }
                _ => f64::NAN,
            });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use robhaz_estimator::LinkReading;

    fn frame(time: f64, torque: Option<f64>) -> SensorFrame {
        let link = LinkReading {
            inclination: Some(0.0),
            ..LinkReading::default()
        };
        SensorFrame {
            time,
            wheel_angle: [Some(time); 3],
            motor_torque: [torque; 3],
            link1: link,
            link2: link,
            ..SensorFrame::default()
        }
    }

    fn recording(frames: &[SensorFrame]) -> Option<Recording> {
        Recording::new(frames, &Robot::default_a())
    }

    /// Closed form: between readings the recording is a straight line; a lost frame is bridged; a
    /// gap of more than 0.1 s and a channel without readings are missing.
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
        let found = recording(&frames).ok_or("recording")?;
        assert!((found.dt - 1e-3).abs() < 1e-12 && found.len() == 300);
        assert_eq!(found.steps(0.01), 10);
        assert!((found.wheel_angle[0][50] - 5.05).abs() < 1e-9);
        assert!((found.torque[1][21] - 0.042).abs() < 1e-9);
        assert!(found.wheel_angle[0][180].is_nan() && found.rate[0][3].is_nan());
        assert!(recording(&frames[..2]).is_none());
        Ok(())
    }

    /// A slow channel is bridged over its own period: readings of 10 Hz in frames of 100 Hz are
    /// there throughout, although the distances of their stamps are not exactly 0.1 s.
    #[test]
    fn a_slow_channel_is_bridged() -> Result<(), &'static str> {
        let slow = |k: u32| k.is_multiple_of(10).then(|| f64::from(k));
        let time = |k: u32| 1e-2 * f64::from(k) + 3e-5 * f64::from(k % 20);
        let frames: Vec<SensorFrame> = (0..500).map(|k| frame(time(k), slow(k))).collect();
        let found = recording(&frames).ok_or("recording")?;
        assert!(found.torque[0][..480].iter().all(|v| v.is_finite()));
        assert!((found.slowest - 0.1).abs() < 1e-3);
        Ok(())
    }

    /// Bounded memory: a clock that is set by decades, bursts of frames, and pairs of frames an
    /// hour apart need some samples a frame, not some a millisecond.
    #[test]
    fn the_number_of_samples_is_bounded() {
        let times: [fn(u32) -> f64; 4] = [
            |k| 1e-3 * f64::from(k) + if k > 5000 { 1.7e9 } else { 0.0 },
            |k| f64::from(k / 10) * 0.1 + 1e-6 * f64::from(k % 10),
            |k| f64::from(k / 2) * 3600.0 + 1e-3 * f64::from(k % 2),
            |k| f64::from(k / 2) * 0.9 + 1e-6 * f64::from(k % 2),
        ];
        for (i, time) in times.into_iter().enumerate() {
            let frames: Vec<SensorFrame> = (0..10_000).map(|k| frame(time(k), None)).collect();
            let samples = recording(&frames).map_or(0, |r| r.len());
            assert!(samples < 100_000, "{i}: {samples}");
        }
    }
}
