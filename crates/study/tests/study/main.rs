//! Studies over many runs: they need the truth, the estimators and their scores.

mod driving;
mod friction_test;
mod no_angles;
mod path_verdict;
mod scale;
