//! Recorded logs as a source of readings: Parquet, CSV and MCAP; folders of runs. [`check`](mod@check) tells whether a log is what the
//! estimators take it for.
//!
//! ```text
//! files -> Rows of each channel -> Frames on one time -> SensorFrame -> (the loop of crate `run`)
//! ```
//!
//! | modules | job |
//! |---|---|
//! | `rows`, `csv_table`, `parquet_rows` | rows of a table, whatever its format |
//! | `mcap_events`, `messages`, `cdr` | topics of MCAP files; the ROS 2 messages in them |
//! | `stamp`, `order` | time stamps and their order |
//! | `readings`, `truth` | readings and truth by the names of columns |
//! | `own_names`, `mapped`, `formula`, `plan` | which column is which reading |
//! | `events`, `survey`, `kept`, `frames` | rows of all channels; a first reading, and its rows; frames on one time |
//! | `place`, `log`, `source` | from a path to a run |
//! | `export` | a run as a log for other tools |
//!
//! A log is read to its end for duration, rates, order of the time stamps, and cells that are no numbers, so that a log that
//! cannot be used is refused before anything is written. Its rows are kept, up to 128 MB; a longer log is read again.

mod cdr;
pub mod check;
mod csv_table;
mod error;
mod events;
mod export;
mod formula;
mod frames;
mod kept;
mod log;
mod mapped;
mod mcap_events;
mod messages;
mod order;
mod own_names;
mod parquet_rows;
mod place;
mod plan;
mod readings;
mod rows;
mod source;
mod stamp;
mod survey;
mod truth;

pub use error::LogError;
pub use export::{ExportFormat, Exported, export};
pub use log::{Log, LogOptions};
pub use place::{LogPlace, PlaceError};
pub use truth::is_column as is_truth_column;
