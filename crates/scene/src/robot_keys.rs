//! The keys of geometry and mass files.

use crate::key::{Form, Key};
use crate::range::{above, at_least};
use crate::units::{ANGLE, INERTIA, LENGTH, MASS, STOP_DAMPING, STOP_STIFFNESS};
use robhaz_model::{Carrier, Geometry, MassSet};
use serde_json::json;
use std::f64::consts::PI;

const CARRIERS: [Carrier; 2] = [Carrier::Link1, Carrier::Link2];

/// Largest coordinate of the robot, m.
const FARTHEST: f64 = 10.0;

/// Any text.
const TEXT: Form = Form {
    words: "a text",
    schema: || json!({"type": "string"}),
};

/// The keys of a geometry file, and of `[robot.geometry]`.
pub(crate) const GEOMETRY: &[Key<Geometry>] = &[
    Key::<Geometry>::own(
        "name",
        "the name or path by which it was chosen",
        TEXT,
        "name in summaries",
    ),
    Key::<Geometry>::number(
        "wheel_radius",
        LENGTH,
        above(0.0).at_most(FARTHEST),
        |g| &mut g.wheel_radius,
        "radius of every wheel",
    )
    .required(),
    Key::<Geometry>::three_points(
        "axles",
        LENGTH,
        at_least(-FARTHEST).at_most(FARTHEST),
        |g| &mut g.axles,
        "axles of the front, middle and rear wheel; their height is the wheel radius",
    )
    .required(),
    Key::<Geometry>::three_words(
        "carriers",
        &[Carrier::Link1.bar().name(), Carrier::Link2.bar().name()],
        |g| g.carriers.map(Carrier::index),
        |g, i| g.carriers = i.map(|i| CARRIERS[i]),
        "the link that carries each wheel; both links must carry one",
    )
    .required(),
    Key::<Geometry>::point(
        "body_cg",
        LENGTH,
        at_least(-FARTHEST).at_most(FARTHEST),
        |g| &mut g.body_cg,
        "centre of mass of the body",
    )
    .required(),
    Key::<Geometry>::three_points(
        LINK_CG,
        LENGTH,
        at_least(-FARTHEST).at_most(FARTHEST),
        |g| &mut g.link_cg,
        "centres of mass of links 1 to 3 without wheels; by default the mean of the link's own pins and axles",
    ),
    Key::<Geometry>::table("pins", PINS, "positions of the four pins").required(),
    Key::<Geometry>::table("stop", STOP, "end stops of pin Q, on theta_1 - theta_2"),
    Key::<Geometry>::table(
        OUTLINE_PATH,
        OUTLINE,
        "outline of body and links, for their clearance to the ground; it carries no force",
    ),
];

/// An optional key: by default it follows from the other keys.
pub(crate) const LINK_CG: &str = "link_cg";

const PINS: &[Key<Geometry>] = &[
    Key::<Geometry>::point(
        "p",
        LENGTH,
        at_least(-FARTHEST).at_most(FARTHEST),
        |g| &mut g.pins.p,
        "between body and link 1",
    )
    .required(),
    Key::<Geometry>::point(
        "q",
        LENGTH,
        at_least(-FARTHEST).at_most(FARTHEST),
        |g| &mut g.pins.q,
        "between link 1 and link 2",
    )
    .required(),
    Key::<Geometry>::point(
        "r",
        LENGTH,
        at_least(-FARTHEST).at_most(FARTHEST),
        |g| &mut g.pins.r,
        "between link 2 and link 3",
    )
    .required(),
    Key::<Geometry>::point(
        "s",
        LENGTH,
        at_least(-FARTHEST).at_most(FARTHEST),
        |g| &mut g.pins.s,
        "between link 3 and body",
    )
    .required(),
];

/// An optional table: by default it follows from the other keys.
pub(crate) const OUTLINE_PATH: &str = "outline";
/// Names of its keys.
pub(crate) const BODY_LOWER: &str = "body_lower";
pub(crate) const BODY_UPPER: &str = "body_upper";
pub(crate) const HALF_WIDTH: &str = "half_width";

const OUTLINE: &[Key<Geometry>] = &[
    Key::<Geometry>::point(
        BODY_LOWER,
        LENGTH,
        at_least(-FARTHEST).at_most(FARTHEST),
        |g| &mut g.outline.body_lower,
        "lower rear corner of the body's box; by default 1/3 of the wheelbase behind body_cg and 0.117 of it below",
    ),
    Key::<Geometry>::point(
        BODY_UPPER,
        LENGTH,
        at_least(-FARTHEST).at_most(FARTHEST),
        |g| &mut g.outline.body_upper,
        "upper front corner of the body's box; by default as far ahead of body_cg and above it",
    ),
    Key::<Geometry>::number(
        HALF_WIDTH,
        LENGTH,
        at_least(0.0).at_most(FARTHEST),
        |g| &mut g.outline.half_width,
        "half of the width of links, and wall about the body's box and pins; by default 0.025 of the wheelbase",
    ),
];

const STOP: &[Key<Geometry>] = &[
    Key::<Geometry>::number(
        "lower",
        ANGLE,
        at_least(-PI).below(0.0),
        |g| &mut g.stop.lower,
        "lower limit",
    ),
    Key::<Geometry>::number(
        "upper",
        ANGLE,
        above(0.0).at_most(PI),
        |g| &mut g.stop.upper,
        "upper limit",
    ),
    Key::<Geometry>::number(
        "stiffness",
        STOP_STIFFNESS,
        at_least(0.0).at_most(1e9),
        |g| &mut g.stop.stiffness,
        "stiffness beyond a limit",
    ),
    Key::<Geometry>::number(
        "damping",
        STOP_DAMPING,
        at_least(0.0).at_most(1e9),
        |g| &mut g.stop.damping,
        "damping beyond a limit",
    ),
];

/// The keys of a mass file, and of `[robot.mass]`.
pub(crate) const MASSES: &[Key<MassSet>] = &[
    Key::<MassSet>::own(
        "name",
        "the name or path by which it was chosen",
        TEXT,
        "name in summaries",
    ),
    Key::<MassSet>::number(
        "body",
        MASS,
        above(0.0).at_most(1e6),
        |m| &mut m.body,
        "the body: half of the real one",
    )
    .required(),
    Key::<MassSet>::three(
        "links",
        MASS,
        above(0.0).at_most(1e6),
        |m| &mut m.links,
        "links 1 to 3 without wheels",
    )
    .required(),
    Key::<MassSet>::number(
        "wheel",
        MASS,
        above(0.0).at_most(1e6),
        |m| &mut m.wheel,
        "each wheel module",
    )
    .required(),
    Key::<MassSet>::number(
        "body_inertia",
        INERTIA,
        above(0.0).at_most(1e6),
        |m| &mut m.body_inertia,
        "of the body about its centre of mass",
    )
    .required(),
    Key::<MassSet>::three(
        "link_inertias",
        INERTIA,
        above(0.0).at_most(1e6),
        |m| &mut m.link_inertias,
        "of links 1 to 3 about their centres of mass",
    )
    .required(),
    Key::<MassSet>::number(
        "wheel_inertia",
        INERTIA,
        above(0.0).at_most(1e6),
        |m| &mut m.wheel_inertia,
        "J_wheel: the disc, which resists the absolute spin",
    )
    .required(),
    Key::<MassSet>::number(
        "rotor_inertia",
        INERTIA,
        above(0.0).at_most(1e6),
        |m| &mut m.rotor_inertia,
        "J_rotor: the rotor through the gear, which resists the relative spin",
    )
    .required(),
];
