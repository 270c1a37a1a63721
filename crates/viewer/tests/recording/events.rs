//! Events, lanes, gaps and standard deviations, from a run whose records are changed on the way to
//! the recording.

use crate::common;
use crate::reading::{changed, events, rows, scalars};
use re_chunk::Chunk;
use re_sdk_types::archetypes::{Arrows2D, LineStrips2D, StateChange};
use re_sdk_types::components::{LineStrip2D, Text, Vector2D};
use robhaz_estimator::{ContactEstimate, ContactState, EstimateError, Flags, KalmanReport, Parity};
use robhaz_scene::Scene;
use robhaz_sim::clearance::Clearances;
use std::collections::BTreeMap;

/// The recording of a run whose records are changed, so that they contain every kind of event.
fn eventful(scene: &Scene) -> BTreeMap<String, Vec<Chunk>> {
    changed(scene, |record| {
        let (ms, truth, estimates) = (record.ms, &mut record.truth, &mut record.estimates);
        if (100.0..200.0).contains(&ms) {
            truth.wheels[0].contacts = 0;
            truth.wheels[0].normal_force = 0.0;
            truth.wheels[0].traction = 0.0;
        }
        if (200.0..300.0).contains(&ms) {
            truth.wheels[1].contacts = 2;
        }
        if (300.0..400.0).contains(&ms) {
            truth.stop_torque = -1.0;
        }
        if (300.0..=400.0).contains(&ms) {
            truth.links[0].angle = truth.links[1].angle + 0.62;
        }
        if (400.0..500.0).contains(&ms) {
            estimates[2] = Err(EstimateError::Singular);
        }
        if ms >= 500.0 {
            truth.wheels[0].position.x += 10.0;
        }
        if (500.0..550.0).contains(&ms) {
            truth.wheels[2].slip_speed = -0.03;
            truth.wheels[2].slip_limit = 0.02;
        }
        if let (Ok(estimate), true) = (&mut estimates[1], ms >= 500.0) {
            estimate.kalman = Some(known_report());
            estimate.parity = Some(Parity {
                value: 0.5,
                sigma: 0.25,
            });
            if ms < 550.0 {
                estimate.flags = Flags::WHEEL_UNLOADED[0] | Flags::AT_STOP;
            }
        }
        // The body is 50 mm above the ground, and 1 mm in it for 50 ms.
        let is_in = (350.0..400.0).contains(&ms);
        let body = if is_in { -0.001 } else { 0.05 };
        record.clearances = Some(Clearances::of([body, 0.1, 0.1, 0.1]));
    })
}

/// Events have the time of their record. A missing estimate makes a gap in lines and arrows. Ground
/// is drawn wherever the robot is.
#[test]
fn events_and_gaps_are_shown_where_they_happen() {
    let chunks = eventful(&common::smooth(0.6));

    let events = events(&chunks);
    let expected = [
        (0.0, "scene smooth: 0.6 s"),
        (0.1, "front wheel leaves the ground at x = 0.300 m"),
        (0.2, "front wheel touches the ground again at x = 0.300 m"),
        (0.2, "middle wheel touches at two places at x = 0.000 m"),
        (
            0.3,
            "middle wheel touches at one place again at x = 0.000 m",
        ),
        (
            0.3,
            "pin Q reaches its upper stop: theta1 - theta2 = 35.5 deg",
        ),
        (
            0.35,
            "body touches the ground, whose force on it is not modelled, with its centre of mass at x = 0.030 m",
        ),
        (
            0.4,
            "pin Q leaves its upper stop: theta1 - theta2 = 35.5 deg",
        ),
        (
            0.4,
            "body is clear of the ground again, with its centre of mass at x = 0.030 m",
        ),
        (
            0.4,
            "true-mass: no estimate, a normal force is undetermined: the statics are singular in this posture, or readings are wrong",
        ),
        (0.5, "rear wheel starts to slide at x = -0.300 m"),
        (
            0.5,
            "paper-wheels: flags: wheel 1 unloaded, linkage at a stop",
        ),
        (0.5, "true-mass: estimates again"),
        (0.55, "rear wheel grips again at x = -0.300 m"),
        (0.55, "paper-wheels: no flag any more"),
        (0.6, "the run broke off: this is its last record"),
    ];
    assert_eq!(events.len(), expected.len(), "{events:#?}");
    for ((time, text), (expected_time, expected_text)) in events.iter().zip(expected) {
        assert!((time - expected_time).abs() < 1e-9, "{text} at {time}");
        assert_eq!(text, expected_text);
    }

    assert_eq!(chunks["/world/ground"].len(), 2);
    for (time, row) in scalars(&chunks, "/series/normal_force/wheel1/estimated") {
        let refused = (0.4 - 1e-9..0.5 - 1e-9).contains(&time);
        assert_eq!(row[2].is_nan(), refused, "t = {time}");
        assert!(row[..2].iter().all(|n| n.is_finite()));
    }
    for (time, row) in scalars(&chunks, "/series/friction") {
        let in_the_air = (0.1 - 1e-9..0.2 - 1e-9).contains(&time);
        assert_eq!(row[0].is_nan(), in_the_air, "t = {time}");
    }
    let component = Arrows2D::descriptor_vectors().component;
    for (time, row) in rows::<Vector2D>(&chunks, "/world/forces/estimated/normal", component) {
        let refused = (0.4 - 1e-9..0.5 - 1e-9).contains(&time);
        assert_eq!(row.len(), if refused { 0 } else { 3 }, "t = {time}");
    }
}

/// The states of a lane, with their times in ms.
fn lane(chunks: &BTreeMap<String, Vec<Chunk>>, entity: &str) -> Vec<(i64, String)> {
    let component = StateChange::descriptor_state().component;
    let changes = rows::<Text>(chunks, entity, component).into_iter();
    let changes = changes.map(|(time, row)| ((time * 1e3).round() as i64, row[0].to_string()));
    changes.collect()
}

/// Equivalence of lanes and events.
#[test]
fn lanes_follow_the_events() {
    let chunks = eventful(&common::smooth(0.6));
    let lane = |entity| lane(&chunks, entity);
    let states = |list: &[(i64, &str)]| -> Vec<(i64, String)> {
        list.iter().map(|(ms, s)| (*ms, (*s).to_owned())).collect()
    };
    let front = [(0, "grips"), (100, "in the air"), (200, "grips")];
    assert_eq!(lane("/wheels/front"), states(&front));
    let middle = [(0, "grips"), (200, "two contacts"), (300, "grips")];
    assert_eq!(lane("/wheels/middle"), states(&middle));
    assert!(
        !chunks
            .keys()
            .any(|entity| entity.starts_with("/wheels/front/"))
    );
    let rear = [(0, "grips"), (500, "slips"), (550, "grips")];
    assert_eq!(lane("/wheels/rear"), states(&rear));
    let flagged = [
        (0, "trusted"),
        (500, "wheel 1 unloaded, linkage at a stop"),
        (550, "trusted"),
    ];
    assert_eq!(lane("/trust/paper-wheels"), states(&flagged));
    let refusing = [(0, "trusted"), (400, "no estimate"), (500, "trusted")];
    assert_eq!(lane("/trust/true-mass"), states(&refusing));
}

/// An estimator that states contact states has a lane for each wheel, below the true one.
#[test]
fn estimated_contact_states_have_lanes() {
    let chunks = changed(&common::with_kalman(0.3), |record| {
        let ms = record.ms;
        if let Ok(estimate) = &mut record.estimates[3] {
            let mut contact = [ContactEstimate::default(); 3];
            if (150.0..160.0).contains(&ms) {
                contact[0].state = ContactState::InAir;
            } else if ms >= 160.0 {
                contact[0].state = ContactState::TwoContacts;
                contact[0].sliding = true;
            }
            estimate.kalman = Some(KalmanReport {
                contact,
                ..KalmanReport::default()
            });
        }
    });
    let lane = |entity| lane(&chunks, entity);
    let expected = [
        (0, "grips"),
        (150, "in the air"),
        (160, "two contacts, slips"),
    ];
    let expected = expected.map(|(ms, state)| (ms, state.to_owned()));
    assert_eq!(lane("/wheels/front/kalman"), expected);
    assert_eq!(lane("/wheels/rear/kalman"), [(0, "grips".to_owned())]);
    assert_eq!(lane("/wheels/front"), [(0, "grips".to_owned())]);
}

/// The band of two standard deviations starts with the first covariance of an estimator, and has
/// its centre at zero error. The parity residual has a band of its own.
#[test]
fn two_sigma_is_shown_where_it_is_known() {
    let mut scene = common::smooth(0.6);
    // The estimator with the covariance gets another label and another index.
    scene.estimators[2].name = "other".to_owned();
    scene.estimators.swap(1, 2);
    let chunks = eventful(&scene);
    for wheel in 1..=3 {
        let entity = format!("/series/error_of_normal_force/wheel{wheel}/band/other");
        let band = scalars(&chunks, &entity);
        assert_eq!(band.len(), 13, "from 0.5 s to 0.6 s at 125 Hz");
        assert!(band[0].0 > 0.499);
        for (_, edges) in band {
            assert!((edges[0] - 4.0).abs() < 1e-12 && (edges[1] + 4.0).abs() < 1e-12);
        }
        let of_another = format!("/series/error_of_normal_force/wheel{wheel}/band/paper-body");
        assert!(!chunks.contains_key(&of_another));
    }
    let parity = scalars(&chunks, "/series/parity/other");
    assert!(
        parity.iter().all(|(_, row)| row == &[0.5, 0.5, -0.5]),
        "{parity:?}"
    );
}

/// Closed form: a bar is four standard deviations long, at the scale of the arrows.
#[test]
fn bars_have_the_length_of_two_sigma_to_both_sides() {
    let mut scene = common::smooth(0.6);
    scene.estimators.truncate(2);
    // The second estimator is the last, and therefore the one that is drawn.
    let chunks = changed(&scene, |record| {
        if let Ok(estimate) = &mut record.estimates[1] {
            estimate.kalman = Some(known_report());
        }
    });
    let metres_per_newton = 0.15 / scene.robot.robot.mean_wheel_load();
    for (force, sigma) in [("normal", 2.0), ("traction", 1.0)] {
        let entity = format!("/world/forces/estimated/{force}/two_sigma");
        let component = LineStrips2D::descriptor_strips().component;
        let bars = rows::<LineStrip2D>(&chunks, &entity, component);
        assert_eq!(bars.len(), 37, "0.6 s at 60 Hz");
        for bar in bars.iter().flat_map(|(_, row)| row) {
            // Across, along, across: the third and fourth points are the ends.
            let [near, far] = [bar.0[2], bar.0[3]];
            let length = f64::from((far.x() - near.x()).hypot(far.y() - near.y()));
            assert!(
                (length - 4.0 * sigma * metres_per_newton).abs() < 1e-6,
                "{force}"
            );
        }
    }
}

/// A report whose covariance has standard deviations of 1 N for T and 2 N for N.
fn known_report() -> KalmanReport {
    let mut covariance = [[0.0; 6]; 6];
    for (i, row) in covariance.iter_mut().enumerate() {
        row[i] = if i % 2 == 0 { 1.0 } else { 4.0 };
    }
    KalmanReport {
        covariance,
        ..KalmanReport::default()
    }
}
