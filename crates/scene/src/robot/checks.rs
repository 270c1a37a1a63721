//! Completes a half of `[robot]`, and checks it.

use crate::robot::choice::{RobotChoice, SuspensionKind};
use crate::robot::fault::Fault;
use crate::values::POINT;
use robhaz_keys::prelude::*;
use robhaz_model::{Geometry, GeometryError, Outline, Suspension};

/// Largest deviation of an axle's height from the wheel radius in the nominal pose, m.
const LEVEL: f64 = 1e-4;

/// The suspension, with the pins and links that it has.
pub fn suspend(robot: &mut RobotChoice, node: &Node) -> Result<(), Fault> {
    const OF_FOUR_BAR: [&str; 3] = ["pins.p", "pins.r", "pins.s"];
    let given = |key: &&&'static str| node.find(key).is_some();
    let kind = robot.suspension.name();
    let links = node.find("link_cg").map(Node::count);
    let geometry = &mut robot.robot.geometry;
    match (robot.suspension, robot.body) {
        (SuspensionKind::FourBar, body) => {
            geometry.suspension = Suspension::FourBar;
            if body.is_some() {
                let message = "only the body of suspension.kind = \"bogie\" is fixed to a link";
                return Err(("suspension.body", message.to_owned()));
            }
            if let Some(key) = OF_FOUR_BAR.iter().find(|key| !given(key)) {
                let message = format!("{key} is missing; allowed: {}", POINT.allowed());
                return Err(("pins", message));
            }
        }
        (SuspensionKind::Bogie, None) => {
            let message = "suspension.body is missing; allowed: \"link1\", \"link2\"";
            return Err(("suspension", message.to_owned()));
        }
        (SuspensionKind::Bogie, Some(body)) => {
            if let Some(key) = OF_FOUR_BAR.iter().find(given) {
                let message = "with suspension.kind = \"bogie\" Q is the only pin";
                return Err((key, message.to_owned()));
            }
            geometry.make_bogie(body);
        }
    }
    let count = geometry.suspension.bars().len() - 1;
    if links.is_some_and(|links| links != count) {
        let message = format!("a robot with suspension.kind = \"{kind}\" has {count} links");
        return Err(("link_cg", message));
    }
    Ok(())
}

/// Keys that are not given follow from the other keys.
pub fn complete(geometry: &mut Geometry, node: &Node) {
    let lacks = |key: &str| node.find(key).is_none();
    if lacks("link_cg") {
        geometry.link_cg = geometry.mean_link_cgs();
    }
    let derived = Outline::derived(&geometry.axles, geometry.body_cg);
    let outline = &mut geometry.outline;
    if lacks("outline.body_lower") {
        outline.body_lower = derived.body_lower;
    }
    if lacks("outline.body_upper") {
        outline.body_upper = derived.body_upper;
    }
    if lacks("outline.half_width") {
        outline.half_width = derived.half_width;
    }
}

/// The key at fault and why.
pub fn check(geometry: &Geometry) -> Result<(), Fault> {
    if let Err(error) = geometry.check() {
        let key = match error {
            GeometryError::WheelRadius(_) => "wheel_radius",
            GeometryError::NotFinite | GeometryError::ZeroBar(_) => "pins",
            GeometryError::POnLineRs => "pins.p",
            GeometryError::WheelOrder => "axles",
            GeometryError::UnusedCarrier(_) => "carriers",
            GeometryError::Stop => "stop",
        };
        return Err((key, error.to_string()));
    }
    let outline = &geometry.outline;
    if !(outline.body_upper.x > outline.body_lower.x && outline.body_upper.y > outline.body_lower.y)
    {
        let message = "the upper front corner of the body's box must be ahead of its lower rear corner and above it";
        return Err(("outline", message.to_owned()));
    }
    let radius = geometry.wheel_radius;
    if geometry.axles.iter().any(|a| (a.y - radius).abs() > LEVEL) {
        let message = format!(
            "in the nominal pose all wheels stand on y = 0: the y of every axle is wheel_radius = {radius} m"
        );
        return Err(("axles", message));
    }
    Ok(())
}
