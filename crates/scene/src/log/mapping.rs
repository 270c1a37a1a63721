//! Which column of which channel is which reading: `[[channel]]`, `[reading.NAME]`, `[imu.LINK]`.

use crate::key::{Field, Key, Number, Words, quoted};
use crate::range::{above, at_least};
use crate::reader::{Reader, join};
use crate::source::{Entry, Node, Value};
use crate::units::{ANGLE, ANGULAR_RATE, Dimension, NONE, TIME, TORQUE};
use crate::write::value;
use std::f64::consts::TAU;

/// The columns of a log and the readings that follow from them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mapping {
    /// Name of the channel whose rows are the frames. `None` for the first.
    pub time_base: Option<String>,
    /// Readings that the log does not have.
    pub missing: Vec<String>,
    /// `[[channel]]`: tables or topics. Empty for the log's only table.
    pub channels: Vec<ChannelChoice>,
    /// `[reading.NAME]`
    pub readings: Vec<ReadingChoice>,
    /// `[imu.LINK]`
    pub imus: Vec<ImuChoice>,
}

/// A table or topic: rows with time stamps of one clock.
#[derive(Clone, Debug, PartialEq)]
pub struct ChannelChoice {
    /// Its name in this description.
    pub name: String,
    /// A file beside the log, or in its folder. Empty for the log itself.
    pub table: String,
    /// A topic of the log. Empty for a table.
    pub topic: String,
    /// The column of the time; for a topic `header` or `log`. Empty for the default.
    pub time: String,
    /// Index of the unit in [`TIME_UNITS`].
    time_unit: usize,
    /// Added to the time stamps, s.
    pub offset: f64,
}

/// Units of a time column: `s`, `ms`, `us`, `ns`.
const TIME_UNITS: Words = &["s", "ms", "us", "ns"];

/// A reading that is a number in a column.
#[derive(Clone, Debug, PartialEq)]
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
}

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

/// The readings of a frame, by the columns of the table `sensors`, and their dimensions.
pub const READINGS: [&str; 13] = [
    "wheel1_angle",
    "wheel1_motor_torque",
    "wheel1_contact_angle",
    "wheel2_angle",
    "wheel2_motor_torque",
    "wheel2_contact_angle",
    "wheel3_angle",
    "wheel3_motor_torque",
    "wheel3_contact_angle",
    "link1_inclination",
    "link1_rate",
    "link2_inclination",
    "link2_rate",
];

impl ChannelChoice {
    fn standard() -> Self {
        Self {
            name: String::new(),
            table: String::new(),
            topic: String::new(),
            time: String::new(),
            time_unit: 0,
            offset: 0.0,
        }
    }

    /// Units of the time column in a second.
    pub fn time_units_per_second(&self) -> u32 {
        [1, 1_000, 1_000_000, 1_000_000_000][self.time_unit]
    }
}

/// The top-level keys.
pub(super) const TIME_BASE: &str = "time_base";
pub(super) const MISSING: &str = "missing";
pub(super) const CHANNEL: &str = "channel";
pub(super) const READING: &str = "reading";
pub(super) const IMU: &str = "imu";

/// Any number that is not absurd.
const ANY: crate::range::Range = at_least(-1e12).at_most(1e12);

/// The keys of a channel.
pub(super) const CHANNEL_KEYS: &[Key<ChannelChoice>] = &[
    Key::<ChannelChoice>::text("name", |c| &mut c.name, "its name in this file").required(),
    Key::text(
        "table",
        |c| &mut c.table,
        "file beside the log or in its folder; without it the log itself",
    ),
    Key::text("topic", |c| &mut c.topic, "topic of an MCAP file"),
    Key::text(
        "time",
        |c| &mut c.time,
        "column of the time, `time` by default; of a topic the clock: `header` by default, or `log`",
    ),
    Key::word(
        "time_unit",
        TIME_UNITS,
        |c| c.time_unit,
        |c, i| c.time_unit = i,
        "unit of a time column of plain numbers",
    ),
    Key::number(
        "offset",
        TIME,
        ANY,
        |c| &mut c.offset,
        "added to the time stamps: of a clock that is slow, or minus the delay of the sensor",
    ),
];

/// The values of the keys of a reading.
struct ReadingKeys {
    channel: String,
    column: String,
    sign: usize,
    scale: f64,
    gear_ratio: f64,
    counts: f64,
    torque_constant: f64,
}

impl ReadingKeys {
    fn standard() -> Self {
        Self {
            channel: String::new(),
            column: String::new(),
            sign: 0,
            scale: 1.0,
            gear_ratio: 1.0,
            counts: 0.0,
            torque_constant: 0.0,
        }
    }
}

const SIGNS: Words = &["+", "-"];

const READING_KEYS: &[Key<ReadingKeys>] = &[
    Key::text(
        "channel",
        |r| &mut r.channel,
        "name of its channel; the first by default",
    ),
    Key::<ReadingKeys>::text(
        "column",
        |r| &mut r.column,
        "its column; of a topic NAME.position, NAME.effort of a joint",
    )
    .required(),
    Key::own(
        "unit",
        "SI",
        "of an angle rad, deg, turns, counts; of a torque N m, mN m, A, mA; of a rate rad/s, deg/s",
        "unit of the column",
    ),
    Key::word(
        "sign",
        SIGNS,
        |r| r.sign,
        |r, i| r.sign = i,
        "minus where the column counts backwards",
    ),
    Key::number(
        "scale",
        NONE,
        above(0.0).at_most(1e12),
        |r| &mut r.scale,
        "further factor",
    ),
    Key::number(
        "gear_ratio",
        NONE,
        above(0.0).at_most(1e6),
        |r| &mut r.gear_ratio,
        "turns of the motor in a turn of the wheel, where the column is of the motor: divides an angle, multiplies a torque",
    ),
    Key::number(
        "counts",
        NONE,
        at_least(0.0).at_most(1e12),
        |r| &mut r.counts,
        "counts in a turn; needed with unit = \"counts\"",
    ),
    Key::number(
        "torque_constant",
        NONE,
        at_least(0.0).at_most(1e6),
        |r| &mut r.torque_constant,
        "torque of the motor for a current, N m/A; needed with unit = \"A\" or \"mA\"",
    ),
    Key::own(
        "offset",
        "0",
        "a number, or a text with a unit",
        "value of the reading where it should be 0, in its SI unit: subtracted last",
    ),
];

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
        "three columns",
        "columns of the specific force: at rest the axis that points up reads +g; any unit",
    ),
    Key::own(
        "orientation",
        "orientation.x .y .z .w",
        "four columns",
        "columns of the orientation: quaternion from the sensor to a world whose z axis points up",
    ),
    Key::own(
        "angular_velocity",
        "angular_velocity.x .y .z",
        "three columns",
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

/// The rows of the keys of the mapping, as in [`super::reference`].
pub(super) fn keys() -> Vec<[String; 5]> {
    let mut all = rows("channel[]", CHANNEL_KEYS, &mut ChannelChoice::standard());
    all.extend(rows(
        "reading.NAME",
        READING_KEYS,
        &mut ReadingKeys::standard(),
    ));
    all.extend(rows("imu.LINK", IMU_KEYS, &mut ImuKeys::standard()));
    all
}

/// The rows of the keys of a table: key, SI unit, default, allowed values, meaning.
pub(super) fn rows<T>(path: &str, keys: &[Key<T>], defaults: &mut T) -> Vec<[String; 5]> {
    let mut row = |key: &Key<T>| {
        let default = match &key.field {
            _ if key.required => "required".to_owned(),
            Field::Own { default, .. } => (*default).to_owned(),
            field => value(field, defaults).unwrap_or_default(),
        };
        [
            join(path, key.name),
            key.field.unit().to_owned(),
            default.trim_matches('"').to_owned(),
            key.field.allowed_values(),
            key.meaning.to_owned(),
        ]
    };
    keys.iter().map(&mut row).collect()
}

/// Reads the mapping; `None` where the file has none.
pub(super) fn read(reader: &mut Reader, root: &Node) -> Option<Mapping> {
    let has = |key: &&str| root.get(key).is_some();
    let any = [TIME_BASE, MISSING, CHANNEL, READING, IMU].iter().any(has);
    if !any {
        return None;
    }
    let mapping = Mapping {
        time_base: root.get(TIME_BASE).and_then(|n| reader.text(n, TIME_BASE)),
        missing: missing(reader, root),
        channels: channels(reader, root),
        readings: readings(reader, root),
        imus: imus(reader, root),
    };
    check(reader, root, &mapping);
    Some(mapping)
}

fn missing(reader: &mut Reader, root: &Node) -> Vec<String> {
    let Some(node) = root.get(MISSING) else {
        return Vec::new();
    };
    let Value::Array(items) = &node.value else {
        reader.refuse(node, MISSING, "an array of names of readings");
        return Vec::new();
    };
    let mut names = Vec::new();
    for (i, item) in items.iter().enumerate() {
        if let Some(found) = reader.word(&READINGS, item, &format!("{MISSING}[{i}]")) {
            names.push(READINGS[found].to_owned());
        }
    }
    names
}

fn channels(reader: &mut Reader, root: &Node) -> Vec<ChannelChoice> {
    let Some(node) = root.get(CHANNEL) else {
        return Vec::new();
    };
    let Value::Array(items) = &node.value else {
        reader.refuse(node, CHANNEL, "an array of tables, each headed [[channel]]");
        return Vec::new();
    };
    let mut channels: Vec<ChannelChoice> = Vec::new();
    for (i, item) in items.iter().enumerate() {
        let path = format!("{CHANNEL}[{i}]");
        let mut channel = ChannelChoice::standard();
        reader.table(CHANNEL_KEYS, item, &path, &mut channel);
        if channels.iter().any(|c| c.name == channel.name) {
            let allowed = "a name that no other channel has";
            reader.refuse(
                item.get("name").unwrap_or(item),
                &join(&path, "name"),
                allowed,
            );
        }
        if let (Some(table), false) = (item.get("table"), channel.topic.is_empty()) {
            reader.refuse(table, &join(&path, "table"), "a table or a topic, not both");
        }
        channels.push(channel);
    }
    channels
}

fn readings(reader: &mut Reader, root: &Node) -> Vec<ReadingChoice> {
    let Some(node) = root.get(READING) else {
        return Vec::new();
    };
    let mut readings = Vec::new();
    for entry in reader.entries(node, READING) {
        match READINGS.iter().find(|name| **name == entry.key) {
            Some(name) => readings.push(reading(reader, name, entry)),
            None => reader.unknown(entry, READING, &READINGS),
        }
    }
    readings
}

/// Dimension of a reading, and its further units with their factors.
fn dimension(name: &str) -> (&'static Dimension, Words) {
    match name {
        name if name.ends_with("_motor_torque") => (TORQUE, &["N m", "mN m", "A", "mA"]),
        name if name.ends_with("_rate") => (ANGULAR_RATE, &["rad/s", "deg/s"]),
        _ => (ANGLE, &["rad", "deg", "turns", "counts"]),
    }
}

fn reading(reader: &mut Reader, name: &'static str, entry: &Entry) -> ReadingChoice {
    let (node, path) = (&entry.node, format!("{READING}.{name}"));
    let mut keys = ReadingKeys::standard();
    reader.table(READING_KEYS, node, &path, &mut keys);
    let (dimension, units) = dimension(name);
    let unit = node
        .get("unit")
        .and_then(|n| reader.word(units, n, &join(&path, "unit")));
    let unit = units[unit.unwrap_or(0)];
    let number = Number {
        unit: dimension,
        range: ANY,
    };
    let offset = node
        .get("offset")
        .and_then(|n| reader.number(&number, n, &join(&path, "offset")));
    let mut needs = |key: &str, value: f64, needed: bool| {
        if needed && value <= 0.0 {
            let at = node.get(key).or(node.get("unit")).unwrap_or(node);
            let allowed = format!("{key} above 0, which unit = \"{unit}\" needs");
            reader.refuse(at, &join(&path, key), &allowed);
        } else if !needed && let Some(found) = node.get(key) {
            let allowed = format!("no {key}: unit = \"{unit}\" does not need it");
            reader.refuse(found, &join(&path, key), &allowed);
        }
    };
    needs("counts", keys.counts, unit == "counts");
    needs("torque_constant", keys.torque_constant, unit.ends_with('A'));
    if unit.ends_with("/s")
        && let Some(found) = node.get("gear_ratio")
    {
        reader.refuse(
            found,
            &join(&path, "gear_ratio"),
            "no gear ratio: a link's rate has none",
        );
    }
    ReadingChoice {
        name,
        factor: factor(unit, &keys),
        offset: offset.unwrap_or(0.0),
        channel: keys.channel,
        column: keys.column,
    }
}

fn factor(unit: &str, keys: &ReadingKeys) -> f64 {
    let gear = keys.gear_ratio;
    let of_unit = match unit {
        "deg" => 1.0_f64.to_radians() / gear,
        "turns" => TAU / gear,
        "counts" => TAU / keys.counts / gear,
        "rad" => 1.0 / gear,
        "N m" => gear,
        "mN m" => gear / 1e3,
        "A" => keys.torque_constant * gear,
        "mA" => keys.torque_constant * gear / 1e3,
        "deg/s" => 1.0_f64.to_radians(),
        _ => 1.0,
    };
    let sign = if keys.sign == 1 { -1.0 } else { 1.0 };
    sign * keys.scale * of_unit
}

fn imus(reader: &mut Reader, root: &Node) -> Vec<ImuChoice> {
    const LINKS: [&str; 2] = ["link1", "link2"];
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

/// Every reading comes from one place, and every channel that is named exists.
fn check(reader: &mut Reader, root: &Node, mapping: &Mapping) {
    let of_imu = |name: &str| {
        let imu = mapping.imus.iter().find(|i| name.starts_with(i.link));
        imu.map(|imu| format!("{IMU}.{}", imu.link))
    };
    let mut without = Vec::new();
    for name in READINGS {
        let of_reading = mapping.readings.iter().any(|r| r.name == name);
        let places: Vec<String> = of_reading
            .then(|| format!("{READING}.{name}"))
            .into_iter()
            .chain(of_imu(name))
            .chain(
                mapping
                    .missing
                    .iter()
                    .any(|m| m == name)
                    .then(|| MISSING.to_owned()),
            )
            .collect();
        match places.as_slice() {
            [] => without.push(name),
            [_] => {}
            [first, ..] => {
                let node = root.find(first).unwrap_or(root);
                let message = format!(
                    "{name} is in {}, allowed: one of them",
                    places.join(" and ")
                );
                reader.complain(&node.origin, first, || message);
            }
        }
    }
    if !without.is_empty() {
        let message = format!(
            "no column for {}; allowed: [reading.NAME] or [imu.LINK] for each reading, or its name in `{MISSING}`",
            without.join(", ")
        );
        reader.push(crate::error::Problem::at(&root.origin, READING, message).whole());
    }
    let names: Vec<&str> = mapping.channels.iter().map(|c| c.name.as_str()).collect();
    let of_readings = mapping.readings.iter().map(|r| {
        (
            format!("{READING}.{}.{CHANNEL}", r.name),
            r.channel.as_str(),
        )
    });
    let of_imus = mapping
        .imus
        .iter()
        .map(|i| (format!("{IMU}.{}.{CHANNEL}", i.link), i.channel.as_str()));
    let base = mapping.time_base.as_deref().unwrap_or_default();
    let named = of_readings
        .chain(of_imus)
        .chain([(TIME_BASE.to_owned(), base)]);
    for (path, channel) in named.filter(|(_, channel)| !channel.is_empty()) {
        if !names.contains(&channel)
            && let Some(node) = root.find(&path)
        {
            let allowed = match names.is_empty() {
                true => "no channel: the file has no [[channel]]".to_owned(),
                false => quoted(&names),
            };
            reader.refuse(node, &path, &allowed);
        }
    }
}
