//! `[reading.NAME]`: readings that are numbers in a column; `[imu.LINK]`: inclination and rate from
//! an inertial measurement unit.

use super::frame::{READINGS, Reading};
use robhaz_keys::prelude::*;
use robhaz_model::named;
use serde_json::{Value as Json, json};
use std::f64::consts::{PI, TAU};

/// Any number that is not absurd.
pub(super) const ANY: Range = at_least(-1e12).at_most(1e12);

/// Tables by the names of what they describe.
pub(super) struct ByName<C: 'static> {
    pub names: &'static [&'static str],
    /// Stands for a name in tables of keys.
    pub placeholder: &'static str,
    pub keys: &'static [Key<C>],
    /// What has a name, before its keys are read.
    pub start: fn(&'static str) -> C,
    /// Checks and completes it.
    pub check: fn(&mut Reader, &Node, &str, &mut C),
}

impl<C> Form for ByName<C> {
    type Value = Vec<C>;

    fn read(&self, reader: &mut Reader, node: &Node, path: &str, into: &mut Vec<C>) {
        for entry in reader.entries(node, path) {
            match self.names.iter().find(|name| **name == entry.key) {
                Some(name) => {
                    let (path, mut value) = (join(path, name), (self.start)(name));
                    reader.table(self.keys, &entry.node, &path, &mut value);
                    (self.check)(reader, &entry.node, &path, &mut value);
                    into.push(value);
                }
                None => reader.unknown(entry, path, self.names),
            }
        }
    }

    fn schema(&self, _defaults: Option<&mut Vec<C>>) -> Json {
        let table = key::schema(self.keys, Some(&mut (self.start)("")));
        let table = |name: &&str| ((*name).to_owned(), table.clone());
        object(self.names.iter().map(table).collect(), &[])
    }

    fn rows(&self, rows: &mut Vec<KeyReference>, path: &str, _value: &mut Vec<C>) {
        let path = join(path, self.placeholder);
        key::rows(rows, self.keys, &path, &mut (self.start)(""));
    }
}

/// A reading that is a number in a column.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ReadingChoice {
    /// The reading.
    pub name: &'static str,
    /// Its channel. Empty for the first.
    pub channel: String,
    /// Its column.
    pub column: String,
    /// Factor from the column to the reading in SI.
    pub factor: f64,
    /// Subtracted after that, SI.
    pub offset: f64,
    /// The unit of its column, as the description states it.
    pub unit: &'static str,
    /// Further factor.
    pub scale: f64,
    /// Counts in a turn, of unit counts.
    pub counts: f64,
    // The values of its keys.
    sign: f64,
    gear_ratio: f64,
    torque_constant: f64,
    /// Range after which its column starts anew, in the column's unit; 0 if it does not.
    pub wrap: f64,
    /// Unit and offset, whose allowed values depend on the reading.
    of_reading: (),
}

impl ReadingChoice {
    /// The reading of its name.
    pub fn reading(&self) -> Reading {
        Reading::named(self.name).unwrap_or_default()
    }
}

keys! {
    READING_KEYS: ReadingChoice;

    /// name of its channel; the first by default
    channel: text("a text") => channel;

    /// its column; of a topic NAME.position, NAME.effort of a joint
    column (required): text("a text") => column;

    /// unit of the column
    unit ("SI"): dependent(
        "of an angle rad, deg, turns, counts, of a wheel also rad/s, deg/s, rpm: a speed, which is integrated; of a torque N m, mN m, A, mA; of a rate rad/s, deg/s",
        || json!({"enum": [
            "rad", "deg", "turns", "counts", "N m", "mN m", "A", "mA", "rad/s", "deg/s", "rpm",
        ]}),
    ) => of_reading;

    /// minus where the column counts backwards
    sign: word(&[1.0, -1.0], |sign| if sign < 0.0 { "-" } else { "+" }) => sign;

    /// further factor
    scale: number(NONE, above(0.0).at_most(1e12)) => scale;

    /// of a wheel's angle and motor torque only, where the column is of the motor: turns of the
    /// motor in a turn of the wheel; divides an angle, multiplies a torque
    gear_ratio: number(NONE, above(0.0).at_most(1e6)) => gear_ratio;

    /// counts in a turn; needed with unit = "counts"
    counts: number(NONE, at_least(0.0).at_most(1e12)) => counts;

    /// torque of the motor for a current, N m/A; needed with unit = "A" or "mA"
    torque_constant: number(NONE, at_least(0.0).at_most(1e6)) => torque_constant;

    /// of a wheel's angle only: range after which the column starts anew, in its unit, such as 65536
    /// counts or 360 deg; 0 of a column that goes on
    wrap: number(NONE, at_least(0.0).at_most(1e12)) => wrap;

    /// value of the reading where it should be 0, in its SI unit: subtracted last
    offset ("0"): dependent("a number, or a text with a unit", || {
        let units = [ANGLE, TORQUE, ANGULAR_RATE].map(with_unit);
        json!({"anyOf": [{"type": "number"}, {"anyOf": units}]})
    }) => of_reading;
}

/// `[reading.NAME]`
pub(super) const READING: ByName<ReadingChoice> = ByName {
    names: READINGS,
    placeholder: "NAME",
    keys: READING_KEYS,
    start: |name| ReadingChoice {
        name,
        factor: 1.0,
        scale: 1.0,
        sign: 1.0,
        gear_ratio: 1.0,
        ..ReadingChoice::default()
    },
    check,
};

fn check(reader: &mut Reader, node: &Node, path: &str, reading: &mut ReadingChoice) {
    let of = reading.reading();
    let (dimension, units) = of.dimension();
    let unit = node.get("unit");
    let unit = unit.and_then(|n| reader.word(units, n, &join(path, "unit")));
    let unit = units[unit.unwrap_or(0)];
    let number = number(dimension, ANY);
    let offset = node.get("offset");
    let offset = offset.and_then(|n| reader.number(&number, n, &join(path, "offset")));
    let mut needs = |key: &str, value: f64, needed: bool| {
        if needed && value <= 0.0 {
            let (at, path, allowed) = match (node.get(key), node.get("unit")) {
                (None, Some(unit)) => (
                    unit,
                    join(path, "unit"),
                    format!("with the key {key} above 0 beside it, which is missing"),
                ),
                (at, _) => (
                    at.unwrap_or(node),
                    join(path, key),
                    format!("{key} above 0, which unit = \"{unit}\" needs"),
                ),
            };
            reader.refuse(at, &path, &allowed);
        } else if !needed {
            let allowed = format!("no {key}: unit = \"{unit}\" does not need it");
            reader.refuse_given(node, path, key, &allowed);
        }
    };
    needs("counts", reading.counts, unit == "counts");
    let is_current = unit.ends_with('A');
    needs("torque_constant", reading.torque_constant, is_current);
    if !of.is_wheel_angle() && !of.is_torque() {
        let allowed = "gear_ratio of a wheel's angle or motor torque only: a gear has no part in other readings";
        reader.refuse_given(node, path, "gear_ratio", allowed);
    }
    let is_speed = ["rad/s", "deg/s", "rpm"].contains(&unit);
    if !of.is_wheel_angle() || is_speed {
        let allowed = "wrap of a wheel's angle only: other readings and speeds do not start anew";
        reader.refuse_given(node, path, "wrap", allowed);
    }
    reading.unit = unit;
    reading.factor = factor(unit, reading);
    reading.offset = offset.unwrap_or(0.0);
}

fn factor(unit: &str, keys: &ReadingChoice) -> f64 {
    let gear = keys.gear_ratio;
    let of_unit = match unit {
        "deg" | "deg/s" => 1.0_f64.to_radians() / gear,
        "turns" => TAU / gear,
        "counts" => TAU / keys.counts / gear,
        "rad" | "rad/s" => 1.0 / gear,
        "N m" => gear,
        "mN m" => gear / 1e3,
        "A" => keys.torque_constant * gear,
        "mA" => keys.torque_constant * gear / 1e3,
        "rpm" => TAU / 60.0 / gear,
        _ => 1.0,
    };
    keys.sign * keys.scale * of_unit
}

/// An inertial measurement unit on a link.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ImuChoice {
    /// `link1`, `link2` or `body`.
    pub link: &'static str,
    /// Its channel. Empty for the first.
    pub channel: String,
    /// The channel of its angular velocity. Empty for `channel`.
    pub rate_channel: String,
    /// Its axis that points forward in the nominal pose, as a unit vector.
    pub forward: [f64; 3],
    /// Its axis that points up in the nominal pose, as a unit vector.
    pub up: [f64; 3],
    /// What the inclination follows from.
    pub inclination: InclinationSource,
    /// The world of the orientation.
    pub world: World,
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
    /// Of a log of both sides: subtracted from the roll, rad.
    pub roll_offset: f64,
    /// Of a log of both sides: subtracted from the rate of roll, rad/s.
    pub roll_rate_offset: f64,
    /// Of a log of both sides: subtracted from the rate of yaw, rad/s.
    pub yaw_rate_offset: f64,
}

named! {
    /// What the inclination of a link follows from.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
    pub enum InclinationSource {
        /// Direction of the specific force.
        #[default]
        Acceleration = "acceleration",
        /// Orientation.
        Orientation = "orientation",
    }
}

named! {
    /// The world of an orientation.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
    pub enum World {
        /// Its z axis points up: east, north, up, as in ROS.
        #[default]
        Enu = "ENU",
        /// Its z axis points down: north, east, down, as in aviation.
        Ned = "NED",
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
    IMU_KEYS: ImuChoice;

    /// name of its channel; the first by default
    channel: text("a text") => channel;

    /// its axis that points forward in the nominal pose
    forward: word(&AXES, axis_name) => forward;

    /// its axis that points up in the nominal pose; -z by default with world = "NED", whose bodies have z down
    up: word(&AXES, axis_name) => up;

    /// what the inclination follows from: the direction of the specific force, or the orientation
    inclination: word(&InclinationSource::ALL, InclinationSource::name) => inclination;

    /// world of the orientation: its z axis points up (ENU, as in ROS) or down (NED)
    world: word(&World::ALL, World::name) => world;

    /// columns of the specific force: at rest the axis that points up reads +g; any unit
    acceleration ("linear_acceleration.x .y .z"): XYZ => acceleration;

    /// columns of the orientation: quaternion from the sensor to the world
    orientation ("orientation.x .y .z .w"): array("four columns", COLUMN) => orientation;

    /// columns of the angular velocity
    angular_velocity ("angular_velocity.x .y .z"): XYZ => angular_velocity;

    /// name of the channel of the angular velocity, where gyroscope and accelerometer have topics of their own
    rate_channel ("that of channel"): text("a text") => rate_channel;

    /// unit of the angular velocity
    rate_unit: word(&[1.0, DEGREE], |unit| if unit < 1.0 { "deg/s" } else { "rad/s" })
        => rate_factor;

    /// inclination that the sensor shows in the nominal pose: subtracted
    inclination_offset: number(ANGLE, at_least(-3.2).at_most(3.2)) => inclination_offset;

    /// rate that the sensor shows at rest: subtracted
    rate_offset: number(ANGULAR_RATE, at_least(-1e2).at_most(1e2)) => rate_offset;

    /// of logs of both sides: roll that the sensor shows in the nominal pose: subtracted
    roll_offset: number(ANGLE, at_least(-3.2).at_most(3.2)) => roll_offset;

    /// of logs of both sides: rate of roll that the sensor shows at rest: subtracted
    roll_rate_offset: number(ANGULAR_RATE, at_least(-1e2).at_most(1e2)) => roll_rate_offset;

    /// of logs of both sides: rate of yaw that the sensor shows at rest: subtracted
    yaw_rate_offset: number(ANGULAR_RATE, at_least(-1e2).at_most(1e2)) => yaw_rate_offset;
}

/// `[imu.LINK]`
pub(super) const IMUS: ByName<ImuChoice> = ByName {
    names: &["link1", "link2", "body"],
    placeholder: "LINK",
    keys: IMU_KEYS,
    start: ImuChoice::standard,
    check: check_imu,
};

fn check_imu(reader: &mut Reader, node: &Node, path: &str, imu: &mut ImuChoice) {
    if imu.world == World::Ned && node.get("up").is_none() {
        imu.up = AXES[5];
    }
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
            forward: AXES[0],
            up: AXES[4],
            acceleration: names("linear_acceleration"),
            orientation: ["x", "y", "z", "w"].map(|axis| format!("orientation.{axis}")),
            angular_velocity: names("angular_velocity"),
            rate_factor: 1.0,
            ..Self::default()
        }
    }
}
