//! Which column of which channel is which reading: `[[channel]]`, `[reading.NAME]`, `[imu.LINK]`.

use super::imu::{self, ImuChoice};
use super::reading::{self, READINGS, ReadingChoice};
use super::rows::{ANY, rows};
use crate::json;
use crate::key::{Key, Words, quoted};
use crate::reader::{Reader, join};
use crate::source::{Node, Value};
use crate::units::TIME;

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
pub(super) use super::imu::IMU;
pub(super) use super::reading::READING;

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

/// The rows of the keys of the mapping, as in [`super::reference`].
pub(super) fn keys() -> Vec<[String; 5]> {
    let mut all = rows("channel[]", CHANNEL_KEYS, &mut ChannelChoice::standard());
    all.extend(reading::keys());
    all.extend(imu::keys());
    all
}

/// JSON Schema of a channel.
pub(super) fn channel() -> serde_json::Value {
    json::table(CHANNEL_KEYS, Some(&mut ChannelChoice::standard()))
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
        readings: reading::read(reader, root),
        imus: imu::read(reader, root),
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
