//! Errors, gaps and events computed by hand; the keys of the file, and what is refused.

use crate::testing::{
    END, Record, described, failed_frame, frame_of, good_estimate, log, record_of, records, scene,
};
use robhaz_record::{RecordError, Summary, SummarySink, comparison_table};
use robhaz_run::{RunEnd, Sink};
use robhaz_scene::{Grade, ModelError, SensorChoice};
use robhaz_score::events::EventCounts;
use robhaz_sim::{Truth, WheelTruth};

fn summary_of(records: &[Record]) -> Summary {
    let mut sink = SummarySink::new();
    sink.begin(&described(&scene())).expect("begins");
    for record in records {
        sink.frame(&record.frame()).expect("a record");
    }
    sink.end(Some(&END)).expect("ends");
    sink.summary().expect("a finished run")
}

/// A truth with given loads, and an estimate with given errors of N and T.
fn record(time: f64, loads: [f64; 3], n: [f64; 3], t: [f64; 3]) -> Record {
    let mut truth = Truth {
        time,
        ..Truth::default()
    };
    truth.wheels = loads.map(|normal_force| WheelTruth {
        normal_force,
        ..WheelTruth::default()
    });
    let mut estimate = good_estimate(&truth, 0.0);
    for i in 0..3 {
        estimate.normal_force[i] += n[i];
        estimate.traction[i] += t[i];
    }
    record_of(truth, vec![Ok(estimate); 3])
}

fn close(a: f64, b: f64) {
    assert!((a - b).abs() < 1e-12, "{a} is not {b}");
}

/// Two records by hand. The one before 0.5 s does not count, the one at 0.5 s does.
#[test]
fn errors_are_those_computed_by_hand() {
    let summary = summary_of(&[
        record(0.49, [1e3; 3], [1e3; 3], [1e3; 3]),
        record(0.5, [40.0, 50.0, 60.0], [3.0, 0.0, -2.0], [1.0, 0.0, 0.0]),
        record(0.51, [44.0, 50.0, 56.0], [-4.0, 0.0, 2.0], [0.0, 0.0, 7.0]),
    ]);
    let estimator = &summary.estimators[0];
    assert_eq!((estimator.samples, estimator.missing), (2, 0));
    let load = estimator.mean_normal_force.expect("loads");
    for (found, expected) in load.into_iter().zip([42.0, 50.0, 58.0]) {
        close(found, expected);
    }
    let n = estimator.normal_force.expect("errors of N");
    for (found, square) in n.rmse.into_iter().zip([12.5_f64, 0.0, 4.0]) {
        close(found, square.sqrt());
    }
    close(n.rmse_all, (33.0_f64 / 6.0).sqrt());
    close(n.nrmse.expect("a share"), (33.0_f64 / 6.0).sqrt() / 50.0);
    close(n.max_abs, 4.0);
    let t = estimator.traction.expect("errors of T");
    close(t.rmse_all, (50.0_f64 / 6.0).sqrt());
    close(t.nrmse.expect("a share"), (50.0_f64 / 6.0).sqrt() / 50.0);
    close(t.max_abs, 7.0);
}

/// Records without an estimate are counted and take no part in the errors.
#[test]
fn missing_estimates_are_counted() {
    let summary = summary_of(&records());
    let estimator = &summary.estimators[2];
    assert_eq!((estimator.samples, estimator.missing), (131, 20));
    close(estimator.normal_force.expect("errors").rmse_all, 4.0);
}

/// Nothing to compare is `null` in JSON, not a number.
#[test]
fn without_samples_there_are_no_errors() {
    let mut broken = frame_of(1.9);
    for estimate in broken.estimates.iter_mut().flatten() {
        estimate.normal_force[1] = f64::NAN;
    }
    let summary = summary_of(&[frame_of(0.1), failed_frame(1.0), broken]);
    for estimator in summary.estimators.values() {
        assert_eq!(estimator.normal_force, None);
        assert_eq!(estimator.traction, None);
        assert_eq!(estimator.mean_normal_force, None);
        assert_eq!((estimator.samples, estimator.missing), (0, 2));
    }
    let json = summary.to_json().expect("JSON");
    assert!(json.contains("\"normal_force\": null"), "{json}");
}

/// A robot in the air has errors in N, but no load to divide them by.
#[test]
fn without_load_there_is_no_share_of_it() {
    let summary = summary_of(&[record(1.0, [0.0; 3], [1.0; 3], [0.0; 3])]);
    let errors = summary.estimators[0].normal_force.expect("errors");
    close(errors.rmse_all, 1.0);
    assert_eq!(errors.nrmse, None);
}

/// The summary that is read equals the one that was written, to the last digit, with the estimators
/// in the order of the run.
#[test]
fn json_gives_back_what_was_written() {
    let folder = tempfile::tempdir().expect("a folder");
    let summary = summary_of(&records());
    summary.write(folder.path()).expect("written");
    let read = Summary::read(folder.path()).expect("read");
    assert_eq!(read, summary);
    let names: Vec<_> = read.estimators.keys().collect();
    assert_eq!(names, ["paper-body", "true-mass", "mine"]);
}

/// The drawn sensor errors and the nominal robot are in the summary, and agree with the scene.
#[test]
fn sensor_errors_and_the_nominal_robot_are_kept() {
    let mut scene = scene();
    scene.sensors = SensorChoice::of(Grade::Poor);
    scene.model_error = ModelError {
        pins: 0.002,
        ..ModelError::of_grade(Grade::Poor)
    };
    let mut sink = SummarySink::new();
    sink.begin(&described(&scene)).expect("begins");
    sink.end(Some(&END)).expect("ends");
    let summary = sink.summary().expect("a finished run");
    let drawn = summary.sensors.expect("a simulation");
    assert_eq!(drawn.grade, "poor");
    let sensors = scene.sensors();
    for i in 0..2 {
        close(drawn.drawn.torque_gain[i], sensors.drawn().torque_gain[i]);
        close(drawn.drawn.rate_bias[i], sensors.drawn().rate_bias[i]);
    }
    let s = scene.nominal_robot().expect("a robot").geometry.pins.s;
    close(summary.nominal.pins[3][0], s.x);
    close(summary.nominal.pins[3][1], s.y);
    close(summary.nominal.viscous_damping, 0.165);
    close(summary.nominal.wheel_radius, 0.1);
}

/// Events are counted over the records, by hand: the middle wheel leaves the ground, lands, gets a
/// second contact and slips; pin Q reaches an end stop twice.
#[test]
fn events_are_counted() {
    let samples = [
        (1, 0.0, 0.0),
        (0, 0.0, 2.0),
        (1, 0.0, 0.0),
        (2, 0.5, 0.0),
        (1, 0.0, -1.0),
    ];
    let records: Vec<_> = (0_u32..)
        .zip(samples)
        .map(|(k, (contacts, slip_speed, stop_torque))| {
            let mut record = record(f64::from(k), [50.0; 3], [0.0; 3], [0.0; 3]);
            for wheel in &mut record.truth.wheels {
                wheel.contacts = 1;
            }
            record.truth.wheels[1].contacts = contacts;
            record.truth.wheels[1].slip_speed = slip_speed;
            record.truth.stop_torque = stop_torque;
            record
        })
        .collect();
    let counts = EventCounts {
        contact_lost: 1,
        two_contacts: 1,
        slips: 1,
        end_stops: 2,
        touches: None,
    };
    let summary = summary_of(&records);
    assert_eq!(summary.events, Some(counts));
    let json = summary.to_json().expect("JSON");
    let value: serde_json::Value = serde_json::from_str(&json).expect("JSON");
    assert_eq!(value["events"]["end_stops"], 2);
}

/// Recorded readings have no errors, engine, seed or progress: `null`, which is read back.
#[test]
fn without_truth_there_are_no_errors() {
    let mut sink = SummarySink::new();
    sink.begin(&log()).expect("begins");
    for record in &records() {
        sink.frame(&record.without_truth()).expect("a record");
    }
    let end = RunEnd { step: None, ..END };
    sink.end(Some(&end)).expect("ends");
    let json = sink.summary().and_then(|s| s.to_json()).expect("JSON");
    let value: serde_json::Value = serde_json::from_str(&json).expect("JSON");
    for key in ["engine", "seed", "step_s", "progress", "events", "sensors"] {
        assert!(value[key].is_null(), "{key}");
    }
    let mine = &value["estimators"]["mine"];
    assert!(mine["normal_force"].is_null());
    // Records from 0.5 s on, without the 20 that have no estimate.
    assert_eq!(mine["samples"], 131);
    assert_eq!(mine["missing"], 20);
    assert!(
        mine["means"]["normal_force"][0]
            .as_f64()
            .is_some_and(|n| (n - 49.0).abs() < 20.0)
    );
    let read: Summary = serde_json::from_str(&json).expect("a summary");
    assert_eq!(Some(read), sink.summary().ok());
    assert!(!comparison_table(&[("log", &sink.summary().expect("ended"))]).contains("engine"));
}

/// The keys that scripts read.
#[test]
fn json_has_the_keys_that_scripts_rely_on() {
    let json = summary_of(&records()).to_json().expect("JSON");
    let value: serde_json::Value = serde_json::from_str(&json).expect("JSON");
    assert_eq!(value["scene"], "trial");
    assert_eq!(value["engine"], "rapier");
    assert_eq!(value["seed"], 7);
    for key in ["duration_s", "wall_s", "real_time_factor"] {
        assert!(value[key].is_f64(), "{key}");
    }
    assert_eq!(value["friction"]["law"], "adams");
    assert_eq!(value["friction"]["mu_s"], 0.8);
    assert!(value["friction"]["slip_stiffness"].is_null());
    assert_eq!(value["control"]["kind"], "speed");
    assert!(value["control"]["estimator"].is_null());
    for force in ["normal_force", "traction"] {
        let errors = &value["estimators"]["paper-body"][force];
        assert_eq!(errors["rmse"].as_array().map(Vec::len), Some(3));
        for key in ["rmse_all", "nrmse", "max_abs"] {
            assert!(errors[key].is_f64(), "{force}.{key}");
        }
    }
}

/// Why something is refused.
fn refused<T>(result: Result<T, RecordError>) -> String {
    match result {
        Err(RecordError::Refused(why)) => why,
        Err(other) => panic!("{other}"),
        Ok(_) => panic!("it is not refused"),
    }
}

/// JSON has no infinity: it is an error, not a silent `null`.
#[test]
fn numbers_that_are_not_finite_are_refused() {
    let good = summary_of(&records());
    let mut bad = good.clone();
    bad.real_time_factor = f64::INFINITY;
    assert!(refused(bad.to_json()).contains("not finite"));
    let mut bad = good;
    if let Some(errors) = bad.estimators[1].traction.as_mut() {
        errors.rmse[2] = f64::NAN;
    }
    assert!(refused(bad.to_json()).contains("not finite"));
}

/// A run that broke off has a summary of what was recorded, which says when and why. Without a
/// record there is none.
#[test]
fn a_broken_run_says_so_in_its_summary() {
    let mut sink = SummarySink::new();
    assert!(refused(sink.summary()).contains("no summary"));
    sink.begin(&described(&scene())).expect("begins");
    sink.end(None).expect("ends");
    assert!(refused(sink.summary()).contains("no summary"));
    sink.begin(&described(&scene())).expect("begins");
    sink.frame(&frame_of(1.0).frame()).expect("a record");
    let end = RunEnd {
        duration: 1.0,
        broken_off: Some("stopped by Ctrl-C".to_owned()),
        ..END
    };
    sink.end(Some(&end)).expect("ends");
    let json = sink.summary().and_then(|s| s.to_json()).expect("JSON");
    let value: serde_json::Value = serde_json::from_str(&json).expect("JSON");
    assert_eq!(value["broken_off"]["reason"], "stopped by Ctrl-C");
    assert_eq!(value["broken_off"]["time_s"], 1.0);
    assert_eq!(value["estimators"]["mine"]["samples"], 1);
    // A complete run has the key, too, and a summary of an earlier version is read without it.
    let whole = summary_of(&records()).to_json().expect("JSON");
    assert!(whole.contains("\"broken_off\": null"), "{whole}");
    let earlier = whole.replace("  \"broken_off\": null,\n", "");
    assert!(serde_json::from_str::<Summary>(&earlier).is_ok());
}

/// Each kind of wrong folder has an error of its own, with the path.
#[test]
fn wrong_folders_have_errors_of_their_own() {
    let folder = tempfile::tempdir().expect("a folder");
    let absent = folder.path().join("absent");
    let shown = absent.display().to_string();
    assert!(refused(Summary::read(&absent)).contains(&shown));
    let shown = format!("{} holds no summary.json", folder.path().display());
    assert!(refused(Summary::read(folder.path())).starts_with(&shown));
    for text in ["{\"scene\": 3}", "not JSON"] {
        std::fs::write(folder.path().join("summary.json"), text).expect("written");
        let error = Summary::read(folder.path()).expect_err("no summary");
        assert!(matches!(error, RecordError::NotASummary { .. }));
        assert!(error.to_string().contains("summary.json"), "{error}");
    }
}
