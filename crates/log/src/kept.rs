//! Rows that the first reading of a log keeps, so that a log of usual length is read once.

use crate::error::LogError;
use crate::events::{Event, Events};
use crate::plan::{ChannelPlace, Plan};
use crate::rows::{Place, Row};
use crate::stamp::Stamp;

/// Most bytes that are kept: 10 minutes of all readings at 1 kHz take 86 MB. Longer logs are read again.
const MOST_BYTES: usize = 128_000_000;

/// Rows of one file in the order in which it gave them.
#[derive(Default)]
struct Rows {
    heads: Vec<Head>,
    /// The cells of one row after the other; not a number where a cell has none.
    cells: Vec<f64>,
    /// How many rows and cells have been given back.
    given: (usize, usize),
}

/// What a row has beside its cells.
#[derive(Clone, Copy)]
struct Head {
    channel: u32,
    place: Place,
    stamp: Stamp,
}

/// The rows of all channels of a log, kept while it is read for the first time and then given back: as the files give them, in
/// the same order.
pub struct Kept {
    /// Topics of a file share the first; each table has its own.
    files: Vec<Rows>,
    /// Index of each channel's file in `files`, and number of its columns.
    channels: Vec<(usize, usize)>,
    cut_off: Vec<Option<String>>,
    bytes: usize,
    most_bytes: usize,
}

impl Kept {
    /// No rows yet.
    pub fn new(plan: &Plan) -> Self {
        Self::at_most(MOST_BYTES, plan)
    }

    fn at_most(most_bytes: usize, plan: &Plan) -> Self {
        let mut files = vec![Rows::default()];
        let file = |place: &ChannelPlace| match place {
            ChannelPlace::Topic(_) => 0,
            ChannelPlace::Table(_) => {
                files.push(Rows::default());
                files.len() - 1
            }
        };
        let places = plan.channels.iter().map(|channel| &channel.place);
        let of_channels: Vec<usize> = places.map(file).collect();
        let columns = plan.channels.iter().map(|channel| channel.columns.len());
        Self {
            channels: of_channels.into_iter().zip(columns).collect(),
            files,
            cut_off: Vec::new(),
            bytes: 0,
            most_bytes,
        }
    }

    /// Adds a row, if there is room for it. Gives all memory back when there is none.
    pub fn add(&mut self, event: &Event) {
        if !self.is_whole() {
            return;
        }
        let row = &event.row;
        self.bytes += size_of::<Head>() + row.cells.len() * size_of::<f64>();
        let place = self.channels.get(event.channel);
        let rows = place.and_then(|(file, _)| self.files.get_mut(*file));
        let (Some(rows), Ok(channel)) = (rows, u32::try_from(event.channel)) else {
            self.bytes = usize::MAX;
            return;
        };
        rows.heads.push(Head {
            channel,
            place: row.place,
            stamp: row.stamp,
        });
        let cells = row.cells.iter();
        rows.cells
            .extend(cells.map(|cell| cell.unwrap_or(f64::NAN)));
        if !self.is_whole() {
            self.files.clear();
        }
    }

    fn is_whole(&self) -> bool {
        self.bytes <= self.most_bytes
    }

    /// The rows of the whole log, which `events` has given to the end. `None` if there was no room for all of them.
    pub fn at_end(mut self, events: &dyn Events) -> Option<Self> {
        let channels = 0..self.channels.len();
        self.cut_off = channels
            .map(|channel| events.cut_off(channel).map(str::to_owned))
            .collect();
        self.is_whole().then_some(self)
    }
}

impl Events for Kept {
    fn next_event(&mut self, wanted: usize) -> Result<Option<Event>, LogError> {
        let place = self.channels.get(wanted);
        let Some(rows) = place.and_then(|(file, _)| self.files.get_mut(*file)) else {
            return Ok(None);
        };
        let (row, cell) = rows.given;
        let Some(head) = rows.heads.get(row) else {
            return Ok(None);
        };
        let channel = head.channel as usize;
        let columns = self
            .channels
            .get(channel)
            .map_or(0, |(_, columns)| *columns);
        rows.given = (row + 1, cell + columns);
        let cells = rows.cells.iter().skip(cell).take(columns);
        Ok(Some(Event {
            channel,
            row: Row {
                place: head.place,
                stamp: head.stamp,
                cells: cells.map(|v| Some(*v).filter(|v| v.is_finite())).collect(),
            },
        }))
    }

    fn cut_off(&self, channel: usize) -> Option<&str> {
        self.cut_off.get(channel)?.as_deref()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mcap_events::{Clock, TopicPlace};
    use crate::plan::{ChannelPlan, TableFormat, TablePlace};
    use crate::rows::TimeColumn;
    use crate::stamp::TimeUnit;
    use std::path::PathBuf;

    /// A log of two topics and a table.
    fn plan() -> Plan {
        let topic = |topic: &str| {
            ChannelPlace::Topic(TopicPlace {
                path: PathBuf::from("log.mcap"),
                topic: topic.to_owned(),
                clock: Clock::Header,
            })
        };
        let table = ChannelPlace::Table(TablePlace {
            path: PathBuf::from("truth.csv"),
            format: TableFormat::Csv,
            time: TimeColumn {
                name: "time".to_owned(),
                unit: TimeUnit::SECOND,
            },
        });
        let places = [(topic("/joints"), 2), (topic("/imu"), 1), (table, 0)];
        let channel = |(place, columns): (ChannelPlace, usize)| ChannelPlan {
            name: String::new(),
            place,
            offset: 0.0,
            columns: vec![String::new(); columns],
            readings: Vec::new(),
            is_truth: false,
        };
        Plan {
            source: PathBuf::from("log.mcap"),
            channels: places.map(channel).into(),
            files: Vec::new(),
        }
    }

    fn event(channel: usize, at: u64, cells: &[Option<f64>]) -> Event {
        Event {
            channel,
            row: Row {
                place: Place::Message(at),
                stamp: Stamp::Nanoseconds(-7),
                cells: cells.to_vec(),
            },
        }
    }

    /// Equivalence: rows come back as they were, those of topics in the order of their file whichever is wanted, and the reason of
    /// an early end, too.
    #[test]
    fn rows_come_back_as_they_were_read() -> Result<(), LogError> {
        let topics = [
            event(0, 1, &[Some(1.5), None]),
            event(1, 1, &[Some(-0.0)]),
            event(0, 2, &[None, Some(f64::MAX)]),
        ];
        let rows = [event(2, 1, &[]), event(2, 2, &[])];
        let mut kept = Kept::new(&plan());
        topics.iter().chain(&rows).for_each(|e| kept.add(e));
        kept.cut_off = vec![None, Some("after message 1".to_owned()), None];
        let source = kept;
        let mut kept = Kept::new(&plan());
        topics.iter().chain(&rows).for_each(|e| kept.add(e));
        let mut kept = kept.at_end(&source).expect("room for five rows");
        for (wanted, expected) in [(2, &rows[0]), (1, &topics[0]), (1, &topics[1])] {
            assert_eq!(kept.next_event(wanted)?.as_ref(), Some(expected));
        }
        assert_eq!(kept.next_event(0)?.as_ref(), Some(&topics[2]));
        assert_eq!(kept.next_event(0)?, None);
        assert_eq!(kept.next_event(1)?, None);
        assert_eq!(kept.next_event(2)?.as_ref(), Some(&rows[1]));
        assert_eq!(kept.next_event(2)?, None);
        assert_eq!(kept.cut_off(1), Some("after message 1"));
        assert_eq!(kept.cut_off(0), None);
        Ok(())
    }

    /// Property: a log without room is not kept in part.
    #[test]
    fn a_long_log_is_not_kept() {
        let row = event(0, 1, &[Some(1.0), None]);
        let of_row = size_of::<Head>() + 16;
        for (rows, is_kept) in [(3, true), (4, false), (5, false)] {
            let mut kept = Kept::at_most(3 * of_row, &plan());
            (0..rows).for_each(|_| kept.add(&row));
            let source = Kept::new(&plan());
            assert_eq!(kept.at_end(&source).is_some(), is_kept, "{rows} rows");
        }
    }
}
