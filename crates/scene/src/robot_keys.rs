//! The keys of geometry and mass files.

use crate::form::{Array, Point, TEXT, array, point, section, word};
use crate::key::keys;
use crate::quantity::{ANGLE, INERTIA, LENGTH, MASS, STOP_DAMPING, STOP_STIFFNESS};
use crate::quantity::{Number, above, at_least, number};
use crate::robot::RobotChoice;
use robhaz_model::{Carrier, Vec2};
use std::f64::consts::PI;

/// Largest coordinate of the robot, m.
const FARTHEST: f64 = 10.0;

/// A point of the robot in its nominal pose.
const POINT: Point = point(number(LENGTH, at_least(-FARTHEST).at_most(FARTHEST)));
const THREE_POINTS: Array<Point, [Vec2; 3]> = array("[[x, y], [x, y], [x, y]], each {}", POINT);
const LINKS: &[Carrier] = &[Carrier::Link1, Carrier::Link2];
const MASS_OF: Number = number(MASS, above(0.0).at_most(1e6));
const INERTIA_OF: Number = number(INERTIA, above(0.0).at_most(1e6));

keys! {
    /// The keys of a geometry file, and of `[robot.geometry]`.
    pub(crate) GEOMETRY: RobotChoice;

    /// name in summaries
    name ("the name or path by which it was chosen"): TEXT => |r| &mut r.geometry_name;

    /// radius of every wheel
    wheel_radius (required): number(LENGTH, above(0.0).at_most(FARTHEST))
        => |r| &mut r.robot.geometry.wheel_radius;

    /// axles of the front, middle and rear wheel; their height is the wheel radius
    axles (required): THREE_POINTS => |r| &mut r.robot.geometry.axles;

    /// the link that carries each wheel; both links must carry one
    carriers (required): array("three of {}", word(LINKS, |link| link.bar().name()))
        => |r| &mut r.robot.geometry.carriers;

    /// centre of mass of the body
    body_cg (required): POINT => |r| &mut r.robot.geometry.body_cg;

    /// centres of mass of links 1 to 3 without wheels; by default the mean of the link's own pins and axles
    link_cg ("mean of own pins and axles"): THREE_POINTS => |r| &mut r.robot.geometry.link_cg;

    /// positions of the four pins
    pins (required): section(PINS) => |x| x;

    /// end stops of pin Q, on theta_1 - theta_2
    stop: section(STOP) => |x| x;

    /// outline of body and links, for their clearance to the ground; it carries no force
    outline: section(OUTLINE) => |x| x;
}

keys! {
    PINS: RobotChoice;

    /// between body and link 1
    p (required): POINT => |r| &mut r.robot.geometry.pins.p;

    /// between link 1 and link 2
    q (required): POINT => |r| &mut r.robot.geometry.pins.q;

    /// between link 2 and link 3
    r (required): POINT => |r| &mut r.robot.geometry.pins.r;

    /// between link 3 and body
    s (required): POINT => |r| &mut r.robot.geometry.pins.s;
}

keys! {
    OUTLINE: RobotChoice;

    /// lower rear corner of the body's box; by default 1/3 of the wheelbase behind body_cg and 0.117 of it below
    body_lower ("from body_cg and wheelbase"): POINT
        => |r| &mut r.robot.geometry.outline.body_lower;

    /// upper front corner of the body's box; by default as far ahead of body_cg and above it
    body_upper ("from body_cg and wheelbase"): POINT
        => |r| &mut r.robot.geometry.outline.body_upper;

    /// half of the width of links, and wall about the body's box and pins; by default 0.025 of the wheelbase
    half_width: number(LENGTH, at_least(0.0).at_most(FARTHEST)) => |r| &mut r.robot.geometry.outline.half_width;
}

keys! {
    STOP: RobotChoice;

    /// lower limit
    lower: number(ANGLE, at_least(-PI).below(0.0)) => |r| &mut r.robot.geometry.stop.lower;

    /// upper limit
    upper: number(ANGLE, above(0.0).at_most(PI)) => |r| &mut r.robot.geometry.stop.upper;

    /// stiffness beyond a limit
    stiffness: number(STOP_STIFFNESS, at_least(0.0).at_most(1e9)) => |r| &mut r.robot.geometry.stop.stiffness;

    /// damping beyond a limit
    damping: number(STOP_DAMPING, at_least(0.0).at_most(1e9)) => |r| &mut r.robot.geometry.stop.damping;
}

keys! {
    /// The keys of a mass file, and of `[robot.mass]`.
    pub(crate) MASSES: RobotChoice;

    /// name in summaries
    name ("the name or path by which it was chosen"): TEXT => |r| &mut r.mass_name;

    /// the body: half of the real one
    body (required): MASS_OF => |r| &mut r.robot.mass.body;

    /// links 1 to 3 without wheels
    links (required): array("[a, b, c], each {}", MASS_OF) => |r| &mut r.robot.mass.links;

    /// each wheel module
    wheel (required): MASS_OF => |r| &mut r.robot.mass.wheel;

    /// of the body about its centre of mass
    body_inertia (required): INERTIA_OF => |r| &mut r.robot.mass.body_inertia;

    /// of links 1 to 3 about their centres of mass
    link_inertias (required): array("[a, b, c], each {}", INERTIA_OF)
        => |r| &mut r.robot.mass.link_inertias;

    /// J_wheel: the disc, which resists the absolute spin
    wheel_inertia (required): INERTIA_OF => |r| &mut r.robot.mass.wheel_inertia;

    /// J_rotor: the rotor through the gear, which resists the relative spin
    rotor_inertia (required): INERTIA_OF => |r| &mut r.robot.mass.rotor_inertia;
}
