//! A judged path is read back from its recording.

use crate::common;
use crate::reading::{chunks, rows, scalars};
use rerun::archetypes::{Ellipses2D, Points2D};
use rerun::components::{Position2D, Text};
use robhaz_path::{Options, PathSetup, judge};
use robhaz_viewer::save_path;

/// Equivalence of the recording and the report, place by place: distance, friction, margin, centres of the wheels. A path
/// that fails has a mark with its reason.
#[test]
fn a_path_is_recorded_as_judged() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("path.rrd");
    for (mu, go) in [(0.8, true), (0.05, false)] {
        let options = Options {
            mu: Some(mu),
            ..Options::default()
        };
        let setup = PathSetup::new(&common::smooth(1.0), options).expect("a path");
        let report = judge(&setup).expect("a judgement");
        assert_eq!(report.go, go);
        save_path(&setup, &report, &file).expect("a recording");
        let chunks = chunks(&file);
        let friction = scalars(&chunks, "/series/path/friction");
        let margin = scalars(&chunks, "/series/path/margin");
        let component = Ellipses2D::descriptor_centers().component;
        let centres = rows::<Position2D>(&chunks, "/world/wheels", component);
        let start = report.places[0].x();
        let count = report.places.len();
        assert_eq!([friction.len(), margin.len(), centres.len()], [count; 3]);
        for (k, place) in report.places.iter().enumerate() {
            // Times are in whole nanoseconds.
            assert!((friction[k].0 - (place.x() - start)).abs() < 2e-9);
            let bits = |value: Option<f64>| value.unwrap_or(f64::NAN).to_bits();
            assert_eq!(friction[k].1[0].to_bits(), bits(place.available_mu()));
            assert_eq!(friction[k].1[1].to_bits(), bits(place.needed_mu));
            assert_eq!(margin[k].1[1].to_bits(), bits(place.margin));
            for (i, centre) in centres[k].1.iter().enumerate() {
                // Single precision, at most 10 m.
                assert!((f64::from(centre.x()) - place.wheel_x[i]).abs() < 1e-6);
                assert!((f64::from(centre.y()) - place.wheel_y[i]).abs() < 1e-6);
            }
        }
        assert_eq!(chunks.contains_key("/world/failure"), !go);
        if let Some(failure) = report.first_failure {
            let component = Points2D::descriptor_labels().component;
            let label = &chunks["/world/failure"][0];
            let label = label.iter_component::<Text>(component).next();
            let label = label.expect("a label").as_slice()[0].to_string();
            assert_eq!(label, format!("no-go: {}", failure.reason.words()));
        }
    }
}
