//! The comparison of runs.

use crate::testing::finished;
use robhaz_record::comparison_json;

/// Golden: the keys that scripts read. None is lost because a score was renamed.
#[test]
fn every_score_is_in_the_list() {
    let golden = "run,scene,estimator,rmse_wheel1,rmse_wheel2,rmse_wheel3,rmse,nrmse,bias_wheel1,bias_wheel2,bias_wheel3,\
        largest_error,largest_error_time,lag,stated_sigma,coverage,nees,traction_rmse,traction_largest_error,samples,missing";
    let json = comparison_json(&[("run", &finished())]).expect("JSON");
    let keys = json.lines().skip(2).map(str::trim);
    let keys = keys.map_while(|line| line.strip_prefix('"')?.split_once('"'));
    let keys: Vec<&str> = keys.map(|(key, _)| key).collect();
    assert_eq!(keys.join(","), golden);
}
