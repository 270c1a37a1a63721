//! `[drive]`: eq. (2), motors, their speed control and its friction tests; the estimator that the
//! control gets, and what does not go with it.

use crate::estimators;
use crate::scene::Scene;
use crate::values::{LONGEST_RUN, WHEEL_LIST, WHEEL_SET};
use robhaz_control::{ControlKind, FrictionTestPlan};
use robhaz_keys::prelude::*;
use robhaz_sim::drive::SpeedScaling;

keys! {
    /// The keys of the section.
    pub(crate) KEYS: Scene;

    /// set speed of travel, forward positive
    speed: number(SPEED, at_least(-10.0).at_most(10.0)) => drive.speed;

    /// proportional gain on the wheel speed
    kp: number(ROTARY_DAMPING, at_least(0.0).at_most(1e6)) => drive.kp;

    /// integral gain on the wheel speed; 0 for a proportional control alone
    ki: number(TORQUE, at_least(0.0).at_most(1e6)) => drive.ki;

    /// largest motor torque at the wheel
    torque_limit: number(TORQUE, above(0.0).at_most(1e6)) => drive.torque_limit;

    /// tracking time constant T_t of the anti-windup; Kp/Ki is usual
    tracking_time: number(TIME, at_least(1e-3).at_most(LONGEST_RUN)) => drive.tracking_time;

    /// damping B in the wheel module
    viscous_damping: number(ROTARY_DAMPING, at_least(0.0).at_most(1e3)) => drive.viscous_damping;

    /// Coulomb friction F in the gear, at the wheel
    gear_friction: number(TORQUE, at_least(0.0).at_most(1e3)) => drive.gear_friction;

    /// time at rest before the start
    start_time: number(TIME, at_least(0.0).at_most(LONGEST_RUN)) => drive.start_time;

    /// duration of the smooth start and of each change of a scaling; 0 for a jump
    ramp_time: number(TIME, at_least(0.0).at_most(LONGEST_RUN)) => drive.ramp_time;

    /// every drive keeps its own set speed; one speed control shares its torque by the estimated
    /// normal forces; or torque ramps on one wheel after the other find mu_max
    kind: word(&ControlKind::ALL, ControlKind::name) => control.kind;

    /// the estimator that a control with readings gets
    estimator ("kalman-no-angles if the scene has it, else kalman"): LABEL => control.estimator;

    /// what kind friction-test does
    friction_test ("each wheel in turn"): Table {
        words: "a table {wheels, start, rate, both_ways}",
        ..section(FRICTION_TEST)
    } => control.friction_test if |s| s.control.friction_test != FrictionTestPlan::default();

    /// times in which single wheels have another set speed; those of one wheel must not overlap
    scaling ("none"): List {
        item: section(SCALING),
        words: "up to 100 tables, each headed [[drive.scaling]]",
        // Each evaluation of the drive looks them up.
        count: [0, 100],
        start: || SpeedScaling { wheels: [false; 3], from: 0.0, to: 0.0, factor: 1.0 },
        check: |reader, node, path, scaling, others| {
            if let Err((key, rule)) = checked(scaling, others) {
                reader.refuse_key(node, path, key, &rule);
            }
        },
    } => drive.scalings;
}

/// Which one it is, or the default, is known when the estimators are: see [`choose_estimator`].
const LABEL: Plain<Option<String>> = Plain {
    words: "the label of one of the scene's estimators",
    schema: NAME.schema,
    read: |node| Some(node.as_text().map(str::to_owned)),
    text: |label| label.as_deref().map(quote),
};

keys! {
    FRICTION_TEST: FrictionTestPlan;

    /// the tested wheels, in this order
    wheels: WHEEL_LIST => wheels;

    /// time at which the first torque begins to rise, before the end of the run
    start: number(TIME, at_least(0.0).at_most(LONGEST_RUN)) => start;

    /// rate of the torque; the default and the largest rate, 1 N m/s of robot A, follow from weight
    /// and wheel radius: at higher ones the wheel runs away before its slip is found
    rate ("0.35 of robot A"): number(TORQUE_RATE, above(0.0).at_most(1e6)) => rate;

    /// whether each wheel is tested in both directions, by which errors of the torque cancel
    both_ways: SWITCH => both_ways;
}

keys! {
    SCALING: SpeedScaling;

    /// the wheels that it acts on
    wheels (required): WHEEL_SET => wheels;

    /// time at which the set speed begins to change
    from (required): number(TIME, at_least(0.0).at_most(LONGEST_RUN)) => from;

    /// time at which it begins to change back, above from
    to (required): number(TIME, at_least(0.0).at_most(LONGEST_RUN)) => to;

    /// factor of the set speed; 0 stops the wheels, a negative one reverses them
    factor (required): number(NONE, at_least(-100.0).at_most(100.0)) => factor;
}

/// The key at fault and what is allowed.
fn checked(scaling: &SpeedScaling, others: &[SpeedScaling]) -> Result<(), (&'static str, String)> {
    let SpeedScaling { from, to, .. } = scaling;
    if to <= from {
        return Err(("to", format!("above from, {from} s")));
    }
    for (i, other) in others.iter().enumerate() {
        let shared = (0..3).find(|wheel| scaling.wheels[*wheel] && other.wheels[*wheel]);
        if let Some(wheel) = shared.filter(|_| *from < other.to && other.from < *to) {
            let (from, to, wheel) = (other.from, other.to, wheel + 1);
            let rule = format!(
                "a time outside of that of drive.scaling[{i}], {from} to {to} s, which has wheel {wheel} too"
            );
            return Err(("from", rule));
        }
    }
    Ok(())
}

/// The estimators that a control gets if none is named, the first one that the scene has.
const DEFAULTS: [&str; 2] = [
    estimators::WITHOUT_ANGLES,
    estimators::PRESETS[estimators::KALMAN].0,
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
        let unit = FrictionTestPlan::unit_rate(&scene.robot.robot);
        control.friction_test.rate = FrictionTestPlan::RATE * unit;
    }
}

/// Adds what does not go with one speed control, which has one set speed.
pub(crate) fn add_conflicts(scene: &Scene, found: &mut Vec<Conflict>) {
    if scene.control.kind != ControlKind::Shared || scene.drive.scalings.is_empty() {
        return;
    }
    let kind = named("drive.kind", scene.control.kind.name());
    let count = (
        "drive.scaling".into(),
        scene.drive.scalings.len().to_string(),
    );
    let rule = "no [[drive.scaling]]: one speed control has one set speed for all wheels";
    found.push(conflict([count, kind], rule));
}

/// The labels in words.
fn listed(labels: &[&str]) -> String {
    if labels.is_empty() {
        return "one of the scene's estimators, which has none".to_owned();
    }
    quoted(labels)
}
