//! Which samples count in a score.

use robhaz_sim::Truth;

/// Times closer than this are equal, s: the time of a record is a rounded multiple of the period.
const SAME_TIME: f64 = 1e-9;

/// Whether a sample is included in a score.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Inclusion {
    /// It is included in the score.
    Included,
    /// It lies before the time from which errors count: the robot rests or starts.
    TooEarly,
    /// Some wheel has two contacts: all three wheels are left out. An estimator has one contact angle per wheel, so N and T of
    /// such a wheel cannot be compared.
    TwoContacts,
}

/// The rule by which samples count: the same for tables, studies, figures, tests and benches.
#[derive(Clone, Copy, Debug, PartialEq)]
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
        } else if truth.wheels.iter().any(|wheel| wheel.contacts > 1) {
            Inclusion::TwoContacts
        } else {
            Inclusion::Included
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_count_from_a_time_on_with_one_contact_a_wheel() {
        let rule = Rule { compare_from: 2.0 };
        let mut truth = Truth {
            time: 1.999,
            ..Truth::default()
        };
        assert_eq!(rule.judge(&truth), Inclusion::TooEarly);
        // 2000 periods of 1 ms, rounded downwards.
        truth.time = 2.0 - 4e-16;
        assert_eq!(rule.judge(&truth), Inclusion::Included);
        truth.wheels[1].contacts = 2;
        assert_eq!(rule.judge(&truth), Inclusion::TwoContacts);
    }
}
