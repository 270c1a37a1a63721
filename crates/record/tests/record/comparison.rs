//! The comparison of runs.

use crate::testing::finished;
use robhaz_record::comparison_json;

/// Golden: the keys that scripts read, named as in the dataset of a study.
#[test]
fn every_score_is_in_the_list() {
    let golden = "run,scene,estimator,rmse_front,rmse_middle,rmse_rear,rmse,nrmse,bias_front,bias_middle,bias_rear,\
        max_error,max_error_time,lag,stated,coverage,nees,traction_rmse,traction_max_error,samples,missing";
    let json = comparison_json(&[("run", &finished())]).expect("JSON");
    let keys = json.lines().skip(2).map(str::trim);
    let keys = keys.map_while(|line| line.strip_prefix('"')?.split_once('"'));
    let keys: Vec<&str> = keys.map(|(key, _)| key).collect();
    assert_eq!(keys.join(","), golden);
}
