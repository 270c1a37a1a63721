//! Progress of a run: whether the robot advances, and whether its wheels spin.

use robhaz_sim::Truth;
use robhaz_sim::drive::Drive;
use serde::{Deserialize, Serialize};

/// Advance that counts as a gain, in wheel radii: 10 mm for the default robot.
const GAIN: f64 = 0.1;
/// Integral of the set speed since the last gain after which the robot counts as stuck, in wheel
/// radii: ten times the gain, so that a robot is stuck that advances at less than a tenth of the
/// set speed.
const ASKED: f64 = 1.0;
/// Time without gain after which the robot counts as stuck, s: longer than any of the shipped kerbs
/// and trenches holds it.
const PATIENCE: f64 = 2.0;
/// Slip speed beyond the one that the set speeds ask for above which a wheel spins, as a share of
/// the set speed of travel: creep stays below a tenth of it.
const SPIN: f64 = 0.5;

/// Progress of a run. Its keys in `summary.json` have units.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Progress {
    /// Travel of the body along x since the start, m, positive in the direction of `drive.speed`.
    #[serde(rename = "distance_m")]
    pub distance: f64,
    /// Integral of the set speed of travel over time ([`Drive::travel_speed`]), m, with the sign of
    /// `distance`.
    #[serde(rename = "asked_m")]
    pub asked: f64,
    /// Time since which the robot has not advanced as its set speed asks, s; `None` where it
    /// advances, or that speed is zero.
    #[serde(rename = "stuck_since_s")]
    pub stuck_since: Option<f64>,
    /// Time for which each wheel spun, s: its slip speed differed from the one that its set speed
    /// asks for by more than half the set speed. A wheel that is driven apart and slips as asked
    /// does not spin.
    #[serde(rename = "spinning_s")]
    pub spinning: [f64; 3],
}

/// Measures the progress of a run, record by record.
#[derive(Clone, Debug)]
pub struct ProgressMeter {
    drive: Drive,
    wheel_radius: f64,
    start: Option<Truth>,
    last: Option<Truth>,
    progress: Progress,
    /// Integral of the magnitude of the set speed of travel, m.
    asked_way: f64,
    /// Direction of the last set speed of travel that was not zero: 1 along `distance`, -1 against
    /// it.
    direction: f64,
    /// The last gain.
    mark: Mark,
}

/// An instant at which the robot had advanced.
#[derive(Clone, Copy, Debug, Default)]
struct Mark {
    time: f64,
    distance: f64,
    asked_way: f64,
}

impl ProgressMeter {
    /// For a robot with this drive and wheels of this radius (m).
    pub fn new(drive: &Drive, wheel_radius: f64) -> Self {
        Self {
            drive: drive.clone(),
            wheel_radius,
            start: None,
            last: None,
            progress: Progress::default(),
            asked_way: 0.0,
            direction: 1.0,
            mark: Mark::default(),
        }
    }

    /// Adds the next record.
    pub fn add(&mut self, truth: &Truth) {
        let start = self.start.get_or_insert(*truth);
        let ahead = if self.drive.speed < 0.0 { -1.0 } else { 1.0 };
        self.progress.distance = ahead * (truth.body.position.x - start.body.position.x);
        let asks = ahead * self.drive.travel_speed(truth.time, self.wheel_radius);
        if let Some(last) = self.last {
            let asked = ahead * self.drive.travel_speed(last.time, self.wheel_radius);
            let time = truth.time - last.time;
            self.progress.asked += 0.5 * time * (asked + asks);
            self.asked_way += 0.5 * time * (asked.abs() + asks.abs());
            self.add_spinning(truth, time);
        }
        let turned = asks * self.direction < 0.0;
        if turned {
            self.direction = -self.direction;
        }
        let gain = self.direction * (self.progress.distance - self.mark.distance);
        let gained = gain > GAIN * self.wheel_radius;
        let waits = self.asked_way <= self.mark.asked_way;
        if gained || waits || turned {
            self.mark = Mark {
                time: truth.time,
                distance: self.progress.distance,
                asked_way: self.asked_way,
            };
        }
        self.last = Some(*truth);
    }

    /// Adds `time` (s) to the spinning of the wheels that spin at this record.
    fn add_spinning(&mut self, truth: &Truth, time: f64) {
        let (drive, radius) = (&self.drive, self.wheel_radius);
        let set = drive.speed.abs();
        let travel = drive.travel_speed(truth.time, radius);
        for (i, wheel) in truth.wheels.iter().enumerate() {
            let apart = radius * drive.set_speed(i, truth.time, radius) - travel;
            if set > 0.0 && (wheel.slip_speed - apart).abs() > SPIN * set {
                self.progress.spinning[i] += time;
            }
        }
    }

    /// The progress up to the last record.
    pub fn progress(&self) -> Progress {
        let Mark {
            time, asked_way, ..
        } = self.mark;
        let since = self.last.map_or(0.0, |t| t.time) - time;
        let is_stuck = since >= PATIENCE && self.asked_way - asked_way >= ASKED * self.wheel_radius;
        Progress {
            stuck_since: is_stuck.then_some(time),
            ..self.progress
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use robhaz_sim::drive::SpeedScaling;

    /// A run of `seconds` at 100 records a second in which the body goes as `way` says (m at s), at
    /// a slip speed of 0.15 m/s.
    fn run(drive: &Drive, seconds: u32, way: impl Fn(f64) -> f64) -> Progress {
        let mut meter = ProgressMeter::new(drive, 0.1);
        for k in 0..=100 * seconds {
            let mut truth = Truth {
                time: 0.01 * f64::from(k),
                ..Truth::default()
            };
            truth.body.position.x = 3.0 + way(truth.time);
            truth.wheels[1].slip_speed = 0.15;
            meter.add(&truth);
        }
        meter.progress()
    }

    /// Closed form: way, way asked for (speed times time less half the ramp), time of the last
    /// gain, time of spinning.
    #[test]
    fn a_robot_that_stops_is_stuck_since_its_last_gain() {
        let drive = Drive::default();
        // Stops at 5 s, one metre on, and shakes by 8 mm ever after.
        let way = |t: f64| {
            if t < 5.0 {
                0.2 * t
            } else {
                1.0 + 8e-3 * (40.0 * t).sin()
            }
        };
        let found = run(&drive, 9, way);
        assert!((found.distance - way(9.0)).abs() < 1e-12);
        assert!(
            (found.asked - 0.2 * (9.0 - 0.8 - 0.3)).abs() < 1e-4,
            "{found:?}"
        );
        // The last gain is less than 10 mm of way old at 5 s, or the first swing thereafter.
        let since = found.stuck_since.unwrap_or_default();
        assert!((4.95..5.1).contains(&since), "{found:?}");
        assert!((found.spinning[1] - 9.0).abs() < 1e-9 && found.spinning[0] == 0.0);
        // Two seconds must have passed.
        assert_eq!(run(&drive, 6, way).stuck_since, None);
    }

    /// Never called stuck: before the drive starts, at a set speed of zero, at a tenth of the speed
    /// and more, at a speed at which little was asked for, backwards as asked.
    #[test]
    fn who_makes_way_or_need_not_is_not_stuck() {
        let with = |speed: f64, start_time: f64| Drive {
            speed,
            start_time,
            ..Drive::default()
        };
        assert_eq!(run(&with(0.2, 20.0), 19, |_| 0.0).stuck_since, None);
        assert_eq!(run(&with(0.0, 0.8), 19, |_| 0.0).stuck_since, None);
        let spinning = run(&with(0.0, 0.8), 19, |_| 0.0).spinning;
        assert!(spinning.iter().all(|time| time.abs() < 1e-12));
        assert_eq!(run(&with(0.2, 0.0), 19, |t| 0.021 * t).stuck_since, None);
        assert_eq!(run(&with(0.004, 0.0), 20, |_| 0.0).stuck_since, None);
        assert_eq!(run(&with(-0.2, 0.0), 19, |t| -0.2 * t).stuck_since, None);
    }

    /// Reversed set speeds: the way that is asked for and the distance fall, and a robot that comes
    /// back is not stuck. One that stays is stuck from the reversal on. Slip that the set speeds
    /// ask for is no spinning.
    #[test]
    fn a_robot_that_is_asked_back_has_to_come_back() {
        let mut drive = Drive::default();
        drive.scalings.push(SpeedScaling {
            wheels: [true; 3],
            from: 5.0,
            to: 60.0,
            factor: -1.0,
        });
        let out = |t: f64| 0.2 * t.min(5.3);
        let found = run(&drive, 15, |t| out(t) - 0.2 * (t - 5.3).max(0.0));
        assert_eq!(found.stuck_since, None, "{found:?}");
        // Forward for 4.2 s less half of the first ramp; the reversal takes as much forward as
        // back; back for 9.4 s.
        let asked = 0.2 * (5.0 - 1.1 - 9.4);
        assert!((found.asked - asked).abs() < 1e-3, "{found:?}");
        assert!((found.distance - 0.2 * (5.3 - 9.7)).abs() < 1e-12);
        let since = run(&drive, 15, out).stuck_since.unwrap_or_default();
        assert!((5.2..5.5).contains(&since), "{since}");

        // Slip of 0.15 m/s at the middle wheel, which is asked for at a factor of 1.75.
        drive.scalings[0] = SpeedScaling {
            wheels: [false, true, false],
            from: 0.0,
            to: 60.0,
            factor: 1.75,
        };
        let spinning = run(&drive, 15, |t| 0.2 * t).spinning[1];
        // Until the start has passed a third of the set speed the wheel slips more than asked.
        assert!((1.0..1.4).contains(&spinning), "{spinning}");
    }

    /// Stuck from the drive's start on; also where the robot slides back, and where it goes the
    /// wrong way.
    #[test]
    fn who_never_moves_is_stuck_from_the_start() {
        let drive = Drive::default();
        for way in [0.0, -0.05, -0.2] {
            let found = run(&drive, 9, |t| way * t);
            // Of the quintic ramp the first records ask for less than a double shows.
            let since = found.stuck_since.unwrap_or_default();
            assert!((since - 0.8).abs() < 0.02, "{found:?}");
        }
        assert!(
            run(
                &Drive {
                    speed: -0.2,
                    ..drive
                },
                9,
                |t| 0.1 * t
            )
            .stuck_since
            .is_some()
        );
    }
}
