//! `[imu.LINK]`: inclination and rate from an inertial measurement unit.

use super::rows::rows;
use crate::json;
use crate::key::{Form, Key, Words};
use crate::range::at_least;
use crate::reader::{Reader, join};
use crate::source::{Node, Value};
use crate::units::{ANGLE, ANGULAR_RATE};

/// Name of the section.
pub(super) const IMU: &str = "imu";

/// An inertial measurement unit on a link.
#[derive(Clone, Debug, PartialEq)]
pub struct ImuChoice {
    /// `link1` or `link2`.
    pub link: &'static str,
    /// Its channel. Empty for the first.
    pub channel: String,
    /// Its axis that points forward in the nominal pose, as a unit vector.
    pub forward: [f64; 3],
    /// Its axis that points up in the nominal pose, as a unit vector.
    pub up: [f64; 3],
    /// What the inclination follows from.
    pub inclination: InclinationSource,
    /// Columns of the specific force, x y z.
    pub acceleration: [String; 3],
    /// Columns of the orientation as a quaternion, x y z w.
    pub orientation: [String; 4],
    /// Columns of the angular velocity, x y z.
    pub angular_velocity: [String; 3],
    /// Factor from these columns to rad/s.
    pub rate_factor: f64,
    /// Subtracted from the inclination, rad.
    pub inclination_offset: f64,
    /// Subtracted from the rate, rad/s.
    pub rate_offset: f64,
}

/// What the inclination of a link follows from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum InclinationSource {
    /// Direction of the specific force.
    Acceleration,
    /// Orientation.
    Orientation,
}

/// The values of the keys of an IMU, as words.
struct ImuKeys {
    channel: String,
    forward: usize,
    up: usize,
    inclination: usize,
    rate_unit: usize,
    inclination_offset: f64,
    rate_offset: f64,
}

impl ImuKeys {
    /// As in ROS: x forward, z up.
    fn standard() -> Self {
        Self {
            channel: String::new(),
            forward: 0,
            up: 4,
            inclination: 0,
            rate_unit: 0,
            inclination_offset: 0.0,
            rate_offset: 0.0,
        }
    }
}

const THREE_COLUMNS: Form = Form {
    words: "three columns",
    schema: || json::array(json::text(), 3, 3),
};

const AXES: Words = &["+x", "-x", "+y", "-y", "+z", "-z"];
const RATE_UNITS: Words = &["rad/s", "deg/s"];

const IMU_KEYS: &[Key<ImuKeys>] = &[
    Key::text(
        "channel",
        |i| &mut i.channel,
        "name of its channel; the first by default",
    ),
    Key::word(
        "forward",
        AXES,
        |i| i.forward,
        |i, w| i.forward = w,
        "its axis that points forward in the nominal pose",
    ),
    Key::word(
        "up",
        AXES,
        |i| i.up,
        |i, w| i.up = w,
        "its axis that points up in the nominal pose",
    ),
    Key::word(
        "inclination",
        &["acceleration", "orientation"],
        |i| i.inclination,
        |i, w| i.inclination = w,
        "what the inclination follows from: the direction of the specific force, or the orientation",
    ),
    Key::own(
        "acceleration",
        "linear_acceleration.x .y .z",
        THREE_COLUMNS,
        "columns of the specific force: at rest the axis that points up reads +g; any unit",
    ),
    Key::own(
        "orientation",
        "orientation.x .y .z .w",
        Form {
            words: "four columns",
            schema: || json::array(json::text(), 4, 4),
        },
        "columns of the orientation: quaternion from the sensor to a world whose z axis points up",
    ),
    Key::own(
        "angular_velocity",
        "angular_velocity.x .y .z",
        THREE_COLUMNS,
        "columns of the angular velocity",
    ),
    Key::word(
        "rate_unit",
        RATE_UNITS,
        |i| i.rate_unit,
        |i, w| i.rate_unit = w,
        "unit of the angular velocity",
    ),
    Key::number(
        "inclination_offset",
        ANGLE,
        at_least(-3.2).at_most(3.2),
        |i| &mut i.inclination_offset,
        "inclination that the sensor shows in the nominal pose: subtracted",
    ),
    Key::number(
        "rate_offset",
        ANGULAR_RATE,
        at_least(-1e2).at_most(1e2),
        |i| &mut i.rate_offset,
        "rate that the sensor shows at rest: subtracted",
    ),
];

/// The rows of the keys, as in [`super::reference`].
pub(super) fn keys() -> Vec<[String; 5]> {
    rows("imu.LINK", IMU_KEYS, &mut ImuKeys::standard())
}

/// JSON Schema of a unit.
pub(super) fn schema() -> serde_json::Value {
    json::table(IMU_KEYS, Some(&mut ImuKeys::standard()))
}

/// The links that can carry one.
pub(super) const LINKS: [&str; 2] = ["link1", "link2"];

/// Reads the section.
pub(super) fn read(reader: &mut Reader, root: &Node) -> Vec<ImuChoice> {
    let Some(node) = root.get(IMU) else {
        return Vec::new();
    };
    let mut imus = Vec::new();
    for entry in reader.entries(node, IMU) {
        match LINKS.iter().find(|link| **link == entry.key) {
            Some(link) => imus.push(imu(reader, link, &entry.node)),
            None => reader.unknown(entry, IMU, &LINKS),
        }
    }
    imus
}

fn imu(reader: &mut Reader, link: &'static str, node: &Node) -> ImuChoice {
    let path = format!("{IMU}.{link}");
    let mut keys = ImuKeys::standard();
    reader.table(IMU_KEYS, node, &path, &mut keys);
    if keys.forward / 2 == keys.up / 2 {
        let at = node.get("up").or(node.get("forward")).unwrap_or(node);
        reader.refuse(at, &join(&path, "up"), "another axis than forward");
    }
    let names = |start: &str, axes: &[&str]| -> Vec<String> {
        axes.iter().map(|axis| format!("{start}.{axis}")).collect()
    };
    let xyz = ["x", "y", "z"];
    let standard = (
        names("linear_acceleration", &xyz),
        names("orientation", &["x", "y", "z", "w"]),
        names("angular_velocity", &xyz),
    );
    ImuChoice {
        link,
        forward: axis(keys.forward),
        up: axis(keys.up),
        inclination: match keys.inclination {
            0 => InclinationSource::Acceleration,
            _ => InclinationSource::Orientation,
        },
        acceleration: columns(reader, node, &path, "acceleration", standard.0),
        orientation: columns(reader, node, &path, "orientation", standard.1),
        angular_velocity: columns(reader, node, &path, "angular_velocity", standard.2),
        rate_factor: match keys.rate_unit {
            0 => 1.0,
            _ => 1.0_f64.to_radians(),
        },
        inclination_offset: keys.inclination_offset,
        rate_offset: keys.rate_offset,
        channel: keys.channel,
    }
}

/// Unit vector of an axis in [`AXES`].
fn axis(index: usize) -> [f64; 3] {
    let mut axis = [0.0; 3];
    axis[index / 2] = if index.is_multiple_of(2) { 1.0 } else { -1.0 };
    axis
}

/// The names of `N` columns, or the standard ones.
fn columns<const N: usize>(
    reader: &mut Reader,
    node: &Node,
    path: &str,
    key: &str,
    standard: Vec<String>,
) -> [String; N] {
    let path = join(path, key);
    let mut names = standard;
    if let Some(node) = node.get(key) {
        match &node.value {
            Value::Array(items) if items.len() == N => {
                let items = items.iter().enumerate();
                let texts: Vec<_> = items
                    .filter_map(|(i, item)| reader.text(item, &format!("{path}[{i}]")))
                    .collect();
                names = texts;
            }
            _ => reader.refuse(node, &path, &format!("the names of {N} columns")),
        }
    }
    let mut names = names.into_iter();
    // Fewer only after a problem.
    std::array::from_fn(|_| names.next().unwrap_or_default())
}
