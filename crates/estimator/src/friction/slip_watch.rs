//! Onset of slip of one wheel, and the largest T/N just before.

use super::needed::{NeededFriction, OffsetShare};
use super::slipped_distance::SlippedDistance;
use crate::common::FILTER_TIME;
use crate::contact::{LEAST_SLIP, SLIPPING_RATIO};
use crate::deviation::{GATE, WITHIN, root_sum_square};
use robhaz_model::low_pass_share;

/// A wheel begins to slip: the ground bears no more than the largest T/N just before.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SlipEvent {
    /// Largest |T/N| before the slip: mu_max, -.
    pub mu_max: f64,
    /// Its standard deviation by the budget of the readings, -: without that of a common scale of
    /// all torques, which T/N of every wheel has too.
    pub sigma: f64,
    /// Part of that deviation that comes from a systematic error of the torque reading, -. A slip
    /// in the other direction has it with the other sign.
    pub systematic: f64,
    /// N at that T/N, N.
    pub load: f64,
    /// Time since that T/N, s.
    pub age: f64,
    /// Place of the contact at that time along the path, m, in the frame of
    /// [`crate::Estimator::ground`]. `None` before the robot has moved.
    pub place: Option<f64>,
}

/// One wheel at one sample.
#[derive(Clone, Copy, Debug)]
pub(crate) struct WheelSample {
    /// T/N.
    pub needed: NeededFriction,
    /// N, N.
    pub load: f64,
    /// What the torque offset has to do with it.
    pub offset: OffsetShare,
    /// Slip speed, m/s.
    pub slip: f64,
    /// Median of the slip speeds of the three wheels, m/s.
    pub median_slip: f64,
    /// Density of the noise of the slip, m^2/s.
    pub slip_density: f64,
    /// Place of the contact, m.
    pub place: Option<f64>,
}

impl WheelSample {
    /// The slip that counts, m/s, at a low-pass filtered T/N.
    ///
    /// The motion filter takes the slip of a wheel with |T/N| below
    /// [`SLIPPING_RATIO`] for an error of the estimated speed, and corrects that
    /// speed: where a wheel spins on ice, the others then seem to slip backwards. The median slip
    /// is that error. It counts in full up to that |T/N|, and less and less up to twice as much,
    /// where slip no longer changes the speed.
    fn counted_slip(&self, ratio: f64) -> f64 {
        let part = (2.0 - ratio.abs() / SLIPPING_RATIO).clamp(0.0, 1.0);
        self.slip - part * self.median_slip
    }
}

/// Watches one wheel for the onset of slip.
///
/// While a wheel grips, its slip follows T/N and hardly accelerates. Once T/N is at the ground's
/// limit, further torque accelerates the wheel: the slip speed grows faster and faster, because
/// friction falls with slip. The onset is a slip acceleration beyond [`Self::ACCELERATION`] in the
/// direction of the traction, for [`Self::HOLD`], in which T/N hardly rises: where it rises fast,
/// creep accelerates the slip of a wheel that grips.
///
/// Where noise or rate of the readings hide that acceleration, the onset shows in the distance that
/// the wheel has slipped: [`SlippedDistance`]. T/N of the onset is then the largest from its last
/// zero on, so that noise of T/N hardly adds to it.
///
/// On ice the slip counts relative to the median of the three wheels: see
/// [`WheelSample::counted_slip`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct SlipWatch {
    /// Whether there has been a sample since the last reset.
    started: bool,
    /// Low-pass filtered T/N, -.
    ratio: f64,
    /// T/N through a faster low pass, -.
    fast_ratio: f64,
    /// The same when the slip began to accelerate, -.
    first_ratio: f64,
    /// Low-pass filtered slip speed, m/s.
    slip: f64,
    /// Time for which the slip has accelerated, s.
    time: f64,
    /// Where readings do not show the acceleration.
    distance: SlippedDistance,
    /// Whether they do not.
    coarse: bool,
    /// Direction in which the wheel slips, 1 or -1, if so.
    forward: f64,
    /// Whether the wheel slips: the onset is over, and the wheel has not gripped again.
    slips: bool,
    /// Slip speed in the direction of the traction below which it grips again, m/s: with as much it
    /// has borne the peak.
    gripping: f64,
    /// Distance that the rim has slid over the ground since the peak, m.
    slid: f64,
    /// The largest |T/N|; while the wheel slips, that before.
    pub peak: Peak,
}

/// The largest low-pass filtered |T/N| of a wheel of the last 0.6 s; where noise or rate hide the
/// acceleration of its slip, that of its last samples.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PeakFriction {
    /// T/N with its sign, and its standard deviation without those of the torque offset and of the
    /// common scale of all torques, -.
    pub needed: NeededFriction,
    /// What the torque offset has to do with it.
    pub offset: OffsetShare,
}

/// That peak, and what else is of its time.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Peak {
    pub friction: PeakFriction,
    load: f64,
    /// Low-pass filtered slip speed in the direction of the traction, m/s.
    slip: f64,
    age: f64,
    place: Option<f64>,
}

impl Peak {
    /// |T/N|, -.
    fn value(&self) -> f64 {
        self.friction.needed.value.abs()
    }
}

impl SlipWatch {
    /// Time constant of the low pass on T/N, s. T/N is level for about four times as long: from the
    /// peak of friction until the wheel has accelerated.
    /// Chosen; held by `crates/study/tests/study/friction_test`.
    const RATIO_SMOOTHING: f64 = 0.05;
    /// Time constant of the faster low pass on T/N, s.
    /// Chosen; held by `crates/study/tests/study/friction_test`.
    const FAST_SMOOTHING: f64 = 0.01;
    /// Time constant of the low pass on T/N of readings that do not show the acceleration, s. At the
    /// default rate T/N rises by 0.01 in it, about as much as noise of 0.03 in samples of 0.02 to
    /// 0.05 s leaves.
    /// Chosen; held by `tests/rovers.rs`.
    const COARSE_SMOOTHING: f64 = 0.15;
    /// Increase of |T/N| from the last zero of the slipped distance on with which the wheel still
    /// grips, -: beyond three deviations of that noise.
    /// Chosen; held by `tests/rovers.rs`.
    const COARSE_RISE: f64 = 0.1;
    /// Increase of |T/N| in that time with which the wheel still grips, -: at 0.5/s or faster the
    /// creep alone accelerates the slip as much.
    /// Chosen; held by `crates/study/tests/study/friction_test`.
    const RISE: f64 = 0.015;
    /// Slip acceleration at the onset, m/s^2: for a rotor and wheel of 0.094 kg m^2 and a load of
    /// 46 N it is a torque of 1.6 % of r N that the ground does not bear. The slip of a gripping
    /// wheel accelerates in proportion to the ramp: up to 98 % of mu_max below 0.02 m/s^2 at
    /// 0.25 N m/s, hence below 0.028 at the default 0.35.
    /// Chosen; held by `crates/study/tests/study/friction_test`.
    const ACCELERATION: f64 = 0.08;
    /// Time for which it has to be beyond, s: longer than an error of the observers.
    const HOLD: f64 = FILTER_TIME;
    /// Age beyond which a peak is dropped, s.
    const WINDOW: f64 = SlippedDistance::USUAL_TIME;
    /// Part of the peak that a wheel in the onset still bears, -: sliding friction is more than
    /// half of mu_max on all common grounds. A wheel that was relieved after the peak bears less,
    /// and is moved by others.
    /// Chosen; held by `crates/study/tests/study/friction_test`.
    const STILL_BORNE: f64 = 0.5;

    /// Takes a sample, `dt` seconds after the last. Returns the event at the sample at which an
    /// onset is found.
    pub fn update(&mut self, sample: &WheelSample, dt: f64) -> Option<SlipEvent> {
        let ratio = sample.needed.value;
        if !(ratio + sample.slip + sample.median_slip).is_finite() {
            *self = Self::default();
            return None;
        }
        if !self.started {
            *self = Self {
                started: true,
                ratio,
                fast_ratio: ratio,
                slip: sample.counted_slip(ratio),
                ..Self::default()
            };
        }
        self.coarse = !Self::shows_acceleration(sample.slip_density, dt);
        let smoothing = match self.coarse {
            true => Self::COARSE_SMOOTHING,
            false => Self::RATIO_SMOOTHING,
        };
        self.ratio += low_pass_share(dt, smoothing) * (ratio - self.ratio);
        self.fast_ratio += low_pass_share(dt, Self::FAST_SMOOTHING) * (ratio - self.fast_ratio);
        let forward = libm::copysign(1.0, self.ratio);
        let slip = sample.counted_slip(self.ratio);
        let acceleration = (slip - self.slip) / Self::RATIO_SMOOTHING;
        self.slip += low_pass_share(dt, Self::RATIO_SMOOTHING) * (slip - self.slip);
        self.slid += slip.abs() * dt;
        if self.slips {
            let speed = match self.coarse {
                true => self.slip * self.forward,
                false => slip * forward,
            };
            self.slips = speed > self.gripping;
            if !self.slips {
                self.peak = Peak::default();
                self.distance.restart(self.slip);
            }
            return None;
        }
        if self.coarse {
            return self.update_distance(sample, slip, dt);
        }
        self.follow_peak(sample, dt);
        let begins = acceleration * forward > Self::ACCELERATION
            && slip * forward > LEAST_SLIP
            && self.fast_ratio.abs() > Self::STILL_BORNE * self.peak.value();
        self.time = if begins { self.time + dt } else { 0.0 };
        if self.time <= dt {
            self.first_ratio = self.fast_ratio;
        }
        if self.time < Self::HOLD {
            return None;
        }
        if (self.fast_ratio - self.first_ratio) * forward > Self::RISE {
            self.time = 0.0;
            return None;
        }
        self.gripping = self.peak.slip.max(LEAST_SLIP);
        Some(self.event())
    }

    /// Whether the slip acceleration of the onset is beyond the noise of the slip, of `density`
    /// (m^2/s), after the low pass, and [`Self::HOLD`] has two samples.
    fn shows_acceleration(density: f64, dt: f64) -> bool {
        let time = Self::RATIO_SMOOTHING;
        let noise = density / (time * time * time);
        let least = Self::ACCELERATION / GATE;
        2.0 * dt <= Self::HOLD && noise < least * least
    }

    /// Above 1 noise or rate hide the onset of slip: [`SlippedDistance::noise`].
    pub fn noise(&self, dt: f64) -> f64 {
        match self.coarse {
            true => self.distance.noise(dt),
            false => 0.0,
        }
    }

    /// The onset by the slipped distance, for a slip speed in m/s.
    ///
    /// It is none of this wheel where the traction has become half of what it was or rises fast, as
    /// above, or where the slip is against the traction.
    fn update_distance(&mut self, sample: &WheelSample, slip: f64, dt: f64) -> Option<SlipEvent> {
        let found = self.distance.update(slip, sample.slip_density, dt);
        let relieved = self.ratio.abs() < Self::STILL_BORNE * self.peak.value();
        let rises = self.fast_ratio.abs() - self.first_ratio.abs() > Self::COARSE_RISE;
        let sigma = root_sum_square(sample.needed.sigma, sample.offset.sigma);
        let against = |forward: f64| self.ratio * forward < -WITHIN * sigma;
        let wrong = found.is_some_and(|forward| rises || against(forward));
        if relieved || wrong {
            self.distance.restart(self.slip);
        }
        self.peak.age += dt;
        let grips = self.distance.grips();
        if grips {
            self.first_ratio = self.fast_ratio;
        }
        if grips || self.ratio.abs() > self.peak.value() {
            self.set_peak(sample);
        }
        self.forward = found.filter(|_| !grips)?;
        self.gripping = self.peak.slip.max(0.0) + SlippedDistance::ALLOWANCE;
        Some(self.event())
    }

    /// The wheel begins to slip.
    fn event(&mut self) -> SlipEvent {
        (self.slips, self.time) = (true, 0.0);
        let PeakFriction { needed, offset } = self.peak.friction;
        SlipEvent {
            mu_max: self.peak.value(),
            sigma: root_sum_square(needed.sigma, offset.sigma),
            systematic: offset.sigma,
            load: self.peak.load,
            age: self.peak.age,
            place: self.peak.place,
        }
    }

    fn follow_peak(&mut self, sample: &WheelSample, dt: f64) {
        self.peak.age += dt;
        if self.ratio.abs() >= self.peak.value() || self.peak.age > Self::WINDOW {
            self.set_peak(sample);
        }
    }

    /// T/N of now is that of the peak.
    fn set_peak(&mut self, sample: &WheelSample) {
        self.peak = Peak {
            friction: PeakFriction {
                needed: NeededFriction {
                    value: self.ratio,
                    sigma: sample.needed.sigma,
                },
                offset: sample.offset,
            },
            load: sample.load,
            slip: self.slip * libm::copysign(1.0, self.ratio),
            age: 0.0,
            place: sample.place,
        };
        self.slid = 0.0;
    }

    /// Distance that the rim has slid over the ground since the largest T/N, m, if the wheel slips.
    pub fn slid(&self) -> Option<f64> {
        self.slips.then_some(self.slid)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const DT: f64 = 1e-3;

    fn sample(ratio: f64, slip: f64) -> WheelSample {
        WheelSample {
            needed: NeededFriction {
                value: ratio,
                sigma: 0.01,
            },
            load: 45.0,
            offset: OffsetShare::default(),
            slip,
            median_slip: 0.0,
            slip_density: 0.0,
            place: Some(1.0),
        }
    }

    /// A wheel under a ramp of T/N of 0.05/s up to `mu` with creep in proportion; then its slip
    /// accelerates by `growth` (1/s), from 0.01 m/s^2 on. Returns the event and the time since the
    /// limit was reached.
    fn ramp(mu: f64, growth: f64, forward: f64) -> Option<(SlipEvent, f64)> {
        let mut watch = SlipWatch::default();
        for k in 0..40_000 {
            let t = DT * f64::from(k);
            let after = t - mu / 0.05;
            let (ratio, slip) = if after < 0.0 {
                (0.05 * t, 0.02 * t * 0.05)
            } else {
                let slip = 0.02 * mu + 0.01 / growth * ((growth * after).exp() - 1.0);
                (mu - (slip - 0.02 * mu).min(0.1), slip)
            };
            if let Some(event) = watch.update(&sample(forward * ratio, forward * slip), DT) {
                return Some((event, after));
            }
        }
        None
    }

    /// Closed form: the acceleration reaches 0.08 m/s^2 within ln(8)/growth, later by the low pass
    /// (0.05 s) and the hold (0.03 s). The low pass lags the ramp by 0.1 s, 0.005; the time until
    /// the slip has accelerated catches up with half of it.
    #[test]
    fn the_onset_follows_the_limit() {
        for forward in [1.0, -1.0] {
            for mu in [0.2, 0.3, 0.6, 0.9] {
                let (event, after) = ramp(mu, 8.0, forward).expect("it slips");
                assert!(after > 0.2 && after < 0.45, "{after} s");
                assert!((event.mu_max / mu - 1.0).abs() < 0.013, "{event:?}");
                assert!(event.age > 0.0 && event.age < 0.35, "{event:?}");
                assert_eq!(event.place, Some(1.0));
            }
        }
    }

    /// Property: creep in proportion to T/N is no slip; nor is slip against the traction.
    #[test]
    fn what_is_no_onset() {
        assert_eq!(ramp(5.0, 8.0, 1.0), None);
        let mut watch = SlipWatch::default();
        for k in 0..1000 {
            let slip = -0.1 * DT * f64::from(k);
            assert_eq!(watch.update(&sample(0.4, slip), DT), None);
        }
    }

    /// Property: on ice, T/N = 0.05, a wheel spins up by 0.2 m/s^2 and the estimated speed of the
    /// robot follows it: its own slip stays, and the other wheels seem to slip backwards. It has an
    /// onset, they have none.
    #[test]
    fn a_spinning_wheel_on_ice_has_an_onset() {
        for forward in [1.0, -1.0] {
            let mut watches = [SlipWatch::default(); 2];
            let mut found = [None; 2];
            for k in 0..1000 {
                let error = -forward * 0.2 * DT * f64::from(k);
                let wheels = [
                    sample(0.05 * forward, 0.01 * forward),
                    sample(-0.025 * forward, error),
                ];
                for ((watch, wheel), found) in watches.iter_mut().zip(wheels).zip(&mut found) {
                    let wheel = WheelSample {
                        median_slip: error,
                        ..wheel
                    };
                    *found = found.or(watch.update(&wheel, DT));
                }
            }
            let [spinning, other] = found;
            assert!(spinning.is_some_and(|event| (event.mu_max - 0.05).abs() < 1e-9));
            assert_eq!(other, None);
        }
    }

    /// Property: T/N that rises by 3/s takes its creep with it, 0.03 m/s at T = N: 0.09 m/s^2, no
    /// onset. Once T/N stays and the slip accelerates on, there is one within 0.1 s.
    #[test]
    fn fast_creep_is_no_onset() {
        let mut watch = SlipWatch::default();
        let mut found = None;
        for k in 0..400 {
            let t = DT * f64::from(k);
            let ratio = (3.0 * t).min(0.75);
            let slip = 0.03 * ratio + 0.2 * (t - 0.25).max(0.0);
            if let Some(event) = watch.update(&sample(ratio, slip), DT) {
                found.get_or_insert((t, event));
            }
        }
        let (t, event) = found.expect("it slips");
        assert!(t > 0.25 && t < 0.35, "{t}");
        assert!((event.mu_max - 0.75).abs() < 0.15, "{event:?}");
    }

    /// Property: a wheel that bore 0.3, is relieved to 0.05 and then moves, faster and faster, has
    /// not slipped: others move it. With 0.2 left, as where sliding friction is two thirds of
    /// mu_max, it slips.
    #[test]
    fn a_relieved_wheel_has_no_onset() {
        for (left, slips) in [(0.05, false), (0.2, true)] {
            let mut watch = SlipWatch::default();
            let mut count = 0;
            for k in 0..700 {
                let since = (DT * f64::from(k) - 0.3).max(0.0);
                let ratio = 0.3 - (since / 0.2).min(1.0) * (0.3 - left);
                let slip = (since - 0.15).max(0.0).powi(2);
                let event = watch.update(&sample(ratio, slip), DT);
                count += u32::from(event.is_some());
            }
            assert_eq!(count > 0, slips, "{left}");
        }
    }

    /// Property: a wheel grips again at the slip with which it bore the peak, here a creep of 15
    /// mm/s.
    #[test]
    fn a_creeping_wheel_grips_again() {
        let mut watch = SlipWatch::default();
        let mut slips = [false; 1500];
        for (k, slips) in (0..1500).zip(&mut slips) {
            let t = DT * f64::from(k);
            let slip = 0.015 + 0.2 * (t - 0.5).max(0.0).min((1.0 - t).max(0.0));
            watch.update(&sample(0.5, slip), DT);
            *slips = watch.slid().is_some();
        }
        assert!(slips[700] && slips[950] && !slips[499] && !slips[1100]);
    }

    /// Property: a wheel that slips has one onset; after it has gripped again it can have another.
    /// A NaN resets it.
    #[test]
    fn one_onset_until_the_wheel_grips() {
        let mut watch = SlipWatch::default();
        let mut count = 0;
        for k in 0..4000 {
            let phase = DT * f64::from(k % 2000);
            let slip = if phase < 1.0 {
                0.0
            } else {
                0.2 * (phase - 1.0)
            };
            count += u32::from(watch.update(&sample(0.5, slip), DT).is_some());
        }
        assert_eq!(count, 2);
        assert!(watch.slid().is_some_and(|slid| slid > 0.09 && slid < 0.11));
        assert_eq!(watch.update(&sample(f64::NAN, 0.0), DT), None);
        assert_eq!(watch, SlipWatch::default());
    }
}
