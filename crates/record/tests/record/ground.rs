//! The ground that estimators have found.

use crate::testing::{END, described, frame_of, scene};
use robhaz_estimator::{FrictionBounds, GroundPoint};
use robhaz_model::Vec2;
use robhaz_record::SummarySink;
use robhaz_run::{RunDescription, RunEnd, Sink};
use robhaz_score::GroundErrors;
use robhaz_terrain::Profile;
use std::sync::Arc;

/// Errors of two estimators, of which the first has found points 0.4 and 0.6 m from the origin, and
/// one in a later section.
fn errors(run: &RunDescription) -> [Option<GroundErrors>; 2] {
    let point = |x: f64, height: f64, section: u32| GroundPoint {
        x,
        axle_x: x,
        sigma_x: 0.0,
        height,
        sigma_height: 0.001,
        slope: 0.0,
        friction: FrictionBounds::default(),
        sigma_slope: 0.01,
        section,
    };
    let mut record = frame_of(1.0);
    let wheel = &mut record.truth.wheels[1];
    wheel.position = Vec2::new(0.2, 0.1);
    wheel.contact_angle = 0.0;
    wheel.contact_list = Default::default();
    let mut sink = SummarySink::new();
    sink.begin(run).expect("begins");
    let frame = match run.has_truth {
        true => record.frame(),
        false => record.without_truth(),
    };
    sink.frame(&frame).expect("a record");
    let end = RunEnd {
        start: run.has_truth.then_some(record.truth),
        ground: vec![Arc::new([
            point(0.4, 0.02, 0),
            point(0.6, 0.05, 0),
            point(0.0, 0.05, 1),
        ])],
        ..END
    };
    sink.end(Some(&end)).expect("ends");
    let summary = sink.summary().expect("a finished run");
    [0, 1].map(|k| summary.estimators[k].ground)
}

/// Closed form: on the kerb of 50 mm at 0.7 m, with the origin at x = 0.2 m on the lower level,
/// places from 0.5 m on are 50 mm high; without truth, of an estimator without points, and in a
/// later section, nothing is compared.
#[test]
fn the_truth_is_that_of_the_place() {
    let mut scene = scene();
    scene.terrain.profile = Profile::Stairs(robhaz_terrain::Stairs::step());
    let run = described(&scene);
    let [found, none] = errors(&run);
    let found = found.expect("two points");
    assert_eq!((found.points, found.slope_rmse_rad), (2, Some(0.0)));
    // Errors of 20 mm and 0.
    assert!((found.height_rmse_m - 0.02 / 2.0_f64.sqrt()).abs() < 1e-15);
    assert_eq!(none, None);
    let log = RunDescription {
        has_truth: false,
        world: None,
        ..run
    };
    assert_eq!(errors(&log), [None; 2]);
}
