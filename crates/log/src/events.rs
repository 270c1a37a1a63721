//! Rows of all channels of a log.

use crate::error::LogError;
use crate::rows::{Row, Rows};

/// A row of a channel.
#[derive(Clone, Debug, PartialEq)]
pub struct Event {
    /// Index of the channel.
    pub channel: usize,
    /// The row.
    pub row: Row,
}

/// Rows of all channels, of each in the order of its file.
pub trait Events: Send {
    /// The next row of the `wanted` channel, or of another one that comes before it. `None`: the wanted channel has no
    /// more rows.
    ///
    /// # Errors
    /// [`LogError`]
    fn next_event(&mut self, wanted: usize) -> Result<Option<Event>, LogError>;

    /// Why a channel ends before its end. Known at its end.
    fn cut_off(&self, channel: usize) -> Option<&str>;
}

/// Channels with a table each, and channels that share a file of topics.
pub struct Sources {
    /// The table of each channel; `None` for a topic.
    pub tables: Vec<Option<Box<dyn Rows>>>,
    /// The file of topics, and the channels of its topics.
    pub topics: Option<(Box<dyn Events>, Vec<usize>)>,
}

impl Events for Sources {
    fn next_event(&mut self, wanted: usize) -> Result<Option<Event>, LogError> {
        if let Some(Some(rows)) = self.tables.get_mut(wanted) {
            let row = rows.next_row()?;
            return Ok(row.map(|row| Event {
                channel: wanted,
                row,
            }));
        }
        let Some((events, channels)) = &mut self.topics else {
            return Ok(None);
        };
        let event = events.next_event(wanted)?;
        Ok(event.map(|event| Event {
            channel: channels[event.channel],
            ..event
        }))
    }

    fn cut_off(&self, channel: usize) -> Option<&str> {
        match self.tables.get(channel)? {
            Some(rows) => rows.cut_off(),
            None => self.topics.as_ref()?.0.cut_off(channel),
        }
    }
}
