//! What a run leaves behind.
//!
//! | what | where | written by |
//! |---|---|---|
//! | tables of truth, readings and estimates | `truth`, `sensors`, `estimate-NAME`, `.parquet` or `.csv` | [`TableSink`] |
//! | how far each estimator was off | `summary.json` | [`SummarySink`], [`Summary`] |
//! | Figs. 5 to 8 of the paper | `fig5_linkage.svg`, `fig6_forces.svg`, ... | [`FigureSink`] |
//! | runs and estimators side by side | the terminal | [`comparison_table`] |
//!
//! Every column of every table is declared once, with its unit, in [`Table`]. Everything is in SI; the same run leaves the
//! same bytes, but for the summary, which tells how long the run took.

mod accuracy;
mod columns;
mod csv_table;
mod error;
mod figures;
mod parquet_table;
mod report;
mod summary;
mod table;
#[cfg(test)]
mod testing;

pub use columns::{Column, Kind, Table, Value};
pub use error::RecordError;
pub use figures::FigureSink;
pub use report::comparison_table;
pub use summary::{EstimatorSummary, ForceErrors, Summary, SummarySink};
pub use table::{TableFormat, TableSink};
