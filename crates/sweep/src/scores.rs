//! Columns of scores and events.

use robhaz_record::{EstimatorSummary, Summary};

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
    pub(crate) is_count: bool,
    of: fn(&Summary, Option<&EstimatorSummary>) -> Option<f64>,
}

/// A score of the estimator.
macro_rules! score {
    ($name:literal, $unit:literal, $description:literal, $of:expr) => {
        ScoreColumn {
            name: $name,
            unit: $unit,
            description: $description,
            is_count: false,
            of: |_, estimator| {
                let of: fn(&EstimatorSummary) -> Option<f64> = $of;
                of(estimator?)
            },
        }
    };
}

/// A count of samples of the estimator.
macro_rules! count {
    ($name:literal, $description:literal, $of:expr) => {
        ScoreColumn {
            name: $name,
            unit: "",
            description: $description,
            is_count: true,
            of: |_, estimator| {
                let of: fn(&EstimatorSummary) -> u64 = $of;
                Some(number(of(estimator?)))
            },
        }
    };
}

/// A value of the run, the same for all its estimators.
macro_rules! of_run {
    ($name:literal, $unit:literal, $count:literal, $description:literal, $of:expr) => {
        ScoreColumn {
            name: $name,
            unit: $unit,
            description: $description,
            is_count: $count,
            of: |summary, _| {
                let of: fn(&Summary) -> Option<f64> = $of;
                of(summary)
            },
        }
    };
}

static COLUMNS: [ScoreColumn; 40] = [
    score!(
        "nrmse",
        "",
        "RMS error of N over wheels and samples, over the mean of N",
        |e| e.normal_force?.nrmse
    ),
    score!(
        "nrmse_at_one_contact",
        "",
        "the same over the samples at which no wheel has two contacts",
        |e| e.normal_force_at_one_contact?.nrmse
    ),
    score!("rmse", "N", "RMS error of N over wheels and samples", |e| {
        Some(e.normal_force?.rmse_all)
    }),
    score!(
        "rmse_front",
        "N",
        "RMS error of N of the front wheel",
        |e| Some(e.normal_force?.rmse[0])
    ),
    score!(
        "rmse_middle",
        "N",
        "RMS error of N of the middle wheel",
        |e| Some(e.normal_force?.rmse[1])
    ),
    score!("rmse_rear", "N", "RMS error of N of the rear wheel", |e| {
        Some(e.normal_force?.rmse[2])
    }),
    score!(
        "max_error",
        "N",
        "largest absolute error of N of any wheel",
        |e| Some(e.normal_force?.max_abs)
    ),
    score!(
        "max_error_time",
        "s",
        "time of the largest error of N",
        |e| e.normal_force?.max_abs_time_s
    ),
    score!(
        "bias_front",
        "N",
        "mean error of N of the front wheel, estimate minus truth",
        |e| Some(e.normal_force?.bias?[0])
    ),
    score!(
        "bias_middle",
        "N",
        "mean error of N of the middle wheel, estimate minus truth",
        |e| Some(e.normal_force?.bias?[1])
    ),
    score!(
        "bias_rear",
        "N",
        "mean error of N of the rear wheel, estimate minus truth",
        |e| Some(e.normal_force?.bias?[2])
    ),
    score!(
        "traction_rmse",
        "N",
        "RMS error of T over wheels and samples",
        |e| Some(e.traction?.rmse_all)
    ),
    score!(
        "traction_max_error",
        "N",
        "largest absolute error of T of any wheel",
        |e| Some(e.traction?.max_abs)
    ),
    score!(
        "mean_normal_force",
        "N",
        "mean of the true N over wheels and samples",
        |e| Some(e.mean_normal_force?.iter().sum::<f64>() / 3.0)
    ),
    score!(
        "stated",
        "",
        "geometric mean of the stated standard deviations of N, over the mean of N",
        |e| e.stated
    ),
    score!(
        "coverage",
        "",
        "share of errors of N within two stated standard deviations",
        |e| e.coverage
    ),
    score!(
        "nees",
        "",
        "mean NEES of the three N: 3 if the stated covariance is right",
        |e| e.nees
    ),
    score!(
        "lag",
        "s",
        "time by which the estimated N follow the true ones; null where the truth hardly changes",
        |e| e.lag_s
    ),
    score!(
        "ground_height_rmse",
        "m",
        "RMS error of the height of the ground that was found",
        |e| Some(e.ground?.height_rmse_m)
    ),
    score!(
        "ground_slope_rmse",
        "rad",
        "RMS error of the slope of the ground that was found",
        |e| e.ground?.slope_rmse_rad
    ),
    count!("samples", "records compared", |e| e.samples),
    count!("missing", "records that count but have no estimate", |e| e
        .missing),
    count!(
        "two_contacts",
        "records compared at which a wheel has two contacts",
        |e| e.two_contacts
    ),
    count!(
        "no_equivalent",
        "records left out: no single contact is equivalent to those of a wheel",
        |e| e.no_equivalent
    ),
    of_run!("duration", "s", false, "simulated time", |s| Some(
        s.duration_s
    )),
    of_run!(
        "distance",
        "m",
        false,
        "travel of the body along x, positive in the direction of drive.speed",
        |s| Some(s.progress?.distance_m)
    ),
    of_run!(
        "asked_distance",
        "m",
        false,
        "integral of the set speed of travel",
        |s| Some(s.progress?.asked_m)
    ),
    of_run!(
        "stuck_since",
        "s",
        false,
        "time since which the robot has not advanced; null where it advanced to the end",
        |s| s.progress?.stuck_since_s
    ),
    of_run!(
        "spinning_front",
        "s",
        false,
        "time for which the front wheel spun",
        |s| Some(s.progress?.spinning_s[0])
    ),
    of_run!(
        "spinning_middle",
        "s",
        false,
        "time for which the middle wheel spun",
        |s| Some(s.progress?.spinning_s[1])
    ),
    of_run!(
        "spinning_rear",
        "s",
        false,
        "time for which the rear wheel spun",
        |s| Some(s.progress?.spinning_s[2])
    ),
    of_run!(
        "contact_lost_events",
        "",
        true,
        "how often a wheel lost its contact",
        |s| Some(number(s.events?.contact_lost))
    ),
    of_run!(
        "two_contact_events",
        "",
        true,
        "how often a wheel with one contact got a second one",
        |s| Some(number(s.events?.two_contacts))
    ),
    of_run!(
        "slip_events",
        "",
        true,
        "how often a wheel began to slip",
        |s| Some(number(s.events?.slips))
    ),
    of_run!(
        "end_stop_events",
        "",
        true,
        "how often pin Q reached an end stop",
        |s| Some(number(s.events?.end_stops))
    ),
    of_run!(
        "least_clearance",
        "m",
        false,
        "least distance of body and links to the ground",
        |s| Some(s.clearance.as_ref()?.least_m)
    ),
    of_run!(
        "touch_events",
        "",
        true,
        "how often body or links began to touch the ground, whose force is not modelled",
        |s| Some(number(s.clearance.as_ref()?.touches))
    ),
    of_run!(
        "friction_tests",
        "",
        true,
        "friction tests that were made",
        |s| Some(number(s.friction_tests.len() as u64))
    ),
    of_run!(
        "friction_tests_slipped",
        "",
        true,
        "friction tests that ended in slip, so that mu_max was found",
        |s| {
            let slipped = s.friction_tests.iter().filter(|t| t.ramps > 0);
            Some(number(slipped.count() as u64))
        }
    ),
    of_run!(
        "friction_test_mu_max",
        "",
        false,
        "mean of mu_max over the friction tests that ended in slip; null without one",
        |s| {
            let found = s.friction_tests.iter().filter(|t| t.ramps > 0);
            let found: Vec<f64> = found.map(|t| t.mu_max).collect();
            (!found.is_empty()).then(|| found.iter().sum::<f64>() / number(found.len() as u64))
        }
    ),
];

#[expect(clippy::cast_precision_loss, reason = "counts of samples and events")]
fn number(count: u64) -> f64 {
    count as f64
}

impl ScoreColumn {
    /// All columns of scores and events, in their order.
    pub fn all() -> &'static [Self] {
        &COLUMNS
    }

    /// The value for one estimator of a run; `None` where there is none, or it is not finite.
    pub fn value(&self, summary: &Summary, estimator: Option<&EstimatorSummary>) -> Option<f64> {
        (self.of)(summary, estimator).filter(|value| value.is_finite())
    }
}
