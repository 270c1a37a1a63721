//! Quantiles on the page of a study.

use arrow_array::{ArrayRef, Float64Array, RecordBatch, StringArray};
use robhaz_record::{Dataset, study_page};
use robhaz_scene::StudyChoice;
use std::sync::Arc;

const STUDY: &str = "
scene = \"smooth.toml\"
[[axis]]
key = \"sensors.seed\"
values = [1, 2]
";

/// Median and 5 and 95 % quantiles of a score with these values, as the page states them.
fn stated(values: impl IntoIterator<Item = f64>) -> String {
    let values = Float64Array::from_iter(values);
    let labels = StringArray::from(vec!["mine"; values.len()]);
    let columns: [(&str, ArrayRef); 2] =
        [("estimator", Arc::new(labels)), ("rmse", Arc::new(values))];
    let page = study_page(&Dataset {
        rows: vec![RecordBatch::try_from_iter(columns).expect("columns of one length")],
        study: StudyChoice::parse(STUDY, "study.toml").expect("a study"),
        runs: 1,
        version: String::new(),
        scene: String::new(),
    });
    let (_, row) = page.split_once("<code>rmse</code>").expect("a score");
    let (_, cell) = row.split_once("<td>").expect("a cell");
    cell.split('<').next().expect("its end").to_owned()
}

/// Closed form: of 0, 1 ... 20 the quantile of a share is 20 times the share; between two values it
/// is linear.
#[test]
fn quantiles_of_evenly_spaced_values_are_linear() {
    assert_eq!(
        stated((0..=20).rev().map(f64::from)),
        "10.00 (1.000 to 19.00)"
    );
    assert_eq!(
        stated((0..=10).rev().map(f64::from)),
        "5.000 (0.5000 to 9.500)"
    );
}

/// Closed form: one value is each of its quantiles; the median of two is their mean.
#[test]
fn small_samples_have_quantiles() {
    assert_eq!(stated([3.0]), "3.000 (3.000 to 3.000)");
    assert_eq!(stated([4.0, 1.0]), "2.500 (1.150 to 3.850)");
}
