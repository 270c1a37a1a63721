//! `[robot]`: geometry and masses, by name, from a file, or written in the scene.

use crate::across::{self, Across};
use crate::inertias::too_large;
use crate::steering::Steering;
use crate::values::{FARTHEST, POINT};
use robhaz_keys::error::Problem;
use robhaz_keys::form::{
    About, Array, Form, KeyReference, Maybe, Out, Plain, array, did_you_mean, quoted, word,
};
use robhaz_keys::key::{self, Key, Table, keys, section};
use robhaz_keys::quantity::{
    ANGLE, INERTIA, LENGTH, MASS, Number, STOP_DAMPING, STOP_STIFFNESS, above, at_least, number,
};
use robhaz_keys::reader::{Reader, join};
use robhaz_keys::source::{self, Entry, Node, Origin, Source, Value};
use robhaz_keys::values::TEXT;
use robhaz_model::{
    Bar, Carrier, GRAVITY, Geometry, GeometryError, Outline, Pin, Robot, StanceError, Suspension,
    Vec2, WholeRover, named,
};
use serde_json::{Value as Json, json};
use std::f64::consts::PI;
use std::path::Path;

/// Largest deviation of an axle's height from the wheel radius in the nominal pose, m.
const LEVEL: f64 = 1e-4;

/// A robot file that is compiled into the program: its name, path and text.
type BuiltIn = (&'static str, &'static str, &'static str);

macro_rules! builtin {
    ($name:literal, $file:literal) => {
        ($name, $file, include_str!(concat!("../../../", $file)))
    };
}

/// The key at fault, and why.
type Fault = (&'static str, String);

/// One of the two halves of `[robot]`.
pub(crate) struct Part {
    /// Full key.
    pub path: &'static str,
    /// The first is the default.
    builtins: &'static [BuiltIn],
    what: &'static str,
    keys: &'static [Key<RobotChoice>],
    name: fn(&mut RobotChoice) -> &mut String,
    /// Completes and checks a table whose keys have no problem.
    check: fn(&mut RobotChoice, &Node) -> Result<(), Fault>,
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

keys! {
    /// The keys of `[robot]` itself.
    KEYS: RobotChoice;

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

/// The robot, and the names under which its parts were chosen.
#[derive(Clone, Debug, PartialEq)]
pub struct RobotChoice {
    /// `A`, `B`, `C`, the path of a geometry file, or `inline`; with `, changed` when an override
    /// changed a part of it.
    pub geometry_name: String,
    /// `caption`, `text`, the path of a mass file, or `inline`; with `, changed` as above.
    pub mass_name: String,
    /// Geometry and masses.
    pub robot: Robot,
    /// `suspension.kind`.
    suspension: SuspensionKind,
    /// `suspension.body`: the link that the body of a bogie is fixed to.
    body: Option<Carrier>,
    /// Steering as a file states it; the links of [`Self::robot`] have it.
    steering: Steering,
    /// `[robot.across]`
    across: Option<Across>,
}

named! {
    /// `suspension.kind`
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub enum SuspensionKind {
        /// Link 3 joins the body to link 2.
        FourBar = "four-bar",
        /// The body is fixed to link 1 or 2.
        Bogie = "bogie",
    }
}

impl RobotChoice {
    /// A robot with names for its geometry and its masses.
    pub fn new(geometry_name: String, mass_name: String, robot: Robot) -> Self {
        let (suspension, body) = match robot.geometry.suspension {
            Suspension::FourBar => (SuspensionKind::FourBar, None),
            Suspension::Bogie { body } => (SuspensionKind::Bogie, Some(body)),
        };
        Self {
            geometry_name,
            mass_name,
            robot,
            suspension,
            body,
            steering: Steering::default(),
            across: None,
        }
    }

    /// The robot after a weighing.
    #[must_use]
    pub fn weighed(&self, robot: Robot) -> Self {
        let names = [&self.geometry_name, &self.mass_name];
        let [geometry, mass] = names.map(|name| format!("{name}, weighed"));
        Self {
            across: self.across.clone(),
            ..Self::new(geometry, mass, robot)
        }
    }

    /// States the lateral place of the body's centre of mass, m, left positive, of a robot that
    /// says what lies across.
    pub fn set_body_place(&mut self, place: f64) {
        if let Some(across) = &mut self.across {
            across.body_place = place;
        }
    }

    /// The rover with both sides, of a file that says what lies across. Its side is
    /// [`Self::robot`].
    pub fn whole_rover(&self) -> Option<WholeRover> {
        Some(self.across.as_ref()?.rover(&self.robot))
    }
}

impl Default for RobotChoice {
    /// Geometry A with the masses of the captions.
    fn default() -> Self {
        let [geometry, mass] = [&GEOMETRY_PART, &MASS_PART].map(|p| p.builtins[0].0.to_owned());
        Self::new(geometry, mass, Robot::default_a())
    }
}

/// `[robot]`
pub(crate) const ROBOT: Table<RobotChoice> = Table {
    check: |reader, section, robot| {
        robot.steering.mount(&mut robot.robot);
        check_stance(reader, section, robot);
        if let Some(across) = &robot.across {
            across.report(reader, section, &robot.robot);
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
    if let Some((key, message)) = too_large(&robot.robot) {
        if let Some((_, masses, path)) = MASS_PART.content(reader, section.get("mass")) {
            let node = masses.find(key).unwrap_or(&masses);
            let message = format!("found {}, but {message}", node.origin.found());
            reader.push(Problem::at(&node.origin, &join(path, key), message).whole());
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
        StanceError::PinBelowGround { pin, .. } => match pin {
            Pin::P => &["pins.p"],
            Pin::Q => &["pins.q"],
            Pin::R => &["pins.r"],
            Pin::S => &["pins.s"],
        },
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

impl Form for Part {
    type Value = RobotChoice;

    fn read(&self, reader: &mut Reader, node: &Node, _path: &str, into: &mut RobotChoice) {
        let mark = reader.mark();
        let Some((name, node, path)) = self.content(reader, Some(node)) else {
            return;
        };
        *(self.name)(into) = name;
        reader.table(self.keys, &node, path, into);
        if reader.mark() > mark {
            return;
        }
        if let Err((key, message)) = (self.check)(into, &node) {
            let at = node.find(key).unwrap_or(&node);
            let message = format!("found {}, but {message}", at.origin.found());
            reader.push(Problem::at(&at.origin, &join(path, key), message).whole());
        }
    }

    fn about(&self) -> About {
        let (names, what) = (quoted(&self.names()), self.what);
        let values = format!("{names}, the path of a .toml file, or a table");
        About {
            values,
            ..About::new(format!(
                "{names}, the path of a {what} file ending in .toml, or a table with the keys of such a file"
            ))
        }
    }

    fn schema(&self, _defaults: Option<&mut RobotChoice>) -> Json {
        let table = key::schema(self.keys, None);
        json!({"anyOf": [{"enum": self.names()}, {"type": "string", "pattern": r"\.toml$"}, table]})
    }

    fn tables(&self, out: &mut Out, path: &str, meaning: &str, value: &mut RobotChoice) {
        out.head(&format!("[{path}]"), meaning);
        out.table(self.keys, value, path);
    }

    fn rows(&self, rows: &mut Vec<KeyReference>, path: &str, value: &mut RobotChoice) {
        key::rows(rows, self.keys, path, value);
    }
}

impl Part {
    fn names(&self) -> Vec<&'static str> {
        self.builtins.iter().map(|b| b.0).collect()
    }

    /// The content of a built-in or a file.
    fn by_name(&self, reader: &mut Reader, node: &Node, name: &str) -> Option<Node> {
        if let Some((_, file, text)) = self.builtins.iter().find(|b| b.0 == name) {
            return reader.document(&Source::file(file, text));
        }
        if Path::new(name).extension().is_none_or(|e| e != "toml") {
            let allowed = self.allowed() + &did_you_mean(name, &self.names());
            reader.refuse(node, self.path, &allowed);
            return None;
        }
        let path = reader.base_dir.join(name);
        let shown = path.display().to_string();
        let text = source::read_toml(&path).map_err(|error| {
            let (found, allowed) = (node.origin.found(), self.allowed());
            let message = format!("found {found}, but {shown} {error}; allowed: {allowed}");
            Problem::at(&node.origin, self.path, message)
        });
        let text = reader.keep(text)?;
        reader.document(&Source::file(&shown, &text))
    }

    /// The name and the table that `chosen`, or the default, stands for, and the table's key; an
    /// empty one for a file.
    fn content(
        &self,
        reader: &mut Reader,
        chosen: Option<&Node>,
    ) -> Option<(String, Node, &'static str)> {
        let (name, node, path) = match chosen.map(|node| (node, &node.value)) {
            None => {
                let (name, file, text) = self.builtins[0];
                (name, reader.document(&Source::file(file, text))?, "")
            }
            Some((node, Value::Text(name))) => {
                (name.as_str(), self.by_name(reader, node, name)?, "")
            }
            Some((node, Value::Table(_))) => ("inline", node.clone(), self.path),
            Some((node, _)) => {
                reader.refuse(node, self.path, &self.allowed());
                return None;
            }
        };
        Some((name.to_owned(), node, path))
    }

    /// The table that `chosen` (or the default) names, so that an override can change a part of it.
    /// Its name gets the ending [`CHANGED`].
    pub(crate) fn written_out(
        &self,
        reader: &mut Reader,
        chosen: Option<&Node>,
        origin: &Origin,
    ) -> Option<Node> {
        let own_name = chosen.map(|c| c.get("name").and_then(Node::as_text));
        let (name, node) = match (chosen, own_name.flatten()) {
            (Some(table), Some(name)) => (name.to_owned(), table.clone()),
            (Some(other), None) if other.as_text().is_none() => return Some(other.clone()),
            _ => self
                .content(reader, chosen)
                .map(|(name, node, _)| (name, node))?,
        };
        let name = name.strip_suffix(CHANGED).unwrap_or(&name);
        let mut entries: Vec<Entry> = node.entries().unwrap_or_default().to_vec();
        entries.retain(|e| e.key != "name");
        let name = Node::text(origin, &format!("{name}{CHANGED}"));
        entries.push(Entry::new("name", origin, name));
        Some(Node::new(&node.origin, Value::Table(entries)))
    }
}

/// Ends the name of a part that an override has changed.
const CHANGED: &str = ", changed";

/// The suspension, with the pins and links that it has.
fn suspend(robot: &mut RobotChoice, node: &Node) -> Result<(), Fault> {
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
fn complete(geometry: &mut Geometry, node: &Node) {
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
fn check(geometry: &Geometry) -> Result<(), Fault> {
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
