//! Control of the wheels: the estimator that it gets, and what does not go with it.

use crate::conflict::{Conflict, conflict, named, valued};
use crate::estimators;
use crate::explicit_step::floor;
use crate::form::{did_you_mean, quoted};
use crate::reader::Reader;
use crate::scene::Scene;
use crate::source::Node;
use robhaz_control::shared::{largest_integral_ratio, largest_proportional_gain};
use robhaz_control::{ControlKind, FrictionTestPlan};

/// The estimators that a control gets if none is named, the first one that the scene has.
const DEFAULTS: [&str; 2] = [
    estimators::WITHOUT_ANGLES,
    estimators::PRESETS[estimators::BEST],
];

/// Checks the estimator of the control, or chooses the default one. A control without readings
/// needs none.
pub(crate) fn choose_estimator(reader: &mut Reader, root: &Node, scene: &mut Scene) {
    const PATH: &str = "drive.estimator";
    if !reader.is_clean(&[estimators::PATH]) {
        return;
    }
    let labels: Vec<&str> = scene.estimators.iter().map(|e| e.name.as_str()).collect();
    if let Some(node) = root.find(PATH) {
        let label = node.as_text().unwrap_or_default();
        if !labels.contains(&label) {
            let allowed = listed(&labels) + &did_you_mean(label, &labels);
            reader.refuse(node, PATH, &allowed);
        }
    } else if scene.control.kind.is_closed_loop() {
        let default = DEFAULTS.iter().find(|label| labels.contains(label));
        if default.is_none() {
            let kind = root.find("drive.kind").unwrap_or(root);
            let allowed = format!(
                "\"{}\" without one of the estimators {}; or {PATH}: {}",
                ControlKind::Speed.name(),
                listed(&DEFAULTS),
                listed(&labels)
            );
            reader.refuse(kind, "drive.kind", &allowed);
        }
        scene.control.estimator = default.map(|label| (*label).to_owned());
    }
}

/// The rate of friction tests that a robot of this size bears, where none is stated.
pub(crate) fn choose_rate(root: &Node, scene: &mut Scene) {
    let control = &mut scene.control;
    if control.kind == ControlKind::FrictionTest && root.find("drive.friction_test.rate").is_none()
    {
        control.friction_test.rate = FrictionTestPlan::usual_rate(&scene.robot.robot);
    }
}

/// What does not go with one speed control, which has one set speed, and gains that the rate of its
/// samples limits.
pub(crate) fn conflicts(scene: &Scene) -> Vec<Conflict> {
    if scene.control.kind != ControlKind::Shared {
        return Vec::new();
    }
    let (drive, rate) = (&scene.drive, scene.sensors.rate);
    let kind = || named("drive.kind", scene.control.kind.name());
    let mut found = Vec::new();
    if !drive.scalings.is_empty() {
        let count = ("drive.scaling", drive.scalings.len().to_string());
        let rule = "no [[drive.scaling]]: one speed control has one set speed for all wheels";
        found.push(conflict([count, kind()], rule));
    }
    let most_kp = largest_proportional_gain(&scene.robot.robot, rate);
    let most_ki = largest_integral_ratio(rate) * drive.kp;
    let inertia = "what the inertia of a wheel in the air bears at this rate";
    let gains = [
        ("drive.kp", drive.kp, most_kp, inertia),
        (
            "drive.ki",
            drive.ki,
            most_ki,
            "what drive.kp damps at this rate",
        ),
    ];
    for (key, gain, most, why) in gains.into_iter().filter(|(_, gain, most, _)| gain > most) {
        let keys = [valued(key, gain), valued("sensors.rate", rate), kind()];
        let rule = format!("{key} at most {}, {why}", floor(most));
        found.push(conflict(keys, rule));
    }
    found
}

/// The labels in words.
fn listed(labels: &[&str]) -> String {
    if labels.is_empty() {
        return "one of the scene's estimators, which has none".to_owned();
    }
    quoted(labels)
}
