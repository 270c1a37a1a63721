//! A run as a Rerun recording: robot, ground and forces in motion beside the time series of every estimator.
//!
//! [`RecordingSink`] writes one `.rrd` file that also holds its layout, so that `rerun run.rrd` shows everything at once.
//!
//! | entity | what it holds |
//! |---|---|
//! | `world` | the 2-D scene in metres, x forward, y up |
//! | `world/robot/...` | bars, wheels with spokes, pins P, Q, R, S, contact points |
//! | `world/forces/true/...` | N and T of the simulator, as arrows at the contacts |
//! | `world/forces/estimated/...` | N and T of one estimator: `true-mass`, or else the last |
//! | `world/trails` | where the pins have been (Fig. 5) |
//! | `world/follow` | a frame that goes along with the body, and the scale of the arrows |
//! | `series/...` | forces, errors, contact angles and needed friction over time |
//! | `events` | contact lost or regained, stops reached, estimates refused |
//! | `about` | how to read the recording |
//!
//! Time is the timeline `sim_time`. Nothing depends on the clock: the same scene gives the same recording.

mod about;
mod colours;
mod error;
mod events;
mod layout;
mod plot;
mod rrd;
mod scene_view;
mod series;
mod shapes;
mod sink;

pub use error::ViewerError;
pub use sink::RecordingSink;
