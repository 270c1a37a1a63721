//! One ramp: when to take the torque back, and what it has shown.

use super::result::{FrictionTestEnd, FrictionTestResult, RampLimit};
use libm::hypot;
use robhaz_estimator::{Estimate, Flags, PeakFriction, WheelFriction};

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
    /// The result; before [`FrictionTestPhase::Done`] as far as it is known: mu_max is at least
    /// `mu`.
    pub result: FrictionTestResult,
    phase: FrictionTestPhase,
    /// Start of the ramp, and the last estimate, s.
    pub(super) start: f64,
    last: f64,
    /// Whether each wheel has gripped since the start: what slipped before says nothing of the
    /// ramp.
    gripped: [bool; 3],
    /// Time for which nothing was clear, s.
    unclear: f64,
    /// Time for which noise hid an onset of slip, s.
    hidden: f64,
}

impl FrictionTest {
    /// Longest time without a clear estimate, s.
    pub const PATIENCE: f64 = 0.5;

    /// A test of wheel `wheel` (0 to 2) whose ramp starts at `time` (s).
    pub fn new(wheel: usize, time: f64) -> Self {
        Self {
            result: FrictionTestResult {
                wheel,
                time,
                ..FrictionTestResult::default()
            },
            phase: FrictionTestPhase::Rising,
            start: time,
            last: time,
            gripped: [false; 3],
            unclear: 0.0,
            hidden: 0.0,
        }
    }

    /// Takes the estimate of a sample at `time` (s); `None` where there is none.
    pub fn update(&mut self, time: f64, estimate: Option<&Estimate>) -> FrictionTestPhase {
        let dt = (time - self.last).max(0.0);
        self.last = time;
        if self.phase == FrictionTestPhase::Done {
            return self.phase;
        }
        self.result.duration = time - self.start;
        let wheels = estimate
            .and_then(|e| e.kalman.as_ref())
            .map(|k| &k.friction);
        let wheel = wheels.and_then(|wheels| wheels.get(self.result.wheel));
        if self.phase == FrictionTestPhase::BackingOff {
            match wheel.and_then(|wheel| wheel.slid) {
                Some(slid) => self.result.slipped_distance = slid,
                None => self.phase = FrictionTestPhase::Done,
            }
            return self.phase;
        }
        let none = [WheelFriction::default(); 3];
        let known = wheels.unwrap_or(&none);
        for (gripped, wheel) in self.gripped.iter_mut().zip(known) {
            *gripped |= wheels.is_some() && wheel.slid.is_none();
        }
        let noise = wheel.map_or(0.0, |wheel| wheel.slip_noise);
        self.result.slip_noise = noise;
        self.hidden = if noise > 1.0 { self.hidden + dt } else { 0.0 };
        if self.hidden > Self::PATIENCE {
            return self.end(FrictionTestEnd::Noise);
        }
        let limit = RampLimit::new(self.result.wheel, known);
        if let Some(event) = wheel.and_then(|wheel| wheel.slip_event) {
            self.result = FrictionTestResult {
                end: FrictionTestEnd::Slipped,
                time: time - event.age,
                place: event.place,
                mu: event.mu_max,
                sigma: event.sigma,
                systematic: event.systematic,
                ramps: 1,
                limits: [Some(limit.of_tested()), None],
                ..self.result
            };
            self.phase = FrictionTestPhase::BackingOff;
            return self.phase;
        }
        if let Some((other, slips)) = wheels.and_then(|wheels| self.other_that_slips(wheels)) {
            return self.end_with(other, slips, limit);
        }
        let clear = estimate.is_some_and(|estimate| {
            let mut wheels = estimate.kalman.iter().flat_map(|k| &k.friction);
            let loaded = wheels.all(|wheel| wheel.needed.is_some());
            loaded && !estimate.flags.intersects(Flags::UNRELIABLE)
        });
        match wheel.filter(|_| clear) {
            Some(wheel) => {
                self.unclear = 0.0;
                self.hold(time, &wheel.peak);
            }
            None => self.unclear += dt,
        }
        if self.unclear > Self::PATIENCE {
            return self.end(FrictionTestEnd::NotClear);
        }
        self.phase
    }

    /// Wheel `other` slips, or may slip instead of the tested one. A wheel that `slips` with less
    /// T/N than another one bears stands on ground of its own: it says nothing of mu_max.
    fn end_with(&mut self, other: usize, slips: bool, limit: RampLimit) -> FrictionTestPhase {
        if slips && !limit.may_slip(other) {
            return self.end(FrictionTestEnd::OtherWheel(other));
        }
        self.result.limits = [Some(limit), None];
        if !limit.may_slip(self.result.wheel) {
            return self.end(FrictionTestEnd::OtherWheel(other));
        }
        self.result.end = FrictionTestEnd::EitherWheel(other);
        self.result.mu = limit.friction(&[0.0; 3]).mu;
        self.result.ramps = 1;
        self.phase = FrictionTestPhase::BackingOff;
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

    /// Another wheel that slips; or, if the tested one seems to slip, the other one that needs
    /// most. And whether it is the first case.
    fn other_that_slips(&self, wheels: &[WheelFriction; 3]) -> Option<(usize, bool)> {
        let need = |wheel: &WheelFriction| wheel.needed.map_or(0.0, |needed| needed.value.abs());
        let slips = |i: usize, wheel: &WheelFriction| {
            wheel.slid.is_some() && self.gripped.get(i).is_some_and(|gripped| *gripped)
        };
        let tested = self.result.wheel;
        let seems = slips(tested, wheels.get(tested)?);
        let mut others = wheels.iter().enumerate().filter(|(i, _)| *i != tested);
        let first = others.clone().find(|(i, wheel)| slips(*i, wheel));
        let most = others.next().map(|first| {
            others.fold(first, |most, other| match need(other.1) > need(most.1) {
                true => other,
                false => most,
            })
        });
        let found = first.or(most.filter(|_| seems));
        found.map(|(i, _)| (i, first.is_some()))
    }

    /// The wheel bears a T/N: mu_max is at least this.
    fn hold(&mut self, time: f64, peak: &PeakFriction) {
        let mu = peak.needed.value.abs();
        if mu > self.result.mu {
            self.result = FrictionTestResult {
                mu,
                sigma: hypot(peak.needed.sigma, peak.offset.sigma),
                time,
                ..self.result
            };
        }
    }
}

#[cfg(test)]
#[path = "test_tests.rs"]
mod tests;
