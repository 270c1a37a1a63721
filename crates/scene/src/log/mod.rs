//! Log descriptions: what is known of a recorded log beside its readings. Robot, nominal damping,
//! noise budget and estimators.
//!
//! | modules | job |
//! |---|---|
//! | `choice` | the result of reading a description |
//! | `mapping`, `reading` | keys of channels, readings and IMUs: columns, and what follows from them |
//! | `frame` | readings by their names, and the frames that they make |
//! | `units` | units that a table states of a column |
//! | `load` | declarations of the other keys; from a file; as a file |

mod choice;
mod frame;
mod load;
mod mapping;
mod reading;
mod units;

pub use choice::{EstimatorError, LogChoice, LogSides};
pub use frame::{Reading, Values, coupling_angle, frame, whole_frame};
pub(crate) use load::LOG;
pub use load::log_reference;
pub use mapping::{ChannelChoice, Mapping, StatedAt};
pub use reading::{ImuChoice, InclinationSource, ReadingChoice, World};
pub use units::{Kind, Unit};
