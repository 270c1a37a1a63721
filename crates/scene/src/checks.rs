//! Rules that involve several keys.

use crate::contact;
use crate::control;
use crate::error::Problem;
use crate::explicit_step;
use crate::quantity::short;
use crate::reader::Reader;
use crate::scene::Scene;
use crate::source::Node;
use robhaz_control::ControlKind;
use robhaz_sim::EngineKind;

/// Largest number of records of a run.
const MOST_RECORDS: f64 = 1e8;
/// Largest number of integration steps of a run: days of computing.
const MOST_STEPS: f64 = 1e11;
/// Largest jitter in sampling periods: beyond it samples would change their order.
const MOST_JITTER: f64 = 0.3;
/// Relative rounding error allowed in a whole number.
const WHOLE: f64 = 1e-12;

/// A key and its value as text, for messages.
pub(crate) type Value = (&'static str, String);

/// Keys whose values do not go together, and what is allowed.
pub(crate) struct Conflict {
    /// The keys, the one to blame first.
    pub keys: Vec<Value>,
    /// What is allowed.
    pub rule: String,
}

impl Conflict {
    /// What was found and what is allowed.
    pub fn message(&self) -> String {
        let found: Vec<String> = self
            .keys
            .iter()
            .map(|(key, value)| format!("{key} = {value}"))
            .collect();
        format!("found {}, allowed: {}", found.join(" and "), self.rule)
    }
}

/// A key and its number.
pub(crate) fn valued(key: &'static str, value: f64) -> Value {
    (key, short(value))
}

/// A key and its word.
pub(crate) fn named(key: &'static str, value: &str) -> Value {
    (key, format!("\"{value}\""))
}

/// Checks the rules whose keys have no problem of their own.
pub(crate) fn check(reader: &mut Reader, root: &Node, scene: &Scene) {
    if reader.is_clean(&["contact."]) {
        report_all(reader, root, &contact::conflicts(scene));
    }
    if reader.is_clean(&["record."]) {
        record(reader, root, scene);
    }
    if reader.is_clean(&["drive.", "sensors.", "robot."]) {
        report_all(reader, root, &control::conflicts(scene));
    }
    if reader.is_clean(&["record.", "sensors."]) {
        sensors(reader, root, scene);
    }
    if reader.is_clean(&["record.", "engine."]) {
        engine(reader, root, scene);
    }
    if reader.is_clean(&["record.", "drive."]) {
        friction_test(reader, root, scene);
    }
    if reader.is_clean(&["robot.", "model_error."]) {
        model_error(reader, root, scene);
    }
    if reader.is_clean(&["contact.", "drive.", "engine.", "robot."]) {
        stability(reader, root, scene);
    }
}

fn record(reader: &mut Reader, root: &Node, scene: &Scene) {
    let r = &scene.record;
    let duration = || valued("record.duration", r.duration);
    let rate = || valued("record.rate", r.rate);
    if r.compare_from >= r.duration {
        let from = valued("record.compare_from", r.compare_from);
        let rule = "record.compare_from below record.duration";
        conflict(reader, root, vec![from, duration()], rule);
    }
    let count = r.duration * r.rate;
    if count > MOST_RECORDS {
        let rule = format!("at most {} records", short(MOST_RECORDS));
        conflict(reader, root, vec![rate(), duration()], &rule);
    } else if !is_whole(count) {
        let rule = "a whole number of records: record.duration times record.rate";
        conflict(reader, root, vec![duration(), rate()], rule);
    }
}

/// A test that begins after the end of the run would never begin.
fn friction_test(reader: &mut Reader, root: &Node, scene: &Scene) {
    let tests = scene.control.kind == ControlKind::FrictionTest;
    let (start, duration) = (scene.control.friction_test.start, scene.record.duration);
    if tests && start >= duration {
        let keys = vec![
            valued("drive.friction_test.start", start),
            valued("record.duration", duration),
        ];
        let rule = "drive.friction_test.start below record.duration";
        conflict(reader, root, keys, rule);
    }
    let estimator = scene
        .control_estimator()
        .and_then(|i| scene.estimators.get(i));
    if let Some(estimator) = estimator.filter(|e| tests && !e.settings.states_covariance()) {
        let keys = vec![
            named("drive.kind", scene.control.kind.name()),
            named("drive.estimator", &estimator.name),
        ];
        let rule = "an estimator with Kalman filters: drive.estimator of the preset \"best\"";
        conflict(reader, root, keys, rule);
    }
}

fn sensors(reader: &mut Reader, root: &Node, scene: &Scene) {
    if !is_whole(scene.sensors.rate / scene.record.rate) {
        let keys = vec![
            valued("sensors.rate", scene.sensors.rate),
            valued("record.rate", scene.record.rate),
        ];
        let rule = "sensors.rate a whole multiple of record.rate";
        conflict(reader, root, keys, rule);
    }
    let (jitter, rate) = (scene.sensors.spec.jitter, scene.sensors.rate);
    if jitter * rate > MOST_JITTER {
        let keys = vec![
            valued("sensors.jitter", jitter),
            valued("sensors.rate", rate),
        ];
        let rule = format!(
            "sensors.jitter at most {} s, {MOST_JITTER} of the time between samples",
            short(MOST_JITTER / rate)
        );
        conflict(reader, root, keys, &rule);
    }
}

/// The nominal robot must be a valid robot.
fn model_error(reader: &mut Reader, root: &Node, scene: &Scene) {
    if let Err(error) = scene.nominal_robot() {
        let origin = &root.get("model_error").unwrap_or(root).origin;
        let message = format!("with seed {} {error}; allowed: smaller errors", scene.seed);
        reader.push(Problem::at(origin, "model_error", message).whole());
    }
}

fn engine(reader: &mut Reader, root: &Node, scene: &Scene) {
    if scene.record.duration / scene.engine.step > MOST_STEPS {
        let keys = vec![
            valued("engine.step", scene.engine.step),
            valued("record.duration", scene.record.duration),
        ];
        let rule = format!("at most {} steps", short(MOST_STEPS));
        conflict(reader, root, keys, &rule);
    }
}

/// The step of `rapier` against the stability limits of contact, friction and drive.
fn stability(reader: &mut Reader, root: &Node, scene: &Scene) {
    if scene.engine.kind == EngineKind::Rapier {
        report_all(reader, root, &explicit_step::conflicts(scene));
    }
}

/// Whether a number is 1, 2, 3 ... apart from rounding.
fn is_whole(value: f64) -> bool {
    value.round() >= 1.0 && (value - value.round()).abs() <= WHOLE * value
}

fn conflict(reader: &mut Reader, root: &Node, keys: Vec<Value>, rule: &str) {
    let rule = rule.to_owned();
    report(reader, root, &Conflict { keys, rule });
}

fn report_all(reader: &mut Reader, root: &Node, found: &[Conflict]) {
    for conflict in found {
        report(reader, root, conflict);
    }
}

/// Reports a conflict at the key that an override set, else at the first key that is written; defaults have no
/// conflicts.
fn report(reader: &mut Reader, root: &Node, found: &Conflict) {
    let keys = || found.keys.iter().map(|(key, _)| *key);
    let written = || keys().filter_map(|key| Some((key, &root.find(key)?.origin)));
    let blamed = written()
        .find(|(_, origin)| origin.is_override())
        .or_else(|| written().next());
    // No key is written: the cause is in the robot, so the report is for the whole file.
    let (key, origin) = blamed.unwrap_or((keys().next().unwrap_or(""), &root.origin));
    reader.push(Problem::at(origin, key, found.message()).whole());
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whole_numbers_may_be_rounded() {
        assert!(is_whole(2.3 * 1000.0) && is_whole(1.0) && is_whole(0.1 * 3.0 * 10.0));
        assert!(!is_whole(0.0) && !is_whole(0.5) && !is_whole(1000.001) && !is_whole(1e-20));
    }
}
