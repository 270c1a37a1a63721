//! Many runs: a scene with many seeds, or a study file that varies anything; on all cores or many
//! machines, into one dataset and one report. How exact the estimators are, whether their stated
//! covariance is right, and what each step from the paper's estimator to `best` contributes.
//!
//! A [`Study`] knows the settings of every run by its index alone, so that any process computes any
//! run without asking another. [`compute`] computes the runs of one [`Shard`] on several threads.
//! Runs whose scenes differ in sensors and estimators alone have one truth, a [`TruthRun`]: it is
//! simulated once and observed anew by each. Each finished run is one line of a journal in the
//! study's folder: a process that is killed loses the runs in flight, and the next one goes on. The
//! dataset of all journals has the same bytes for any number of threads, shards and interruptions.
//! [`Report`] sums it up.
//!
//! | modules | job |
//! |---|---|
//! | `study` | study file and base scene, or scene and seeds, checked; what identifies them |
//! | `plan`, `draw` | the settings of every run, and which runs have one truth; drawn values |
//! | `truth_run`, `single` | the truth of several runs; one run and its scores |
//! | `ablation` | the ladder of estimators |
//! | `scores`, `columns` | columns of scores; all columns of the dataset |
//! | `journal`, `folder`, `files` | finished runs on disk; the folder of a study; files that are complete or not there |
//! | `shard`, `compute` | a part of the runs; its runs, on several threads |
//! | `dataset`, `report` | the dataset of all journals; means, consistency and verdicts |
//! | `statistics`, `consistency` | means with standard errors; is a stated covariance right? |

mod ablation;
mod columns;
mod compute;
mod consistency;
mod dataset;
mod draw;
mod error;
mod files;
mod folder;
mod journal;
mod plan;
mod report;
mod shard;
mod single;
mod statistics;
mod study;
mod truth_run;

pub use ablation::ladder;
pub use compute::{Done, Job, Watch, compute, compute_dataset};
pub use consistency::{Consistency, CovarianceVerdict};
pub use error::StudyError;
pub use folder::DATASET;
pub use journal::{Row, RunRecord};
pub use report::{Line, Report};
pub use shard::Shard;
pub use statistics::Mean;
pub use study::{Identity, Study};
pub use truth_run::TruthRun;
