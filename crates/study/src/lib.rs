//! Many runs: a scene with many seeds, or a study file that varies anything; on all cores or many
//! machines, into one dataset and one report. How exact the estimators are, whether their stated
//! covariance is right, and what each step from the paper's estimator to `kalman` contributes.
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
//! | `plan` | the settings of every run, and which runs have one truth; drawn values |
//! | `single` | the truth of several runs; one run and its scores |
//! | `ablation` | the ladder of estimators |
//! | `journal`, `folder` | finished runs on disk; the folder of a study, files that are complete or not there, a part of the runs |
//! | `compute` | the runs of such a part, on several threads |
//! | `dataset`, `report` | the dataset of all journals with its columns; means, consistency and verdicts |
//! | `statistics` | means with standard errors; is a stated covariance right? |

mod ablation;
mod compute;
mod dataset;
mod error;
mod folder;
mod journal;
mod plan;
mod report;
mod single;
mod statistics;
mod study;

pub use ablation::ladder;
pub use compute::{Done, Watch, compute, compute_dataset};
pub use error::{Result, StudyError};
pub use folder::{DATASET, Shard};
pub use journal::{Row, RunRecord};
pub use plan::Plan;
pub use report::{Line, Report};
pub use single::TruthRun;
pub use statistics::{Consistency, CovarianceVerdict, Mean};
pub use study::{Identity, Study};
