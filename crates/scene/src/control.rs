//! `[drive]`: control of the wheels, and the estimator that it gets.

use crate::estimators;
use crate::key::Key;
use crate::reader::Reader;
use crate::scene::Scene;
use crate::source::{Node, Value};
use crate::suggest::nearest;
use robhaz_control::ControlKind;

/// Name of the key of the estimator.
pub(crate) const ESTIMATOR_NAME: &str = "estimator";
const ESTIMATOR_PATH: &str = "drive.estimator";

/// Kind of control.
pub(crate) const KIND: Key<Scene> = Key::word(
    "kind",
    &[ControlKind::Speed.name(), ControlKind::Shared.name()],
    |s| s.control.kind as usize,
    |s, i| s.control.kind = ControlKind::ALL[i],
    "every drive keeps its own set speed; or one speed control shares its torque by the estimated normal forces",
);

/// The estimator that the control gets.
pub(crate) const ESTIMATOR: Key<Scene> = Key::own(
    ESTIMATOR_NAME,
    "no-angles if the scene has it, else best",
    "the label of one of the scene's estimators",
    "the estimator that a control with readings gets",
);

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

/// The labels in words.
fn listed(labels: &[&str]) -> String {
    if labels.is_empty() {
        return "one of the scene's estimators, which has none".to_owned();
    }
    let labels: Vec<String> = labels.iter().map(|label| format!("\"{label}\"")).collect();
    labels.join(", ")
}
