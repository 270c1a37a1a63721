//! Judges a path from its geometry before it is driven: needed friction, go or no-go.
//!
//! The robot moves so slowly that inertia does not count. [`PathSetup`] takes robot, ground, friction and torque limit
//! from a scene, [`judge`] gives a [`PathReport`].
//!
//! | module | job |
//! |---|---|
//! | `curve` | the curve on which the wheels' centres move |
//! | `mechanism` | postures in which all wheels touch the ground, one after the other |
//! | `balance` | eq. (8) with all contacts; the best tractions by linear programs |
//! | `vertex` | the needed friction in closed form, with its proof, where three contacts limit it |
//! | `judge` | follows the path and judges its places |
//! | `setup` | what is judged |
//! | `report`, `text` | the result, and its words |

mod balance;
mod curve;
mod judge;
mod mechanism;
mod report;
mod setup;
mod text;
mod vertex;

pub use judge::judge;
pub use report::{Failure, PathReport, Place, Reason};
pub use setup::{DriveKind, Options, PathError, PathSetup};
