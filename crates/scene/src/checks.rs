//! Rules that involve several keys; among them the stability limits of the steps of `rapier`, which
//! the engine divides into [`MOST_PARTS`] parts at most.

use crate::contact;
use crate::drive;
use crate::scene::Scene;
use robhaz_control::{ControlKind, FrictionTestPlan};
use robhaz_keys::conflict::Value;
use robhaz_keys::prelude::*;
use robhaz_sim::EngineKind;
use robhaz_sim::drive::FRICTION_SPEED;
use robhaz_sim::friction::FrictionKind;
use robhaz_sim::stability::{
    MOST_PARTS, largest_integral_gain, largest_slope, longest_step_for_contact,
    longest_step_for_friction, longest_step_for_stiffness, rolling_is_stiffer,
};

/// Largest number of records of a run.
const MOST_RECORDS: f64 = 1e8;
/// Largest number of integration steps of a run: days of computing.
const MOST_STEPS: f64 = 1e11;
/// Largest jitter in sampling periods: beyond it samples would change their order.
const MOST_JITTER: f64 = 0.3;
/// Relative rounding error allowed in a whole number.
const WHOLE: f64 = 1e-12;

/// Adds the rules that a scene breaks, of those that some sections determine.
type Rules = (&'static [&'static str], fn(&Scene, &mut Vec<Conflict>));

const RULES: &[Rules] = &[
    (&["contact."], contact::add_conflicts),
    (&["contact.", "robot."], stiffness),
    (&["record."], record),
    (&["drive."], drive::add_conflicts),
    (&["record.", "sensors."], sensors),
    (&["record.", "engine."], engine),
    (&["record.", "drive."], friction_test),
    (
        &["contact.", "drive.", "engine.", "robot."],
        |scene, found| {
            if scene.engine.kind == EngineKind::Rapier {
                stability(scene, found);
            }
        },
    ),
];

/// Checks the rules whose keys have no problem of their own.
pub(crate) fn check(reader: &mut Reader, root: &Node, scene: &Scene) {
    for (sections, add_conflicts) in RULES {
        let mut found = Vec::new();
        if reader.is_clean(sections) {
            add_conflicts(scene, &mut found);
        }
        found.iter().for_each(|found| report(reader, root, found));
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

/// Deepest penetration at rest over the wheel's radius: a wheel that sinks by more does not stand on
/// ground that eq. (10) describes. The paper's value in N/mm^2.1 sinks by six radii.
const DEEPEST: f64 = 0.5;

fn stiffness(scene: &Scene, found: &mut Vec<Conflict>) {
    let (contact, robot) = (&scene.contact, &scene.robot.robot);
    let radius = robot.geometry.wheel_radius;
    let depth = contact.mean_penetration(robot);
    if depth <= DEEPEST * radius {
        return;
    }
    let (stiffness, n) = (contact.stiffness, contact.exponent);
    let millimetres = stiffness * 1e3_f64.powf(n);
    let rule = format!(
        "a stiffness under which the wheels sink by less than half their radius of {} m; with this one they sink by {} m. Its unit is N/m^{n}: {} N/mm^{n} is {}",
        short(radius),
        rounded(depth),
        short(stiffness),
        rounded(millimetres),
    );
    found.push(conflict([valued("contact.stiffness", stiffness)], rule));
}

fn record(scene: &Scene, found: &mut Vec<Conflict>) {
    let r = &scene.record;
    let [duration, rate, from] = [
        valued("record.duration", r.duration),
        valued("record.rate", r.rate),
        valued("record.compare_from", r.compare_from),
    ];
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
}

/// A test that begins after the end of the run would never begin; it needs covariances.
fn friction_test(scene: &Scene, found: &mut Vec<Conflict>) {
    let control = &scene.control;
    if control.kind != ControlKind::FrictionTest {
        return;
    }
    let (start, duration) = (control.friction_test.start, scene.record.duration);
    if start >= duration {
        let start = valued("drive.friction_test.start", start);
        let rule = "drive.friction_test.start below record.duration";
        found.push(conflict([start, valued("record.duration", duration)], rule));
    }
    let (rate, robot) = (control.friction_test.rate, &scene.robot.robot);
    let fastest = FrictionTestPlan::FASTEST * FrictionTestPlan::unit_rate(robot);
    if rate > fastest {
        let rate = valued("drive.friction_test.rate", rate);
        let most = floor(fastest);
        let rule = format!("at most {most} N m/s for the weight and the wheels of this robot");
        found.push(conflict([rate], rule));
    }
    let estimator = (scene.control_estimator()).and_then(|i| scene.estimators.get(i));
    if let Some(estimator) = estimator.filter(|e| !e.settings.states_covariance()) {
        let keys = [
            named("drive.kind", control.kind.name()),
            named("drive.estimator", &estimator.name),
        ];
        let rule = "an estimator with Kalman filters: drive.estimator of the preset \"kalman\"";
        found.push(conflict(keys, rule));
    }
}

fn sensors(scene: &Scene, found: &mut Vec<Conflict>) {
    let (jitter, rate) = (scene.sensors.spec.jitter, scene.sensors.rate);
    let record_rate = scene.record.rate;
    let sensors_rate = || valued("sensors.rate", rate);
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
}

fn engine(scene: &Scene, found: &mut Vec<Conflict>) {
    let (step, duration) = (scene.engine.step, scene.record.duration);
    if duration / step > MOST_STEPS {
        let keys = [
            valued("engine.step", step),
            valued("record.duration", duration),
        ];
        let rule = format!("at most {} steps", short(MOST_STEPS));
        found.push(conflict(keys, rule));
    }
}

/// Whether a number is 1, 2, 3 ... apart from rounding.
fn is_whole(value: f64) -> bool {
    value.round() >= 1.0 && (value - value.round()).abs() <= WHOLE * value
}

/// Reports a conflict at the key that an override set, else at the first key that is written;
/// defaults have no conflicts.
fn report(reader: &mut Reader, root: &Node, found: &Conflict) {
    let keys = || found.keys.iter().map(|(key, _)| key.as_ref());
    let written = || keys().filter_map(|key| Some((key, &root.find(key)?.origin)));
    let blamed = written()
        .find(|(_, origin)| origin.is_override())
        .or_else(|| written().next());
    // No key is written: the cause is in the robot, so the report is for the whole file.
    let (key, origin) = blamed.unwrap_or((keys().next().unwrap_or(""), &root.origin));
    reader.push(Problem::at(origin, key, found.message()).whole());
}

impl Scene {
    /// Why the forces of this scene are too stiff for the steps of `rapier`, whether it is the
    /// engine of the scene or not; `None` if they are not.
    pub fn too_stiff_for_rapier(&self) -> Option<String> {
        let mut found = Vec::new();
        stability(self, &mut found);
        found.first().map(Conflict::message)
    }
}

/// Adds the limits of `rapier` that a scene exceeds: contact, friction, drive. Beyond them the forces
/// oscillate without any other sign of the error.
fn stability(scene: &Scene, found: &mut Vec<Conflict>) {
    let (contact, robot) = (&scene.contact, &scene.robot.robot);
    let limits = [
        (
            vec![valued("contact.damping", contact.damping)],
            f64::from(MOST_PARTS) * longest_step_for_contact(contact, robot),
            "39 times the wheel's mass over the damping",
        ),
        (
            vec![valued("contact.stiffness", contact.stiffness)],
            longest_step_for_stiffness(contact, robot),
            "two over the natural frequency of the wheel on the contact",
        ),
        friction(scene),
    ];
    for (keys, longest, why) in limits {
        if scene.engine.step > longest {
            let rule = format!("engine.step at most {} s, {why}", floor(longest));
            found.push(beyond(scene, keys, rule));
        }
    }
    of_drive(scene, found);
}

/// Keys whose values the step does not bear, and what is allowed beside the other engine.
fn beyond(scene: &Scene, mut keys: Vec<Value>, rule: String) -> Conflict {
    keys.push(valued("engine.step", scene.engine.step));
    conflict(keys, rule + "; or engine.kind = \"direct\"")
}

/// The keys that make friction or rolling resistance stiff, the longest step (s), and the reason.
fn friction(scene: &Scene) -> (Vec<Value>, f64, &'static str) {
    let (law, robot) = (&scene.friction, &scene.robot.robot);
    let is_chosen = law.kind != FrictionKind::default();
    let kind = is_chosen.then(|| named("contact.friction", law.kind.name()));
    let parameters = law.kind.parameters().iter();
    let parameters = parameters.map(|parameter| contact::key_of(parameter, law));
    let keys = kind.into_iter().chain(parameters).collect();
    let parts = match law.kind.bears_cut_steps() {
        true => f64::from(MOST_PARTS),
        false => 1.0,
    };
    let load = 2.0 * robot.mean_wheel_load();
    let longest = parts * longest_step_for_friction(law, robot, load);
    if rolling_is_stiffer(law, robot) {
        let key = valued("contact.rolling_resistance", law.rolling);
        let why = "the moment's slope at standstill against wheel and rotor";
        return (vec![key], longest, why);
    }
    let why = "the friction's slope at zero slip against wheel and robot";
    (keys, longest, why)
}

/// The step against the slope of the torque over the wheel speed, and against the integral gain.
fn of_drive(scene: &Scene, found: &mut Vec<Conflict>) {
    let (drive, mass) = (&scene.drive, &scene.robot.robot.mass);
    let part = scene.engine.step / f64::from(MOST_PARTS);
    let Some(greatest) = largest_slope(&scene.robot.robot, part) else {
        let keys = [
            valued("robot.mass.wheel_inertia", mass.wheel_inertia),
            valued("robot.mass.rotor_inertia", mass.rotor_inertia),
        ];
        let rule = "inertias of wheels and rotors small against those of the links; or engine.kind = \"direct\"";
        return found.push(conflict(keys, rule));
    };
    let slope = drive.slope();
    if slope > greatest {
        let slopes = [
            ("drive.gear_friction", drive.gear_friction, FRICTION_SPEED),
            ("drive.viscous_damping", drive.viscous_damping, 1.0),
            ("drive.kp", drive.kp, 1.0),
        ];
        let of = |(_, value, unit): &(_, f64, f64)| value / unit;
        let most = slopes.iter().max_by(|a, b| of(a).total_cmp(&of(b)));
        let most = most.unwrap_or(&slopes[0]);
        let left = greatest - (slope - of(most));
        let instead = match left > 0.0 {
            true => format!(" or {} at most {}", most.0, floor(left * most.2)),
            false => String::new(),
        };
        let longest = floor(scene.engine.step * greatest / slope);
        let rule = format!(
            "engine.step at most {longest} s{instead}, the drive's slope against wheel, rotor and links"
        );
        found.push(beyond(scene, vec![valued(most.0, most.1)], rule));
    }
    let most = largest_integral_gain(drive, part);
    if drive.ki > most {
        let rule = format!(
            "drive.ki at most {}, what drive.kp and the losses damp at this step",
            floor(most)
        );
        found.push(beyond(scene, vec![valued("drive.ki", drive.ki)], rule));
    }
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
