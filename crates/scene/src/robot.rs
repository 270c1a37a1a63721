//! `[robot]`: geometry and masses, by name, from a file, or written in the scene.

use crate::error::Problem;
use crate::file;
use crate::json;
use crate::key::{Form, Key, quoted};
use crate::reader::{Reader, join};
use crate::robot_keys::{
    BODY_LOWER, BODY_UPPER, GEOMETRY, HALF_WIDTH, LINK_CG, MASSES, OUTLINE_PATH,
};
use crate::source::{Entry, Node, Origin, Source, Value};
use crate::suggest::nearest;
use robhaz_model::{
    Bar, Geometry, GeometryError, MassSet, Outline, Pin, PinStop, Robot, StanceError, mean_link_cgs,
};
use serde_json::json;
use std::path::Path;

/// Largest deviation of an axle's height from the wheel radius in the nominal pose, m.
const LEVEL: f64 = 1e-4;

const DEFAULT_GEOMETRY: &str = "A";
const DEFAULT_MASS: &str = "caption";

/// A robot file that is compiled into the program.
struct BuiltIn {
    name: &'static str,
    file: &'static str,
    text: &'static str,
}

/// One of the two halves of `[robot]`.
pub(crate) struct Part {
    /// Full key.
    pub path: &'static str,
    /// The first is the default.
    builtins: &'static [BuiltIn],
    what: &'static str,
}

/// `robot.geometry`
pub(crate) const GEOMETRY_PART: Part = Part {
    path: "robot.geometry",
    builtins: &[
        BuiltIn {
            name: DEFAULT_GEOMETRY,
            file: "robots/geometry-a.toml",
            text: include_str!("../../../robots/geometry-a.toml"),
        },
        BuiltIn {
            name: "B",
            file: "robots/geometry-b.toml",
            text: include_str!("../../../robots/geometry-b.toml"),
        },
        BuiltIn {
            name: "C",
            file: "robots/geometry-c.toml",
            text: include_str!("../../../robots/geometry-c.toml"),
        },
    ],
    what: "geometry",
};

/// `robot.mass`
pub(crate) const MASS_PART: Part = Part {
    path: "robot.mass",
    builtins: &[
        BuiltIn {
            name: DEFAULT_MASS,
            file: "robots/mass-caption.toml",
            text: include_str!("../../../robots/mass-caption.toml"),
        },
        BuiltIn {
            name: "text",
            file: "robots/mass-text.toml",
            text: include_str!("../../../robots/mass-text.toml"),
        },
    ],
    what: "mass",
};

/// The keys of `[robot]` itself.
pub(crate) const KEYS: &[Key<()>] = &[
    Key::own(
        "geometry",
        DEFAULT_GEOMETRY,
        Form {
            words: "\"A\", \"B\", \"C\", the path of a .toml file, or a table",
            schema: || GEOMETRY_PART.schema(json::table(GEOMETRY, None)),
        },
        "dimensions of the robot; a path is relative to the scene file",
    ),
    Key::own(
        "mass",
        DEFAULT_MASS,
        Form {
            words: "\"caption\", \"text\", the path of a .toml file, or a table",
            schema: || MASS_PART.schema(json::table(MASSES, None)),
        },
        "masses and inertias; a path is relative to the scene file",
    ),
];

/// The robot, and the names under which its parts were chosen.
#[derive(Clone, Debug, PartialEq)]
pub struct RobotChoice {
    /// `A`, `B`, `C`, the path of a geometry file, or `inline`; with `, changed` when an override changed a part of it.
    pub geometry_name: String,
    /// `caption`, `text`, the path of a mass file, or `inline`; with `, changed` as above.
    pub mass_name: String,
    /// Geometry and masses.
    pub robot: Robot,
}

impl Default for RobotChoice {
    /// Geometry A with the masses of the captions.
    fn default() -> Self {
        Self {
            geometry_name: DEFAULT_GEOMETRY.to_owned(),
            mass_name: DEFAULT_MASS.to_owned(),
            robot: Robot::default_a(),
        }
    }
}

/// Reads the section.
pub(crate) fn read(reader: &mut Reader, root: &Node) -> RobotChoice {
    if let Some(node) = root.get("robot") {
        reader.table(KEYS, node, "robot", &mut ());
    }
    let mark = reader.mark();
    let geometry = read_part(reader, root, &GEOMETRY_PART, read_geometry);
    let mass = read_part(reader, root, &MASS_PART, read_masses);
    let robot = Robot {
        // Both exist unless there is a problem.
        geometry: geometry.value.unwrap_or_else(Geometry::a),
        mass: mass.value.unwrap_or_else(MassSet::caption),
    };
    if let (true, Err(error)) = (reader.mark() == mark, robot.check_stance()) {
        refuse_stance(reader, root, &geometry.place, &error);
    }
    RobotChoice {
        geometry_name: geometry.name,
        mass_name: mass.name,
        robot,
    }
}

/// A half of `[robot]` as it was read.
struct ReadPart<T> {
    name: String,
    place: Place,
    value: Option<T>,
}

/// Origin of one half of `[robot]`.
struct Place {
    /// Its table.
    node: Option<Node>,
    /// The key under which the table is; empty for a file.
    path: String,
}

/// Reports a robot that cannot stand, at the key of its geometry that an override set, else at the likeliest key.
fn refuse_stance(reader: &mut Reader, root: &Node, place: &Place, error: &StanceError) {
    let keys = stance_keys(error);
    let whole = place.node.as_ref().unwrap_or(root);
    let written: Vec<(&str, &Node)> = keys
        .iter()
        .filter_map(|key| whole.find(key).map(|node| (*key, node)))
        .collect();
    let changed = written.iter().find(|(_, node)| node.origin.is_override());
    let (key, node) = *changed.or(written.first()).unwrap_or(&("", whole));
    let path = join(&place.path, key);
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
        StanceError::CentreBelowGround { bar, .. } if *bar != Bar::Body => &[LINK_CG],
        StanceError::CentreBelowGround { .. } => &["body_cg"],
        StanceError::TipsForward { .. } | StanceError::TipsBackward { .. } => {
            &["body_cg", "axles", LINK_CG]
        }
        StanceError::Folds { .. } | StanceError::Undetermined => &[
            "body_cg", "pins.q", "pins.p", "pins.r", "pins.s", "axles", LINK_CG,
        ],
    }
}

fn read_part<T>(
    reader: &mut Reader,
    root: &Node,
    part: &Part,
    read: fn(&mut Reader, &Node, &str) -> Option<T>,
) -> ReadPart<T> {
    let (chosen, node, path) = match root.find(part.path) {
        None => {
            let default = &part.builtins[0];
            (default.name, Some(part.builtin(reader, default)), "")
        }
        Some(node) => match &node.value {
            Value::Text(name) => (name.as_str(), part.by_name(reader, node, name), ""),
            Value::Table(_) => ("inline", Some(node.clone()), part.path),
            _ => {
                reader.refuse(node, part.path, &part.allowed());
                ("", None, "")
            }
        },
    };
    let Some(node) = node else {
        return ReadPart {
            name: chosen.to_owned(),
            place: Place {
                node: None,
                path: path.to_owned(),
            },
            value: None,
        };
    };
    let name = match node.get("name").map(|n| (n, &n.value)) {
        Some((_, Value::Text(name))) => name.clone(),
        Some((name, _)) => {
            reader.refuse(name, &join(path, "name"), "a text");
            String::new()
        }
        None => chosen.to_owned(),
    };
    let value = read(reader, &node, path);
    ReadPart {
        name,
        place: Place {
            node: Some(node),
            path: path.to_owned(),
        },
        value,
    }
}

impl Part {
    fn names(&self) -> Vec<&'static str> {
        self.builtins.iter().map(|b| b.name).collect()
    }

    fn allowed(&self) -> String {
        format!(
            "{}, the path of a {} file ending in .toml, or a table with the keys of such a file",
            quoted(&self.names()),
            self.what
        )
    }

    /// JSON Schema of its key: a name, a path, or a table.
    fn schema(&self, table: serde_json::Value) -> serde_json::Value {
        json!({"anyOf": [{"enum": self.names()}, {"type": "string", "pattern": r"\.toml$"}, table]})
    }

    fn builtin(&self, reader: &mut Reader, builtin: &BuiltIn) -> Node {
        reader.document(&Source::file(builtin.file, builtin.text))
    }

    /// The content of a built-in or a file.
    fn by_name(&self, reader: &mut Reader, node: &Node, name: &str) -> Option<Node> {
        if let Some(builtin) = self.builtins.iter().find(|b| b.name == name) {
            return Some(self.builtin(reader, builtin));
        }
        if Path::new(name).extension().is_none_or(|e| e != "toml") {
            let mut allowed = self.allowed();
            if let Some(near) = nearest(name, &self.names()) {
                allowed += &format!("; did you mean \"{near}\"?");
            }
            reader.refuse(node, self.path, &allowed);
            return None;
        }
        let path = reader.base_dir.join(name);
        let shown = path.display().to_string();
        match file::read_toml(&path) {
            Ok(text) => Some(reader.document(&Source::file(&shown, &text))),
            Err(error) => {
                let message = format!(
                    "found {}, but {shown} {error}; allowed: {}",
                    node.origin.found(),
                    self.allowed()
                );
                reader.push(Problem::at(&node.origin, self.path, message));
                None
            }
        }
    }

    /// The table that `chosen` (or the default) names, so that an override can change a part of it. Its name gets the
    /// ending [`CHANGED`].
    pub(crate) fn written_out(
        &self,
        reader: &mut Reader,
        chosen: Option<&Node>,
        origin: &Origin,
    ) -> Option<Node> {
        let (name, node) = match chosen.map(|c| (c, &c.value)) {
            None => {
                let default = &self.builtins[0];
                (default.name, self.builtin(reader, default))
            }
            Some((node, Value::Text(name))) => (name.as_str(), self.by_name(reader, node, name)?),
            Some((node, _)) => match node.get("name").map(|n| &n.value) {
                Some(Value::Text(name)) => (name.as_str(), node.clone()),
                _ => return Some(node.clone()),
            },
        };
        let name = name.strip_suffix(CHANGED).unwrap_or(name);
        let mut entries: Vec<Entry> = node.entries().unwrap_or_default().to_vec();
        entries.retain(|e| e.key != "name");
        entries.push(Entry {
            key: "name".to_owned(),
            origin: origin.clone(),
            node: Node::text(origin, &format!("{name}{CHANGED}")),
        });
        Some(Node::table(&node.origin, entries))
    }
}

/// Ends the name of a part that an override has changed.
const CHANGED: &str = ", changed";

fn read_geometry(reader: &mut Reader, node: &Node, path: &str) -> Option<Geometry> {
    let mark = reader.mark();
    // Filled in key by key; only the stops have defaults.
    let mut geometry = Geometry {
        stop: PinStop::standard(),
        ..Geometry::a()
    };
    reader.table(GEOMETRY, node, path, &mut geometry);
    if reader.mark() != mark {
        return None;
    }
    if node.get(LINK_CG).is_none() {
        geometry.link_cg = mean_link_cgs(&geometry.axles, &geometry.carriers, &geometry.pins);
    }
    complete_outline(&mut geometry, node);
    if let Err((key, message)) = check(&geometry) {
        let at = node.find(key).unwrap_or(node);
        let message = format!("found {}, but {message}", at.origin.found());
        reader.push(Problem::at(&at.origin, &join(path, key), message).whole());
        return None;
    }
    Some(geometry)
}

/// Keys of the outline that are not given follow from the other keys.
fn complete_outline(geometry: &mut Geometry, node: &Node) {
    let derived = Outline::derived(&geometry.axles, geometry.body_cg);
    let outline = &mut geometry.outline;
    let is_given = |key: &str| node.find(&join(OUTLINE_PATH, key)).is_some();
    if !is_given(BODY_LOWER) {
        outline.body_lower = derived.body_lower;
    }
    if !is_given(BODY_UPPER) {
        outline.body_upper = derived.body_upper;
    }
    if !is_given(HALF_WIDTH) {
        outline.half_width = derived.half_width;
    }
}

/// The key at fault and why.
fn check(geometry: &Geometry) -> Result<(), (&'static str, String)> {
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
        return Err((OUTLINE_PATH, message.to_owned()));
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

fn read_masses(reader: &mut Reader, node: &Node, path: &str) -> Option<MassSet> {
    let mark = reader.mark();
    let mut masses = MassSet::caption();
    reader.table(MASSES, node, path, &mut masses);
    if let (true, Err(error)) = (reader.mark() == mark, masses.check()) {
        let message = error.to_string();
        reader.push(Problem::at(&node.origin, &join(path, error.entry), message).whole());
    }
    (reader.mark() == mark).then_some(masses)
}
