//! `[robot]` as a whole: whether the robot can stand.

use crate::robot::choice::{RobotChoice, SuspensionKind};
use crate::robot::fault::{impossible, report};
use crate::robot::keys::{GEOMETRY_PART, KEYS, MASS_PART};
use robhaz_keys::prelude::*;
use robhaz_model::{Bar, StanceError};

/// `[robot]`
pub(crate) const ROBOT: Table<RobotChoice> = Table {
    check: |reader, section, robot| {
        robot.steering.mount(&mut robot.robot);
        check_stance(reader, section, robot);
        let across = robot.across.as_ref().zip(section.get("across"));
        if let Some((across, table)) = across
            && let Err(fault) = across.check(&robot.robot)
        {
            report(reader, table, "robot.across", fault);
        }
    },
    ..section(KEYS)
};

/// Reports a robot that cannot stand, at the key of its geometry that an override set, else at the
/// likeliest key.
fn check_stance(reader: &mut Reader, section: &Node, robot: &RobotChoice) {
    let has_link3 = robot.robot.mass.links[2] > 0.0;
    if has_link3 != (robot.suspension == SuspensionKind::FourBar) {
        if let Some((_, masses, path)) = MASS_PART.content(reader, section.get("mass")) {
            let node = masses.find("links").unwrap_or(&masses);
            let (found, kind) = (node.count(), robot.suspension.name());
            let message = format!(
                "the masses are those of {found} links, but a robot with suspension.kind = \"{kind}\" has {}",
                5 - found
            );
            reader.push(Problem::at(&node.origin, &join(path, "links"), message).whole());
        }
        return;
    }
    if let Some(fault) = impossible(&robot.robot) {
        if let Some((_, masses, path)) = MASS_PART.content(reader, section.get("mass")) {
            report(reader, &masses, path, fault);
        }
        return;
    }
    let Err(error) = robot.robot.check_stance() else {
        return;
    };
    let Some((_, geometry, path)) = GEOMETRY_PART.content(reader, section.get("geometry")) else {
        return;
    };
    let keys = stance_keys(&error).iter();
    let written: Vec<(&str, &Node)> = keys
        .filter_map(|key| geometry.find(key).map(|node| (*key, node)))
        .collect();
    let changed = written.iter().find(|(_, node)| node.origin.is_override());
    let (key, node) = *changed.or(written.first()).unwrap_or(&("", &geometry));
    let path = join(path, key);
    reader.push(Problem::at(&node.origin, &path, error.to_string()).whole());
}

/// The keys of a geometry that can make a robot unable to stand, the likeliest first.
fn stance_keys(error: &StanceError) -> &'static [&'static str] {
    match error {
        StanceError::WheelsOverlap { .. } => &["axles", "wheel_radius"],
        StanceError::PinBelowGround { pin, .. } => {
            [&["pins.p"], &["pins.q"], &["pins.r"], &["pins.s"]][*pin as usize]
        }
        StanceError::CentreBelowGround { bar, .. } if *bar != Bar::Body => &["link_cg"],
        StanceError::CentreBelowGround { .. } => &["body_cg"],
        StanceError::TipsForward { .. } | StanceError::TipsBackward { .. } => {
            &["body_cg", "axles", "link_cg"]
        }
        StanceError::Folds { .. } | StanceError::Undetermined => &[
            "body_cg", "pins.q", "pins.p", "pins.r", "pins.s", "axles", "link_cg",
        ],
    }
}
