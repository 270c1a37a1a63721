//! Progress of a run: whether the robot advances, and whether its wheels spin.

use robhaz_sim::Truth;
use robhaz_sim::drive::Drive;

/// Advance that counts as a gain, in wheel radii: 10 mm for the default robot.
const GAIN: f64 = 0.1;
/// Integral of the set speed since the last gain after which the robot counts as stuck, in wheel radii: ten times the
/// gain, so that a robot is stuck that advances at less than a tenth of the set speed.
const ASKED: f64 = 1.0;
/// Time without gain after which the robot counts as stuck, s: longer than any of the shipped kerbs and trenches holds it.
const PATIENCE: f64 = 2.0;
/// Slip speed above which a wheel spins, as a share of the set speed: creep stays below a tenth of it.
const SPIN: f64 = 0.5;

/// Progress of a run.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Progress {
    /// Travel of the body along x since the start, m, positive in the direction of the set speed.
    pub distance: f64,
    /// Integral of the set speed over time, m.
    pub asked: f64,
    /// Time since which the robot has not advanced, s; `None` where it advances, or the set speed is zero.
    pub stuck_since: Option<f64>,
    /// Time for which each wheel spun: its slip speed was above half the set speed, s.
    pub spinning: [f64; 3],
}

/// Measures the progress of a run, record by record.
#[derive(Clone, Copy, Debug)]
pub struct ProgressMeter {
    drive: Drive,
    wheel_radius: f64,
    start: Option<Truth>,
    last: Option<Truth>,
    progress: Progress,
    /// The last gain.
    mark: Mark,
}

/// An instant at which the robot had advanced.
#[derive(Clone, Copy, Debug, Default)]
struct Mark {
    time: f64,
    distance: f64,
    asked: f64,
}

impl ProgressMeter {
    /// For a robot with this drive and wheels of this radius (m).
    pub fn new(drive: &Drive, wheel_radius: f64) -> Self {
        Self {
            drive: *drive,
            wheel_radius,
            start: None,
            last: None,
            progress: Progress::default(),
            mark: Mark::default(),
        }
    }

    /// Adds the next record.
    pub fn add(&mut self, truth: &Truth) {
        let start = self.start.get_or_insert(*truth);
        let ahead = if self.drive.speed < 0.0 { -1.0 } else { 1.0 };
        self.progress.distance = ahead * (truth.body.position.x - start.body.position.x);
        if let Some(last) = self.last {
            let time = truth.time - last.time;
            let rim = |t: f64| self.wheel_radius * self.drive.set_speed(t, self.wheel_radius).abs();
            self.progress.asked += 0.5 * time * (rim(last.time) + rim(truth.time));
            let set = self.drive.speed.abs();
            for (spinning, wheel) in self.progress.spinning.iter_mut().zip(&truth.wheels) {
                if set > 0.0 && wheel.slip_speed.abs() > SPIN * set {
                    *spinning += time;
                }
            }
        }
        let Progress {
            distance, asked, ..
        } = self.progress;
        let gained = distance - self.mark.distance > GAIN * self.wheel_radius;
        let waits = asked <= self.mark.asked;
        if gained || waits {
            self.mark = Mark {
                time: truth.time,
                distance,
                asked,
            };
        }
        self.last = Some(*truth);
    }

    /// The progress up to the last record.
    pub fn progress(&self) -> Progress {
        let Mark { time, asked, .. } = self.mark;
        let since = self.last.map_or(0.0, |t| t.time) - time;
        let is_stuck =
            since >= PATIENCE && self.progress.asked - asked >= ASKED * self.wheel_radius;
        Progress {
            stuck_since: is_stuck.then_some(time),
            ..self.progress
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A run of `seconds` at 100 records a second in which the body goes as `way` says (m at s), at a slip speed of 0.15 m/s.
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

    /// Closed form: way, way asked for (speed times time less half the ramp), time of the last gain, time of spinning.
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

    /// Never called stuck: before the drive starts, at a set speed of zero, at a tenth of the speed and more, at a
    /// speed at which little was asked for, backwards as asked.
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

    /// Stuck from the drive's start on; also where the robot slides back, and where it goes the wrong way.
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
