//! What an engineer knows of ROBHAZ-6WHEEL from its drawings: geometry, masses, and the kinematics of the closed four-bar.
//!
//! One side of the robot in the plane: x forward, y up, angles counter-clockwise, SI units throughout.
//!
//! ```text
//!     body --P-- link1 --Q-- link2 --R-- link3 --S-- body
//! ```
//!
//! | symbol | here |
//! |---|---|
//! | P, Q, R, S | [`Pins`], [`Pin`] |
//! | link 1 to 3, body | [`Bar`] |
//! | W1 to W3 (front, middle, rear) | [`Geometry::axles`], [`Geometry::carriers`] |
//! | theta_1, theta_2 given, theta_3 and theta_body found | [`Posture::close`] |
//! | static loads on level ground | [`Robot::static_loads`], [`Robot::check_stance`] |
//! | masses and inertias | [`MassSet`]; what statics needs of them: [`PointMasses`] |
//!
//! The crate is `no_std` and allocates nothing, so that the estimator can carry it onto a robot.
#![no_std]

mod geometry;
mod mass;
mod plane;
mod posture;
mod stance;

pub use geometry::{Bar, Carrier, Geometry, GeometryError, Pin, PinStop, Pins, mean_link_cgs};
pub use mass::{MassError, MassSet, PointMasses};
pub use plane::{cross, perp, rotate, turned};
pub use posture::{Posture, PostureError, corner_s};
pub use stance::StanceError;

/// A position, velocity or force in the plane (x forward, y up).
pub type Vec2 = nalgebra::Vector2<f64>;

/// Standard acceleration of free fall used throughout, m/s^2; gravity is `(0, -GRAVITY)`.
pub const GRAVITY: f64 = 9.81;

/// The robot on one side: its geometry and its masses.
#[derive(Clone, Debug, PartialEq)]
pub struct Robot {
    /// Positions in the nominal pose.
    pub geometry: Geometry,
    /// Masses and inertias.
    pub mass: MassSet,
}

impl Robot {
    /// Geometry A with the mass set `caption`: the default robot.
    pub fn default_a() -> Self {
        Self {
            geometry: Geometry::a(),
            mass: MassSet::caption(),
        }
    }

    /// Mean static load of a wheel on level ground, N: a third of the weight.
    pub fn mean_wheel_load(&self) -> f64 {
        self.mass.total() * GRAVITY / 3.0
    }
}
