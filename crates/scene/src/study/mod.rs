//! Study files: a base scene and what is varied in it.
//!
//! | modules | job |
//! |---|---|
//! | `choice` | the result of reading a study file |
//! | `axis` | one axis: its keys and values |
//! | `load`, `axes` | from a file |
//! | `run` | the scene of one run; problems at the place in the study file that causes them |

mod axes;
mod axis;
mod choice;
mod load;
mod run;

pub use axis::{Axis, AxisItem, AxisValue, AxisValues, Distribution};
pub use choice::{DrawMethod, Draws, StudyChoice, StudyTables};
pub(crate) use load::STUDY;
pub use run::{BaseScene, Setting};
