//! Topics of an MCAP file.

use crate::error::LogError;
use crate::events::{Event, Events};
use crate::messages::{MessageKind, Number};
use crate::rows::{ColumnInfo, Place, Row};
use crate::stamp::{Stamp, TimeUnit};
use mcap::McapError;
use mcap::records::Record;
use mcap::sans_io::{LinearReadEvent, LinearReader, LinearReaderOptions};
use std::collections::HashMap;
use std::fs::File;
use std::io::Read as _;
use std::path::{Path, PathBuf};

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

/// A topic of a file.
#[derive(Clone, Debug, PartialEq)]
pub struct TopicPlace {
    /// The file.
    pub path: PathBuf,
    /// The topic.
    pub topic: String,
    /// Its time.
    pub clock: Clock,
}

/// A message of a file.
struct Message<'a> {
    channel: u16,
    log_time: u64,
    data: &'a [u8],
}

impl<'a> Message<'a> {
    /// The message of a record: number of its channel, sequence, log time, publish time, data. Parsed here, since the general
    /// parser takes most of the time of a log.
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

/// Messages of a file from its start to its end, also of one without an end.
struct Messages {
    path: PathBuf,
    file: File,
    reader: LinearReader,
    /// Schemas by number: name.
    schemas: HashMap<u16, String>,
    /// Channels by number: topic and name of the schema.
    topics: HashMap<u16, (String, String)>,
    cut_off: Option<String>,
    /// The last record.
    record: Vec<u8>,
    count: u64,
    ended: bool,
}

impl Messages {
    fn open(path: &Path) -> Result<Self, LogError> {
        let options = LinearReaderOptions::default().with_record_length_limit(LARGEST_RECORD);
        Ok(Self {
            path: path.to_path_buf(),
            file: File::open(path).map_err(LogError::io(path))?,
            reader: LinearReader::new_with_options(options),
            schemas: HashMap::new(),
            topics: HashMap::new(),
            cut_off: None,
            record: Vec::new(),
            count: 0,
            ended: false,
        })
    }

    /// Hands the next message to `of`; `None` at the end.
    fn next<T>(&mut self, of: impl FnOnce(&Self, Message<'_>) -> T) -> Result<Option<T>, LogError> {
        while !self.ended {
            let opcode = match self.reader.next_event() {
                None => break,
                Some(Ok(LinearReadEvent::ReadRequest(size))) => {
                    let buffer = self.reader.insert(size.clamp(1, BLOCK));
                    let read = self.file.read(buffer).map_err(LogError::io(&self.path))?;
                    self.reader.notify_read(read);
                    continue;
                }
                // Copied, because the topics are changed.
                Some(Ok(LinearReadEvent::Record { opcode, data })) => {
                    self.record.clear();
                    self.record.extend_from_slice(data);
                    opcode
                }
                Some(Err(McapError::UnexpectedEof)) => {
                    let count = self.count;
                    self.cut_off = Some(format!(
                        "after message {count}: the file has no end, its recording was killed"
                    ));
                    break;
                }
                Some(Err(error)) => return Err(self.damaged(&error)),
            };
            if opcode == mcap::records::op::MESSAGE {
                self.count += 1;
                let record = std::mem::take(&mut self.record);
                let message =
                    Message::of(&record).ok_or_else(|| self.damaged(&McapError::UnexpectedEof))?;
                let result = of(self, message);
                self.record = record;
                return Ok(Some(result));
            }
            let record = mcap::parse_record(opcode, &self.record);
            match record.map_err(|e| self.damaged(&e))? {
                Record::Schema { header, .. } => {
                    self.schemas.insert(header.id, header.name);
                }
                Record::Channel(channel) => {
                    let schema = self.schemas.get(&channel.schema_id).cloned();
                    let found = (channel.topic, schema.unwrap_or_default());
                    self.topics.insert(channel.id, found);
                }
                _ => {}
            }
        }
        self.ended = true;
        Ok(None)
    }

    fn damaged(&self, error: &McapError) -> LogError {
        LogError::Format {
            path: self.path.clone(),
            what: "MCAP",
            reason: format!("{error}, after message {}", self.count),
        }
    }
}

/// The columns of topics, each from its first message.
///
/// # Errors
/// [`LogError`]: topics that the file does not have, or with messages of another kind.
pub fn columns(path: &Path, topics: &[String]) -> Result<Vec<Vec<ColumnInfo>>, LogError> {
    let mut messages = Messages::open(path)?;
    let mut found: HashMap<String, Result<Vec<ColumnInfo>, LogError>> = HashMap::new();
    while topics.iter().any(|topic| !found.contains_key(topic)) {
        let next = messages.next(|messages, message| {
            let (topic, schema) = messages.topics.get(&message.channel)?;
            let wanted = topics.contains(topic) && !found.contains_key(topic);
            wanted.then(|| (topic.clone(), columns_of(path, topic, schema, message.data)))
        })?;
        match next {
            None => break,
            Some(Some((topic, columns))) => {
                found.insert(topic, columns);
            }
            Some(None) => {}
        }
    }
    let missing: Vec<&String> = topics.iter().filter(|t| !found.contains_key(*t)).collect();
    if let Some(topic) = missing.first() {
        let mut known: Vec<String> = messages
            .topics
            .values()
            .map(|(topic, schema)| format!("{topic} ({schema})"))
            .collect();
        known.sort();
        let message = format!(
            "has no message of the topic {topic}; found the topics {}; state topics with --sensors SENSORS.toml (docs/logs.md)",
            known.join(", ")
        );
        return Err(LogError::whole(path, message));
    }
    let of_topic = |topic: &String| found.remove(topic).unwrap_or_else(|| Ok(Vec::new()));
    topics.iter().map(of_topic).collect()
}

fn columns_of(
    path: &Path,
    topic: &str,
    schema: &str,
    data: &[u8],
) -> Result<Vec<ColumnInfo>, LogError> {
    let kind = kind(path, topic, schema)?;
    let decoded = kind
        .decode(data)
        .ok_or_else(|| not_of_kind(path, topic, kind))?;
    let column = |number: &Number<'_>| ColumnInfo {
        name: number.column(),
        unit: None,
    };
    Ok(decoded.numbers.iter().map(column).collect())
}

fn kind(path: &Path, topic: &str, schema: &str) -> Result<MessageKind, LogError> {
    MessageKind::of_schema(schema).ok_or_else(|| {
        let allowed: Vec<_> = MessageKind::ALL.iter().map(|kind| kind.schema()).collect();
        let message = format!(
            "found messages of the type {schema:?}, allowed: {}",
            allowed.join(", ")
        );
        LogError::place(path, format!("topic {topic}"), message)
    })
}

fn not_of_kind(path: &Path, topic: &str, kind: MessageKind) -> LogError {
    let message = format!("found bytes that are no {} in CDR encoding", kind.schema());
    LogError::place(path, format!("topic {topic}"), message)
}

/// A channel while it is read.
struct Wanted {
    place: TopicPlace,
    columns: Vec<String>,
    /// Messages so far.
    count: u64,
}

/// Channels of one file, a topic each.
pub struct McapEvents {
    messages: Messages,
    wanted: Vec<Wanted>,
}

impl McapEvents {
    /// Opens a file at its start for topics of it, each with its chosen columns.
    pub fn open(path: &Path, topics: Vec<(TopicPlace, Vec<String>)>) -> Result<Self, LogError> {
        let wanted = topics.into_iter().map(|(place, columns)| Wanted {
            place,
            columns,
            count: 0,
        });
        Ok(Self {
            messages: Messages::open(path)?,
            wanted: wanted.collect(),
        })
    }
}

impl Events for McapEvents {
    fn next_event(&mut self, _: usize) -> Result<Option<Event>, LogError> {
        let wanted = &mut self.wanted;
        loop {
            let next = self.messages.next(|messages, message| {
                let (topic, schema) = messages.topics.get(&message.channel)?;
                let channel = wanted.iter().position(|w| w.place.topic == *topic)?;
                let row = row(&mut wanted[channel], schema, &message);
                Some(row.map(|row| Event { channel, row }))
            })?;
            match next {
                None => return Ok(None),
                Some(Some(event)) => return event.map(Some),
                Some(None) => {}
            }
        }
    }

    fn cut_off(&self, _: usize) -> Option<&str> {
        self.messages.cut_off.as_deref()
    }
}

fn row(wanted: &mut Wanted, schema: &str, message: &Message<'_>) -> Result<Row, LogError> {
    let (path, topic) = (&wanted.place.path, &wanted.place.topic);
    let kind = kind(path, topic, schema)?;
    let decoded = kind.decode(message.data);
    let decoded = decoded.ok_or_else(|| not_of_kind(path, topic, kind))?;
    wanted.count += 1;
    let log_time = i64::try_from(message.log_time).unwrap_or(i64::MAX);
    let cell = |name: &String| {
        let found = decoded.numbers.iter().find(|number| number.is(name));
        found.map(|number| number.value).filter(|v| v.is_finite())
    };
    Ok(Row {
        place: Place::Message(wanted.count),
        stamp: match wanted.place.clock {
            Clock::Header => decoded.stamp,
            Clock::Log => TimeUnit::NANOSECOND
                .of_whole(log_time)
                .unwrap_or(Stamp::Nanoseconds(log_time)),
        },
        cells: wanted.columns.iter().map(cell).collect(),
    })
}
