//! The score of one estimator over one run.

use crate::errors::{ErrorSums, ForceErrors};
use crate::rule::{Compared, Inclusion, Rule};
use crate::sum::Sum;
use nalgebra::{Matrix3, Vector3};
use robhaz_estimator::Estimate;
use robhaz_sim::Truth;

/// Errors of one estimator over one run, and how they compare with the covariance that it states.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Score {
    rule: Rule,
    missing: u64,
    no_equivalent: u64,
    all: Sums,
    /// Of the samples at which no wheel has two contacts.
    one_contact: Sums,
    stated: Stated,
}

/// Sums over samples.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Sums {
    samples: u64,
    load: [Sum; 3],
    normal_force: ErrorSums,
    traction: ErrorSums,
}

impl Sums {
    /// Adds the loads and the errors of N and T at one sample, N.
    fn add(&mut self, compared: &Compared, normal_force: [f64; 3], traction: [f64; 3]) {
        self.samples += 1;
        for (sum, wheel) in self.load.iter_mut().zip(&compared.wheels) {
            sum.add(wheel.normal_force);
        }
        self.normal_force.add(normal_force);
        self.traction.add(traction);
    }

    /// Mean true N of each wheel, N; `None` without samples.
    fn mean_normal_force(&self) -> Option<[f64; 3]> {
        let [front, middle, rear] = self.load.map(|sum| sum.mean(self.samples));
        Some([front?, middle?, rear?])
    }

    /// Mean of N over wheels and samples, N; `None` where it is not positive.
    fn mean_load(&self) -> Option<f64> {
        let mean = self.mean_normal_force()?.iter().sum::<f64>() / 3.0;
        (mean > 0.0).then_some(mean)
    }

    /// Errors of N; `None` without samples.
    fn normal_force(&self) -> Option<ForceErrors> {
        self.normal_force.errors(self.samples, self.mean_load())
    }
}

/// Sums over the samples for which the estimator states a covariance of N.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Stated {
    /// Samples with a positive definite covariance of the three N and every N > 0. At N = 0 the error is not Gaussian. The NIS
    /// has its own count.
    samples: u64,
    /// Sum of ln sigma over wheels and samples.
    logarithm: Sum,
    /// Sum of `(e/sigma)^2` over wheels and samples.
    normalised: Sum,
    nees: Sum,
    /// Errors within two standard deviations, over wheels and samples.
    inside: u64,
    /// Samples with an expected standard deviation of the parity residual.
    innovations: u64,
    nis: Sum,
}

impl Score {
    /// A score without samples.
    pub fn new(rule: Rule) -> Self {
        Self {
            rule,
            missing: 0,
            no_equivalent: 0,
            all: Sums::default(),
            one_contact: Sums::default(),
            stated: Stated::default(),
        }
    }

    /// Adds a sample, if the rule counts it. No estimate, or an estimate with a force that is not finite, counts as missing.
    pub fn add(&mut self, truth: &Truth, estimate: Option<&Estimate>) {
        let compared = match self.rule.judge(truth) {
            Inclusion::TooEarly => return,
            Inclusion::NoEquivalent => {
                self.no_equivalent += 1;
                return;
            }
            Inclusion::Included(compared) => compared,
        };
        let usable = |e: &&Estimate| {
            let mut forces = e.normal_force.iter().chain(&e.traction);
            forces.all(|f| f.is_finite())
        };
        let Some(estimate) = estimate.filter(usable) else {
            self.missing += 1;
            return;
        };
        let wheels = &compared.wheels;
        let normal_force = [0, 1, 2].map(|i| estimate.normal_force[i] - wheels[i].normal_force);
        let traction = [0, 1, 2].map(|i| estimate.traction[i] - wheels[i].traction);
        self.all.add(&compared, normal_force, traction);
        if !compared.two_contacts {
            self.one_contact.add(&compared, normal_force, traction);
        }
        self.stated.add(estimate, normal_force);
    }

    /// Errors of N; `None` without samples.
    pub fn normal_force(&self) -> Option<ForceErrors> {
        self.all.normal_force()
    }

    /// Errors of N over the samples at which no wheel has two contacts; `None` without such samples. Their NRMSE refers to the
    /// mean N of these samples.
    pub fn normal_force_at_one_contact(&self) -> Option<ForceErrors> {
        self.one_contact.normal_force()
    }

    /// Errors of T; `None` without samples.
    pub fn traction(&self) -> Option<ForceErrors> {
        let all = &self.all;
        all.traction.errors(all.samples, all.mean_load())
    }

    /// RMS error of N divided by the mean true N, dimensionless; `None` without samples or load.
    pub fn nrmse(&self) -> Option<f64> {
        self.normal_force()?.nrmse
    }

    /// Mean true N of each wheel, N; `None` without samples.
    pub fn mean_normal_force(&self) -> Option<[f64; 3]> {
        self.all.mean_normal_force()
    }

    /// Geometric mean of the stated standard deviations of N, divided by the mean true N, dimensionless; `None` if the estimator
    /// stated none. Geometric, because at an impact the estimator states hundreds of times as much as before and after.
    pub fn stated(&self) -> Option<f64> {
        let sigma = self.stated.logarithm.mean(3 * self.stated.samples)?.exp();
        Some(sigma / self.all.mean_load()?)
    }

    /// RMS of error divided by stated standard deviation of N, dimensionless: 1 if these are right; `None` if none was stated.
    pub fn normalised(&self) -> Option<f64> {
        let mean = self.stated.normalised.mean(3 * self.stated.samples)?;
        Some(mean.sqrt())
    }

    /// Mean NEES of the three N: 3 if the stated covariance is right; `None` if none was stated.
    pub fn nees(&self) -> Option<f64> {
        self.stated.nees.mean(self.stated.samples)
    }

    /// Mean NIS of the parity residual: 1 if its expected variance is right; `None` if none was stated.
    pub fn nis(&self) -> Option<f64> {
        self.stated.nis.mean(self.stated.innovations)
    }

    /// Share of errors of N within two stated standard deviations, -; `None` if none was stated.
    pub fn coverage(&self) -> Option<f64> {
        #[expect(clippy::cast_precision_loss, reason = "counts of samples")]
        let share = |inside: u64, of: u64| (of > 0).then(|| inside as f64 / of as f64);
        share(self.stated.inside, 3 * self.stated.samples)
    }

    /// Samples that count and have an estimate.
    pub fn samples(&self) -> u64 {
        self.all.samples
    }

    /// Samples that count but have no estimate.
    pub fn missing(&self) -> u64 {
        self.missing
    }

    /// How many of [`Self::samples`] have a wheel with two contacts.
    pub fn two_contacts(&self) -> u64 {
        self.all.samples - self.one_contact.samples
    }

    /// Samples left out because no single contact is equivalent to those of a wheel.
    pub fn no_equivalent(&self) -> u64 {
        self.no_equivalent
    }
}

impl Stated {
    /// Adds the errors of N at one sample, N.
    fn add(&mut self, estimate: &Estimate, error: [f64; 3]) {
        let Some(covariance) = &estimate.covariance else {
            return;
        };
        if let Some(parity) = estimate.parity.filter(|p| p.sigma > 0.0) {
            self.innovations += 1;
            self.nis.add((parity.value / parity.sigma).powi(2));
        }
        if estimate.normal_force.iter().any(|n| *n <= 0.0) {
            return;
        }
        // The covariance is ordered as x' = [T1 N1 T2 N2 T3 N3].
        let p = Matrix3::from_fn(|i, j| covariance[2 * i + 1][2 * j + 1]);
        let Some(nees) = mahalanobis(&error.into(), p) else {
            return;
        };
        self.samples += 1;
        self.nees.add(nees);
        for (i, e) in error.iter().enumerate() {
            let variance = p[(i, i)];
            self.logarithm.add(0.5 * variance.ln());
            self.normalised.add(e * e / variance);
            self.inside += u64::from(e * e <= 4.0 * variance);
        }
    }
}

/// `e' P^-1 e`; `None` where P is not positive definite.
fn mahalanobis(e: &Vector3<f64>, p: Matrix3<f64>) -> Option<f64> {
    Some(e.dot(&p.cholesky()?.solve(e)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector2;
    use robhaz_estimator::{Estimator, EstimatorSettings, LinkReading, SensorFrame};
    use robhaz_model::Robot;
    use robhaz_sim::WheelTruth;

    /// An estimate with given N and T (N).
    fn estimate_of(normal_force: [f64; 3], traction: [f64; 3]) -> Estimate {
        let link = LinkReading {
            inclination: Some(0.0),
            rate: Some(0.0),
        };
        let at_rest = SensorFrame {
            time: 0.0,
            wheel_angle: [Some(0.0); 3],
            motor_torque: [Some(0.0); 3],
            link1: link,
            link2: link,
            contact_angle: [Some(0.0); 3],
        };
        let mut estimator = Estimator::new(&Robot::default_a(), EstimatorSettings::paper_wheels());
        let estimate = estimator.update(&at_rest).expect("an estimate at rest");
        Estimate {
            normal_force,
            traction,
            ..estimate
        }
    }

    /// Closed form: P = L L' with L = [[2,0,0],[1,1,0],[0,3,1]] and e = L (1, 2, 3) give 1 + 4 + 9.
    #[test]
    fn mahalanobis_distance_of_a_known_factor() {
        let l = Matrix3::new(2.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 3.0, 1.0);
        let e = l * Vector3::new(1.0, 2.0, 3.0);
        let square = mahalanobis(&e, l * l.transpose()).expect("positive definite");
        assert!((square - 14.0).abs() < 1e-12, "{square}");
        assert_eq!(mahalanobis(&e, Matrix3::zeros()), None);
    }

    /// Without samples every result is `None`, never a number.
    #[test]
    fn an_empty_score_has_no_results() {
        let mut score = Score::new(Rule { compare_from: 0.0 });
        score.add(&Truth::default(), None);
        assert_eq!((score.samples(), score.missing()), (0, 1));
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

    /// Equivalence: a sample with two contacts is compared with the equivalent contact, and counted. The errors at one contact
    /// leave it out. A sample without an equivalent contact counts in neither.
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
        assert_eq!((score.missing(), score.no_equivalent()), (0, 1));
        let errors = score.normal_force().expect("samples");
        assert_eq!(errors.max_abs, 2.0);
        assert!((errors.rmse_all - (4.0_f64 / 6.0).sqrt()).abs() < 1e-15);
        let single = score.normal_force_at_one_contact().expect("a sample");
        assert_eq!((single.rmse_all, single.max_abs), (0.0, 0.0));
        assert_eq!(score.traction().map(|t| t.max_abs), Some(0.0));
    }
}
