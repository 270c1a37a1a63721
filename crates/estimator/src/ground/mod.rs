//! Memory of the ground: the profile that the wheels have passed, along the path.
//!
//! Front, middle and rear wheel pass the same places. The first wheel at a place stores height and
//! slope of the ground there; each later wheel measures the height of that place once more.
//!
//! # Dead reckoning and its errors
//! The estimated velocity of Q, integrated, gives its place `X`. With the position `a_i` of axle
//! `i` relative to Q, which the link angles give, the contact point of wheel `i` is
//!
//! ```text
//! p_i = X + a_i - r n(gamma_i),    n = (-sin gamma, cos gamma)
//! ```
//!
//! An error of `gamma_i` moves `p_i` along the ground, not away from it. Three errors remain, and
//! they are common to the three wheels, because all wheels take the same velocity and the same link
//! angles:
//!
//! | state | meaning | change along the path |
//! |---|---|---|
//! | `d` | error of the height of Q, m | `d(x + dx) = d(x) + s dx` |
//! | `s` | error of the direction of the velocity | Gauss-Markov process; its deviation is that of the motion filter |
//! | `b_1`, `b_2` | errors of the angles of links 1 and 2, rad | constant, prior: bias of the inclinometers |
//! | `c_j` | error of the stored heights at node `j`, m | constant |
//!
//! The height of `p_i` errs by `d + a_ix b_k`, k the link of wheel `i`. A wheel on new ground at
//! `x` sets the error of what it stores: `c(x) = d + a_ix b_k`. A wheel on mapped ground gives a
//! measurement:
//!
//! ```text
//! y_i - (y_stored - c(x)) = d + a_ix b_k + noise
//! ```
//!
//! One Kalman filter holds all of these ([`drift`]). Between nodes `c` is linear. The variance of a
//! stored height is that of its `c`: passes of further wheels reduce it only as far as their errors
//! are independent. The slope at a place follows from the contact angle of the first wheel there,
//! corrected by `dc/dx`. The contact angles of the later wheels give no further measurement:
//! relative to the first wheel's they are given by the link rates, which the link angles contain
//! already.
//!
//! # What is not observable
//! The mean of `b_1` and `b_2` turns the whole profile, and no pass of any wheel shows it. Their
//! difference is observable. An error with the period of equal wheel spacings repeats from wheel to
//! wheel; only the direction of the velocity reduces it.
//!
//! # Friction
//! Beside height and slope a place holds what the wheels have shown of its friction:
//! [`FrictionBounds`].
//!
//! # Place
//! `x` is dead reckoning alone. It errs by the slip that the motion filter does not know. Its
//! variance grows along the path.

mod cells;
mod drift;
mod memory;
mod motion;

pub use cells::FrictionBounds;
pub(crate) use memory::GroundMemory;
pub use memory::GroundPoint;
pub(crate) use motion::GroundMotion;
