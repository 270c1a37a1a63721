//! The friction test of section 5 of the paper: the torque of one wheel rises linearly until the
//! wheel slips.
//!
//! | step | file |
//! |---|---|
//! | which wheel is tested when, in which direction | `sequence.rs` |
//! | the torque of one ramp | `ramp.rs` |
//! | when a ramp ends: [`FrictionTest`] takes the estimates | `test.rs` |
//! | forces at which a ramp ended in slip, and the result | `result.rs` |
//! | several ramps together: torque offsets are common to them | `together.rs` |

mod ramp;
mod result;
mod sequence;
mod test;
mod together;

pub use result::{FrictionTestEnd, FrictionTestResult, RampLimit};
pub use sequence::FrictionTests;
pub use test::{FrictionTest, FrictionTestPhase};
pub use together::together;
