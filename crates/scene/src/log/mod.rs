//! Log descriptions: what is known of a recorded log beside its readings. Robot, nominal damping,
//! noise budget and estimators.
//!
//! | modules | job |
//! |---|---|
//! | `choice` | the result of reading a description |
//! | `mapping`, `reading` | keys of channels, readings and IMUs: columns, and what follows from them |
//! | `load` | declarations of the other keys; from a file; as a file |

mod choice;
mod load;
mod mapping;
mod reading;

pub use choice::{EstimatorError, LogChoice, LogSides};
pub(crate) use load::LOG;
pub use load::log_reference;
pub use mapping::{ChannelChoice, Mapping};
pub use reading::{
    ImuChoice, InclinationSource, READINGS, ReadingChoice, World, is_of_body, is_of_both,
    is_optional, is_wheel_angle, unit_of,
};
