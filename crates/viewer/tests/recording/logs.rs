//! Recordings of recorded readings, with and without the truth.

use crate::common;
use crate::reading::{chunks, record, scalars};
use re_chunk::Chunk;
use robhaz_run::{Frame, RunDescription, RunEnd, Sink, SinkError};
use robhaz_viewer::RecordingSink;
use std::collections::BTreeMap;

/// The recording of a run as that of its log, with the truth as a table gives it, or without any.
struct OfLog {
    sink: RecordingSink,
    has_truth: bool,
}

impl Sink for OfLog {
    fn begin(&mut self, run: &RunDescription) -> Result<(), SinkError> {
        self.sink.begin(&RunDescription {
            has_truth: self.has_truth,
            world: None,
            both: None,
            ..run.clone()
        })
    }
    fn frame(&mut self, frame: &Frame<'_>) -> Result<(), SinkError> {
        // The table of the truth has 100 Hz, the log 1 kHz.
        let in_rows = frame.time * 100.0;
        let is_row = (in_rows - in_rows.round()).abs() < 0.01;
        self.sink.frame(&Frame {
            clearances: None,
            truth: frame.truth.filter(|_| self.has_truth && is_row),
            ..*frame
        })
    }
    fn end(&mut self, end: Option<&RunEnd>) -> Result<(), SinkError> {
        self.sink.end(end)
    }
}

/// Chunks by entity of recorded readings, with or without a table of true forces, and of the run
/// that they are from.
fn of_log_and_run(has_truth: bool) -> [BTreeMap<String, Vec<Chunk>>; 2] {
    let folder = tempfile::tempdir().expect("a folder");
    let [log, simulated] = ["log.rrd", "run.rrd"].map(|name| folder.path().join(name));
    let scene = common::with_kalman(0.6);
    let sink = RecordingSink::save(&log).expect("a file");
    let mut sink = OfLog { sink, has_truth };
    robhaz_run::run(&scene, &mut [&mut sink]).expect("a run");
    record(&scene, &simulated);
    [chunks(&log), chunks(&simulated)]
}

/// Recorded readings with a table of true forces: true N, T, contact angle and needed friction
/// beside the estimates, and errors, as in the recording of the run; gaps in records without truth.
/// No robot, ground or slip margin.
#[test]
fn the_truth_of_a_log_is_recorded_beside_its_estimates() {
    let [log, simulated] = of_log_and_run(true);
    for entity in [
        "/series/normal_force/wheel1/actual",
        "/series/error_of_normal_force/wheel2/error",
        "/series/error_of_normal_force/wheel3/band/kalman",
        "/series/error_of_normal_force/rms",
        "/series/traction/wheel1",
        "/series/contact_angle",
        "/series/friction",
    ] {
        let (found, expected) = (scalars(&log, entity), scalars(&simulated, entity));
        let mut compared = 0;
        for (time, row) in &found {
            let of_run = expected.iter().find(|(at, _)| (at - time).abs() < 1e-9);
            let (_, of_run) = of_run.expect("a row of the run");
            assert_eq!(row.len(), of_run.len(), "{entity}");
            for (value, of_run) in row.iter().zip(of_run).filter(|(v, _)| !v.is_nan()) {
                assert_eq!(value.to_bits(), of_run.to_bits(), "{entity} at {time}");
                compared += 1;
            }
        }
        // Of the rows at 125 Hz those every 40 ms have the truth; the first estimates may be
        // missing.
        assert!(compared >= 14, "{entity}: {compared}");
    }
    for entity in log.keys() {
        let unknown = ["/world", "/series/slip_margin"];
        assert!(!unknown.iter().any(|u| entity.starts_with(u)), "{entity}");
    }
}

/// Recorded readings: without truth the recording holds the estimates, and nothing that needs the
/// truth: no robot, ground, errors, slip margin or true states of wheels.
#[test]
fn without_truth_the_estimates_are_recorded_alone() {
    let [log, simulated] = of_log_and_run(false);
    for entity in log.keys() {
        let unknown = ["/world", "/wheels", "/series/error", "/series/slip_margin"];
        // The states of the wheels that an estimator states are known.
        let stated = entity.starts_with("/wheels/") && entity.ends_with("/kalman");
        let unknown = unknown.iter().any(|u| entity.starts_with(u));
        assert!(stated || !unknown, "{entity}");
        assert!(!entity.ends_with("/actual"), "{entity}");
    }
    for entity in [
        "/series/normal_force/wheel1/estimated",
        "/series/parity/kalman",
        "/series/residual/force",
    ] {
        let rows = scalars(&log, entity);
        assert!(!rows.is_empty());
        assert_eq!(
            format!("{rows:?}"),
            format!("{:?}", scalars(&simulated, entity))
        );
    }
    // The bands that the errors have with truth are around N and T, and the angle that is found is
    // beside the given one.
    for (entity, lines) in [
        ("/series/normal_force/wheel2/band/kalman", 2),
        ("/series/traction/wheel3/band/kalman", 2),
        ("/series/contact_angle/estimated", 3),
        ("/series/contact_angle/estimated/band", 6),
    ] {
        let rows = scalars(&log, entity);
        assert!(rows.len() > 30, "{entity}: {}", rows.len());
        assert!(rows.iter().all(|(_, row)| row.len() == lines), "{entity}");
    }
    let middle = scalars(&log, "/series/normal_force/wheel2/estimated");
    for (time, band) in scalars(&log, "/series/normal_force/wheel2/band/kalman") {
        let at = middle.iter().find(|(at, _)| (at - time).abs() < 1e-9);
        let (_, forces) = at.expect("forces of that time");
        // `kalman` is the last of four estimators.
        let centre = 0.5 * (band[0] + band[1]);
        assert!(
            band[0] > band[1] && (centre - forces[3]).abs() < 1e-9,
            "{time}"
        );
    }
    // One line for each of four estimators, without the true one.
    let traction = scalars(&log, "/series/traction/wheel1");
    assert!(traction.iter().all(|(_, row)| row.len() == 4));
}
