//! `[drive]`: eq. (2), motors and their speed control.

use crate::control;
use crate::json;
use crate::key::{Form, Key};
use crate::range::{LONGEST_RUN, above, at_least};
use crate::reader::{Reader, join};
use crate::scene::Scene;
use crate::source::{Node, Value};
use crate::units::{NONE, ROTARY_DAMPING, SPEED, TIME, TORQUE};
use crate::wheels::{self, WHEELS};
use robhaz_sim::scaling::SpeedScaling;

/// Where the section is in the file.
pub(crate) const PATH: &str = "drive";

/// The keys of the section.
pub(crate) const KEYS: &[Key<Scene>] = &[
    Key::number(
        "speed",
        SPEED,
        at_least(-10.0).at_most(10.0),
        |s| &mut s.drive.speed,
        "set speed of travel, forward positive",
    ),
    Key::number(
        "kp",
        ROTARY_DAMPING,
        at_least(0.0).at_most(1e6),
        |s| &mut s.drive.kp,
        "proportional gain on the wheel speed",
    ),
    Key::number(
        "ki",
        TORQUE,
        at_least(0.0).at_most(1e6),
        |s| &mut s.drive.ki,
        "integral gain on the wheel speed; 0 for the soft drive",
    ),
    Key::number(
        "torque_limit",
        TORQUE,
        above(0.0).at_most(1e6),
        |s| &mut s.drive.torque_limit,
        "largest motor torque at the wheel",
    ),
    Key::number(
        "tracking_time",
        TIME,
        at_least(1e-3).at_most(LONGEST_RUN),
        |s| &mut s.drive.tracking_time,
        "tracking time constant T_t of the anti-windup; Kp/Ki is usual",
    ),
    Key::number(
        "viscous_damping",
        ROTARY_DAMPING,
        at_least(0.0).at_most(1e3),
        |s| &mut s.drive.viscous_damping,
        "damping B in the wheel module",
    ),
    Key::number(
        "gear_friction",
        TORQUE,
        at_least(0.0).at_most(1e3),
        |s| &mut s.drive.gear_friction,
        "Coulomb friction F in the gear, at the wheel",
    ),
    Key::number(
        "start_time",
        TIME,
        at_least(0.0).at_most(LONGEST_RUN),
        |s| &mut s.drive.start_time,
        "time at rest before the start",
    ),
    Key::number(
        "ramp_time",
        TIME,
        at_least(0.0).at_most(LONGEST_RUN),
        |s| &mut s.drive.ramp_time,
        "duration of the smooth start and of each change of a scaling; 0 for a jump",
    ),
    control::KIND,
    control::ESTIMATOR,
    control::FRICTION_TEST,
    Key::own(
        SCALING,
        "none",
        Form {
            words: SCALINGS_ALLOWED,
            schema: || json::array(json::table(SCALINGS, None), 0, MOST_SCALINGS),
        },
        "times in which single wheels have another set speed; those of one wheel must not overlap",
    ),
];

/// Where the scalings are in the file.
pub(crate) const SCALING_PATH: &str = "drive.scaling";

const SCALING: &str = "scaling";
/// Largest number of scalings: each evaluation of the drive looks them up.
const MOST_SCALINGS: usize = 100;
const SCALINGS_ALLOWED: &str = "up to 100 tables, each headed [[drive.scaling]]";

/// The keys of one scaling.
pub(crate) const SCALINGS: &[Key<SpeedScaling>] = &[
    Key::<SpeedScaling>::own(WHEELS, "", wheels::FORM, "the wheels that it acts on").required(),
    Key::<SpeedScaling>::number(
        "from",
        TIME,
        at_least(0.0).at_most(LONGEST_RUN),
        |s| &mut s.from,
        "time at which the set speed begins to change",
    )
    .required(),
    Key::<SpeedScaling>::number(
        "to",
        TIME,
        at_least(0.0).at_most(LONGEST_RUN),
        |s| &mut s.to,
        "time at which it begins to change back, above from",
    )
    .required(),
    Key::<SpeedScaling>::number(
        "factor",
        NONE,
        at_least(-100.0).at_most(100.0),
        |s| &mut s.factor,
        "factor of the set speed; 0 stops the wheels, a negative one reverses them",
    )
    .required(),
];

/// A scaling before its keys are read.
pub(crate) const NO_SCALING: SpeedScaling = SpeedScaling {
    wheels: [false; 3],
    from: 0.0,
    to: 0.0,
    factor: 1.0,
};

/// Reads the scalings.
pub(crate) fn read_scalings(reader: &mut Reader, root: &Node) -> Vec<SpeedScaling> {
    let Some(node) = root.get(PATH).and_then(|drive| drive.get(SCALING)) else {
        return Vec::new();
    };
    let items = match &node.value {
        Value::Array(items) if items.len() <= MOST_SCALINGS => items.as_slice(),
        _ => {
            reader.refuse(node, SCALING_PATH, SCALINGS_ALLOWED);
            &[]
        }
    };
    let mut scalings: Vec<SpeedScaling> = Vec::with_capacity(items.len());
    for (i, item) in items.iter().enumerate() {
        let path = format!("{SCALING_PATH}[{i}]");
        let mark = reader.mark();
        let mut scaling = NO_SCALING;
        reader.table(SCALINGS, item, &path, &mut scaling);
        for wheel in wheels::read(reader, item, &path) {
            scaling.wheels[wheel] = true;
        }
        if reader.mark() == mark {
            check_scaling(reader, item, &path, &scaling, &scalings);
            scalings.push(scaling);
        }
    }
    scalings
}

fn check_scaling(
    reader: &mut Reader,
    node: &Node,
    path: &str,
    scaling: &SpeedScaling,
    others: &[SpeedScaling],
) {
    if scaling.to <= scaling.from {
        let rule = format!("above from, {} s", scaling.from);
        let to = node.get("to").unwrap_or(node);
        return reader.refuse(to, &join(path, "to"), &rule);
    }
    for (i, other) in others.iter().enumerate() {
        let shared = (0..3).find(|wheel| scaling.wheels[*wheel] && other.wheels[*wheel]);
        let overlap = scaling.from < other.to && other.from < scaling.to;
        if let (Some(wheel), true) = (shared, overlap) {
            let rule = format!(
                "a time outside of that of {SCALING_PATH}[{i}], {} to {} s, which has wheel {} too",
                other.from,
                other.to,
                wheel + 1
            );
            let from = node.get("from").unwrap_or(node);
            return reader.refuse(from, &join(path, "from"), &rule);
        }
    }
}
