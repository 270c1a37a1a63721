//! Whether the readings of a log agree, by the estimates of it: the one verdict of an estimate and of a check.

use crate::score::has_forces;
use robhaz_estimator::{Channels, ContactState, Estimate, Flags, Health};
use serde::{Deserialize, Serialize};

/// Mean NIS that no impact on an edge makes: honest logs show up to 9.2 (`tests/check/honest_logs.rs`).
const CERTAIN: f64 = 12.0;
/// Time for which an impact on an edge can look like a contradiction, s: the link's angle that it has
/// left to the filters errs by half a degree until the inclinometers are believed again. At 200 Hz
/// honest logs of `scenes/stairs.toml` show mean NIS up to 6, at 500 Hz 2.3.
const AFTER_EDGE: f64 = 3.0;

/// Time within which a mean NIS of 2 s falls from [`CERTAIN`] to 2, below which it is none any more, s: 2 s ln(12/2).
const DECAY: f64 = 3.6;

/// Channels of the links, and the equilibrium: such an impact makes them look wrong, but neither drives nor ground.
const OF_IMPACTS: u16 = Channels::GYROSCOPE[0].bits()
    | Channels::GYROSCOPE[1].bits()
    | Channels::INCLINOMETER[0].bits()
    | Channels::INCLINOMETER[1].bits()
    | Channels::PARITY.bits();

/// What the estimates of a log so far say of its readings.
#[derive(Clone, Copy, Debug)]
pub struct Agreement {
    /// Time from which on forces count, s.
    from: f64,
    /// Contradictions, and those that no edge explains.
    all: Seen,
    without_edge: Seen,
    /// Last time at which a wheel was at an edge, s.
    edge: f64,
    /// Whether the present contradiction began soon after an edge; `None` without one.
    after_edge: Option<bool>,
    /// Largest mean NIS of any test, and of which.
    largest: f64,
    of: &'static str,
    /// Estimates that count, and those of them whose forces no weight and no impact explains.
    records: f64,
    out_of_range: f64,
}

/// Contradictions: time of the first, s, and their channels.
#[derive(Clone, Copy, Debug, Default)]
struct Seen(Option<f64>, Channels);

impl Seen {
    fn add(&mut self, time: f64, faulty: Channels) {
        self.0.get_or_insert(time);
        self.1 |= faulty;
    }
}

/// Readings that contradict each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Contradiction {
    /// Channels whose readings do.
    pub faulty: Channels,
    /// Why it may be none.
    pub excuse: Option<Excuse>,
}

/// What may look like a contradiction.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Excuse {
    /// Readings that are too far apart for the filters.
    FarApart,
    /// An impact on an edge.
    AfterEdge,
}

impl Excuse {
    /// What it is, and which log would show a contradiction.
    pub const fn in_words(self) -> &'static str {
        match self {
            Self::FarApart => {
                "more than 20 ms between readings, a turn of a wheel by more than 0.02 rad, or a speed beyond sqrt(g r/2) may look like a contradiction: record at a higher rate, or drive slower"
            }
            Self::AfterEdge => {
                "a wheel was at an edge just before, and an impact between two readings may look like a contradiction: record at a higher rate, or drive where no wheel meets an edge"
            }
        }
    }
}

impl Agreement {
    /// Share of the records that may have forces which neither weight nor impacts explain: those of single
    /// impacts have.
    pub const FEW_OUT_OF_RANGE: f64 = 0.01;
    /// The same where readings are too far apart for the filters: there honest logs show up to 1.4 %
    /// (`tests/check/honest_logs.rs`).
    const FEW_FAR_APART: f64 = 0.05;
    /// Mean NIS of a contradiction that is none of the filters' own where readings are too far apart for
    /// them, or the robot too fast: there honest logs show up to 9.2. It is no chance, which more samples
    /// would tell: the mean of 2 s at 50 Hz has a deviation of 0.1. It is the way between readings, of which
    /// the filters know nothing.
    pub const FAR_APART: f64 = 12.0;

    /// Of no estimate; forces count from a time (s) on.
    pub fn new(from: f64) -> Self {
        Self {
            from,
            all: Seen::default(),
            without_edge: Seen::default(),
            edge: f64::NEG_INFINITY,
            after_edge: None,
            largest: 0.0,
            of: "all",
            records: 0.0,
            out_of_range: 0.0,
        }
    }

    /// Adds the estimate of a time, s.
    pub fn add(&mut self, time: f64, estimate: &Estimate) {
        if time >= self.from && has_forces(estimate) {
            self.records += 1.0;
            if estimate.flags.contains(Flags::OUT_OF_RANGE) {
                self.out_of_range += 1.0;
            }
        }
        let Some(kalman) = &estimate.kalman else {
            return;
        };
        let mut now = 0.0;
        for (values, name) in tests(&kalman.health) {
            for nis in values {
                now = nis.max(now);
                if *nis > self.largest {
                    (self.largest, self.of) = (*nis, name);
                }
            }
        }
        let mut states = kalman.contact.iter().map(|contact| contact.state);
        if states.any(|state| state == ContactState::TwoContacts) {
            self.edge = time;
        }
        // The torques' scale has a verdict of its own.
        let bits = kalman.health.faulty.bits() & !Channels::TORQUE_SCALE.bits();
        if bits == 0 {
            self.after_edge = None;
            return;
        }
        let since = time - self.edge;
        let began = *self.after_edge.get_or_insert(since < AFTER_EDGE);
        let is_of_impact = bits & !OF_IMPACTS == 0;
        // What an edge leaves to the equilibrium lasts to the next one.
        let is_of_parity = bits == Channels::PARITY.bits() && self.edge.is_finite();
        let is_soon = began && since < AFTER_EDGE + DECAY || is_of_parity;
        let is_of_edge = is_of_impact && is_soon && now < CERTAIN;
        self.all.add(time, Channels::from_bits(bits));
        if !is_of_edge {
            self.without_edge.add(time, Channels::from_bits(bits));
        }
    }

    /// The contradiction, if there is one. `certain`: mean NIS from which on it is one, 0 where the readings
    /// follow each other closely enough for the filters.
    pub fn contradiction(&self, certain: f64) -> Option<Contradiction> {
        self.all.0?;
        let (excuse, seen) = match (self.largest < certain, self.without_edge.0) {
            (true, _) => (Some(Excuse::FarApart), &self.all),
            (false, None) => (Some(Excuse::AfterEdge), &self.all),
            (false, Some(_)) => (None, &self.without_edge),
        };
        let faulty = seen.1;
        Some(Contradiction { faulty, excuse })
    }

    /// Time of the first contradiction, s; that without an excuse, if there is one.
    pub fn first(&self) -> Option<f64> {
        self.without_edge.0.or(self.all.0)
    }

    /// Largest mean NIS of any test, and of which.
    pub const fn largest(&self) -> (f64, &'static str) {
        (self.largest, self.of)
    }

    /// Whether so many records have forces that neither weight nor impacts explain, and why these may be
    /// right; `certain` as above.
    pub fn wrong(&self, certain: f64) -> Option<Option<Excuse>> {
        let share = self.out_of_range();
        let is_far_apart = certain > 0.0 && share <= Self::FEW_FAR_APART;
        (share > Self::FEW_OUT_OF_RANGE).then(|| is_far_apart.then_some(Excuse::FarApart))
    }

    /// Share of the records whose forces neither weight nor impacts explain; 0 without records.
    pub fn out_of_range(&self) -> f64 {
        self.out_of_range / self.records.max(1.0)
    }
}

/// The mean NIS of each test, by its name. One that is added does not compile until it is judged.
pub fn tests(health: &Health) -> [(&[f64], &'static str); 5] {
    let Health {
        faulty: _,
        encoder,
        slip,
        direction,
        inclination,
        parity,
    } = health;
    [
        (encoder, "encoders"),
        (slip, "speeds of the rims"),
        (direction, "directions of the wheels' centres"),
        (inclination, "inclinometers"),
        (std::slice::from_ref(parity), "equilibrium"),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::score::tests::estimate_of;
    use robhaz_estimator::{ContactEstimate, KalmanReport};

    /// An estimate whose inclinometer 1 has this mean NIS, with a wheel at an edge or not.
    fn estimate(nis: f64, at_edge: bool) -> Estimate {
        let mut kalman = KalmanReport::default();
        kalman.health.inclination[0] = nis;
        if nis > 4.0 {
            kalman.health.faulty = Channels::INCLINOMETER[0];
        }
        if at_edge {
            kalman.contact[0] = ContactEstimate {
                state: ContactState::TwoContacts,
                ..kalman.contact[0]
            };
        }
        Estimate {
            kalman: Some(kalman),
            ..estimate_of([50.0; 3], [0.0; 3])
        }
    }

    /// The verdict of 20 s with an edge at 1 s and a mean NIS from 2 s on, for some time (s).
    fn excuse(nis: f64, lasts: f64, certain: f64) -> Option<Option<Excuse>> {
        let mut agreement = Agreement::new(0.0);
        for k in 0..200 {
            let time = 0.1 * f64::from(k);
            let contradicts = time > 2.0 && time < 2.0 + lasts;
            let nis = if contradicts { nis } else { 1.0 };
            agreement.add(time, &estimate(nis, k == 10));
        }
        let found = agreement.contradiction(certain)?;
        assert_eq!(found.faulty, Channels::INCLINOMETER[0]);
        Some(found.excuse)
    }

    /// A contradiction right behind an edge may be an impact; one that lasts, or is certain, is one. Readings that are far
    /// apart excuse what is not certain.
    #[test]
    fn an_edge_excuses_a_while() {
        assert_eq!(excuse(1.0, 3.0, 0.0), None);
        assert_eq!(excuse(5.0, 3.0, 0.0), Some(Some(Excuse::AfterEdge)));
        assert_eq!(excuse(5.0, 9.0, 0.0), Some(None));
        assert_eq!(excuse(13.0, 3.0, 0.0), Some(None));
        assert_eq!(
            excuse(5.0, 9.0, Agreement::FAR_APART),
            Some(Some(Excuse::FarApart))
        );
        assert_eq!(excuse(13.0, 9.0, Agreement::FAR_APART), Some(None));
    }

    /// Forces out of range count from the time on from which forces do.
    #[test]
    fn forces_out_of_range_count() {
        let mut agreement = Agreement::new(1.0);
        for k in 0..200 {
            let flags = if k < 10 || k % 20 == 0 {
                Flags::OUT_OF_RANGE
            } else {
                Flags::NONE
            };
            let estimate = Estimate {
                flags,
                ..estimate(1.0, false)
            };
            agreement.add(0.1 * f64::from(k) + 0.001, &estimate);
        }
        // 9 of the 190 from 1 s on.
        assert!((agreement.out_of_range() - 9.0 / 190.0).abs() < 1e-12);
        assert_eq!(agreement.wrong(0.0), Some(None));
        let far_apart = agreement.wrong(Agreement::FAR_APART);
        assert_eq!(far_apart, Some(Some(Excuse::FarApart)));
    }
}
