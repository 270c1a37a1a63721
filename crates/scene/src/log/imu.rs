//! `[imu.LINK]`: inclination and rate from an inertial measurement unit.

use super::reading::ByName;
use crate::form::{Array, Plain, array, word};
use crate::key::keys;
use crate::quantity::{ANGLE, ANGULAR_RATE, at_least, number};
use crate::reader::{Reader, join};
use crate::source::Node;
use crate::values::text;
use robhaz_model::named;
use std::f64::consts::PI;

/// An inertial measurement unit on a link.
#[derive(Clone, Debug, PartialEq)]
pub struct ImuChoice {
    /// `link1`, `link2` or `body`.
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

named! {
    /// What the inclination of a link follows from.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    pub enum InclinationSource {
        /// Direction of the specific force.
        Acceleration = "acceleration",
        /// Orientation.
        Orientation = "orientation",
    }
}

/// The axes of the sensor, as [`AXIS_NAMES`].
const AXES: [[f64; 3]; 6] = [
    [1.0, 0.0, 0.0],
    [-1.0, 0.0, 0.0],
    [0.0, 1.0, 0.0],
    [0.0, -1.0, 0.0],
    [0.0, 0.0, 1.0],
    [0.0, 0.0, -1.0],
];
const AXIS_NAMES: [&str; 6] = ["+x", "-x", "+y", "-y", "+z", "-z"];

fn axis_name([x, y, z]: [f64; 3]) -> &'static str {
    let mut along = [x, -x, y, -y, z, -z].into_iter();
    AXIS_NAMES[along.position(|part| part > 0.5).unwrap_or_default()]
}

const DEGREE: f64 = PI / 180.0;
const COLUMN: Plain<String> = text("a text");
const XYZ: Array<Plain<String>, [String; 3]> = array("three columns", COLUMN);

keys! {
    KEYS: ImuChoice;

    /// name of its channel; the first by default
    channel: text("a text") => channel;

    /// its axis that points forward in the nominal pose
    forward: word(&AXES, axis_name) => forward;

    /// its axis that points up in the nominal pose
    up: word(&AXES, axis_name) => up;

    /// what the inclination follows from: the direction of the specific force, or the orientation
    inclination: word(&InclinationSource::ALL, InclinationSource::name) => inclination;

    /// columns of the specific force: at rest the axis that points up reads +g; any unit
    acceleration ("linear_acceleration.x .y .z"): XYZ => acceleration;

    /// columns of the orientation: quaternion from the sensor to a world whose z axis points up
    orientation ("orientation.x .y .z .w"): array("four columns", COLUMN) => orientation;

    /// columns of the angular velocity
    angular_velocity ("angular_velocity.x .y .z"): XYZ => angular_velocity;

    /// unit of the angular velocity
    rate_unit: word(&[1.0, DEGREE], |unit| if unit < 1.0 { "deg/s" } else { "rad/s" })
        => rate_factor;

    /// inclination that the sensor shows in the nominal pose: subtracted
    inclination_offset: number(ANGLE, at_least(-3.2).at_most(3.2)) => inclination_offset;

    /// rate that the sensor shows at rest: subtracted
    rate_offset: number(ANGULAR_RATE, at_least(-1e2).at_most(1e2)) => rate_offset;
}

/// `[imu.LINK]`
pub(super) const IMUS: ByName<ImuChoice> = ByName {
    names: &["link1", "link2", "body"],
    placeholder: "LINK",
    keys: KEYS,
    start: ImuChoice::standard,
    check,
};

fn check(reader: &mut Reader, node: &Node, path: &str, imu: &mut ImuChoice) {
    let along: f64 = imu.forward.iter().zip(imu.up).map(|(a, b)| a * b).sum();
    if along.abs() > 0.5 {
        let at = node.get("up").or(node.get("forward")).unwrap_or(node);
        reader.refuse(at, &join(path, "up"), "another axis than forward");
    }
}

impl ImuChoice {
    /// As in ROS: x forward, z up.
    fn standard(link: &'static str) -> Self {
        let names = |start: &str| ["x", "y", "z"].map(|axis| format!("{start}.{axis}"));
        Self {
            link,
            channel: String::new(),
            forward: AXES[0],
            up: AXES[4],
            inclination: InclinationSource::Acceleration,
            acceleration: names("linear_acceleration"),
            orientation: ["x", "y", "z", "w"].map(|axis| format!("orientation.{axis}")),
            angular_velocity: names("angular_velocity"),
            rate_factor: 1.0,
            inclination_offset: 0.0,
            rate_offset: 0.0,
        }
    }
}
