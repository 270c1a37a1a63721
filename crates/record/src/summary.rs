//! `summary.json`: how a run went and how far each estimator was off.

use crate::append::write_whole;
use crate::error::{RecordError, io_error};
use robhaz_estimator::{Estimate, EstimateError};
use robhaz_model::{Pin, Robot};
use robhaz_run::{Frame, RunDescription, RunEnd, Sink, SinkError, World};
use robhaz_score::events::{EventCounts, EventDetector};
use robhaz_score::{ForceErrors, Progress, ProgressMeter, Rule, Score};
use robhaz_sim::Truth;
use robhaz_sim::sensors::DrawnErrors;
use serde::de::{MapAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::fmt;
use std::io;
use std::path::Path;

/// Name of the file in a run's folder.
const FILE: &str = "summary.json";

/// How a run went and how far each estimator was off.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Summary {
    /// Name of the scene or log.
    pub scene: String,
    /// Name of the engine that computed the truth; `None` for recorded readings.
    pub engine: Option<String>,
    /// Seed of everything random in the run; `None` for recorded readings.
    pub seed: Option<u64>,
    /// Time of the run, s.
    pub duration_s: f64,
    /// Time that simulation and estimation took, s.
    pub wall_s: f64,
    /// Seconds of the run per second of computing.
    pub real_time_factor: f64,
    /// Mean integration step, s; `None` for recorded readings.
    pub step_s: Option<f64>,
    /// Rate of the records, Hz.
    pub record_rate_hz: f64,
    /// Time from which on errors count, s.
    pub compare_from_s: f64,
    /// Version of robhaz.
    pub version: String,
    /// Why and when the run ended before its source did; `None` for a complete run. All else then holds up to that time.
    #[serde(default)]
    pub broken_off: Option<BrokenOff>,
    /// How far the robot came; `None` for recorded readings and in the summaries of earlier versions.
    #[serde(default)]
    pub progress: Option<ProgressSummary>,
    /// How often wheels and end stops changed their state; `None` for recorded readings and in the summaries of earlier versions.
    #[serde(default)]
    pub events: Option<EventCounts>,
    /// Sensor errors that were drawn for the run; no estimator knows them. `None` for recorded readings.
    pub sensors: Option<SensorErrors>,
    /// The nominal robot, which the estimators were given.
    #[serde(alias = "told")]
    pub nominal: NominalRobot,
    /// The estimators in the order of the run; in JSON an object with their names as keys.
    #[serde(with = "by_name")]
    pub estimators: Vec<EstimatorSummary>,
}

/// The end of a run that broke off.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct BrokenOff {
    /// The cause, in words.
    pub reason: String,
    /// Simulated time of the last record, s.
    pub time_s: f64,
}

/// How far the robot came, and whether it was stuck at the end: [`Progress`] with its units.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ProgressSummary {
    /// Way of the body along x, m, positive in the direction in which the drive was to go.
    pub distance_m: f64,
    /// Way that the drive asked for, m.
    pub asked_m: f64,
    /// Time since which the robot gained no ground, s; `None` where it made way to the end.
    pub stuck_since_s: Option<f64>,
    /// Time for which each wheel spun, s.
    pub spinning_s: [f64; 3],
}

impl From<Progress> for ProgressSummary {
    fn from(progress: Progress) -> Self {
        Self {
            distance_m: progress.distance,
            asked_m: progress.asked,
            stuck_since_s: progress.stuck_since,
            spinning_s: progress.spinning,
        }
    }
}

impl ProgressSummary {
    fn is_finite(&self) -> bool {
        let numbers = [self.distance_m, self.asked_m];
        let since = self.stuck_since_s;
        numbers
            .iter()
            .chain(&since)
            .chain(&self.spinning_s)
            .all(|v| v.is_finite())
    }
}

/// The grade of the run's sensors and the errors that they drew once.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SensorErrors {
    /// Name of the grade; single errors may have been changed.
    pub grade: String,
    /// Relative error of each torque's scale.
    pub torque_gain: [f64; 3],
    /// Offset of each torque, N m.
    pub torque_offset: [f64; 3],
    /// Bias of the inclinometers on links 1 and 2, rad.
    pub inclination_bias: [f64; 2],
    /// Bias of the gyros on links 1 and 2 at the start, rad/s.
    pub rate_bias: [f64; 2],
    /// Relative error of the gyros' scale.
    pub rate_scale: [f64; 2],
}

/// The nominal robot, which the estimators are given, as far as it can differ from the simulated one.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct NominalRobot {
    /// The body's centre of mass, m.
    pub body_cg: [f64; 2],
    /// P, Q, R and S, m.
    pub pins: [[f64; 2]; 4],
    /// Masses of links 1 to 3, kg.
    pub link_masses: [f64; 3],
    /// Viscous damping B, N m s.
    pub viscous_damping: f64,
    /// J_wheel, kg m^2.
    pub wheel_inertia: f64,
    /// J_rotor, kg m^2.
    pub rotor_inertia: f64,
    /// Radius of the wheels, m.
    pub wheel_radius: f64,
}

/// How far one estimator was off.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct EstimatorSummary {
    /// Its name in the scene.
    #[serde(skip)]
    pub name: String,
    /// Errors of the normal forces; `None` when nothing could be compared.
    pub normal_force: Option<ForceErrors>,
    /// Errors of the tractions; `None` when nothing could be compared.
    pub traction: Option<ForceErrors>,
    /// Mean of the true normal force of each wheel over the samples compared, N.
    pub mean_normal_force: Option<[f64; 3]>,
    /// Stated standard deviation of N over the mean of N, -: [`Score::stated`]. `None` if the estimator states none.
    #[serde(default)]
    pub stated: Option<f64>,
    /// Share of errors of N within two stated standard deviations, -. `None` if the estimator states none.
    #[serde(default)]
    pub coverage: Option<f64>,
    /// Mean NEES of the three N: 3 if the stated covariance is right. `None` if the estimator states none.
    #[serde(default)]
    pub nees: Option<f64>,
    /// Number of records compared.
    pub samples: u64,
    /// Number of records that should have been compared, but had no estimate.
    pub missing: u64,
    /// Number of records left out because a wheel has two contacts.
    #[serde(default)]
    pub two_contacts: u64,
}

impl Summary {
    /// The text of `summary.json`.
    ///
    /// # Errors
    /// [`RecordError::NotFinite`]: JSON has no such numbers, and none is put in their place.
    pub fn to_json(&self) -> Result<String, RecordError> {
        if let Some(key) = self.not_finite() {
            return Err(RecordError::NotFinite { key });
        }
        let mut text = serde_json::to_string_pretty(self).map_err(RecordError::Json)?;
        text.push('\n');
        Ok(text)
    }

    /// Writes `summary.json` into the folder of a run.
    ///
    /// # Errors
    /// [`RecordError`] with the file's path, or as [`Summary::to_json`].
    pub fn write(&self, folder: &Path) -> Result<(), RecordError> {
        let path = folder.join(FILE);
        write_whole(&path, self.to_json()?.as_bytes())
    }

    /// Reads `summary.json` from the folder of a run, complete or broken off.
    ///
    /// # Errors
    /// [`RecordError`]: there is no such folder, the run was killed or never started, or the file is no summary.
    pub fn read(folder: &Path) -> Result<Self, RecordError> {
        if !folder.is_dir() {
            return Err(RecordError::NoFolder {
                path: folder.to_path_buf(),
            });
        }
        let path = folder.join(FILE);
        let text = match std::fs::read_to_string(&path) {
            Ok(text) => text,
            Err(error) if error.kind() == io::ErrorKind::NotFound => {
                return Err(RecordError::NoSummary {
                    path: folder.to_path_buf(),
                });
            }
            Err(error) => return Err(io_error("read", &path)(error)),
        };
        serde_json::from_str(&text).map_err(|source| RecordError::NotASummary { path, source })
    }

    /// The first number that JSON cannot hold.
    fn not_finite(&self) -> Option<String> {
        let run = [
            ("duration_s", self.duration_s),
            ("wall_s", self.wall_s),
            ("real_time_factor", self.real_time_factor),
            ("step_s", self.step_s.unwrap_or_default()),
            ("record_rate_hz", self.record_rate_hz),
            ("compare_from_s", self.compare_from_s),
        ];
        let of_run = run.iter().find(|(_, value)| !value.is_finite());
        let parts = [
            (
                "progress",
                self.progress.is_none_or(|progress| progress.is_finite()),
            ),
            (
                "sensors",
                self.sensors.as_ref().is_none_or(SensorErrors::is_finite),
            ),
            ("nominal", self.nominal.is_finite()),
        ];
        let of_parts = parts.iter().find(|(_, finite)| !finite);
        let of_run = of_run
            .map(|(key, _)| key)
            .or_else(|| of_parts.map(|(key, _)| key));
        of_run.map(|key| (*key).to_owned()).or_else(|| {
            self.estimators
                .iter()
                .find_map(EstimatorSummary::not_finite)
        })
    }
}

impl SensorErrors {
    pub(crate) fn of(world: &World) -> Self {
        let DrawnErrors {
            torque_gain,
            torque_offset,
            inclination_bias,
            rate_bias,
            rate_scale,
        } = world.drawn;
        Self {
            grade: world.grade.name().to_owned(),
            torque_gain,
            torque_offset,
            inclination_bias,
            rate_bias,
            rate_scale,
        }
    }

    fn is_finite(&self) -> bool {
        let of_torques = self.torque_gain.iter().chain(&self.torque_offset);
        let of_links = [&self.inclination_bias, &self.rate_bias, &self.rate_scale];
        of_torques
            .chain(of_links.into_iter().flatten())
            .all(|v| v.is_finite())
    }
}

impl NominalRobot {
    pub(crate) fn of(run: &RunDescription) -> Self {
        let Robot { geometry, mass } = &run.nominal_robot;
        Self {
            body_cg: geometry.body_cg.into(),
            pins: Pin::ALL.map(|pin| geometry.pins.get(pin).into()),
            link_masses: mass.links,
            viscous_damping: run.nominal_damping,
            wheel_inertia: mass.wheel_inertia,
            rotor_inertia: mass.rotor_inertia,
            wheel_radius: geometry.wheel_radius,
        }
    }

    fn is_finite(&self) -> bool {
        let points = self.pins.iter().chain([&self.body_cg]).flatten();
        let numbers = [
            self.viscous_damping,
            self.wheel_inertia,
            self.rotor_inertia,
            self.wheel_radius,
        ];
        points
            .chain(&self.link_masses)
            .chain(&numbers)
            .all(|v| v.is_finite())
    }
}

impl EstimatorSummary {
    pub(crate) fn new(name: &str, score: &Score) -> Self {
        Self {
            name: name.to_owned(),
            normal_force: score.normal_force(),
            traction: score.traction(),
            mean_normal_force: score.mean_normal_force(),
            stated: score.stated(),
            coverage: score.coverage(),
            nees: score.nees(),
            samples: score.samples(),
            missing: score.missing(),
            two_contacts: score.two_contacts(),
        }
    }

    fn not_finite(&self) -> Option<String> {
        let name = &self.name;
        let forces = [
            ("normal_force", &self.normal_force),
            ("traction", &self.traction),
        ];
        let of_forces = forces
            .iter()
            .find(|(_, errors)| errors.is_some_and(|e| !e.is_finite()));
        let load = self.mean_normal_force.iter().flatten();
        let stated = [
            ("stated", self.stated),
            ("coverage", self.coverage),
            ("nees", self.nees),
        ];
        let of_stated = stated
            .iter()
            .find(|(_, value)| value.is_some_and(|v| !v.is_finite()));
        of_forces
            .map(|(force, _)| *force)
            .or(of_stated.map(|(key, _)| *key))
            .map(|key| format!("estimators.{name}.{key}"))
            .or_else(|| {
                load.copied()
                    .find(|value| !value.is_finite())
                    .map(|_| format!("estimators.{name}.mean_normal_force"))
            })
    }
}

/// A list of estimators as a JSON object, in order.
mod by_name {
    use super::{Deserializer, EstimatorSummary, MapAccess, Serializer, Visitor, fmt};

    pub fn serialize<S: Serializer>(
        estimators: &[EstimatorSummary],
        serializer: S,
    ) -> Result<S::Ok, S::Error> {
        serializer.collect_map(estimators.iter().map(|e| (&e.name, e)))
    }

    pub fn deserialize<'de, D: Deserializer<'de>>(
        deserializer: D,
    ) -> Result<Vec<EstimatorSummary>, D::Error> {
        deserializer.deserialize_map(ByName)
    }

    struct ByName;

    impl<'de> Visitor<'de> for ByName {
        type Value = Vec<EstimatorSummary>;

        fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
            f.write_str("estimators by their names")
        }

        fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Self::Value, A::Error> {
            let mut estimators = Vec::new();
            while let Some((name, estimator)) = map.next_entry::<String, EstimatorSummary>()? {
                estimators.push(EstimatorSummary { name, ..estimator });
            }
            Ok(estimators)
        }
    }
}

/// Sums up a run; keeps nothing of it but sums.
#[derive(Debug, Default)]
pub struct SummarySink {
    run: Option<RunDescription>,
    /// Scores of the estimators, in the order of the run.
    scores: Vec<Score>,
    /// Progress and events of a simulation.
    progress: Option<ProgressMeter>,
    events: Option<(EventDetector, EventCounts)>,
    end: Option<RunEnd>,
}

impl SummarySink {
    /// A sink for one run.
    pub fn new() -> Self {
        Self::default()
    }

    /// The summary of the run, marked when it broke off.
    ///
    /// # Errors
    /// [`RecordError::Unfinished`] when the run goes on, or has no record.
    pub fn summary(&self) -> Result<Summary, RecordError> {
        let (Some(run), Some(end)) = (&self.run, &self.end) else {
            return Err(RecordError::Unfinished);
        };
        let world = run.world.as_ref();
        let estimators = run.estimators.iter().zip(&self.scores);
        Ok(Summary {
            scene: run.name.clone(),
            engine: world.map(|w| w.engine.name().to_owned()),
            seed: world.map(|w| w.seed),
            duration_s: end.duration,
            wall_s: end.wall,
            real_time_factor: end.real_time_factor(),
            step_s: end.step,
            record_rate_hz: run.record.rate,
            compare_from_s: run.record.compare_from,
            version: env!("CARGO_PKG_VERSION").to_owned(),
            broken_off: end.broken_off.clone().map(|reason| BrokenOff {
                reason,
                time_s: end.duration,
            }),
            progress: self.progress.map(|meter| meter.progress().into()),
            events: self.events.as_ref().map(|(_, counts)| *counts),
            sensors: world.map(SensorErrors::of),
            nominal: NominalRobot::of(run),
            estimators: estimators
                .map(|(e, score)| EstimatorSummary::new(&e.label, score))
                .collect(),
        })
    }
}

impl SummarySink {
    /// Adds a record with its truth.
    fn compare(&mut self, truth: &Truth, estimates: &[Result<Estimate, EstimateError>]) {
        for (i, score) in self.scores.iter_mut().enumerate() {
            score.add(truth, estimates.get(i).and_then(|e| e.as_ref().ok()));
        }
        if let Some(progress) = &mut self.progress {
            progress.add(truth);
        }
        if let Some((detector, counts)) = &mut self.events {
            detector.sample(truth, &mut |event| counts.add(&event));
        }
    }
}

impl Sink for SummarySink {
    fn begin(&mut self, run: &RunDescription) -> Result<(), SinkError> {
        let rule = Rule {
            compare_from: run.record.compare_from,
        };
        let geometry = &run.robot.robot.geometry;
        let world = run.world.as_ref();
        *self = Self {
            run: Some(run.clone()),
            scores: vec![Score::new(rule); run.estimators.len()],
            progress: world.map(|w| ProgressMeter::new(&w.drive, geometry.wheel_radius)),
            events: world.map(|w| {
                let detector = EventDetector::new(geometry.stop, w.friction.v_s);
                (detector, EventCounts::default())
            }),
            end: None,
        };
        Ok(())
    }

    fn frame(&mut self, frame: &Frame<'_>) -> Result<(), SinkError> {
        if let Some(truth) = frame.truth {
            self.compare(truth, frame.estimates);
        }
        Ok(())
    }

    fn end(&mut self, end: Option<&RunEnd>) -> Result<(), SinkError> {
        self.end = end.cloned();
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{
        described, failed_frame, frame_of, good_estimate, log, record_of, records, scene,
    };
    use robhaz_scene::{Grade, ModelError, SensorChoice};
    use robhaz_sim::{Truth, WheelTruth};

    const END: RunEnd = RunEnd {
        duration: 2.0,
        wall: 0.1,
        step: Some(1e-4),
        broken_off: None,
    };

    fn summary_of(records: &[crate::testing::Record]) -> Summary {
        let mut sink = SummarySink::new();
        sink.begin(&described(&scene())).expect("begins");
        for record in records {
            sink.frame(&record.frame()).expect("a record");
        }
        sink.end(Some(&END)).expect("ends");
        sink.summary().expect("a finished run")
    }

    /// A truth with given loads, and an estimate with given errors of N and T.
    fn record(time: f64, loads: [f64; 3], n: [f64; 3], t: [f64; 3]) -> crate::testing::Record {
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
        for estimator in &summary.estimators {
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

    /// What is written is what is read, to the last digit, with the estimators in the scene's order.
    #[test]
    fn json_gives_back_what_was_written() {
        let folder = tempfile::tempdir().expect("a folder");
        let summary = summary_of(&records());
        summary.write(folder.path()).expect("written");
        let read = Summary::read(folder.path()).expect("read");
        assert_eq!(read, summary);
        let names: Vec<_> = read.estimators.iter().map(|e| e.name.as_str()).collect();
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
            close(drawn.torque_gain[i], sensors.drawn().torque_gain[i]);
            close(drawn.rate_bias[i], sensors.drawn().rate_bias[i]);
        }
        let s = scene.nominal_robot().expect("a robot").geometry.pins.s;
        close(summary.nominal.pins[3][0], s.x);
        close(summary.nominal.pins[3][1], s.y);
        close(summary.nominal.viscous_damping, 0.165);
        close(summary.nominal.wheel_radius, 0.1);
    }

    /// Events are counted over the records, by hand: the middle wheel leaves the ground, lands, gets a second contact and slips; pin Q
    /// reaches an end stop twice.
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
        assert_eq!(mine["samples"], 0);
        let read: Summary = serde_json::from_str(&json).expect("a summary");
        assert_eq!(Some(read), sink.summary().ok());
        assert!(
            !crate::comparison_table(&[("log", &sink.summary().expect("ended"))])
                .contains("engine")
        );
    }

    /// The keys that others read.
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
        for force in ["normal_force", "traction"] {
            let errors = &value["estimators"]["paper-body"][force];
            assert_eq!(errors["rmse"].as_array().map(Vec::len), Some(3));
            for key in ["rmse_all", "nrmse", "max_abs"] {
                assert!(errors[key].is_f64(), "{force}.{key}");
            }
        }
    }

    /// JSON has no infinity: it is an error, not a silent `null`.
    #[test]
    fn numbers_that_are_not_finite_are_refused() {
        let good = summary_of(&records());
        let mut bad = good.clone();
        bad.real_time_factor = f64::INFINITY;
        let error = bad.to_json().expect_err("refused").to_string();
        assert!(error.contains("real_time_factor"), "{error}");
        let mut bad = good;
        if let Some(errors) = bad.estimators[1].traction.as_mut() {
            errors.rmse[2] = f64::NAN;
        }
        let error = bad.to_json().expect_err("refused").to_string();
        assert!(error.contains("estimators.true-mass.traction"), "{error}");
    }

    /// A run that broke off has a summary of what was recorded, which says when and why. Without a record there is none.
    #[test]
    fn a_broken_run_says_so_in_its_summary() {
        let mut sink = SummarySink::new();
        assert!(matches!(sink.summary(), Err(RecordError::Unfinished)));
        sink.begin(&described(&scene())).expect("begins");
        sink.end(None).expect("ends");
        assert!(matches!(sink.summary(), Err(RecordError::Unfinished)));
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

    /// Each way of pointing at the wrong thing has words of its own, with the path.
    #[test]
    fn wrong_folders_are_told_apart() {
        let folder = tempfile::tempdir().expect("a folder");
        let absent = folder.path().join("absent");
        assert!(matches!(
            Summary::read(&absent),
            Err(RecordError::NoFolder { path }) if path == absent
        ));
        assert!(matches!(
            Summary::read(folder.path()),
            Err(RecordError::NoSummary { path }) if path == folder.path()
        ));
        for text in ["{\"scene\": 3}", "not JSON"] {
            std::fs::write(folder.path().join(FILE), text).expect("written");
            let error = Summary::read(folder.path()).expect_err("no summary");
            assert!(matches!(error, RecordError::NotASummary { .. }));
            assert!(error.to_string().contains(FILE), "{error}");
        }
    }
}
