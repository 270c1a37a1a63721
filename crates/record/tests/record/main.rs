//! Tables, summary, figures, page and texts of runs.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::float_cmp,
    reason = "a test that cannot go on has failed; exact copies are compared"
)]

mod clip;
mod columns;
mod comparison;
mod drawn;
mod figures;
mod ground;
mod page;
mod panel;
mod path;
mod quantile;
mod report;
mod runs;
mod strip;
mod summary;
mod table;
mod terrain;
mod testing;
mod trace;
