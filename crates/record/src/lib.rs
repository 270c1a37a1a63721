//! The files that a run writes: tables, summary, figures.
//!
//! | content | file | written by |
//! |---|---|---|
//! | tables of truth, readings and estimates | `truth`, `sensors`, `estimate-NAME`, `.parquet` or `.csv` | [`TableSink`] |
//! | the ground | `terrain`, `.parquet` or `.csv` | [`TableSink`] |
//! | the ground that an estimator has found | `ground-NAME`, `.parquet` or `.csv` | [`TableSink`] |
//! | all tables, in memory | none | [`TableSink::in_memory`] |
//! | all of it on one page | `report.html` | [`page`], of a study [`study_page`] |
//! | errors of each estimator | `summary.json` | [`SummarySink`], [`Summary`] |
//! | Figs. 5 to 8 of the paper, all estimators, the path | `fig5_linkage.svg`, ... | [`FigureSink`] |
//! | the dataset of a study, read back | `study.parquet` | [`Dataset`] |
//! | runs and estimators side by side | the terminal | [`comparison_table`], [`comparison_json`] |
//!
//! Every column of every table is declared once, with its unit, in [`Table`], and every score in
//! [`ScoreColumn`]. Everything is in SI; the same run leaves the same bytes, except for the
//! duration of the computation in the summary.

mod batch;
mod columns;
mod dataset;
mod error;
mod estimated_terrain;
pub mod figures;
mod grid;
mod log_lines;
mod page;
mod point_table;
mod report;
mod scores;
mod study_page;
mod summary;
mod table;
mod table_file;

pub use batch::{BatchBuilder, field, schema};
pub use columns::{Column, Kind, Table};
pub use dataset::Dataset;
pub use error::{RecordError, Result, create_folder, io_error, names_in};
pub use figures::FigureSink;
pub use grid::Grid;
pub use log_lines::{TimeLine, time_lines};
pub use page::page;
pub use point_table::{PointColumn, write_points};
pub use report::{comparison_json, comparison_table};
pub use scores::ScoreColumn;
pub use study_page::study_page;
pub use summary::{
    BothSummary, BrokenOff, EstimatorSummary, FrictionSummary, FrictionTestSummary, MeanForces,
    NominalRobot, SensorErrors, Summary, SummarySink,
};
pub use table::TableSink;
pub use table_file::{GROUP_ROWS, TableFile, TableFormat};
