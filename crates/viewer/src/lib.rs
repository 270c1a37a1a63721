//! A run as a Rerun recording: an animation of robot, ground and forces, and the time series of
//! every estimator.
//!
//! [`RecordingSink`] writes one `.rrd` file, with the layout of its views: `rerun run.rrd` shows
//! everything, a rover with both sides in 3-D. Or it sends the recording to a viewer, which shows the
//! run while it is simulated.
//! [`open`] shows recordings on the screen. [`picture()`] saves a picture of one as a PNG.
//!
//! | entity | what it holds |
//! |---|---|
//! | `world` | the 2-D scene in metres, x forward, y up |
//! | `world/ground` | the terrain; `stretches`: friction stretches |
//! | `world/estimated_terrain/...` | the ground that one estimator has found; `two_sigma`: two standard deviations |
//! | `world/robot/...` | bars, wheels with spokes, pins P, Q, R, S, the end stops, contact points |
//! | `world/forces/true/...` | true N and T, as arrows at each contact |
//! | `world/forces/estimated/...` | N and T of one estimator, as arrows; `two_sigma`: bars |
//! | `world/trails` | paths of the pins (Fig. 5) |
//! | `world/follow` | a frame that moves with the body, with the legend of the arrows |
//! | `world/friction_tests/...` | results of friction tests at their places |
//! | `world/scale` | an axis below the ground |
//! | `series/...` | forces, errors, contact angles, friction and residuals over time |
//! | `wheels/...`, `trust/...` | lanes: state of each wheel, true and as estimators state it; flags of each estimator |
//! | `events` | contact lost or regained, slip, end stops reached, bars on the ground, friction tests, flags, missing estimates |
//! | `key` | the key to the plots |
//! | `about` | how to read the recording |
//!
//! The estimator of the arrows is the last that states a covariance, or else the last of the scene.
//!
//! Time is the timeline `sim_time`. A saved recording does not depend on the clock: the same scene
//! gives the same recording.

mod colours;
mod draw;
mod error;
mod estimated_terrain;
mod events;
mod explain;
mod forces;
mod friction_tests;
mod ground;
mod layout;
mod picture;
mod program;
mod recorder;
mod scene_view;
mod series;
mod sink;
mod target;
mod whole;
mod writer;

pub use error::{INSTALL, VIEWER_VERSION, ViewerError};
pub use picture::{picture, recording_end};
pub use program::{is_installed, open};
pub use sink::RecordingSink;
