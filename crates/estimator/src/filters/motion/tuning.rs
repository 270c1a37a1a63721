//! Constants of the motion filter. One tuning holds for all sensors and grounds: data sheets go
//! into the noise budget.
//!
//! A value without a reason beside it is an engineering assumption of the stated size.
//! `docs/measurements` has the errors that this tuning reaches, and what half and double of each
//! value do (`sensitivity.md`).

use crate::deviation::GATE;
use crate::filters::GaussMarkov;
use robhaz_model::Units;

/// Speed for which [`PENETRATION_SPEED`] holds, m/s. It is proportional to the speed, its
/// correlation time to the inverse.
/// Chosen; sensitive.
pub const REFERENCE_SPEED: f64 = 0.2;
/// Unmeasured part of the acceleration of Q, a first-order Gauss-Markov process: standard
/// deviation, m/s^2, and correlation time, s. The measured parts add in quadrature.
/// Chosen; sensitive.
pub const ACCELERATION: GaussMarkov = GaussMarkov::new(0.015, 1.0);
/// Standard deviation of Q's acceleration over the measured acceleration of the rims, -.
/// Chosen; sensitive.
pub const RIM_FACTOR: f64 = 2.0;
/// Standard deviation of the velocity of a robot at rest, m/s.
/// Guard.
pub const VELOCITY_AT_REST: f64 = 0.01;
/// Standard deviation of an unknown velocity, m/s: after a gap between frames.
/// Guard.
pub const UNKNOWN_VELOCITY: f64 = 0.5;
/// Speed of penetration at the reference speed, m/s and s: 0.5 mm of penetration changes by 5 %
/// over 50 ms.
/// Chosen; sensitive.
pub const PENETRATION_SPEED: GaussMarkov = GaussMarkov::new(5e-4, 0.05);
/// Correlation time of the error of a link's angle, s. The angle follows its inclinometer
/// within seconds, so that what both have in common shows no acceleration.
/// Chosen; sensitive.
pub const ANGLE_TIME: f64 = 10.0;
/// Time for which an error of a steering angle or dragged wheels last, s: a turn.
/// Chosen; insensitive.
pub const TURN_TIME: f64 = 30.0;
/// Slip speed that creep does not explain: standard deviation, m/s, and correlation time, s, at
/// the reference speed. It is a rolling-radius error of 0.1 %. The time, not scaled by the
/// speed, also holds for the gyroscope's bias and for the error of creep times T/N.
/// Chosen; sensitive.
pub const SLIP: GaussMarkov = GaussMarkov::new(2e-4, 0.5);
/// Correlation time of the product of the errors of creep and T/N in the plane at the reference speed, s. It goes with
/// the inverse square of the speed, up to that of [`SLIP`], so that N errs no more at 5 mm/s.
/// Chosen on seeds 300 to 302 of `no_angles`; sensitive.
pub const PRODUCT_TIME: f64 = 0.1;
/// Prior of the logarithm of the creep speed in m/s: 1 to 4 mm/s for a hard wheel on rock, 100
/// mm/s on soft ground at 0.2 m/s (slip ratio over T/N of 0.005 to 0.5: Pacejka, Tyre and
/// Vehicle Dynamics, ch. 3).
/// Chosen; sensitive.
pub const CREEP: f64 = -3.5; // 30 mm/s
/// Standard deviation of that prior, -.
/// Chosen; sensitive.
pub const CREEP_SIGMA: f64 = 0.8; // a factor of 2.2: 39 mm/s
/// Correlation of two wheels in that prior, 0 to 1: wheels on one ground.
/// Chosen; sensitive.
pub const COMMON_CREEP: f64 = 0.9;
/// Upper limit of the logarithm of the creep speed in m/s: false readings could carry it to
/// where no later one corrects it.
/// Guard.
pub const GREATEST_CREEP: f64 = -1.2; // 0.3 m/s
/// Way over which rolling resistance changes by its deviation in the budget, as a random walk, m: a
/// change of ground is followed within some metres. A tenth of it takes impacts on stairs for one.
/// Chosen; sensitive.
pub const GROUND_LENGTH: f64 = 1000.0;
/// Lower limit of the logarithm of the creep speed in m/s: [`GATE`] deviations of the prior. Harder
/// wheels act as rigid ones.
/// Definition.
pub const LEAST_CREEP: f64 = CREEP - GATE * CREEP_SIGMA; // 0.6 mm/s
/// T/N beyond this many of its standard deviations corrects the creep speed. Below, slip that
/// is missing shows a torque offset, not a hard wheel: a creep of zero would explain any
/// offset.
/// Chosen; sensitive.
pub const PULLING: f64 = 6.0;
/// Random walk of a torque offset and of the wheels' resistance, N m/sqrt(s): they follow the
/// temperature of the motors.
/// Chosen; insensitive.
pub const TORQUE_WALK: f64 = 1e-3;
/// Change of the logarithm of the creep speed along the ground: random walk, 1/sqrt(m).
/// Chosen; sensitive.
pub const CREEP_WALK: f64 = 0.2;
/// Prior of the ground where no contact angle is given: RMS deviation of its slope from the
/// line between the wheels, rad. Where the estimated angle itself deviates, that adds.
/// Chosen; sensitive.
pub const SLOPE: f64 = 0.1;
/// Correlation length of that deviation along the ground, m: the wheel's radius, which smooths
/// shorter waves.
/// Definition.
pub const SLOPE_LENGTH: f64 = Units::RADIUS;
/// Random walk of a given contact angle while its reading is missing, rad/sqrt(s).
/// Guard.
pub const UNREAD_ANGLE_WALK: f64 = 0.5;
/// Steepest contact angle, rad, where none is given.
/// Guard: near a wall.
pub const STEEPEST: f64 = 1.4;
/// Standard deviation of the contact angles of a robot that is held by an edge, rad: anything
/// between level ground and a wall.
/// Chosen; held by `crates/study/tests/study/no_angles.rs`: with 0.45 a kerb is too narrow.
pub const HELD_ANGLE: f64 = 0.6;
/// T/N up to which slip corrects the creep speed, -. Beyond, a wheel may slide, which a greater
/// creep speed would explain. Chosen: with 0.25 wheels that push against a riser under a
/// low-gain drive teach nothing, and the parity residual contradicts them.
pub const LINEAR_RATIO: f64 = 0.35;
/// T/N below which a wheel is taken to grip, -: an outlier of its slip then shows a wrong
/// velocity. Chosen: with 0.15 the error of N in `ditch` under the PI drive is 2.6 in place of
/// 1.8 %, other cases hardly change.
pub const STICKING_RATIO: f64 = 0.25;
/// Lower limit of the contact-angle error, rad, where the budget is zero.
/// Guard.
pub const LEAST_ANGLE: f64 = 1e-3;
/// Time after an impact or at an edge for which measurements are down-weighted or skipped, s;
/// after a parity outlier until this time after the unmodelled load has decayed.
/// Chosen; sensitive.
pub const IMPACT_TIME: f64 = 0.2;
/// Time for which a wheel counts as sliding after an outlier of its slip, s.
/// Chosen; insensitive.
pub const SLIDING_TIME: f64 = 0.1;
/// Additional measurement noise of both rolling constraints after an impact, with given contact
/// angles: standard deviation, m/s, and correlation time, s. They hardly count then.
/// Guard.
pub const IMPACT_NOISE: GaussMarkov = GaussMarkov::new(0.1, 0.1);
/// The same where no contact angle is given: mean slip of a wheel that meets an edge. The
/// direction of the velocity is then the only source of the angle.
/// Chosen; sensitive.
pub const EDGE_NOISE: GaussMarkov = GaussMarkov::new(0.0045, 0.1);
/// Variance of the unmodelled load below which it becomes zero, N^2.
/// Guard.
pub const UNMODELLED_FLOOR: f64 = 1e-6;
