//! The two methods: the paper's filters and those of `best`. Each turns the inputs of one instant
//! into an estimate.

mod best;
mod paper;
mod wheel;

pub(crate) use best::BestFilters;
pub(crate) use paper::PaperFilters;
