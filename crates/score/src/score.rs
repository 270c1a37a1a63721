//! The score of one estimator over one run.

use crate::rule::{Inclusion, Rule};
use crate::statistics::Statistics;
use robhaz_estimator::Estimate;
use robhaz_sim::Truth;
use std::ops::Deref;

/// Errors of one estimator over one run: the [`Statistics`] of all samples that count, and of those
/// without two contacts.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Score {
    rule: Rule,
    /// Samples that count but have no estimate.
    pub missing: u64,
    /// Samples left out because no single contact is equivalent to those of a wheel.
    pub no_equivalent: u64,
    all: Statistics,
    /// Those of the samples without two contacts; `None` while all samples are such.
    one_contact: Option<Statistics>,
}

/// As the errors over all samples that count and have an estimate.
impl Deref for Score {
    type Target = Statistics;

    fn deref(&self) -> &Statistics {
        &self.all
    }
}

/// Whether all forces of an estimate are finite. Others count as missing.
pub fn has_forces(estimate: &Estimate) -> bool {
    let mut forces = estimate.normal_force.iter().chain(&estimate.traction);
    forces.all(|f| f.is_finite())
}

impl Score {
    /// A score without samples.
    pub fn new(rule: Rule) -> Self {
        Self {
            rule,
            ..Self::default()
        }
    }

    /// Adds a sample, if the rule counts it. No estimate, or an estimate with a force that is not
    /// finite, counts as missing.
    pub fn add(&mut self, truth: &Truth, estimate: Option<&Estimate>) {
        self.add_judged(truth.time, &self.rule.judge(truth), estimate);
    }

    /// The same for a sample of which is known whether it counts: several estimators share one
    /// truth. `time` in s.
    pub fn add_judged(&mut self, time: f64, judged: &Inclusion, estimate: Option<&Estimate>) {
        let compared = match judged {
            Inclusion::TooEarly => return,
            Inclusion::NoEquivalent => {
                self.no_equivalent += 1;
                return;
            }
            Inclusion::Included(compared) => compared,
        };
        let Some(estimate) = estimate.filter(|e| has_forces(e)) else {
            self.missing += 1;
            return;
        };
        if compared.two_contacts {
            self.one_contact.get_or_insert(self.all);
        } else if let Some(one_contact) = &mut self.one_contact {
            one_contact.add(time, compared, estimate);
        }
        self.all.add(time, compared, estimate);
    }

    /// The errors over the samples at which no wheel has two contacts. Relative errors refer to the
    /// mean N of these samples.
    pub fn at_one_contact(&self) -> &Statistics {
        self.one_contact.as_ref().unwrap_or(&self.all)
    }

    /// How many of the samples with an estimate have a wheel with two contacts.
    pub fn two_contacts(&self) -> u64 {
        self.all.samples() - self.at_one_contact().samples()
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use nalgebra::Vector2;
    use robhaz_estimator::{Estimator, EstimatorSettings, LinkReading, SensorFrame};
    use robhaz_model::Robot;
    use robhaz_sim::WheelTruth;

    /// An estimate with given N and T (N).
    pub fn estimate_of(normal_force: [f64; 3], traction: [f64; 3]) -> Estimate {
        let link = LinkReading {
            inclination: Some(0.0),
            rate: Some(0.0),
            rate_error: 0.0,
        };
        let at_rest = SensorFrame {
            time: 0.0,
            wheel_angle: [Some(0.0); 3],
            motor_torque: [Some(0.0); 3],
            link1: link,
            link2: link,
            contact_angle: [Some(0.0); 3],
            ..SensorFrame::default()
        };
        let mut estimator = Estimator::new(&Robot::default_a(), EstimatorSettings::paper_wheels());
        let estimate = estimator.update(&at_rest).expect("an estimate at rest");
        Estimate {
            normal_force,
            traction,
            ..estimate
        }
    }

    /// Without samples every result is `None`, never a number.
    #[test]
    fn an_empty_score_has_no_results() {
        let mut score = Score::new(Rule { compare_from: 0.0 });
        score.add(&Truth::default(), None);
        assert_eq!((score.samples(), score.missing), (0, 1));
        let all = [
            score.nrmse(),
            score.stated(),
            score.normalised(),
            score.nees(),
            score.nis(),
            score.coverage(),
        ];
        assert_eq!(all, [None; 6]);
        assert_eq!(score.normal_force(), None);
    }

    /// Equivalence: a sample with two contacts is compared with the equivalent contact, and
    /// counted. The errors at one contact leave it out. A sample without an equivalent contact
    /// counts in neither.
    #[test]
    fn two_contacts_are_compared_with_their_equivalent() {
        let mut score = Score::new(Rule { compare_from: 0.0 });
        let mut truth = Truth::default();
        for wheel in &mut truth.wheels {
            wheel.contacts = 1;
            wheel.normal_force = 4.0;
        }
        let estimate = estimate_of([4.0; 3], [0.0; 3]);
        score.add(&truth, Some(&estimate));
        truth.wheels[0] = WheelTruth {
            contacts: 2,
            // Not what is compared.
            normal_force: 100.0,
            traction: 3.0,
            force: Vector2::new(-5.0, 0.0),
            ..truth.wheels[0]
        };
        let estimate = estimate_of([6.0, 4.0, 4.0], [3.0, 0.0, 0.0]);
        score.add(&truth, Some(&estimate));
        truth.wheels[0].traction = 5.1;
        score.add(&truth, Some(&estimate));
        assert_eq!((score.samples(), score.two_contacts()), (2, 1));
        assert_eq!((score.missing, score.no_equivalent), (0, 1));
        let errors = score.normal_force().expect("samples");
        // Differences of small whole numbers are exact.
        assert_eq!(errors.max_abs.to_bits(), 2.0_f64.to_bits());
        assert!((errors.rmse_all - (4.0_f64 / 6.0).sqrt()).abs() < 1e-15);
        let single = score.at_one_contact().normal_force().expect("a sample");
        assert_eq!([single.rmse_all, single.max_abs].map(f64::to_bits), [0; 2]);
        assert_eq!(score.traction().map(|t| t.max_abs), Some(0.0));
    }
}
