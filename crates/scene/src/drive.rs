//! `[drive]`: eq. (2), motors, their speed control and its friction tests.

use crate::form::{Plain, word};
use crate::key::{List, Table, keys, section};
use crate::quantity::{
    LONGEST_RUN, NONE, ROTARY_DAMPING, SPEED, TIME, TORQUE, TORQUE_RATE, above, at_least, number,
};
use crate::reader::Reader;
use crate::scene::Scene;
use crate::source::Node;
use crate::values::{NAME, SWITCH, WHEEL_LIST, WHEEL_SET};
use crate::write::quote;
use robhaz_control::{ControlKind, FrictionTestPlan};
use robhaz_sim::scaling::SpeedScaling;

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
    estimator ("no-angles if the scene has it, else best"): LABEL => control.estimator;

    /// what kind friction-test does
    friction_test ("each wheel in turn"): Table {
        words: "a table {wheels, start, rate, both_ways}",
        ..section(FRICTION_TEST)
    } => control.friction_test if |s| s.control.friction_test != FrictionTestPlan::default();

    /// times in which single wheels have another set speed; those of one wheel must not overlap
    scaling ("none"): List {
        keys: SCALING,
        words: "up to 100 tables, each headed [[drive.scaling]]",
        least: 0,
        // Each evaluation of the drive looks them up.
        most: 100,
        start: || SpeedScaling { wheels: [false; 3], from: 0.0, to: 0.0, factor: 1.0 },
        check: check_scaling,
    } => drive.scalings;
}

/// Which one it is, or the default, is known when the estimators are: see [`crate::control`].
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

fn check_scaling(
    reader: &mut Reader,
    node: &Node,
    path: &str,
    scaling: &mut SpeedScaling,
    others: &[SpeedScaling],
) {
    let mut refuse = |key: &str, rule: &str| reader.refuse_key(node, path, key, rule);
    if scaling.to <= scaling.from {
        return refuse("to", &format!("above from, {} s", scaling.from));
    }
    for (i, other) in others.iter().enumerate() {
        let shared = (0..3).find(|wheel| scaling.wheels[*wheel] && other.wheels[*wheel]);
        let overlap = scaling.from < other.to && other.from < scaling.to;
        if let (Some(wheel), true) = (shared, overlap) {
            let rule = format!(
                "a time outside of that of drive.scaling[{i}], {} to {} s, which has wheel {} too",
                other.from,
                other.to,
                wheel + 1
            );
            return refuse("from", &rule);
        }
    }
}
