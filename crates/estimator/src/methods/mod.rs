//! The two methods: the paper's filters and those of `kalman`. Each turns the inputs of one instant
//! into an estimate.

mod kalman;
mod paper;
mod wheel;

pub(crate) use kalman::{Across, KalmanFilters, SideState, Step};
pub(crate) use paper::PaperFilters;
