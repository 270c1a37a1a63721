//! Log descriptions: what is known of a recorded log beside its readings. Robot, nominal damping, noise budget and
//! estimators.
//!
//! | modules | job |
//! |---|---|
//! | `choice` | the result of reading a description |
//! | `keys` | declarations of its keys |
//! | `load`, `write` | from a file; as a file |

mod choice;
mod keys;
mod load;
mod write;

pub use choice::{LogChoice, LogEstimator, NeedsContactAngles, UnknownEstimator};
