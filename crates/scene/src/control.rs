//! `[drive]`: control of the wheels, the estimator that it gets, and its friction tests.

use crate::conflict::{Conflict, number, word};
use crate::estimators;
use crate::json;
use crate::key::{Form, Key};
use crate::name;
use crate::range::{LONGEST_RUN, above, at_least, short};
use crate::reader::Reader;
use crate::scene::Scene;
use crate::source::{Node, Value};
use crate::suggest::nearest;
use crate::units::{TIME, TORQUE_RATE};
use crate::wheels::{self, WHEELS};
use robhaz_control::shared::{largest_integral_ratio, largest_proportional_gain};
use robhaz_control::{ControlKind, FrictionTestPlan};

/// Name of the key of the estimator.
pub(crate) const ESTIMATOR_NAME: &str = "estimator";
const ESTIMATOR_PATH: &str = "drive.estimator";

/// Kind of control.
pub(crate) const KIND: Key<Scene> = Key::word(
    "kind",
    &[
        ControlKind::Speed.name(),
        ControlKind::Shared.name(),
        ControlKind::FrictionTest.name(),
    ],
    |s| s.control.kind as usize,
    |s, i| s.control.kind = ControlKind::ALL[i],
    "every drive keeps its own set speed; one speed control shares its torque by the estimated normal forces; or torque ramps on one wheel after the other find mu_max",
);

/// The estimator that the control gets.
pub(crate) const ESTIMATOR: Key<Scene> = Key::own(
    ESTIMATOR_NAME,
    "no-angles if the scene has it, else best",
    Form {
        words: "the label of one of the scene's estimators",
        schema: name::FORM.schema,
    },
    "the estimator that a control with readings gets",
);

/// Name of the table of the friction tests.
pub(crate) const FRICTION_TEST_NAME: &str = "friction_test";
/// Where it is in the file.
pub(crate) const FRICTION_TEST_PATH: &str = "drive.friction_test";

/// The friction tests.
pub(crate) const FRICTION_TEST: Key<Scene> = Key::own(
    FRICTION_TEST_NAME,
    "each wheel in turn",
    Form {
        words: "a table {wheels, start, rate, both_ways}",
        schema: || json::table(FRICTION_TESTS, Some(&mut FrictionTestPlan::default())),
    },
    "what kind friction-test does",
);

/// The keys of the friction tests.
pub(crate) const FRICTION_TESTS: &[Key<FrictionTestPlan>] = &[
    Key::<FrictionTestPlan>::own(
        WHEELS,
        "[1, 2, 3]",
        wheels::FORM,
        "the tested wheels, in this order",
    ),
    Key::<FrictionTestPlan>::number(
        "start",
        TIME,
        at_least(0.0).at_most(LONGEST_RUN),
        |plan| &mut plan.start,
        "time at which the first torque begins to rise, before the end of the run",
    ),
    Key::<FrictionTestPlan>::number(
        "rate",
        TORQUE_RATE,
        above(0.0).at_most(1.0),
        |plan| &mut plan.rate,
        "rate of the torque; at higher rates the wheel runs away before its slip is found",
    ),
    Key::<FrictionTestPlan>::switch(
        "both_ways",
        |plan| &mut plan.both_ways,
        "whether each wheel is tested in both directions, by which errors of the torque cancel",
    ),
];

/// Reads the friction tests.
pub(crate) fn read_friction_test(reader: &mut Reader, root: &Node) -> FrictionTestPlan {
    let mut plan = FrictionTestPlan::default();
    let Some(node) = root.find(FRICTION_TEST_PATH) else {
        return plan;
    };
    reader.table(FRICTION_TESTS, node, FRICTION_TEST_PATH, &mut plan);
    if node.get(WHEELS).is_some() {
        let wheels = wheels::read(reader, node, FRICTION_TEST_PATH);
        plan.wheels = core::array::from_fn(|k| wheels.get(k).copied());
    }
    plan
}

/// The estimators that a control gets if none is named, the first one that the scene has.
const DEFAULTS: [&str; 2] = [
    estimators::WITHOUT_ANGLES,
    estimators::PRESETS[estimators::BEST],
];

/// Reads the estimator of the control. A control without readings needs none.
pub(crate) fn read_estimator(reader: &mut Reader, root: &Node, scene: &Scene) -> Option<String> {
    if !reader.is_clean(&[estimators::PATH]) {
        return None;
    }
    let labels: Vec<&str> = scene.estimators.iter().map(|e| e.name.as_str()).collect();
    if let Some(node) = root.find(ESTIMATOR_PATH) {
        let label = match &node.value {
            Value::Text(label) => label.as_str(),
            _ => "",
        };
        if labels.contains(&label) {
            return Some(label.to_owned());
        }
        let mut allowed = listed(&labels);
        if let Some(near) = nearest(label, &labels) {
            allowed += &format!("; did you mean \"{near}\"?");
        }
        reader.refuse(node, ESTIMATOR_PATH, &allowed);
        return None;
    }
    if !scene.control.kind.is_closed_loop() {
        return None;
    }
    let default = DEFAULTS.iter().find(|label| labels.contains(label));
    if default.is_none() {
        let kind = root.find("drive.kind").unwrap_or(root);
        let allowed = format!(
            "\"{}\" without one of the estimators {}; or {ESTIMATOR_PATH}: {}",
            ControlKind::Speed.name(),
            listed(&DEFAULTS),
            listed(&labels)
        );
        reader.refuse(kind, "drive.kind", &allowed);
    }
    default.map(|label| (*label).to_owned())
}

/// Keys that do not go together with the kind of control.
pub(crate) fn conflicts(scene: &Scene) -> Vec<Conflict> {
    match scene.control.kind {
        ControlKind::Speed | ControlKind::FrictionTest => Vec::new(),
        ControlKind::Shared => conflicts_of_shared(scene),
    }
}

/// One speed control has one set speed, and gains that the rate of its samples limits.
fn conflicts_of_shared(scene: &Scene) -> Vec<Conflict> {
    let (drive, rate) = (&scene.drive, scene.sensors.rate);
    let kind = || word("drive.kind", scene.control.kind.name());
    let mut found = Vec::new();
    if !drive.scalings.is_empty() {
        let count = drive.scalings.len().to_string();
        found.push(Conflict {
            keys: vec![("drive.scaling", count), kind()],
            rule: "no [[drive.scaling]]: one speed control has one set speed for all wheels"
                .to_owned(),
        });
    }
    let most = largest_proportional_gain(&scene.robot.robot, rate);
    if drive.kp > most {
        let sensors = number("sensors.rate", rate);
        found.push(Conflict {
            keys: vec![number("drive.kp", drive.kp), sensors, kind()],
            rule: format!(
                "drive.kp at most {}, what the inertia of a wheel in the air bears at this rate",
                short(floor(most))
            ),
        });
    }
    let most = largest_integral_ratio(rate) * drive.kp;
    if drive.ki > most {
        let sensors = number("sensors.rate", rate);
        found.push(Conflict {
            keys: vec![number("drive.ki", drive.ki), sensors, kind()],
            rule: format!(
                "drive.ki at most {}, what drive.kp damps at this rate",
                short(floor(most))
            ),
        });
    }
    found
}

/// Rounded down to hundredths, so that what a message allows is allowed.
fn floor(limit: f64) -> f64 {
    (limit * 100.0).floor() / 100.0
}

/// The labels in words.
fn listed(labels: &[&str]) -> String {
    if labels.is_empty() {
        return "one of the scene's estimators, which has none".to_owned();
    }
    let labels: Vec<String> = labels.iter().map(|label| format!("\"{label}\"")).collect();
    labels.join(", ")
}
