//! Recorded logs as a source of readings: Parquet, CSV and MCAP; folders of runs.
//! [`check`](mod@check) tells whether a log is what the estimators take it for.
//!
//! ```text
//! files -> rows of each channel -> Frames on one time -> SensorFrame -> (the loop of crate `run`)
//! ```
//!
//! | modules | job |
//! |---|---|
//! | `rows`, `csv_table`, `parquet_rows` | rows of a table, whatever its format |
//! | `mcap_events`, `messages`, `cdr` | topics of MCAP files; the ROS 2 messages in them |
//! | `stamp`, `iso8601`, `order` | time stamps and their order |
//! | `truth` | truth by the names of columns |
//! | `own_names`, `mapped`, `formula`, `channel` | which column is which reading, and in which unit |
//! | `survey`, `integral`, `frames` | rows of all channels, read and judged; speeds integrated; frames on one time |
//! | `place`, `bag`, `content`, `log` | from a path to a run; whether a log has what is needed |
//! | `export` | a run as a log for other tools: readings, forces, odometry |
//!
//! A log is read to its end for duration, rates, order of the time stamps, and cells that are no
//! numbers, so that a log that cannot be used is refused before anything is written. Its rows are
//! kept: ten minutes of all readings at 1 kHz take 80 MB.

mod bag;
mod bursts;
mod cdr;
mod channel;
pub mod check;
mod content;
mod csv_table;
mod error;
mod export;
mod formula;
mod frames;
mod held;
mod integral;
mod iso8601;
mod jitter;
mod log;
mod mapped;
mod mcap_events;
mod measured;
mod merged;
mod messages;
mod order;
mod own_names;
mod parquet_rows;
mod place;
mod rows;
mod stamp;
mod survey;
mod truth;
mod wrap;

pub use content::LogOptions;
pub use error::LogError;
pub use export::{ExportFormat, Exported, export};
pub use log::Log;
pub use place::{LogPlace, PlaceError};
pub use truth::columns as truth_columns;

pub(crate) use channel::{Channel, Channels, Rows, TableFormat};
pub(crate) use formula::{Formula, Source, Upward};
pub(crate) use frames::Frames;
pub(crate) use jitter::Jitter;
pub(crate) use mcap_events::Clock;
pub(crate) use rows::{AddRow, ColumnInfo, Place, Row, TimeColumn};
pub(crate) use stamp::{Stamp, TimeUnit};
