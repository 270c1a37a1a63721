//! Studies over anything: many runs of one base scene, on all cores or many machines, into one table of scores.
//!
//! A [`Sweep`] is a study file with its base scene; it knows the settings of every run by its index alone, so that any
//! process computes any run without asking another. [`compute`] computes the runs of one [`Shard`] on several threads. Each
//! finished run is one line of a journal in the sweep's folder: a process that is killed loses the runs in flight, and the
//! next one goes on. [`merge`] makes the dataset of one or several journals, in the order of the runs: the same bytes for
//! any number of threads, shards and interruptions.
//!
//! | modules | job |
//! |---|---|
//! | `plan`, `draw` | the settings of every run; drawn values |
//! | `sweep` | study file and base scene, checked; what identifies them |
//! | `single` | one run and its scores |
//! | `scores`, `columns` | columns of scores; all columns of the dataset |
//! | `journal`, `folder`, `files` | finished runs on disk; the folder of a sweep; files that are complete or not there |
//! | `compute` | the runs of a shard, on several threads |
//! | `dataset` | the dataset from journals |

mod columns;
mod compute;
mod dataset;
mod draw;
mod error;
mod files;
mod folder;
mod journal;
mod plan;
mod scores;
mod single;
mod sweep;

pub use compute::{Done, Job, Shard, Watch, compute};
pub use dataset::{merge, merge_shards};
pub use error::SweepError;
pub use folder::{DATASET, JOURNAL};
pub use journal::{Row, RunRecord};
pub use scores::ScoreColumn;
pub use sweep::{Identity, Sweep};
