//! The keys of `[robot]`, of its two halves, and the robots that are compiled into the program.

use crate::robot::across;
use crate::robot::checks::{check, complete, suspend};
use crate::robot::choice::{RobotChoice, SuspensionKind};
use crate::robot::part::Part;
use crate::values::{FARTHEST, POINT};
use robhaz_keys::prelude::*;
use robhaz_model::{Carrier, GRAVITY, Robot, Vec2};
use serde_json::json;
use std::f64::consts::PI;

macro_rules! builtin {
    ($name:literal, $file:literal) => {
        ($name, $file, include_str!(concat!("../../../../", $file)))
    };
}

/// `robot.geometry`
pub(crate) const GEOMETRY_PART: Part = Part {
    path: "robot.geometry",
    builtins: &[
        builtin!("A", "robots/geometry-a.toml"),
        builtin!("B", "robots/geometry-b.toml"),
        builtin!("C", "robots/geometry-c.toml"),
    ],
    what: "geometry",
    keys: GEOMETRY,
    name: |robot| &mut robot.geometry_name,
    check: |robot, node| {
        suspend(robot, node)?;
        let geometry = &mut robot.robot.geometry;
        complete(geometry, node);
        check(geometry)
    },
};

/// `robot.mass`
pub(crate) const MASS_PART: Part = Part {
    path: "robot.mass",
    builtins: &[
        builtin!("caption", "robots/mass-caption.toml"),
        builtin!("text", "robots/mass-text.toml"),
    ],
    what: "mass",
    keys: MASSES,
    name: |robot| &mut robot.mass_name,
    check: |robot, node| {
        let mass = &mut robot.robot.mass;
        let counts = ["links", "link_inertias"].map(|key| node.find(key).map_or(3, Node::count));
        if counts[0] != counts[1] {
            let message = "links and link_inertias name different numbers of links".to_owned();
            return Err(("link_inertias", message));
        }
        if counts[0] == 2 {
            (mass.links[2], mass.link_inertias[2]) = (0.0, 0.0);
        }
        let checked = mass.check();
        checked.map_err(|error| (error.entry, error.to_string()))
    },
};

impl Default for RobotChoice {
    /// Geometry A with the masses of the captions.
    fn default() -> Self {
        let [geometry, mass] = [&GEOMETRY_PART, &MASS_PART].map(|p| p.builtins[0].0.to_owned());
        Self::new(geometry, mass, Robot::default_a())
    }
}

keys! {
    /// The keys of `[robot]` itself.
    pub(super) KEYS: RobotChoice;

    /// dimensions of the robot; a path is relative to the scene file
    geometry ("A"): GEOMETRY_PART => self;

    /// masses and inertias; a path is relative to the scene file
    mass ("caption"): MASS_PART => self;

    /// a rover with both sides: what lies across
    across: Maybe(section(across::KEYS)) => across;

    /// acceleration of free fall, m/s^2: "earth" is 9.81, "mars" 3.71, "moon" 1.62
    gravity: Plain {
        words: "\"earth\", \"mars\", \"moon\", or a number above 0.01 and at most 100",
        schema: || json!({"anyOf": [
            {"enum": PLANETS.map(|(name, _)| name)},
            {"type": "number", "exclusiveMinimum": 0.01, "maximum": 100.0},
        ]}),
        read: gravity,
        text: |gravity| Some(format!("{gravity:?}")),
    } => robot.gravity;
}

/// Gravity on planets, m/s^2 (NASA, Planetary Fact Sheet; Earth's is the usual one).
const PLANETS: [(&str, f64); 3] = [("earth", GRAVITY), ("mars", 3.71), ("moon", 1.62)];

fn gravity(node: &Node) -> Option<f64> {
    let value = match &node.value {
        Value::Text(name) => PLANETS.iter().find(|(n, _)| n == name)?.1,
        Value::Float(value) | Value::Integer(_, value) => *value,
        _ => return None,
    };
    (value > 0.01 && value <= 100.0).then_some(value)
}

/// Values of links 1 to 3, or of links 1 and 2 of a bogie.
const fn links<F: Form>(
    words: &'static str,
    item: F,
    items: fn(&mut RobotChoice) -> &mut [F::Value],
) -> Array<F, RobotChoice> {
    Array {
        item,
        words,
        count: [2, 3],
        items,
        written: |robot| robot.robot.geometry.suspension.bars().len() - 1,
    }
}

fn is_four_bar(robot: &RobotChoice) -> bool {
    robot.suspension == SuspensionKind::FourBar
}

/// Up to two points of a link.
const THROUGH: Array<Maybe<Array<Number, Vec2>>, [Option<Vec2>; 2]> = Array {
    count: [0, 2],
    ..array("up to two points, each [x, y], each {}", Maybe(POINT))
};
const LINKS: &[Carrier] = &[Carrier::Link1, Carrier::Link2];
const MASS_OF: Number = number(MASS, above(0.0).at_most(1e6));
const INERTIA_OF: Number = number(INERTIA, above(0.0).at_most(1e6));

keys! {
    /// The keys of a geometry file, and of `[robot.geometry]`.
    pub(crate) GEOMETRY: RobotChoice;

    /// name in summaries
    name ("the name or path by which it was chosen"): TEXT => geometry_name;

    /// radius of every wheel
    wheel_radius (required): number(LENGTH, above(0.0).at_most(FARTHEST))
        => robot.geometry.wheel_radius;

    /// axles of the front, middle and rear wheel; their height is the wheel radius
    axles (required): array("[[x, y], [x, y], [x, y]], each {}", POINT)
        => robot.geometry.axles;

    /// the link that carries each wheel; both links must carry one
    carriers (required): array("three of {}", word(LINKS, |link| link.bar().name()))
        => robot.geometry.carriers;

    /// centre of mass of the body
    body_cg (required): POINT => robot.geometry.body_cg;

    /// centres of mass of the links without wheels and steering; by default the mean of the link's
    /// own pins and axles
    link_cg ("mean of own pins and axles"): links(
        "[[x, y], [x, y], [x, y]], of a bogie two points, each {}", POINT,
        |robot| &mut robot.robot.geometry.link_cg,
    ) => self;

    /// height of robot.mass.steering over the ground, above the axle
    steering_height ("3 wheel radii"): Maybe(number(LENGTH, above(0.0).at_most(FARTHEST)))
        => steering.height if |_| false;

    /// how the body hangs on links 1 and 2
    suspension: section(SUSPENSION) => self;

    /// positions of the pins
    pins (required): section(PINS) => self;

    /// end stops of pin Q, on theta_1 - theta_2
    stop: section(STOP) => self;

    /// outline of body and links, for their clearance to the ground; it carries no force
    outline: section(OUTLINE) => self;
}

keys! {
    SUSPENSION: RobotChoice;

    /// link 3 joins the body to link 2, as in ROBHAZ-6WHEEL; or the body is fixed to a link, as in
    /// a rocker-bogie or a triple bogie
    kind: word(&SuspensionKind::ALL, SuspensionKind::name) => suspension;

    /// of a bogie: the link that the body is fixed to
    body ("required of a bogie"): Maybe(word(LINKS, |link| link.bar().name())) => body;
}

keys! {
    PINS: RobotChoice;

    /// between body and link 1
    p ("required of a four-bar"): POINT => robot.geometry.pins.p if is_four_bar;

    /// between link 1 and link 2
    q (required): POINT => robot.geometry.pins.q;

    /// between link 2 and link 3
    r ("required of a four-bar"): POINT => robot.geometry.pins.r if is_four_bar;

    /// between link 3 and body
    s ("required of a four-bar"): POINT => robot.geometry.pins.s if is_four_bar;
}

keys! {
    OUTLINE: RobotChoice;

    /// lower rear corner of the body's box; by default 1/3 of the wheelbase behind body_cg and
    /// 0.117 of it below
    body_lower ("from body_cg and wheelbase"): POINT => robot.geometry.outline.body_lower;

    /// upper front corner of the body's box; by default as far ahead of body_cg and above it
    body_upper ("from body_cg and wheelbase"): POINT => robot.geometry.outline.body_upper;

    /// half of the width of links, and wall about the body's box and pins; by default 0.025 of the
    /// wheelbase
    half_width: number(LENGTH, at_least(0.0).at_most(FARTHEST)) => robot.geometry.outline.half_width;

    /// points that link 1 goes through beside its pins and axles, such as the top of a strut over a
    /// wheel
    link1 ("none"): THROUGH => (|r| &mut r.robot.geometry.outline.through[0]);

    /// the same of link 2
    link2 ("none"): THROUGH => (|r| &mut r.robot.geometry.outline.through[1]);
}

keys! {
    STOP: RobotChoice;

    /// lower limit
    lower: number(ANGLE, at_least(-PI).below(0.0)) => robot.geometry.stop.lower;

    /// upper limit
    upper: number(ANGLE, above(0.0).at_most(PI)) => robot.geometry.stop.upper;

    /// stiffness beyond a limit
    stiffness: number(STOP_STIFFNESS, at_least(0.0).at_most(1e9)) => robot.geometry.stop.stiffness;

    /// damping beyond a limit
    damping: number(STOP_DAMPING, at_least(0.0).at_most(1e9)) => robot.geometry.stop.damping;
}

keys! {
    /// The keys of a mass file, and of `[robot.mass]`.
    pub(crate) MASSES: RobotChoice;

    /// name in summaries
    name ("the name or path by which it was chosen"): TEXT => mass_name;

    /// the body: half of the real one
    body (required): MASS_OF => robot.mass.body;

    /// the links without wheels and steering, which robot.mass.steering states
    links (required): links(
        "[a, b, c], of a bogie [a, b], each {}", MASS_OF,
        |robot| &mut robot.robot.mass.links,
    ) => self;

    /// each wheel module: what all three have, at their axles
    wheel (required): MASS_OF => robot.mass.wheel;

    /// steering of the front, middle and rear wheel, 0 where there is none. It does not roll, so it
    /// is a part of the wheel's link: a resolved scene has it in links, link_inertias and link_cg
    steering ("none"): array("[a, b, c], each {}", number(MASS, at_least(0.0).at_most(1e6)))
        => steering.masses if |_| false;

    /// of the body about its centre of mass
    body_inertia (required): INERTIA_OF => robot.mass.body_inertia;

    /// of the links about their centres of mass
    link_inertias (required): links(
        "[a, b, c], of a bogie [a, b], each {}", INERTIA_OF,
        |robot| &mut robot.robot.mass.link_inertias,
    ) => self;

    /// J_wheel: the disc, which resists the absolute spin
    wheel_inertia (required): INERTIA_OF => robot.mass.wheel_inertia;

    /// J_rotor: the rotor through the gear, which resists the relative spin
    rotor_inertia (required): INERTIA_OF => robot.mass.rotor_inertia;
}
