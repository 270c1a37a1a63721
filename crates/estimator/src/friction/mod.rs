//! Friction learned while driving, section 5 of the paper: the needed friction mu_n = T/N of each
//! wheel, the onset of slip, and what both say about the available friction mu_max.
//!
//! - [`NeededFriction`]: T/N with its standard deviation, from the forces and what the memory of
//!   the ground knows of the direction of the velocity.
//! - [`SlipEvent`]: a wheel begins to slip. The largest T/N just before is mu_max there.
//! - Every T/N that is held bounds mu_max from below, every slip event from above. The bounds are
//!   kept with the ground: [`crate::FrictionBounds`].

mod needed;
mod observer;
mod slip_watch;
mod slipped_distance;

pub use needed::{NeededFriction, OffsetShare};
pub use observer::WheelFriction;
pub(crate) use observer::{FrictionObserver, FrictionSample};
pub use slip_watch::{PeakFriction, SlipEvent};
