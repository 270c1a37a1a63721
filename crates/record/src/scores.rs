//! The scores of a run: name, unit, meaning and value of each, declared once. `robhaz compare`, the
//! pages and the dataset of a study take theirs from here.

use crate::summary::{EstimatorSummary, FrictionTestSummary, Summary};

/// A column of scores or events.
#[derive(Clone, Copy, Debug)]
pub struct ScoreColumn {
    /// Its name.
    pub name: &'static str,
    /// SI unit; empty for counts and shares.
    pub unit: &'static str,
    /// Its meaning.
    pub description: &'static str,
    /// Whether it holds counts.
    pub is_count: bool,
    of: Of,
}

/// How a value is found.
#[derive(Clone, Copy, Debug)]
enum Of {
    /// A score of one estimator.
    Estimator(fn(&EstimatorSummary) -> Option<f64>),
    /// A value of the run, the same for all its estimators.
    Run(fn(&Summary) -> Option<f64>),
    /// The Cramer-Rao bound of the run: [`robhaz_score::Bound::nrmse`]. A summary does not have it.
    Bound,
}

/// A score an entry: name, unit, meaning, value. A count has the unit `#`.
macro_rules! columns {
    ($($owner:ident $name:literal, $unit:literal, $description:literal $(: $of:expr)?;)*) => {
        &[$(ScoreColumn::new($name, $unit, $description, Of::$owner$(($of))?)),*]
    };
}

static COLUMNS: &[ScoreColumn] = columns! {
    Estimator "nrmse", "", "RMS error of N over wheels and samples, over the mean of N":
        |e| e.normal_force?.nrmse;
    Estimator "nrmse_at_one_contact", "", "the same over the samples at which no wheel has two contacts":
        |e| e.normal_force_at_one_contact?.nrmse;
    Estimator "rmse", "N", "RMS error of N over wheels and samples": |e| Some(e.normal_force?.rmse_all);
    Estimator "rmse_front", "N", "RMS error of N of the front wheel": |e| Some(e.normal_force?.rmse[0]);
    Estimator "rmse_middle", "N", "RMS error of N of the middle wheel": |e| Some(e.normal_force?.rmse[1]);
    Estimator "rmse_rear", "N", "RMS error of N of the rear wheel": |e| Some(e.normal_force?.rmse[2]);
    Estimator "max_error", "N", "largest absolute error of N of any wheel": |e| Some(e.normal_force?.max_abs);
    Estimator "max_error_time", "s", "time of the largest error of N": |e| Some(e.normal_force?.max_abs_time_s);
    Estimator "bias_front", "N", "mean error of N of the front wheel, estimate minus truth":
        |e| Some(e.normal_force?.bias[0]);
    Estimator "bias_middle", "N", "mean error of N of the middle wheel, estimate minus truth":
        |e| Some(e.normal_force?.bias[1]);
    Estimator "bias_rear", "N", "mean error of N of the rear wheel, estimate minus truth":
        |e| Some(e.normal_force?.bias[2]);
    Estimator "traction_rmse", "N", "RMS error of T over wheels and samples": |e| Some(e.traction?.rmse_all);
    Estimator "traction_max_error", "N", "largest absolute error of T of any wheel": |e| Some(e.traction?.max_abs);
    Estimator "mean_normal_force", "N", "mean of the true N over wheels and samples":
        |e| Some(e.mean_normal_force?.iter().sum::<f64>() / 3.0);
    Estimator "stated", "", "geometric mean of the stated standard deviations of N, over the mean of N": |e| e.stated;
    Estimator "error_over_stated", "", "RMS of the errors of N, each over its stated standard deviation":
        |e| e.error_over_stated;
    Estimator "coverage", "", "share of errors of N within two stated standard deviations": |e| e.coverage;
    Estimator "nees", "", "mean NEES of the three N: 3 if the stated covariance is right": |e| e.nees;
    Estimator "nis", "", "mean NIS of the parity residual: 1 if its expected variance is right": |e| e.nis;
    Estimator "lag", "s", "time by which the estimated N follow the true ones; null where the truth hardly changes":
        |e| e.lag_s;
    Estimator "ground_height_rmse", "m", "RMS error of the height of the ground that was found":
        |e| Some(e.ground?.height_rmse_m);
    Estimator "ground_slope_rmse", "rad", "RMS error of the slope of the ground that was found":
        |e| e.ground?.slope_rmse_rad;
    Estimator "samples", "#", "records compared": |e| number(e.samples);
    Estimator "missing", "#", "records that count but have no estimate": |e| number(e.missing);
    Estimator "two_contacts", "#", "records compared at which a wheel has two contacts": |e| number(e.two_contacts);
    Estimator "no_equivalent", "#", "records left out: no single contact is equivalent to those of a wheel":
        |e| number(e.no_equivalent);
    Bound "bound", "", "Cramer-Rao bound of nrmse from one sample; null where torques and contact angles are exact";
    Run "duration", "s", "simulated time": |run| Some(run.duration_s);
    Run "distance", "m", "travel of the body along x, positive in the direction of drive.speed":
        |run| Some(run.progress?.distance);
    Run "asked_distance", "m", "integral of the set speed of travel": |run| Some(run.progress?.asked);
    Run "stuck_since", "s", "time since which the robot has not advanced; null where it advanced to the end":
        |run| run.progress?.stuck_since;
    Run "spinning_front", "s", "time for which the front wheel spun": |run| Some(run.progress?.spinning[0]);
    Run "spinning_middle", "s", "time for which the middle wheel spun": |run| Some(run.progress?.spinning[1]);
    Run "spinning_rear", "s", "time for which the rear wheel spun": |run| Some(run.progress?.spinning[2]);
    Run "contact_lost_events", "#", "how often a wheel lost its contact": |run| number(run.events?.contact_lost);
    Run "two_contact_events", "#", "how often a wheel with one contact got a second one":
        |run| number(run.events?.two_contacts);
    Run "slip_events", "#", "how often a wheel began to slip": |run| number(run.events?.slips);
    Run "end_stop_events", "#", "how often pin Q reached an end stop": |run| number(run.events?.end_stops);
    Run "least_clearance", "m", "least distance of body and links to the ground":
        |run| Some(run.clearance.as_ref()?.least_m);
    Run "touch_events", "#", "how often body or links began to touch the ground, whose force is not modelled":
        |run| number(run.clearance.as_ref()?.touches);
    Run "friction_tests", "#", "friction tests that were made": |run| number(run.friction_tests.len() as u64);
    Run "friction_tests_slipped", "#", "friction tests that ended in slip, so that mu_max was found":
        |run| number(slipped(run).count() as u64);
    Run "friction_test_mu_max", "", "mean of mu_max over the friction tests that ended in slip; null without one":
        |run| Some(slipped(run).map(|t| t.mu_max).sum::<f64>() / number(slipped(run).count() as u64)?);
};

// Counts of samples and events.
fn number(count: u64) -> Option<f64> {
    Some(count as f64)
}

/// The friction tests that ended in slip.
fn slipped(run: &Summary) -> impl Iterator<Item = &FrictionTestSummary> {
    run.friction_tests.iter().filter(|t| t.ramps > 0)
}

impl ScoreColumn {
    const fn new(
        name: &'static str,
        unit: &'static str,
        description: &'static str,
        of: Of,
    ) -> Self {
        let is_count = matches!(unit.as_bytes(), b"#");
        Self {
            name,
            unit: if is_count { "" } else { unit },
            description,
            is_count,
            of,
        }
    }

    /// All columns of scores and events, in their order.
    pub fn all() -> &'static [Self] {
        COLUMNS
    }

    /// The value for one estimator of a run with this `bound`; `None` where there is none, or it is
    /// not finite.
    pub fn value(
        &self,
        run: &Summary,
        bound: Option<f64>,
        estimator: Option<&EstimatorSummary>,
    ) -> Option<f64> {
        let value = match self.of {
            Of::Estimator(of) => of(estimator?),
            Of::Run(of) => of(run),
            Of::Bound => bound,
        };
        value.filter(|value| value.is_finite())
    }
}
