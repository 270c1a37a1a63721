//! The test of section 5 of the paper: the torque of one wheel rises linearly until the wheel slips.
//!
//! A [`FrictionTest`] takes the estimates of such a ramp, tells when to take the torque back, and gives the result. Who raises
//! the torque is not its business: on the simulated robot it is the control `friction-test`.

use crate::estimate::Estimate;
use crate::flags::Flags;
use crate::friction::WheelFriction;

/// How a friction test ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FrictionTestEnd {
    /// The wheel slipped: mu_max was found.
    Slipped,
    /// The torque reached its limit.
    TorqueLimit,
    /// The test took too long.
    TimeLimit,
    /// Another wheel, 0 to 2, slipped first, or needed about as much friction when the tested wheel seemed to slip: the reaction was more
    /// than it can bear.
    OtherWheel(usize),
    /// A wheel carries no load, the linkage is at a stop, readings are stale, or there is no estimate, for more than [`FrictionTest::PATIENCE`].
    NotClear,
    /// The run ended first.
    Unfinished,
}

impl FrictionTestEnd {
    /// Short name in summaries.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Slipped => "slipped",
            Self::TorqueLimit => "torque limit",
            Self::TimeLimit => "time limit",
            Self::OtherWheel(_) => "other wheel slipped",
            Self::NotClear => "not clear",
            Self::Unfinished => "unfinished",
        }
    }
}

/// Result of a friction test.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrictionTestResult {
    /// The tested wheel, 0 to 2.
    pub wheel: usize,
    /// How it ended.
    pub end: FrictionTestEnd,
    /// Time of the largest T/N, s.
    pub time: f64,
    /// Place of the wheel's contact at that time along the path, m, in the frame of [`crate::Estimator::ground`]. `None` before the robot
    /// has moved, and without slip.
    pub place: Option<f64>,
    /// Largest |T/N|, -. After a slip it is mu_max; without one mu_max is at least this.
    pub mu: f64,
    /// Its standard deviation, -.
    pub sigma: f64,
    /// Part of that deviation that comes from a lasting error of the torque reading, -; none after two ramps.
    pub lasting: f64,
    /// N at the largest T/N, N.
    pub load: f64,
    /// Number of ramps that ended in slip: with two, `mu` is their mean.
    pub ramps: u32,
    /// Distance that the rim slid from the largest T/N until the wheel gripped again, m. Creep before it does not count.
    pub slipped_distance: f64,
    /// Time from the start of the ramp until the wheel gripped again, or until the ramp ended, s.
    pub duration: f64,
}

impl FrictionTestResult {
    /// This result together with that of a ramp in the other direction, at about the same place.
    ///
    /// A lasting error e of the torque, such as its offset or friction in the gear, adds to one traction and subtracts from the other:
    /// `T1 = mu N1 + e` and `-T2 = mu N2 - e`. So `mu = (T1 - T2)/(N1 + N2)`, the mean of both weighted by their loads. Of the stated
    /// deviations the part of such errors cancels; the rest is common to both, as the torque's gain is, so the deviations add with the
    /// same weights. If one ramp ended without slip, the other one counts alone; of two such ramps that with the larger bound.
    pub fn combined(&self, other: &Self) -> Self {
        let slipped = |result: &Self| result.end == FrictionTestEnd::Slipped;
        let other_counts = match (slipped(self), slipped(other)) {
            (true, _) => false,
            (false, true) => true,
            (false, false) => other.mu - other.sigma > self.mu - self.sigma,
        };
        let mut both = if other_counts { *other } else { *self };
        both.duration = self.duration + other.duration;
        both.slipped_distance = self.slipped_distance + other.slipped_distance;
        let loads = self.load + other.load;
        if slipped(self) && slipped(other) && loads > 0.0 {
            let (a, b) = (self.load / loads, other.load / loads);
            both.mu = a * self.mu + b * other.mu;
            let rest = |result: &Self| {
                let square = result.sigma * result.sigma - result.lasting * result.lasting;
                libm::sqrt(square.max(0.0))
            };
            both.sigma = a * rest(self) + b * rest(other);
            both.lasting = 0.0;
            both.ramps = self.ramps + other.ramps;
        }
        both
    }
}

/// What a test asks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FrictionTestPhase {
    /// Raise the torque.
    Rising,
    /// Take the torque back: the wheel slips, or the test has ended without slip.
    BackingOff,
    /// The wheel grips: the result is there.
    Done,
}

/// A test of one wheel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrictionTest {
    result: FrictionTestResult,
    phase: FrictionTestPhase,
    /// Start of the ramp, and the last estimate, s.
    start: f64,
    last: f64,
    /// Low-pass filtered T/N, -.
    ratio: Option<f64>,
    /// Time for which nothing was clear, s.
    unclear: f64,
}

impl FrictionTest {
    /// Longest time without a clear estimate, s.
    pub const PATIENCE: f64 = 0.5;
    /// Time constant of the low pass on T/N for the lower bound, s.
    const SMOOTHING: f64 = 0.1;

    /// A test of wheel `wheel` (0 to 2) whose ramp starts at `time` (s).
    pub fn new(wheel: usize, time: f64) -> Self {
        Self {
            result: FrictionTestResult {
                wheel,
                end: FrictionTestEnd::Unfinished,
                time,
                place: None,
                mu: 0.0,
                sigma: 0.0,
                lasting: 0.0,
                load: 0.0,
                ramps: 0,
                slipped_distance: 0.0,
                duration: 0.0,
            },
            phase: FrictionTestPhase::Rising,
            start: time,
            last: time,
            ratio: None,
            unclear: 0.0,
        }
    }

    /// What the test asks for now.
    pub fn phase(&self) -> FrictionTestPhase {
        self.phase
    }

    /// The result; before [`FrictionTestPhase::Done`] as far as it is known: mu_max is at least `mu`.
    pub fn result(&self) -> FrictionTestResult {
        self.result
    }

    /// Takes the estimate of a sample at `time` (s); `None` where there is none.
    pub fn update(&mut self, time: f64, estimate: Option<&Estimate>) -> FrictionTestPhase {
        let dt = (time - self.last).max(0.0);
        self.last = time;
        if self.phase == FrictionTestPhase::Done {
            return self.phase;
        }
        self.result.duration = time - self.start;
        let wheels = estimate.and_then(|estimate| estimate.friction.as_ref());
        let wheel = wheels.and_then(|wheels| wheels.get(self.result.wheel));
        if self.phase == FrictionTestPhase::BackingOff {
            match wheel.and_then(|wheel| wheel.slid) {
                Some(slid) => self.result.slipped_distance = slid,
                None => self.phase = FrictionTestPhase::Done,
            }
            return self.phase;
        }
        if let Some(event) = wheel.and_then(|wheel| wheel.slip_event) {
            self.result = FrictionTestResult {
                end: FrictionTestEnd::Slipped,
                time: time - event.age,
                place: event.place,
                mu: event.mu_max,
                sigma: event.sigma,
                lasting: event.lasting,
                load: event.load,
                ramps: 1,
                ..self.result
            };
            self.phase = FrictionTestPhase::BackingOff;
            return self.phase;
        }
        if let Some(other) = wheels.and_then(|wheels| self.other_that_slips(wheels)) {
            return self.end(FrictionTestEnd::OtherWheel(other));
        }
        let clear = estimate.is_some_and(|estimate| {
            let loaded = estimate
                .friction
                .iter()
                .flatten()
                .all(|wheel| wheel.needed.is_some());
            loaded && !estimate.flags.intersects(Flags::DOUBTFUL)
        });
        match wheel.and_then(|wheel| wheel.needed).filter(|_| clear) {
            Some(needed) => {
                self.unclear = 0.0;
                self.hold(time, needed.value, needed.sigma, dt);
            }
            None => self.unclear += dt,
        }
        if self.unclear > Self::PATIENCE {
            return self.end(FrictionTestEnd::NotClear);
        }
        self.phase
    }

    /// Ends a rising test without slip.
    pub fn end(&mut self, end: FrictionTestEnd) -> FrictionTestPhase {
        if self.phase == FrictionTestPhase::Rising {
            self.result.end = end;
            self.phase = FrictionTestPhase::Done;
        }
        self.phase
    }

    /// Another wheel that slips, or that may slip instead of the tested one: that which needs most.
    fn other_that_slips(&self, wheels: &[WheelFriction; 3]) -> Option<usize> {
        let need = |wheel: &WheelFriction| wheel.needed.map_or(0.0, |needed| needed.value.abs());
        let others = wheels.iter().enumerate();
        let mut others = others.filter(|(i, _)| *i != self.result.wheel);
        let slips = others.clone().find(|(_, wheel)| wheel.slid.is_some());
        let seems = wheels.get(self.result.wheel)?.slid.is_some();
        let most = others.next().map(|first| {
            others.fold(first, |most, other| {
                if need(other.1) > need(most.1) {
                    other
                } else {
                    most
                }
            })
        });
        slips.or(most.filter(|_| seems)).map(|(i, _)| i)
    }

    /// The wheel bears a T/N.
    fn hold(&mut self, time: f64, ratio: f64, sigma: f64, dt: f64) {
        let smooth = self.ratio.get_or_insert(ratio);
        *smooth += dt / (Self::SMOOTHING + dt) * (ratio - *smooth);
        if smooth.abs() > self.result.mu {
            self.result = FrictionTestResult {
                mu: smooth.abs(),
                sigma,
                time,
                ..self.result
            };
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::friction::{NeededFriction, SlipEvent};
    use crate::{Estimator, EstimatorSettings, LinkReading, SensorFrame};
    use robhaz_model::Robot;

    /// An estimate of a robot at rest with the friction of its wheels.
    fn estimate(friction: [WheelFriction; 3]) -> Estimate {
        let link = LinkReading {
            inclination: Some(0.0),
            rate: Some(0.0),
        };
        let mut estimator = Estimator::new(
            &Robot::default_a(),
            EstimatorSettings::best_without_angles(),
        );
        let frame = SensorFrame {
            time: 0.0,
            wheel_angle: [Some(0.0); 3],
            motor_torque: [Some(0.0); 3],
            link1: link,
            link2: link,
            contact_angle: [None; 3],
        };
        let mut estimate = estimator.update(&frame).expect("a robot at rest");
        estimate.friction = Some(friction);
        estimate
    }

    fn needs(value: f64) -> WheelFriction {
        WheelFriction {
            needed: Some(NeededFriction { value, sigma: 0.01 }),
            ..WheelFriction::default()
        }
    }

    /// Runs a ramp of T/N of 0.1/s on wheel 2; `change` can change the wheels at a time (s).
    fn run(change: impl Fn(f64, &mut [WheelFriction; 3])) -> (FrictionTest, f64) {
        let mut test = FrictionTest::new(1, 10.0);
        for k in 1..10_000 {
            let t = 1e-3 * f64::from(k);
            let mut wheels = [needs(-0.05 * t), needs(0.1 * t), needs(-0.05 * t)];
            change(t, &mut wheels);
            if test.update(10.0 + t, Some(&estimate(wheels))) == FrictionTestPhase::Done {
                return (test, t);
            }
        }
        (test, f64::INFINITY)
    }

    /// The event gives mu_max, place and time; the test is done when the wheel grips, with the distance that it slid.
    #[test]
    fn a_slip_gives_the_result() {
        let (test, t) = run(|t, wheels| {
            if t > 3.0 && t < 3.4 {
                wheels[1].slid = Some(0.01 * (t - 2.8));
            }
            if (t - 3.001).abs() < 1e-6 {
                wheels[1].slip_event = Some(SlipEvent {
                    mu_max: 0.29,
                    sigma: 0.01,
                    lasting: 0.0,
                    load: 40.0,
                    age: 0.2,
                    place: Some(0.7),
                });
            }
        });
        let result = test.result();
        assert_eq!((result.wheel, result.end), (1, FrictionTestEnd::Slipped));
        assert_eq!(
            (result.mu, result.sigma, result.place),
            (0.29, 0.01, Some(0.7))
        );
        assert!(
            (result.time - 12.801).abs() < 1e-9 && (t - 3.4).abs() < 2e-3,
            "{result:?} {t}"
        );
        assert!((result.slipped_distance - 0.006).abs() < 2e-5, "{result:?}");
        assert!((result.duration - t).abs() < 1e-9);
    }

    /// Closed form: an error of 2 N on both tractions at mu = 0.5 with loads of 30 and 50 N has no effect on the combined result.
    #[test]
    fn lasting_errors_cancel() {
        let ramp = |traction: f64, load: f64| FrictionTestResult {
            end: FrictionTestEnd::Slipped,
            mu: traction / load,
            sigma: 0.05,
            lasting: 0.04,
            load,
            ramps: 1,
            slipped_distance: 0.01,
            duration: 8.0,
            ..FrictionTest::new(0, 1.0).result()
        };
        let (first, second) = (ramp(15.0 + 2.0, 30.0), ramp(25.0 - 2.0, 50.0));
        let both = first.combined(&second);
        assert!((both.mu - 0.5).abs() < 1e-15 && both.ramps == 2, "{both:?}");
        assert!((both.sigma - 0.03).abs() < 1e-15);
        assert!(
            (both.duration - 16.0).abs() < 1e-15 && (both.slipped_distance - 0.02).abs() < 1e-15
        );
        let without = FrictionTestResult {
            end: FrictionTestEnd::OtherWheel(1),
            ..second
        };
        let both = first.combined(&without);
        assert_eq!(
            (both.mu, both.sigma, both.ramps),
            (first.mu, first.sigma, 1)
        );
    }

    /// Without slip: the lower bound is the largest T/N, smoothed over 0.1 s, and the end says why.
    #[test]
    fn other_ends_give_a_lower_bound() {
        let (test, t) = run(|t, wheels| {
            if t > 5.0 {
                wheels[2].slid = Some(0.0);
            }
        });
        let result = test.result();
        assert_eq!(result.end, FrictionTestEnd::OtherWheel(2));
        // The low pass lags by 0.1 s, 0.01.
        assert!(
            (t - 5.0).abs() < 2e-3 && (result.mu - 0.49).abs() < 1e-3,
            "{result:?}"
        );
        let (test, t) = run(|t, wheels| {
            if t > 4.0 {
                wheels[1].needed = None;
            }
        });
        assert_eq!(test.result().end, FrictionTestEnd::NotClear);
        assert!((t - 4.5).abs() < 5e-3, "{t}");
        let mut test = FrictionTest::new(0, 0.0);
        assert_eq!(
            test.end(FrictionTestEnd::TorqueLimit),
            FrictionTestPhase::Done
        );
        assert_eq!(test.result().end, FrictionTestEnd::TorqueLimit);
        assert_eq!(test.update(1.0, None), FrictionTestPhase::Done);
    }
}
