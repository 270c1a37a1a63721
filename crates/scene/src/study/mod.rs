//! Study files: a base scene and what is varied in it.
//!
//! | modules | job |
//! |---|---|
//! | `choice` | the result of reading a study file; the scene of one run, its problems at their place in the study file |
//! | `load`, `axes` | from a file |

mod axes;
mod choice;
mod load;

pub use choice::{
    Axis, AxisItem, AxisValue, AxisValues, BaseScene, Distribution, DrawMethod, Draws, Setting,
    StudyChoice, StudyTables,
};
pub(crate) use load::STUDY;
