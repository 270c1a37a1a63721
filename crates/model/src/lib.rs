#![doc = include_str!("../README.md")]
//!
//! # Where to find what
//!
//! | symbol | here |
//! |---|---|
//! | P, Q, R, S | [`Pins`], [`Pin`] |
//! | link 1 to 3, body | [`Bar`] |
//! | W1 to W3 (front, middle, rear) | [`Geometry::axles`], [`Geometry::carriers`] |
//! | theta_1, theta_2 given, theta_3 and theta_body found | [`Posture::close`] |
//! | angles of the links from those of the body and of pin Q | [`BodyMount`] |
//! | rate of a joint from its angle along the path | [`PathAngle`] |
//! | static loads on level ground | [`Robot::static_loads`], [`Robot::check_stance`] |
//! | readings of an instant; command of a wheel's drive | [`SensorFrame`]; [`WheelCommand`] |
//! | units in which robots of every size move alike | [`Units`] |
//! | both sides of a rover, and what lies across | [`WholeRover`] |
//! | masses and inertias | [`MassSet`]; the masses in the static equilibrium: [`PointMasses`] |
//!
//! The feature `std`: see [`sqrt`].
#![no_std]

#[cfg(feature = "std")]
extern crate std;

mod body_mount;
mod frame;
mod geometry;
mod mass;
mod named;
mod outline;
mod path_angle;
mod plane;
mod posture;
mod stance;
mod units;
mod whole_rover;

pub use body_mount::{BodyMount, BodyReading, LinkReading};
pub use frame::{SensorFrame, WheelCommand};
pub use geometry::{Bar, Carrier, Geometry, GeometryError, Pin, PinStop, Pins, Suspension};
pub use mass::{MassError, MassSet, PointMasses};
pub use outline::Outline;
pub use path_angle::PathAngle;
pub use plane::{cross, direction, perp, rotate, turned};
pub use posture::{Dyad, Posture, PostureError};
pub use stance::StanceError;
pub use units::Units;
pub use whole_rover::{Coupling, LoadShift, WholeRover, WholeRoverError};

/// A position, velocity or force in the plane (x forward, y up).
pub type Vec2 = nalgebra::Vector2<f64>;

/// Acceleration of free fall on Earth, m/s^2.
pub const GRAVITY: f64 = 9.81;

/// One side of the robot: geometry and masses, and the gravity where it drives.
#[derive(Clone, Debug, PartialEq)]
pub struct Robot {
    /// Positions in the nominal pose.
    pub geometry: Geometry,
    /// Masses and inertias.
    pub mass: MassSet,
    /// Acceleration of free fall, m/s^2; gravity is `(0, -gravity)`.
    pub gravity: f64,
}

/// The square root, with the same bits with and without the feature `std`.
///
/// Without it the root is libm's, which on x86-64 is an SSE instruction of its own. Among code that
/// is compiled for AVX (`-C target-cpu=native`) each of these costs a change of state: an update of
/// `kalman` then takes more than twice as long.
#[must_use]
#[inline]
pub fn sqrt(x: f64) -> f64 {
    #[cfg(feature = "std")]
    return x.sqrt();
    #[cfg(not(feature = "std"))]
    libm::sqrt(x)
}

/// Share of a new sample in a first-order low pass of the time constant `time` (s), `dt` (s) after the
/// last one, -: `y += share (x - y)` is the backward Euler step of `time dy/dt = x - y`.
///
/// ```
/// let share = robhaz_model::low_pass_share(0.01, 0.04);
/// assert!((share - 0.2).abs() < 1e-15);
/// ```
#[must_use]
#[inline]
pub fn low_pass_share(dt: f64, time: f64) -> f64 {
    dt / (time + dt)
}

/// `height` times the quintic from 0 at u = 0 to 1 at u = 1 whose first two derivatives are zero at
/// both ends.
#[must_use]
#[inline]
pub fn quintic(height: f64, u: f64) -> f64 {
    height * u * u * u * (10.0 + u * (-15.0 + 6.0 * u))
}

impl Robot {
    /// Geometry A with the mass set `caption`: the default robot.
    pub fn default_a() -> Self {
        Self {
            geometry: Geometry::a(),
            mass: MassSet::caption(),
            gravity: GRAVITY,
        }
    }

    /// Mean static load of a wheel on level ground, N: a third of the weight.
    pub fn mean_wheel_load(&self) -> f64 {
        self.mass.total() * self.gravity / 3.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// Equivalence: the square root has the same bits with the feature `std` as without it.
        #[test]
        fn roots_have_the_bits_of_both_libraries(x in 0.0..1e6_f64, tiny in 0.0..1e-300_f64) {
            for x in [x, tiny] {
                prop_assert_eq!(x.sqrt().to_bits(), libm::sqrt(x).to_bits());
                prop_assert_eq!(sqrt(x).to_bits(), libm::sqrt(x).to_bits());
            }
        }
    }
}
