//! A run as a Rerun recording: robot, ground and forces in motion beside the time series of every estimator.
//!
//! [`RecordingSink`] writes one `.rrd` file that also holds its layout, so that `rerun run.rrd` shows everything at once.
//! [`LiveSink`] shows a run while it goes on. [`save_comparison`] puts several recorded runs into one recording, [`open`] shows
//! recordings on the screen, [`picture`] turns one into a PNG.
//!
//! | entity | what it holds |
//! |---|---|
//! | `world` | the 2-D scene in metres, x forward, y up |
//! | `world/ground` | the terrain; `stretches` of it with friction coefficients of their own |
//! | `world/robot/...` | bars, wheels with spokes, pins P, Q, R, S, the stops of Q, contact points |
//! | `world/forces/true/...` | N and T of the simulator, as arrows at the contacts |
//! | `world/forces/estimated/...` | N and T of one estimator: the last that knows its errors, or else the last; `two_sigma` bars |
//! | `world/trails` | where the pins have been (Fig. 5) |
//! | `world/follow` | a frame that goes along with the body, with the scales of arrows and of lengths |
//! | `world/scale` | an axis below the whole ground, and the scale of the arrows |
//! | `series/...` | forces, errors, contact angles, friction and residuals over time |
//! | `wheels/...`, `trust/...` | what each wheel does, what each estimator says of itself, as lanes |
//! | `events` | contact lost or regained, slip, stops reached, flags, estimates refused |
//! | `key` | which line is which |
//! | `about` | how to read the recording |
//!
//! Time is the timeline `sim_time`. Nothing in a saved recording depends on the clock: the same scene gives the same one.

mod about;
mod colours;
mod comparison;
mod contact;
mod control;
mod convert;
mod error;
mod event_log;
mod events;
mod forces;
mod ground;
mod key;
mod layout;
mod live;
mod picture;
mod plot;
mod print;
mod program;
mod recorder;
mod scale;
mod scene_view;
mod series;
mod shapes;
mod sink;
mod theme;
mod writer;

pub use comparison::{ComparedRun, recording_end, recording_is_closed, save_comparison};
pub use error::{VIEWER_VERSION, ViewerError};
pub use live::{LiveReport, LiveSink};
pub use picture::{PictureOptions, picture};
pub use program::open;
pub use sink::RecordingSink;
pub use theme::Theme;
