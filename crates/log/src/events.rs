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
pub trait Events {
    /// The next row of the `wanted` channel, or of another one that comes before it. `None`: the wanted channel has no
    /// more rows.
    ///
    /// # Errors
    /// [`LogError`]
    fn next_event(&mut self, wanted: usize) -> Result<Option<Event>, LogError>;

    /// Why a channel ends before its end. Known at its end.
    fn cut_off(&self, channel: usize) -> Option<&str>;
}

/// Channels with a table each.
pub struct Tables(pub Vec<Box<dyn Rows>>);

impl Events for Tables {
    fn next_event(&mut self, wanted: usize) -> Result<Option<Event>, LogError> {
        let Some(rows) = self.0.get_mut(wanted) else {
            return Ok(None);
        };
        let row = rows.next_row()?;
        Ok(row.map(|row| Event {
            channel: wanted,
            row,
        }))
    }

    fn cut_off(&self, channel: usize) -> Option<&str> {
        self.0.get(channel)?.cut_off()
    }
}
