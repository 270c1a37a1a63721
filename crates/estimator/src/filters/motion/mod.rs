//! Motion of the robot, errors of contact angles and torques, creep of the wheels: one Kalman
//! filter.
//!
//! Five constraints hold. The filter takes each as a pseudo-measurement of zero:
//! - A wheel's centre moves along the ground. The direction of its velocity is the contact angle,
//!   up to the speed of its penetration.
//! - A wheel rolls. The speed of its centre is that of its rim minus the slip, and the slip of a
//!   wheel that grips is proportional to T/N: creep.
//! - The inclinometers measure the acceleration of the robot.
//! - The parity residual of eq. (8) is zero.
//! - The profile of the ground closes: front, middle and rear wheel find the same heights at the
//!   same places.
//!
//! The first relates the contact angles to each other and to the gyroscopes. The second makes
//! torque offsets observable: for a rolling wheel the slip gives T/N independently of the torque
//! reading. Below 2 mm/s this does not hold, and the constraint corrects the velocity only. The
//! third shows changes of the speed while no wheel grips. The fourth is the force balance with the
//! normal forces eliminated: tractions, contact angles, weight and inertia must agree. It observes
//! one combination of their errors. The fifth shows the slow error of the direction of the
//! velocity, which the others cannot tell from a torque offset common to all wheels.
//!
//! States, their indices and their change over time are in `filter.rs`, each constraint in a file of
//! its own, what both sides of a rover have in common in `coupled.rs`, constants and time-correlated
//! errors in `tuning.rs`.

mod acceleration;
mod closure;
mod coupled;
mod direction;
mod filter;
mod modes;
mod parity;
mod rolling;
mod slip;
#[cfg(test)]
mod tests;
mod tuning;

pub(crate) use acceleration::SensedAcceleration;
pub(crate) use coupled::JointMeasurement;
pub(crate) use filter::MotionFilter;
pub(crate) use parity::ParityResidual;
pub(crate) use rolling::RollingWheel;
pub(crate) use tuning::{
    ACCELERATION, CREEP, CREEP_SIGMA, LINEAR_RATIO, PENETRATION_SPEED, REFERENCE_SPEED, SLIP,
    SLOPE, SLOPE_LENGTH, TURN_TIME,
};
