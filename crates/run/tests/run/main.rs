//! The loop of a run and what it records.

mod clearance;
mod commands;
mod ground;
mod replay;
