//! Which samples count in a score.

use robhaz_sim::{EquivalentContact, Truth};

/// Times closer than this are equal, s: the time of a record is a rounded multiple of the period.
const SAME_TIME: f64 = 1e-9;

/// Whether a sample is included in a score.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Inclusion {
    /// It is included in the score, with these forces.
    Included(Compared),
    /// It lies before the time from which errors count: the robot rests or starts.
    TooEarly,
    /// No single contact is equivalent to the contacts of some wheel: all three wheels are left
    /// out. An estimator has one contact a wheel, so its N cannot be compared.
    NoEquivalent,
}

/// The true forces that an estimate is compared with: those of the equivalent contacts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Compared {
    /// The equivalent contact of each wheel.
    pub wheels: [EquivalentContact; 3],
    /// Whether some wheel has two contacts.
    pub two_contacts: bool,
}

impl Compared {
    /// The equivalent contacts of the three wheels; `None` if a wheel has none
    /// ([`WheelTruth::equivalent_contact`](robhaz_sim::WheelTruth::equivalent_contact)).
    pub fn of(truth: &Truth) -> Option<Self> {
        let [front, middle, rear] = truth.wheels.each_ref().map(|w| w.equivalent_contact());
        Some(Self {
            wheels: [front?, middle?, rear?],
            two_contacts: truth.wheels.iter().any(|wheel| wheel.contacts > 1),
        })
    }
}

/// The rule by which samples count: the same for tables, studies, figures, tests and benches.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Rule {
    /// Errors count from this time on, s.
    pub compare_from: f64,
}

impl Rule {
    /// Whether a time (s) lies in the part of the run that counts.
    pub fn compares(&self, time: f64) -> bool {
        time >= self.compare_from - SAME_TIME
    }

    /// Whether a sample counts.
    pub fn judge(&self, truth: &Truth) -> Inclusion {
        if !self.compares(truth.time) {
            Inclusion::TooEarly
        } else {
            Compared::of(truth).map_or(Inclusion::NoEquivalent, Inclusion::Included)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_count_from_a_time_on_where_a_single_contact_is_equivalent() {
        let rule = Rule { compare_from: 2.0 };
        let mut truth = Truth {
            time: 1.999,
            ..Truth::default()
        };
        assert_eq!(rule.judge(&truth), Inclusion::TooEarly);
        // 2000 periods of 1 ms, rounded downwards.
        truth.time = 2.0 - 4e-16;
        let two_contacts = |truth: &Truth| match rule.judge(truth) {
            Inclusion::Included(compared) => Some(compared.two_contacts),
            _ => None,
        };
        assert_eq!(two_contacts(&truth), Some(false));
        truth.wheels[1].contacts = 2;
        truth.wheels[1].traction = 3.0;
        truth.wheels[1].force.y = 5.0;
        assert_eq!(two_contacts(&truth), Some(true));
        // Closed form: the triangle 3, 4, 5.
        let n = Compared::of(&truth).map(|c| c.wheels[1].normal_force);
        assert_eq!(n, Some(4.0));
        truth.wheels[1].force.y = 2.0;
        assert_eq!(rule.judge(&truth), Inclusion::NoEquivalent);
    }
}
