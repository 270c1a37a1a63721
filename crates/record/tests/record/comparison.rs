//! The comparison of runs.

use crate::testing::finished;
use robhaz_record::{comparison_csv, comparison_markdown};
use robhaz_score::ForceErrors;

/// Golden: the columns that scripts read. None is lost because a score was renamed.
#[test]
fn every_score_is_in_the_list() {
    let golden = "run,scene,estimator,rmse_wheel1,rmse_wheel2,rmse_wheel3,rmse,nrmse,bias_wheel1,bias_wheel2,bias_wheel3,\
        largest_error,largest_error_time,lag,stated_sigma,coverage,nees,traction_rmse,traction_largest_error,samples,missing";
    let csv = comparison_csv(&[("run", &finished())]).expect("CSV");
    assert_eq!(csv.lines().next(), Some(golden));
}

#[test]
fn numbers_have_four_digits() {
    let cases = [
        (0.0123456, "0.01235"),
        (-1.23456, "-1.235"),
        (98.765432, "98.77"),
        (12345.6, "12346"),
        (18001.0, "18001"),
        (0.0, "0"),
    ];
    let mut summary = finished();
    for (value, expected) in cases {
        summary.estimators[0].normal_force = Some(ForceErrors {
            rmse: [1.0; 3],
            rmse_all: value,
            nrmse: None,
            bias: None,
            max_abs: 1.0,
            max_abs_time_s: None,
        });
        let text = comparison_markdown(&[("run", &summary)]);
        assert!(
            text.contains(&format!("| 1 | 1 | 1 | {expected} |")),
            "{text}"
        );
    }
}
