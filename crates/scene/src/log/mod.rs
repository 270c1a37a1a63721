//! Log descriptions: what is known of a recorded log beside its readings. Robot, nominal damping,
//! noise budget and estimators.
//!
//! | modules | job |
//! |---|---|
//! | `choice` | the result of reading a description |
//! | `keys`, `mapping`, `reading`, `imu` | declarations of its keys; columns and the readings that follow from them |
//! | `load` | from a file; as a file |

mod choice;
mod imu;
mod keys;
mod load;
mod mapping;
mod reading;

pub use choice::{EstimatorError, LogChoice};
pub use imu::{ImuChoice, InclinationSource};
pub(crate) use keys::LOG;
pub use keys::log_reference;
pub use mapping::{ChannelChoice, Mapping};
pub use reading::{READINGS, ReadingChoice, is_of_body};
