//! Rules that involve several keys.

use crate::conflict::{Conflict, conflict, named, valued};
use crate::contact;
use crate::drive;
use crate::error::Problem;
use crate::explicit_step;
use crate::quantity::short;
use crate::reader::Reader;
use crate::scene::Scene;
use crate::source::Node;
use robhaz_control::{ControlKind, FrictionTestPlan};
use robhaz_sim::EngineKind;

/// Largest number of records of a run.
const MOST_RECORDS: f64 = 1e8;
/// Largest number of integration steps of a run: days of computing.
const MOST_STEPS: f64 = 1e11;
/// Largest jitter in sampling periods: beyond it samples would change their order.
const MOST_JITTER: f64 = 0.3;
/// Relative rounding error allowed in a whole number.
const WHOLE: f64 = 1e-12;

/// The rules of a scene that some sections determine.
type Rules = (&'static [&'static str], fn(&Scene) -> Vec<Conflict>);

const RULES: &[Rules] = &[
    (&["contact."], contact::conflicts),
    (&["record."], record),
    (&["drive.", "sensors.", "robot."], drive::conflicts),
    (&["record.", "sensors."], sensors),
    (&["record.", "engine."], engine),
    (&["record.", "drive."], friction_test),
    (&["contact.", "drive.", "engine.", "robot."], stability),
];

/// Checks the rules whose keys have no problem of their own.
pub(crate) fn check(reader: &mut Reader, root: &Node, scene: &Scene) {
    for (sections, conflicts) in RULES {
        if reader.is_clean(sections) {
            for conflict in conflicts(scene) {
                report(reader, root, &conflict);
            }
        }
    }
    // The nominal robot must be a valid robot.
    if reader.is_clean(&["robot.", "model_error."])
        && let Err(error) = scene.nominal_robot()
    {
        let origin = &root.get("model_error").unwrap_or(root).origin;
        let message = format!("with seed {} {error}; allowed: smaller errors", scene.seed);
        reader.push(Problem::at(origin, "model_error", message).whole());
    }
}

fn record(scene: &Scene) -> Vec<Conflict> {
    let r = &scene.record;
    let [duration, rate, from] = [
        valued("record.duration", r.duration),
        valued("record.rate", r.rate),
        valued("record.compare_from", r.compare_from),
    ];
    let mut found = Vec::new();
    if r.compare_from >= r.duration {
        let rule = "record.compare_from below record.duration";
        found.push(conflict([from, duration.clone()], rule));
    }
    let count = r.duration * r.rate;
    if count > MOST_RECORDS {
        let rule = format!("at most {} records", short(MOST_RECORDS));
        found.push(conflict([rate, duration], rule));
    } else if !is_whole(count) {
        let rule = "a whole number of records: record.duration times record.rate";
        found.push(conflict([duration, rate], rule));
    }
    found
}

/// A test that begins after the end of the run would never begin; it needs covariances.
fn friction_test(scene: &Scene) -> Vec<Conflict> {
    let mut found = Vec::new();
    let control = &scene.control;
    if control.kind != ControlKind::FrictionTest {
        return found;
    }
    let (start, duration) = (control.friction_test.start, scene.record.duration);
    if start >= duration {
        let start = valued("drive.friction_test.start", start);
        let rule = "drive.friction_test.start below record.duration";
        found.push(conflict([start, valued("record.duration", duration)], rule));
    }
    let (rate, robot) = (control.friction_test.rate, &scene.robot.robot);
    let fastest = FrictionTestPlan::fastest_rate(robot);
    if rate > fastest {
        let rate = valued("drive.friction_test.rate", rate);
        let most = explicit_step::floor(fastest);
        let rule = format!("at most {most} N m/s for the weight and the wheels of this robot");
        found.push(conflict([rate], rule));
    }
    let estimator = (scene.control_estimator()).and_then(|i| scene.estimators.get(i));
    if let Some(estimator) = estimator.filter(|e| !e.settings.states_covariance()) {
        let keys = [
            named("drive.kind", control.kind.name()),
            named("drive.estimator", &estimator.name),
        ];
        let rule = "an estimator with Kalman filters: drive.estimator of the preset \"best\"";
        found.push(conflict(keys, rule));
    }
    found
}

fn sensors(scene: &Scene) -> Vec<Conflict> {
    let (jitter, rate) = (scene.sensors.spec.jitter, scene.sensors.rate);
    let record_rate = scene.record.rate;
    let sensors_rate = || valued("sensors.rate", rate);
    let mut found = Vec::new();
    if !is_whole(rate / record_rate) {
        let keys = [sensors_rate(), valued("record.rate", record_rate)];
        let rule = "sensors.rate a whole multiple of record.rate";
        found.push(conflict(keys, rule));
    }
    if jitter * rate > MOST_JITTER {
        let most = short(MOST_JITTER / rate);
        let most = format!("{most} s, {MOST_JITTER} of the time between samples");
        let keys = [valued("sensors.jitter", jitter), sensors_rate()];
        found.push(conflict(keys, format!("sensors.jitter at most {most}")));
    }
    found
}

fn engine(scene: &Scene) -> Vec<Conflict> {
    let (step, duration) = (scene.engine.step, scene.record.duration);
    if duration / step <= MOST_STEPS {
        return Vec::new();
    }
    let keys = [
        valued("engine.step", step),
        valued("record.duration", duration),
    ];
    let rule = format!("at most {} steps", short(MOST_STEPS));
    vec![conflict(keys, rule)]
}

/// The step of `rapier` against the stability limits of contact, friction and drive.
fn stability(scene: &Scene) -> Vec<Conflict> {
    match scene.engine.kind {
        EngineKind::Rapier => explicit_step::conflicts(scene),
        EngineKind::Direct => Vec::new(),
    }
}

/// Whether a number is 1, 2, 3 ... apart from rounding.
fn is_whole(value: f64) -> bool {
    value.round() >= 1.0 && (value - value.round()).abs() <= WHOLE * value
}

/// Reports a conflict at the key that an override set, else at the first key that is written;
/// defaults have no conflicts.
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
