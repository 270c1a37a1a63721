//! Equations of motion in minimal coordinates.
//!
//! [`crate::direct`] integrates them, [`crate::start`] solves them for the static equilibrium at
//! time zero, from which both engines start, and [`crate::stability`] takes the mass matrix. The
//! motion of [`crate::rapier`] does not depend on them.

mod forces;
mod kinematics;
mod mass_matrix;
mod model;
mod tangents;

pub(crate) use forces::Forces;
pub(crate) use kinematics::{Kinematics, State};
pub(crate) use model::{Carriers, Mechanics};
pub(crate) use tangents::Tangents;
