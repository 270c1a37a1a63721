//! Topics of an MCAP file.

use crate::error::open_file;
use crate::messages::{Decoded, MessageKind, Number};
use crate::rows::finite;
use crate::{ColumnInfo, LogError, Place, Row, Stamp};
use mcap::McapError;
use mcap::records::{self, Record};
use mcap::sans_io::{LinearReadEvent, LinearReader, LinearReaderOptions};
use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::fs::File;
use std::io::Read as _;
use std::path::Path;

/// Largest record, bytes: a damaged file must not fill the memory.
const LARGEST_RECORD: usize = 1 << 28;
/// Bytes that are read at once.
const BLOCK: usize = 1 << 17;

/// Which clock the times of a topic are of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Clock {
    /// The stamp in the message.
    Header,
    /// When the recorder received the message.
    Log,
}

/// A message of a file.
struct Message<'a> {
    channel: u16,
    log_time: u64,
    data: &'a [u8],
}

impl<'a> Message<'a> {
    /// The message of a record: number of its channel, sequence, log time, publish time, data.
    /// Parsed here, since the general parser takes most of the time of a log.
    fn of(record: &'a [u8]) -> Option<Self> {
        let (channel, rest) = record.split_first_chunk()?;
        let (_sequence, rest) = rest.split_first_chunk::<4>()?;
        let (log_time, rest) = rest.split_first_chunk()?;
        let (_publish_time, data) = rest.split_first_chunk::<8>()?;
        Some(Self {
            channel: u16::from_le_bytes(*channel),
            log_time: u64::from_le_bytes(*log_time),
            data,
        })
    }
}

/// A channel of a file.
struct Topic {
    channel: records::Channel,
    /// Name of its schema.
    schema: String,
}

/// Channels by number.
type Topics = HashMap<u16, Topic>;

/// Messages of a file from its start to its end, also of one without an end.
struct Messages<'p> {
    path: &'p Path,
    file: File,
    reader: LinearReader,
    /// Schemas by number: name.
    schemas: HashMap<u16, String>,
    topics: Topics,
    /// Metadata so far: name and entries.
    metadata: HashMap<String, BTreeMap<String, String>>,
    cut_off: Option<String>,
    count: u64,
}

impl<'p> Messages<'p> {
    fn open(path: &'p Path) -> Result<Self, LogError> {
        let options = LinearReaderOptions::default()
            .with_record_length_limit(LARGEST_RECORD)
            .with_validate_chunk_crcs(true);
        Ok(Self {
            path,
            file: open_file(path)?,
            reader: LinearReader::new_with_options(options),
            schemas: HashMap::new(),
            topics: HashMap::new(),
            metadata: HashMap::new(),
            cut_off: None,
            count: 0,
        })
    }

    /// Hands the next message to `of`, with the topics so far. Whether there is one.
    fn next(
        &mut self,
        of: impl FnOnce(&Topics, Message<'_>) -> Result<(), LogError>,
    ) -> Result<bool, LogError> {
        while let Some(event) = self.reader.next_event() {
            let path = self.path;
            let damaged = |count: u64, error: McapError| {
                LogError::format(path, "MCAP", format!("{error}, after message {count}"))
            };
            let (opcode, data) = match event {
                Ok(LinearReadEvent::ReadRequest(size)) => {
                    let buffer = self.reader.insert(size.clamp(1, BLOCK));
                    let read = self.file.read(buffer).map_err(LogError::io(path))?;
                    self.reader.notify_read(read);
                    continue;
                }
                Ok(LinearReadEvent::Record { opcode, data }) => (opcode, data),
                Err(McapError::UnexpectedEof) => {
                    let count = self.count;
                    self.cut_off = Some(format!(
                        "after message {count}: the file has no end, its recording was killed"
                    ));
                    break;
                }
                Err(error) => return Err(damaged(self.count, error)),
            };
            if opcode == records::op::MESSAGE {
                self.count += 1;
                let message = Message::of(data);
                let message = message.ok_or_else(|| damaged(self.count, McapError::UnexpectedEof));
                return of(&self.topics, message?).map(|()| true);
            }
            let record = mcap::parse_record(opcode, data);
            match record.map_err(|error| damaged(self.count, error))? {
                Record::Schema { header, .. } => {
                    self.schemas.insert(header.id, header.name);
                }
                Record::Channel(channel) => {
                    let schema = self.schemas.get(&channel.schema_id).cloned();
                    let schema = schema.unwrap_or_default();
                    self.topics.insert(channel.id, Topic { channel, schema });
                }
                Record::Metadata(found) => {
                    self.metadata.insert(found.name, found.metadata);
                }
                _ => {}
            }
        }
        Ok(false)
    }
}

/// An entry of the metadata of a name, where the file has them before its first message.
///
/// # Errors
///
/// [`LogError`]: a file that cannot be read.
pub fn metadata(path: &Path, name: &str, entry: &str) -> Result<Option<String>, LogError> {
    let mut messages = Messages::open(path)?;
    messages.next(|_, _| Ok(()))?;
    let found = messages.metadata.get_mut(name);
    Ok(found.and_then(|entries| entries.remove(entry)))
}

/// The columns of a topic: those of the first messages, until all that are `wanted` were seen. The
/// messages of one topic can have different columns: joints of their own. Of a `frame` that is not empty those of its
/// messages alone.
///
/// # Errors
///
/// [`LogError`]: a topic or frame that the file does not have, messages of another kind, or with a wanted column twice.
pub fn columns(
    files: &[&Path],
    topic: &str,
    frame: &str,
    wanted: &[String],
) -> Result<Vec<ColumnInfo>, LogError> {
    let mut found: Option<Vec<String>> = None;
    let mut frames = BTreeSet::new();
    let mut topics = BTreeSet::new();
    let is_complete = |found: &Vec<String>| wanted.iter().all(|name| found.contains(name));
    for path in files {
        let mut messages = Messages::open(path)?;
        while !found.as_ref().is_some_and(is_complete) {
            let is_there = messages.next(|topics, message| {
                let of_topic = topics.get(&message.channel);
                let Some(of_topic) = of_topic.filter(|of| of.channel.topic == topic) else {
                    return Ok(());
                };
                let (_, own, numbers) = decode(path, of_topic, message.data)?;
                if !frame.is_empty() && own != frame {
                    frames.insert(format!("{own:?}"));
                    return Ok(());
                }
                let known = found.get_or_insert_default();
                for (i, number) in numbers.iter().enumerate() {
                    let name = number.column();
                    if wanted.contains(&name) && numbers[..i].iter().any(|n| n.is(&name)) {
                        let message = format!("a message has {name} twice, allowed: each joint once, by a name of its own");
                        return Err(LogError::place(path, format!("topic {topic}"), message));
                    }
                    if !known.contains(&name) {
                        known.push(name);
                    }
                }
                Ok(())
            })?;
            if !is_there {
                break;
            }
        }
        let of_file = messages.topics.values();
        topics.extend(of_file.map(|topic| format!("{} ({})", topic.channel.topic, topic.schema)));
    }
    if found.is_none() && !frames.is_empty() {
        let frames: Vec<String> = frames.into_iter().collect();
        let message = format!(
            "has no message with the frame_id {frame:?} of the topic {topic}, found: {}",
            frames.join(", ")
        );
        return Err(LogError::whole(files[0], message));
    }
    let Some(found) = found else {
        let known: Vec<String> = topics.into_iter().collect();
        let message = format!(
            "has no message of the topic {topic}; found the topics {}; state topics with --sensors SENSORS.toml (docs/logs.md)",
            known.join(", ")
        );
        return Err(LogError::whole(
            files.first().unwrap_or(&Path::new("")),
            message,
        ));
    };
    let column = |name| ColumnInfo {
        name,
        unit: None,
        is_time_stamp: false,
    };
    Ok(found.into_iter().map(column).collect())
}

fn decode<'a>(path: &Path, topic: &Topic, data: &'a [u8]) -> Result<Decoded<'a>, LogError> {
    /// First bytes of what zstd compressed.
    const ZSTD: [u8; 4] = [0x28, 0xb5, 0x2f, 0xfd];
    let place = format!("topic {}", topic.channel.topic);
    let refused = |message: String| LogError::place(path, place.clone(), message);
    let encoding = topic.channel.message_encoding.as_str();
    let advice = match encoding {
        "cdr" | "" => None,
        "ros1" => Some(
            "convert the bag of ROS 1 that it was made of: `pip install rosbags`, then `rosbags-convert --src BAG --dst FOLDER --dst-storage mcap`",
        ),
        _ => Some("record the topic with ROS 2, or write its numbers as a table (docs/logs.md)"),
    };
    if let Some(advice) = advice {
        let message = format!(
            "found messages in the encoding {encoding:?}, allowed: cdr, that of ROS 2; {advice}"
        );
        return Err(refused(message));
    }
    let mut kinds = MessageKind::ALL.into_iter();
    let Some(kind) = kinds.find(|kind| kind.name() == topic.schema) else {
        let allowed = MessageKind::ALL.map(MessageKind::name).join(", ");
        let message = format!(
            "found messages of the type {:?}, allowed: {allowed}",
            topic.schema
        );
        return Err(refused(message));
    };
    kind.decode(data).ok_or_else(|| {
        if data.starts_with(&ZSTD) {
            let message = "each message is compressed by itself (compression_mode MESSAGE), allowed: none, or chunks of the file; convert the bag: `ros2 bag convert -i FOLDER -o mcap.yaml`, \
             with mcap.yaml the lines `output_bags:`, `- uri: FOLDER_mcap`, `  storage_id: mcap`, `  all_topics: true`";
            return refused(message.to_owned());
        }
        refused(format!("found bytes that are no {} in CDR encoding", kind.name()))
    })
}

/// A channel of a topic while it is read.
pub struct Wanted<'a> {
    /// Its number.
    pub channel: usize,
    topic: &'a str,
    clock: Clock,
    /// Its messages have this `frame_id`; empty: any one.
    frame: &'a str,
    columns: &'a [String],
    /// The `frame_id` of the first message that had each.
    frames: Vec<Option<String>>,
    /// Messages so far.
    count: u64,
    /// Where the columns were in the last message: they hardly ever move.
    places: Vec<usize>,
}

/// Reads channels of the files of one log, each of a topic. Returns why a file ends before its end.
pub fn read(
    files: &[&Path],
    channels: &mut [Wanted<'_>],
    add: &mut impl FnMut(usize, Row) -> Result<(), LogError>,
) -> Result<Option<String>, LogError> {
    let mut cut_off = None;
    for path in files {
        let mut messages = Messages::open(path)?;
        let mut take = |topics: &Topics, message: Message<'_>| -> Result<(), LogError> {
            let Some(topic) = topics.get(&message.channel) else {
                return Ok(());
            };
            for wanted in channels
                .iter_mut()
                .filter(|w| w.topic == topic.channel.topic)
            {
                if let Some(row) = wanted.row(path, topic, &message)? {
                    add(wanted.channel, row)?;
                }
            }
            Ok(())
        };
        while messages.next(&mut take)? {}
        cut_off = cut_off.or(messages.cut_off);
    }
    Ok(cut_off)
}

impl<'a> Wanted<'a> {
    /// A channel before its first message.
    pub fn new(
        channel: usize,
        topic: &'a str,
        clock: Clock,
        frame: &'a str,
        columns: &'a [String],
    ) -> Self {
        Self {
            channel,
            topic,
            clock,
            frame,
            columns,
            frames: vec![None; columns.len()],
            count: 0,
            places: vec![0; columns.len()],
        }
    }

    /// The row of a message; `None` of one with other columns, or of another frame. A column with two frames is refused.
    fn row(
        &mut self,
        path: &Path,
        topic: &Topic,
        message: &Message<'_>,
    ) -> Result<Option<Row>, LogError> {
        let (stamp, frame, numbers) = decode(path, topic, message.data)?;
        self.count += 1;
        if !self.frame.is_empty() && frame != self.frame {
            return Ok(None);
        }
        let number = |(name, place): (&String, &mut usize)| {
            let is_it = |number: &&Number<'_>| number.is(name);
            if let Some(number) = numbers.get(*place).filter(is_it) {
                return Some(number);
            }
            *place = numbers.iter().position(|number| number.is(name))?;
            numbers.get(*place)
        };
        let columns = self.columns.iter().zip(&mut self.places);
        let found: Vec<_> = columns.map(number).collect();
        let columns = self.columns.iter().zip(&mut self.frames);
        for ((column, first), _) in columns.zip(&found).filter(|(_, number)| number.is_some()) {
            let first = first.get_or_insert_with(|| frame.to_owned());
            if first != frame {
                let message = format!(
                    "message {} has {column} with the frame_id {frame:?}, one before it with {first:?}: two publishers on one topic; allowed: one; state frame = {first:?} or {frame:?} in its [[channel]]",
                    self.count
                );
                return Err(LogError::place(
                    path,
                    format!("topic {}", self.topic),
                    message,
                ));
            }
        }
        let is_other = !found.is_empty() && found.iter().all(Option::is_none);
        let cell = |v: &Option<&Number<'_>>| v.map_or(f64::NAN, |v| finite(v.value));
        let log_time = i64::try_from(message.log_time).unwrap_or(i64::MAX);
        let row = Row {
            place: Place("message", self.count),
            stamp: match self.clock {
                Clock::Header => stamp,
                Clock::Log => Stamp::Nanoseconds(log_time),
            },
            cells: found.iter().map(cell).collect(),
        };
        Ok((!is_other).then_some(row))
    }
}
