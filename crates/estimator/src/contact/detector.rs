//! Contact state of a wheel: in the air, one contact, two contacts; and whether it slides. Detected
//! from its normal force and the residuals of its rolling constraints.

use crate::common::{IMPACT_LASTS, SMOOTHING};
use crate::deviation::{GATE, SIGNIFICANT, WITHIN};
use crate::settings::ContactAngles;

/// T/N from which slip may be more than linear in it, -: ground with less friction carries no robot. A
/// slip that shows below comes from a wrong velocity, as after an impact.
/// Chosen; sensitive. Held by `tests/acceptance_contacts.rs`.
pub(crate) const SLIPPING_RATIO: f64 = 0.15;
/// Least slip of a wheel that slides, m/s: errors of the estimated speed while two wheels slide, and
/// of the creep near the peak of friction. Not less than [`SIGNIFICANT`] deviations of the gyroscope's
/// part.
/// Chosen; held by `tests/acceptance_contacts.rs`.
pub(crate) const LEAST_SLIP: f64 = 0.008;

/// How many contacts a wheel has.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ContactState {
    /// It does not touch the ground.
    InAir,
    /// It touches the ground at one place.
    #[default]
    OneContact,
    /// It touches the ground at two places: riser and tread, or both sides of a concave corner.
    TwoContacts,
}

/// Estimated contact state of a wheel.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ContactEstimate {
    /// How many contacts it has.
    pub state: ContactState,
    /// Whether it slides: its slip is beyond creep. Always `false` in the air.
    pub sliding: bool,
    /// Slip speed, m/s: the rim's speed less that of the wheel's centre along the ground, positive
    /// when the rim outruns the ground. Creep counts. 0 in the air, and before the wheel's speed is
    /// known.
    pub slip: f64,
}

/// Residuals of the rolling constraints of one wheel at one sample, before they correct any state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct RollingResiduals {
    /// Speed of the wheel's centre away from the ground, m/s.
    pub away: f64,
    /// Standard deviation of `away` at a single sample, m/s.
    pub away_sigma: f64,
    /// Slip of the wheel. `None` without a rim speed.
    pub slip: Option<SlipResidual>,
}

/// Slip of a wheel at one sample: rim speed less the speed of the centre along the ground, in two
/// parts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct SlipResidual {
    /// The part that creep does not explain, m/s.
    pub beyond_creep: f64,
    /// The part that creep explains: creep speed times T/N, m/s.
    pub creep: f64,
    /// Variance of `beyond_creep` at a single sample, m^2/s^2.
    pub variance: f64,
    /// Standard deviation of the slip from the gyroscope alone, m/s.
    pub noise: f64,
    /// Density of the noise of the slip at low frequencies, from gyroscope and encoder, m^2/s: its
    /// mean over a time t has the variance density/t.
    pub density: f64,
}

impl RollingResiduals {
    /// Normalised innovation squared of the direction constraint.
    pub fn direction_nis(&self) -> f64 {
        self.away * self.away / (self.away_sigma * self.away_sigma)
    }
}

impl SlipResidual {
    /// Slip beyond creep that needs no fault, in units of that creep: a wheel that comes to other
    /// ground may have none, or three times as much where friction is poor. Beyond that it slides.
    /// Chosen; held by `tests/acceptance_contacts.rs`.
    const OTHER_GROUND: [f64; 2] = [-1.0, 2.0];

    /// Normalised innovation squared of the speed constraint, relative to the slip of another wheel
    /// beyond its creep. What other ground under either wheel explains of the difference does not
    /// count.
    pub fn nis_beside(&self, other: &Self) -> f64 {
        let own = self.beyond_creep - other.beyond_creep;
        let range = |slip: &Self| {
            let [a, b] = Self::OTHER_GROUND.map(|share| share * slip.creep);
            [a.min(b), a.max(b)]
        };
        let ([low, high], [other_low, other_high]) = (range(self), range(other));
        let unmodelled = own - own.max(low - other_high).min(high - other_low);
        unmodelled * unmodelled / self.variance
    }
}

/// What shows the contact state of a wheel at one sample.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ContactEvidence {
    /// Whether it carries no load.
    pub unloaded: bool,
    /// T/N, -.
    pub ratio: f64,
    /// `None` where the constraints do not apply: the wheel carries no load, or no time has passed.
    pub rolling: Option<RollingResiduals>,
    /// Where the contact angle comes from.
    pub angles: ContactAngles,
}

/// Detects the contact state of one wheel.
///
/// - In the air: it carries no load.
/// - Two contacts: the wheel's centre leaves the direction of its contact angle, as it does only
///   while riser and tread share the load.
/// - Sliding: the slip is [`Self::SLIDING`] times the creep of its T/N, and in its direction.
///
/// Each state begins and ends when its condition has held for some time; two contacts and sliding
/// end at another threshold than they begin (hysteresis). The values are engineering choices for
/// sensors of the typical grade; `docs/estimators.md` has what they reach.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct ContactDetector {
    air: Switch,
    two: Switch,
    sliding: Switch,
    /// Low-pass filtered slip beyond creep, m/s.
    beyond_creep: f64,
}

impl ContactDetector {
    /// Slip over creep above which a wheel slides, and below which it grips again, -. Where T/N is
    /// at its peak, the slip is between once (Coulomb friction) and three times (brush model) the
    /// creep at that T/N. The friction law is unknown.
    /// Chosen; held by `tests/acceptance_contacts.rs`.
    const SLIDING: [f64; 2] = [2.0, 1.5];

    /// Takes the evidence of one sample, `dt` seconds after the last.
    pub fn update(&mut self, evidence: &ContactEvidence, dt: f64) -> ContactEstimate {
        let in_air = self.air.on;
        let change = evidence.unloaded != in_air;
        self.air.update(change, IMPACT_LASTS, dt);

        let mut slip = None;
        if let Some(rolling) = evidence.rolling.filter(|_| !self.air.on) {
            slip = rolling
                .slip
                .filter(|slip| (slip.beyond_creep + slip.creep).is_finite());
            self.update_two(&rolling, evidence.angles, dt);
            self.update_sliding(rolling.slip.as_ref(), evidence.ratio, dt);
        } else {
            *self = Self {
                air: self.air,
                ..Self::default()
            };
        }
        ContactEstimate {
            state: match (self.air.on, self.two.on) {
                (true, _) => ContactState::InAir,
                (false, true) => ContactState::TwoContacts,
                (false, false) => ContactState::OneContact,
            },
            sliding: self.sliding.on,
            slip: slip.map_or(0.0, |slip| self.beyond_creep + slip.creep),
        }
    }

    fn update_two(&mut self, rolling: &RollingResiduals, angles: ContactAngles, dt: f64) {
        let (away, sigma) = (rolling.away.abs(), rolling.away_sigma);
        // The estimated angle follows what leaves it, so that less is left.
        let begins = match angles {
            ContactAngles::Given => GATE,
            ContactAngles::Unknown => SIGNIFICANT,
        };
        if self.two.on {
            // The rates behind it have followed by then.
            let ends = away < WITHIN * sigma;
            self.two.update(ends, SMOOTHING, dt);
        } else {
            self.two.update(away > begins * sigma, 0.0, dt);
        }
    }

    fn update_sliding(&mut self, slip: Option<&SlipResidual>, ratio: f64, dt: f64) {
        let Some(slip) = slip.filter(|slip| slip.beyond_creep.is_finite()) else {
            self.sliding = Switch::default();
            self.beyond_creep = 0.0;
            return;
        };
        let weight = robhaz_model::low_pass_share(dt, IMPACT_LASTS);
        self.beyond_creep += weight * (slip.beyond_creep - self.beyond_creep);
        let (beyond, creep) = (self.beyond_creep, slip.creep);
        let least = LEAST_SLIP.max(SIGNIFICANT * slip.noise);
        // In these forms a NaN does not slide.
        let slides = (beyond + creep).abs()
            > Self::SLIDING[usize::from(self.sliding.on)] * creep.abs()
            && beyond.abs() > least
            && beyond * creep > 0.0
            && ratio.abs() > SLIPPING_RATIO;
        self.sliding
            .update(slides != self.sliding.on, IMPACT_LASTS, dt);
    }
}

/// A condition that changes when its opposite has held for some time without a break.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Switch {
    on: bool,
    /// Time for which the opposite has held, s.
    time: f64,
}

impl Switch {
    /// Rounding of the times between samples, s.
    /// Definition.
    const ROUNDING: f64 = 1e-9;

    /// `opposite`: whether the opposite of the present condition holds at this sample, `dt` seconds
    /// after the last. It changes after `hold`, s.
    fn update(&mut self, opposite: bool, hold: f64, dt: f64) {
        if !opposite {
            self.time = 0.0;
            return;
        }
        self.time += dt;
        if self.time >= hold - Self::ROUNDING {
            self.on = !self.on;
            self.time = 0.0;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const DT: f64 = 1e-3;

    /// A wheel that rolls with a load, with a slip beyond creep (m/s) and a speed away from the
    /// ground in standard deviations.
    fn rolling(beyond_creep: f64, away: f64) -> ContactEvidence {
        ContactEvidence {
            unloaded: false,
            ratio: 0.5,
            rolling: Some(RollingResiduals {
                away: 1e-3 * away,
                away_sigma: 1e-3,
                slip: Some(SlipResidual {
                    beyond_creep,
                    creep: 0.0075,
                    variance: 1e-6,
                    noise: 5e-4,
                    density: 2.5e-10,
                }),
            }),
            angles: ContactAngles::Given,
        }
    }

    /// The time (ms) from which on the state satisfies `reached`, over 100 ms.
    fn time_until(
        detector: &mut ContactDetector,
        evidence: ContactEvidence,
        reached: impl Fn(ContactEstimate) -> bool,
    ) -> Option<usize> {
        (1..=100).find(|_| reached(detector.update(&evidence, DT)))
    }

    /// Each state begins and ends within 20 ms of its condition: two contacts begin at the first
    /// sample, no other change is made at a single one.
    #[test]
    fn states_begin_and_end_after_their_times() {
        let mut detector = ContactDetector::default();
        let normal = rolling(0.0, 0.5);
        let one = |e: ContactEstimate| e.state == ContactState::OneContact && !e.sliding;
        assert_eq!(time_until(&mut detector, normal, one), Some(1));
        let air = ContactEvidence {
            unloaded: true,
            rolling: None,
            ..rolling(0.0, 0.0)
        };
        let in_air = |e: ContactEstimate| e.state == ContactState::InAir;
        assert_eq!(time_until(&mut detector, air, in_air), Some(5));
        assert_eq!(time_until(&mut detector, normal, one), Some(5));
        let leaves = rolling(0.0, 7.0);
        let two = |e: ContactEstimate| e.state == ContactState::TwoContacts;
        assert_eq!(time_until(&mut detector, leaves, two), Some(1));
        assert_eq!(time_until(&mut detector, normal, one), Some(20));
        // A step of 50 mm/s passes 8 mm/s in the low pass at the first sample.
        let slips = rolling(0.05, 0.5);
        let sliding = |e: ContactEstimate| e.sliding;
        assert_eq!(time_until(&mut detector, slips, sliding), Some(5));
        // It is below 8 mm/s from the eighth sample on, and has to stay there for 5.
        assert_eq!(time_until(&mut detector, normal, one), Some(12));
    }

    /// A speed of four standard deviations away from a given angle is noise; away from an estimated
    /// one it shows two contacts.
    #[test]
    fn an_estimated_angle_is_left_by_less() {
        for (angles, state) in [
            (ContactAngles::Given, ContactState::OneContact),
            (ContactAngles::Unknown, ContactState::TwoContacts),
        ] {
            let mut detector = ContactDetector::default();
            let mut evidence = rolling(0.0, 4.0);
            evidence.angles = angles;
            assert_eq!(detector.update(&evidence, DT).state, state);
            // Below both thresholds for 20 ms.
            evidence = rolling(0.0, 1.9);
            evidence.angles = angles;
            let one = |e: ContactEstimate| e.state == ContactState::OneContact;
            assert!(time_until(&mut detector, evidence, one).is_some());
        }
    }

    /// Closed form: with creeps of 5 and -2 mm/s the slips beyond them may differ by -5 - 2 to 10 +
    /// 4 mm/s on other ground; what is beyond that counts, over its variance.
    #[test]
    fn slip_of_other_ground_is_no_contradiction() {
        let slip = |beyond_creep, creep| SlipResidual {
            beyond_creep,
            creep,
            variance: 4e-6,
            noise: 5e-4,
            density: 2.5e-10,
        };
        let other = slip(1e-3, -2e-3);
        let square_of = |difference: f64| slip(1e-3 + difference, 5e-3).nis_beside(&other);
        for difference in [-6.9e-3, 0.0, 6.9e-3, 13.9e-3] {
            assert!(square_of(difference).abs() < 1e-12, "{difference}");
        }
        // Rounding of differences of millimetres a second.
        assert!((square_of(-9e-3) - 1.0).abs() < 1e-9);
        assert!((square_of(18e-3) - 4.0).abs() < 1e-9);
    }

    /// Closed form: the slip is creep and what is beyond it, once the low pass has settled; none in
    /// the air.
    #[test]
    fn the_slip_is_that_of_the_rim() {
        let mut detector = ContactDetector::default();
        for _ in 0..100 {
            detector.update(&rolling(0.03, 0.5), DT);
        }
        let found = detector.update(&rolling(0.03, 0.5), DT);
        // 0.83^100 of the step remains.
        assert!((found.slip - 0.0375).abs() < 1e-8, "{found:?}");
        let in_air = ContactEvidence {
            unloaded: true,
            rolling: None,
            ..rolling(0.0, 0.0)
        };
        let found = detector.update(&in_air, DT);
        assert!(found.slip.abs() < 1e-300);
    }

    /// Between the two thresholds the state stays what it was.
    #[test]
    fn between_its_thresholds_a_state_stays() {
        let between = rolling(0.0, 4.0);
        let mut detector = ContactDetector::default();
        for _ in 0..100 {
            let found = detector.update(&between, DT);
            assert_eq!(found.state, ContactState::OneContact);
        }
        let on = rolling(0.03, 9.0);
        for _ in 0..10 {
            detector.update(&on, DT);
        }
        for _ in 0..100 {
            let found = detector.update(&between, DT);
            assert_eq!(found.state, ContactState::TwoContacts);
        }
    }

    /// Slip against the traction and slip without traction are no sliding; and a NaN changes
    /// nothing.
    #[test]
    fn what_is_no_sliding() {
        let mut without_traction = rolling(0.03, 0.5);
        without_traction.ratio = 0.1;
        for evidence in [rolling(-0.03, 0.5), without_traction] {
            let mut detector = ContactDetector::default();
            for _ in 0..100 {
                assert!(!detector.update(&evidence, DT).sliding);
            }
        }
        let nan = rolling(f64::NAN, f64::NAN);
        let mut detector = ContactDetector::default();
        for _ in 0..100 {
            assert_eq!(detector.update(&nan, DT), ContactEstimate::default());
        }
        assert_eq!(detector, ContactDetector::default());
    }
}
