//! Judges a path from its geometry before it is driven: needed friction, go or no-go.
//!
//! With the drive `ideal` the robot moves so slowly that inertia does not count; with `shared` and
//! `speed` it is driven along the path at its set speed. [`PathSetup`] takes robot, ground,
//! friction and torque limit from a scene, [`judge`] gives a [`PathReport`].
//!
//! | module | job |
//! |---|---|
//! | `curve` | the curve on which the wheels' centres move |
//! | `mechanism` | postures in which all wheels touch the ground, one after the other |
//! | `balance` | eq. (8) with all contacts; the best tractions by linear programs |
//! | `route` | the places of the path with all contacts |
//! | `motion` | equations of motion along the path at one place |
//! | `tractions` | the tractions that a control comes to |
//! | `follow` | the robot driven along the path: where it gets stuck |
//! | `judge` | judges the places and the path |
//! | `setup` | what is judged |
//! | `report` | the result, and its words |
//! | `files` | table and figure of the result |

mod balance;
mod curve;
mod files;
mod follow;
mod judge;
mod mechanism;
mod motion;
mod report;
mod route;
mod setup;
mod tractions;

pub use files::{path_files, write_path};
pub use judge::judge;
pub use report::{Failure, PathReport, Place, Reason, Stretch};
pub use setup::{DriveKind, Options, PathError, PathSetup};
