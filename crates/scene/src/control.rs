//! Control of the wheels: the estimator that it gets, and what does not go with it.

use crate::conflict::{Conflict, conflict, named, valued};
use crate::estimators;
use crate::form::{did_you_mean, quoted};
use crate::quantity::short;
use crate::reader::Reader;
use crate::scene::Scene;
use crate::source::Node;
use robhaz_control::ControlKind;
use robhaz_control::shared::{largest_integral_ratio, largest_proportional_gain};

/// The estimators that a control gets if none is named, the first one that the scene has.
const DEFAULTS: [&str; 2] = [
    estimators::WITHOUT_ANGLES,
    estimators::PRESETS[estimators::BEST],
];

/// Checks the estimator of the control, or chooses the default one. A control without readings needs none.
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
    let kind = || named("drive.kind", scene.control.kind.name());
    let mut found = Vec::new();
    if !drive.scalings.is_empty() {
        let count = ("drive.scaling", drive.scalings.len().to_string());
        let rule = "no [[drive.scaling]]: one speed control has one set speed for all wheels";
        found.push(conflict([count, kind()], rule));
    }
    let sensors = || valued("sensors.rate", rate);
    let most = largest_proportional_gain(&scene.robot.robot, rate);
    if drive.kp > most {
        let most = short(floor(most));
        let rule = format!(
            "drive.kp at most {most}, what the inertia of a wheel in the air bears at this rate"
        );
        found.push(conflict(
            [valued("drive.kp", drive.kp), sensors(), kind()],
            rule,
        ));
    }
    let most = largest_integral_ratio(rate) * drive.kp;
    if drive.ki > most {
        let most = short(floor(most));
        let rule = format!("drive.ki at most {most}, what drive.kp damps at this rate");
        found.push(conflict(
            [valued("drive.ki", drive.ki), sensors(), kind()],
            rule,
        ));
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
    quoted(labels)
}
