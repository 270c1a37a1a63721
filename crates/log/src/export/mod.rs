//! A run or an estimate as a log that other tools open: MCAP with ROS 2 messages, or one CSV table.

use crate::error::LogError;
use crate::mapped;
use crate::messages::{
    FORCES, FORCES_DEFINITION, MessageKind, encode_imu, encode_joints, encode_numbers, nanoseconds,
};
use crate::own_names;
use crate::place::{LogPlace, no_table};
use crate::plan::{Plan, TableFormat, stem};
use crate::readings::{COUNT, Reading};
use crate::rows::Row;
use mcap::records::{MessageHeader, Metadata};
use mcap::{McapError, WriteOptions, Writer};
use robhaz_run::Stop;
use robhaz_scene::LogChoice;
use std::collections::BTreeMap;
use std::fs::File;
use std::io::{BufWriter, Write as _};
use std::path::{Path, PathBuf};

/// Start of the names of tables of estimates.
const ESTIMATE: &str = "estimate-";
/// What a table of forces may have of each wheel, in the order of the message. The first two are
/// required.
const FORCE_COLUMNS: [&str; NUMBERS / 3] = [
    "normal_force",
    "traction",
    "normal_force_sigma",
    "traction_sigma",
    "contact_angle",
    "needed_friction",
    "needed_friction_sigma",
];
/// Numbers of a message: those of one kind of all wheels, then those of the next.
const NUMBERS: usize = 21;

/// What a format holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ExportFormat {
    /// Topics of ROS 2 messages.
    Mcap,
    /// One table of text.
    Csv,
}

/// What was written.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Exported {
    /// Number of rows of readings.
    pub rows: u64,
    /// Topics, or tables whose columns were joined.
    pub parts: Vec<String>,
    /// What the user should know, one line each.
    pub warnings: Vec<String>,
}

/// Forces of the wheels: truth or one estimator.
struct Forces {
    /// `truth`, or the estimator's name.
    name: String,
    /// Its columns, and the place of each in the message.
    columns: Vec<String>,
    places: Vec<usize>,
    rows: Vec<Row>,
    /// The first row that is not earlier than the last row of readings.
    next: usize,
}

/// Writes the folder of a run or of an estimate into a file. MCAP gets the folder's description,
/// too: it reads back with its robot and its noise budget.
///
/// # Errors
///
/// [`LogError`]: a folder without readings, tables that cannot be read, a file that cannot be
/// written, a cause to `stop`.
pub fn export(
    place: &LogPlace,
    format: ExportFormat,
    out: &Path,
    stop: Stop<'_>,
) -> Result<Exported, LogError> {
    let folder = &place.path;
    let table = place.table.as_ref().ok_or_else(|| no_table(folder))?;
    let readings = Plan {
        source: folder.clone(),
        channels: vec![own_names::readings(table, &place.choice)?],
    };
    let both = readings.is_of_both();
    if both && format == ExportFormat::Mcap {
        let message =
            "is an estimate of both sides, for which there are no messages yet; allowed: --to csv";
        return Err(LogError::whole(folder, message));
    }
    let (mut forces, mut warnings) = (Vec::new(), Vec::new());
    for (name, (path, format)) in forces_in(folder)? {
        stop().map_or(Ok(()), |cause| Err(LogError::Stopped(cause)))?;
        match Forces::read(name, &path, format, both, &mut warnings) {
            Ok(table) => forces.push(table),
            Err(error) => warnings.push(format!("left out: {error}")),
        }
    }
    let mut exported = match format {
        ExportFormat::Mcap => {
            let version = env!("CARGO_PKG_VERSION");
            let description = place.is_described.then(|| place.choice.to_toml(version));
            write_mcap(&readings, &mut forces, description, out, stop)?
        }
        ExportFormat::Csv => {
            if place.choice.robot.robot != LogChoice::default().robot.robot {
                warnings.push(CSV_HAS_NO_ROBOT.to_owned());
            }
            write_csv(&readings, &mut forces, out, stop)?
        }
    };
    // Those of the forces first.
    exported.warnings.splice(0..0, warnings);
    Ok(exported)
}

/// What a table of text cannot hold.
const CSV_HAS_NO_ROBOT: &str = "a CSV file has no place for the robot: `check` and `estimate` take it for robot A without \
    --robot ROBOT.toml; --to mcap keeps it";

/// Readings of a row; not a number where one is missing.
type Numbers = [f64; COUNT];

/// Hands all rows of readings to `add`, until `stop` has a cause: time (s) and numbers. Returns what was written, under the
/// names of its `parts`.
fn read(
    readings: &Plan,
    parts: Vec<String>,
    stop: Stop<'_>,
    mut add: impl FnMut(f64, Numbers) -> Result<(), LogError>,
) -> Result<Exported, LogError> {
    let mut rows = 0;
    let why = readings.read(|channel, row| {
        stop().map_or(Ok(()), |cause| Err(LogError::Stopped(cause)))?;
        rows += 1;
        let values = readings.channels[channel].content(&row.cells).0;
        add(row.stamp.seconds(), values.map(|v| v.unwrap_or(f64::NAN)))
    })?;
    let why = why.iter().flatten();
    let warnings = why.map(|why| cut_off(&readings.channels[0].path, why));
    Ok(Exported {
        rows,
        parts,
        warnings: warnings.collect(),
    })
}

fn cut_off(path: &Path, why: &str) -> String {
    format!("{} is cut off at {why}", path.display())
}

/// The tables of forces in a folder, in order of their names: the truth and the estimates.
fn forces_in(folder: &Path) -> Result<BTreeMap<String, (PathBuf, TableFormat)>, LogError> {
    let mut found = BTreeMap::new();
    let entries = std::fs::read_dir(folder).map_err(LogError::io(folder))?;
    for entry in entries {
        let path = entry.map_err(LogError::io(folder))?.path();
        let stem = stem(&path);
        let name = match stem.strip_prefix(ESTIMATE) {
            Some(name) => name,
            None if stem == "truth" => "truth",
            None => continue,
        };
        // `estimate-kalman.parquet.partial` has another stem and no format.
        if let Some(format) = TableFormat::of(&path) {
            found.entry(name.to_owned()).or_insert((path, format));
        }
    }
    Ok(found)
}

impl Forces {
    /// Reads a table, so that a fault in its middle is found before anything is written.
    fn read(
        name: String,
        path: &Path,
        format: TableFormat,
        both: bool,
        warnings: &mut Vec<String>,
    ) -> Result<Self, LogError> {
        let found = format.columns(path)?;
        let (mut columns, mut places) = (Vec::new(), Vec::new());
        // Of both sides the table has the left wheels first; no message has it.
        let sides: &[&str] = if both { &["left_", "right_"] } else { &[""] };
        let numbers = sides
            .iter()
            .flat_map(|side| (0..NUMBERS).map(move |n| (side, n)));
        for (side, number) in numbers {
            let (part, wheel) = (number / 3, number % 3 + 1);
            let column = format!("{side}wheel{wheel}_{}", FORCE_COLUMNS[part]);
            if found.iter().any(|c| c.name == column) {
                columns.push(column);
                places.push(number);
            } else if part < 2 {
                return Err(LogError::whole(path, format!("has no column {column}")));
            }
        }
        let mut rows = Vec::new();
        let why = format.read(path, &mapped::time(None), &columns, &mut |row| {
            rows.push(row);
            Ok(())
        })?;
        warnings.extend(why.map(|why| cut_off(path, &why)));
        Ok(Self {
            name,
            columns,
            places,
            rows,
            next: 0,
        })
    }

    /// The cells of the row of a time (s), in the order of the columns; `None` where the table has
    /// none.
    fn at(&mut self, time: f64) -> Option<&[f64]> {
        // Times of one run are equal to the bit; those of its tables as text too.
        const SAME: f64 = 1e-9;
        let late = self.rows[self.next..].iter();
        self.next += late.take_while(|r| r.stamp.seconds() < time - SAME).count();
        let row = self.rows.get(self.next)?;
        (row.stamp.seconds() <= time + SAME).then_some(&row.cells)
    }

    /// The message of the row of a time, s.
    fn message(&mut self, time: f64) -> Option<Vec<u8>> {
        let cells = self.at(time)?.to_vec();
        let mut numbers = [f64::NAN; NUMBERS];
        for (place, cell) in self.places.iter().zip(cells) {
            numbers[*place] = cell;
        }
        Some(encode_numbers(time, &numbers))
    }

    fn topic(&self) -> String {
        match self.name.as_str() {
            "truth" => "/robhaz/truth".to_owned(),
            // ROS 2 allows letters, digits and `_` in the names of topics.
            name => format!("/robhaz/estimate/{}", name.replace('-', "_")),
        }
    }
}

/// Topics of an MCAP file being written.
struct Topics<'a> {
    path: &'a Path,
    writer: Writer<BufWriter<File>>,
    /// Number of each topic in the file, and of its messages.
    topics: Vec<(u16, u32)>,
}

impl Topics<'_> {
    fn failed(path: &Path) -> impl FnOnce(McapError) -> LogError + '_ {
        |error| match error {
            McapError::Io(cause) => LogError::write(path)(cause),
            other => LogError::write(path)(other),
        }
    }

    /// Adds a topic.
    fn add(&mut self, topic: &str, schema: &str, definition: &str) -> Result<(), LogError> {
        let failed = || Self::failed(self.path);
        let writer = &mut self.writer;
        let schema = writer.add_schema(schema, "ros2msg", definition.as_bytes());
        let schema = schema.map_err(failed())?;
        let channel = writer.add_channel(schema, topic, "cdr", &BTreeMap::new());
        self.topics.push((channel.map_err(failed())?, 0));
        Ok(())
    }

    /// Writes a message of a topic, by its place among those added, at a time, s.
    fn write(&mut self, topic: usize, time: f64, data: &[u8]) -> Result<(), LogError> {
        let at = nanoseconds(time);
        let (channel_id, count) = &mut self.topics[topic];
        let header = MessageHeader {
            channel_id: *channel_id,
            sequence: *count,
            log_time: at,
            publish_time: at,
        };
        *count += 1;
        let written = self.writer.write_to_known_channel(&header, data);
        written.map_err(Self::failed(self.path))
    }
}

fn write_mcap(
    readings: &Plan,
    forces: &mut [Forces],
    description: Option<String>,
    out: &Path,
    stop: Stop<'_>,
) -> Result<Exported, LogError> {
    let file = File::create(out).map_err(LogError::write(out))?;
    let options = WriteOptions::new()
        .profile("ros2")
        .library(concat!("robhaz ", env!("CARGO_PKG_VERSION")));
    let mut topics = Topics {
        path: out,
        writer: options
            .create(BufWriter::new(file))
            .map_err(Topics::failed(out))?,
        topics: Vec::new(),
    };
    if let Some(text) = description {
        let metadata = Metadata {
            name: own_names::METADATA.to_owned(),
            metadata: BTreeMap::from([(LogPlace::DESCRIPTION.to_owned(), text)]),
        };
        let written = topics.writer.write_metadata(&metadata);
        written.map_err(Topics::failed(out))?;
    }
    let sensors = [
        (own_names::TOPIC, MessageKind::Readings),
        ("/joint_states", MessageKind::JointState),
        ("/imu/link1", MessageKind::Imu),
        ("/imu/link2", MessageKind::Imu),
    ];
    for (topic, kind) in sensors {
        topics.add(topic, kind.name(), kind.definition())?;
    }
    let mut parts = sensors.map(|(topic, _)| topic.to_owned()).to_vec();
    for forces in &*forces {
        topics.add(&forces.topic(), FORCES, FORCES_DEFINITION)?;
        parts.push(forces.topic());
    }
    let mut last = None;
    let exported = read(readings, parts, stop, |time, now| {
        let messages = sensor_messages(time, &now, last.replace((time, now)));
        let of_forces = forces.iter_mut().map(|forces| forces.message(time));
        let mut all = messages.map(Some).into_iter().chain(of_forces).enumerate();
        all.try_for_each(|(topic, message)| match message {
            Some(message) => topics.write(topic, time, &message),
            None => Ok(()),
        })
    })?;
    topics.writer.finish().map_err(Topics::failed(out))?;
    let mut writer = topics.writer.into_inner();
    writer.flush().map_err(LogError::write(out))?;
    Ok(exported)
}

/// The messages of one frame: readings, joints, both IMUs. `last` is the frame before.
fn sensor_messages(time: f64, now: &Numbers, last: Option<(f64, Numbers)>) -> [Vec<u8>; 4] {
    let of_frame: Vec<f64> = Reading::of_frame().map(|r| now[r.index()]).collect();
    // As in `READINGS`: angle, torque and contact angle of each wheel, then inclination and rate of
    // each link.
    let of_wheels = |part: usize| [now[part], now[part + 3], now[part + 6]];
    let (position, torque) = (of_wheels(0), of_wheels(1));
    // No sensor measures the speed: it is the difference of the last two angles.
    let velocity = [0, 1, 2].map(|i| {
        last.map_or(f64::NAN, |(before, last)| {
            (position[i] - last[3 * i]) / (time - before)
        })
    });
    [
        encode_numbers(time, &of_frame),
        encode_joints(time, &[position, velocity, torque]),
        encode_imu(time, "link1", now[9], now[10]),
        encode_imu(time, "link2", now[11], now[12]),
    ]
}

fn write_csv(
    readings: &Plan,
    forces: &mut [Forces],
    out: &Path,
    stop: Stop<'_>,
) -> Result<Exported, LogError> {
    let file = File::create(out).map_err(LogError::write(out))?;
    let mut text = BufWriter::new(file);
    let mut names = vec!["time".to_owned()];
    let of_frame: Vec<Reading> = match readings.is_of_both() {
        true => readings
            .channels
            .iter()
            .flat_map(|c| &c.readings)
            .map(|(r, _)| *r)
            .collect(),
        false => Reading::of_frame().collect(),
    };
    names.extend(of_frame.iter().map(|r| r.name().to_owned()));
    let mut parts = vec!["readings".to_owned()];
    for forces in &*forces {
        let columns = forces.columns.iter();
        names.extend(columns.map(|column| format!("{}.{column}", forces.name)));
        parts.push(forces.name.clone());
    }
    writeln!(text, "{}", names.join(",")).map_err(LogError::write(out))?;
    let exported = read(readings, parts, stop, |time, values| {
        let readings = of_frame.iter().map(|r| values[r.index()]);
        let mut cells: Vec<f64> = std::iter::once(time).chain(readings).collect();
        for forces in &mut *forces {
            let none = vec![f64::NAN; forces.columns.len()];
            cells.extend_from_slice(forces.at(time).unwrap_or(&none));
        }
        // The shortest text that reads back as the same number; nothing where there is none.
        let text_of = |v: &f64| match v.is_nan() {
            true => String::new(),
            false => format!("{v:?}"),
        };
        let cells: Vec<String> = cells.iter().map(text_of).collect();
        writeln!(text, "{}", cells.join(",")).map_err(LogError::write(out))
    })?;
    text.flush().map_err(LogError::write(out))?;
    Ok(exported)
}
