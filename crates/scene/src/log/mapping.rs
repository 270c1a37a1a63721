//! Which column of which channel is which reading: `[[channel]]`, `[reading.NAME]`, `[imu.LINK]`.

use super::frame::{Reading, is_of_body, is_of_both};
use super::reading::{ANY, ImuChoice, ReadingChoice};
use robhaz_keys::prelude::*;
use std::fmt;

/// The columns of a log and the readings that follow from them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mapping {
    /// Name of the channel whose rows are the frames. `None` for the first.
    pub time_base: Option<String>,
    /// Readings that the log does not have.
    pub missing: Vec<&'static str>,
    /// `[[channel]]`: tables or topics. Empty for the log's only table.
    pub channels: Vec<ChannelChoice>,
    /// `[reading.NAME]`
    pub readings: Vec<ReadingChoice>,
    /// `[imu.LINK]`
    pub imus: Vec<ImuChoice>,
}

/// Where a key is stated, file and line, for messages: no part of what it states.
#[derive(Clone, Default)]
pub struct StatedAt(pub String);

impl StatedAt {
    /// The place of a key.
    pub(super) fn of(node: &Node) -> Self {
        let origin = &node.origin;
        Self(format!("{}:{}", origin.source.text.name(), origin.line()))
    }
}

impl PartialEq for StatedAt {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

impl fmt::Debug for StatedAt {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("-")
    }
}

/// A table or topic: rows with time stamps of one clock.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ChannelChoice {
    /// Its name in this description.
    pub name: String,
    /// A file beside the log, or in its folder. Empty for the log itself.
    pub table: String,
    /// Where that is stated.
    pub table_at: StatedAt,
    /// A topic of the log. Empty for a table.
    pub topic: String,
    /// The `frame_id` of its messages. Empty: any one.
    pub frame: String,
    /// The column of the time; for a topic `header` or `log`. Empty for the default.
    pub time: String,
    /// The column of the nanoseconds that are added to the whole seconds of `time`. Empty without one.
    pub nanoseconds: String,
    /// The unit of the time column, and how many of it a second has.
    pub time_unit: (&'static str, i64),
    /// Added to the time stamps, s.
    pub offset: f64,
}

/// Units of a time column, and how many of each a second has.
const TIME_UNITS: [(&str, i64); 4] = [
    ("s", 1),
    ("ms", 1_000),
    ("us", 1_000_000),
    ("ns", 1_000_000_000),
];

impl ChannelChoice {
    /// Name of the channel that states the clock of the table of the truth.
    pub const TRUTH: &str = "truth";
}

keys! {
    /// The keys of a channel.
    pub(super) CHANNEL_KEYS: ChannelChoice;

    /// its name in this file
    name (required): text("a text") => name;

    /// file beside the log or in its folder; without it the log itself
    table: text("a text") => table;

    /// topic of an MCAP file
    topic: text("a text") => topic;

    /// of a topic that several sensors share, the `frame_id` of the messages that count
    frame: text("a text") => frame;

    /// column of the time, `time` by default; of a topic the clock: `header` by default, or `log`
    time: text("a text") => time;

    /// column of whole nanoseconds, which are added to whole seconds in `time`; found by itself where the names end in
    /// sec and nanosec
    nanoseconds ("none"): text("a text") => nanoseconds;

    /// unit of a time column of plain numbers
    time_unit: word(&TIME_UNITS, |unit| unit.0) => time_unit;

    /// added to the time stamps: of a clock that is slow, or minus the delay of the sensor
    offset: number(TIME, ANY) => offset;
}

/// `[[channel]]`
pub(super) const CHANNELS: List<Table<ChannelChoice>> = List {
    item: section(CHANNEL_KEYS),
    words: "an array of tables, each headed [[channel]]",
    count: [0, 1000],
    start: || ChannelChoice {
        time_unit: TIME_UNITS[0],
        ..ChannelChoice::default()
    },
    check: |reader, node, path, channel, others| {
        if others.iter().any(|other| other.name == channel.name) {
            reader.refuse_key(node, path, "name", "a name that no other channel has");
        }
        if !channel.topic.is_empty() {
            reader.refuse_given(node, path, "table", "a table or a topic, not both");
        } else {
            reader.refuse_given(
                node,
                path,
                "frame",
                "the frame_id of messages, beside a topic",
            );
        }
        if channel.time_unit != TIME_UNITS[0] && !channel.nanoseconds.is_empty() {
            let allowed = "\"s\" beside nanoseconds, which are added to whole seconds";
            reader.refuse_given(node, path, "time_unit", allowed);
        }
    },
};

/// Whether the sensor of a reading's link has columns of their own for both of its readings.
fn is_without_use(mapping: &Mapping, reading: &str) -> bool {
    let link = reading.split('_').next().unwrap_or_default();
    ["inclination", "rate"].iter().all(|part| {
        let name = format!("{link}_{part}");
        mapping.readings.iter().any(|reading| reading.name == name)
    })
}

/// Every reading comes from one place, and every channel that is named exists.
pub(super) fn check(reader: &mut Reader, root: &Node, mapping: &Mapping) {
    let readings = mapping.readings.iter().map(|r| r.name);
    let named: Vec<&str> = readings
        .chain(mapping.imus.iter().map(|i| i.link))
        .collect();
    let both = named.iter().any(|name| is_of_both(name));
    check_kinds(reader, root, &named, both);
    check_readings(reader, root, mapping, &named, both);
    check_channels(reader, root, mapping);
}

/// Readings of one side and of both are not mixed, nor those of the links and of the body.
fn check_kinds(reader: &mut Reader, root: &Node, named: &[&str], both: bool) {
    let of_body = |is: bool| named.iter().any(|name| is_of_body(name) == Some(is));
    let is_of_wheel = |name: &&str| name.starts_with("wheel") || *name == "pin_angle";
    let message = if both && (named.iter().any(is_of_wheel) || of_body(false)) {
        "found readings of one side and of both, allowed: those of both have left_ and right_ in their names, and body_inclination, body_rate"
    } else if !both && of_body(true) && of_body(false) {
        "found readings of the links and of the body, allowed: those of the links, or body_inclination, body_rate and pin_angle"
    } else {
        return;
    };
    reader.push(Problem::at(&root.origin, "reading", message.to_owned()).whole());
}

/// Every reading that is needed comes from one place.
fn check_readings(reader: &mut Reader, root: &Node, mapping: &Mapping, named: &[&str], both: bool) {
    let of_body = named.iter().any(|name| is_of_body(name) == Some(true));
    // Steering is 0 where it is not read, and which coupling there is the robot says.
    let needed: Vec<Reading> = match both {
        true => Reading::of_whole()
            .filter(|r| !r.is_optional() && !r.is_of_coupling())
            .collect(),
        false => Reading::of_side(of_body).collect(),
    };
    let mut without = Vec::new();
    for reading in Reading::all().filter(|r| both || !r.is_of_both()) {
        let name = reading.name();
        let places = places(mapping, name, both);
        match &places[..] {
            [] if needed.contains(&reading) => without.push(name),
            [] | [_] => {}
            [first, ..] => {
                let places = places.join(" and ");
                let node = root.find(first).unwrap_or(root);
                let message = format!("{name} is in {places}, allowed: one of them");
                reader.complain(&node.origin, first, || message);
            }
        }
    }
    if !without.is_empty() {
        let message = format!(
            "no column for {}; allowed: [reading.NAME] or [imu.LINK] for each reading, or its name in `missing`",
            without.join(", ")
        );
        reader.push(Problem::at(&root.origin, "reading", message).whole());
    }
}

/// Where a reading is stated.
fn places(mapping: &Mapping, name: &str, both: bool) -> Vec<String> {
    let readings = mapping.readings.iter();
    let readings = readings.map(|r| (r.name == name, "reading", name));
    let imus = (mapping.imus.iter()).map(|i| (name.starts_with(i.link), "imu", i.link));
    let found = readings.chain(imus).filter(|(is_it, ..)| *is_it);
    let mut places: Vec<String> = found.map(|(_, table, of)| join(table, of)).collect();
    if mapping.missing.contains(&name) {
        places.push("missing".to_owned());
    }
    // A reading of its own stands in place of that of the sensor, whose parts may have topics of their own.
    let is_of_imu = places.get(1).is_some_and(|place| place.starts_with("imu."));
    let is_used = both || !is_without_use(mapping, name);
    if is_of_imu && places[0].starts_with("reading.") && is_used {
        places.remove(1);
    }
    places
}

/// Every channel that is named exists.
fn check_channels(reader: &mut Reader, root: &Node, mapping: &Mapping) {
    let names = mapping.channels.iter().map(|c| c.name.as_str());
    let names: Vec<&str> = names.filter(|name| *name != ChannelChoice::TRUTH).collect();
    if names.is_empty() && !mapping.channels.is_empty() {
        let message = "found that of the truth alone, allowed: one of the readings, too";
        let node = root.find("channel").unwrap_or(root);
        reader.push(Problem::at(&node.origin, "channel", message.to_owned()).whole());
    }
    let channel = |table: &str, of: &str, channel| (format!("{table}.{of}.channel"), channel);
    let readings = mapping.readings.iter();
    let readings = readings.map(|r| channel("reading", r.name, r.channel.as_str()));
    let imus = mapping.imus.iter();
    let imus = imus.flat_map(|i| {
        let rate = (
            format!("imu.{}.rate_channel", i.link),
            i.rate_channel.as_str(),
        );
        [channel("imu", i.link, i.channel.as_str()), rate]
    });
    let base = mapping.time_base.as_deref().unwrap_or_default();
    let named = readings.chain(imus).chain([("time_base".to_owned(), base)]);
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
