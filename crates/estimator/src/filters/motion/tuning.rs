//! Constants of the motion filter. One tuning holds for all sensors and grounds: data sheets go into the noise budget.
//!
//! A value without a reason beside it is an engineering assumption of the stated size. `docs/estimators.md` lists the
//! errors and the consistency that this tuning reaches.

use super::noise::LastingError;

/// See [`TUNING`].
pub struct Tuning {
    /// Speed at which the ground-dependent constants are stated, m/s. At a higher speed the same ground changes in
    /// proportion to the speed, and accelerations grow with its square.
    pub reference_speed: f64,
    /// Largest speed for which they are scaled, m/s. No set speed is higher.
    pub highest_speed: f64,
    /// Gauss-Markov acceleration of Q while no sensor measures any, m/s^2 and s, at the reference speed and with contact
    /// angles as uncertain as `coarse_angle`. Angles of that error can follow it. Finer angles can follow more: the
    /// standard deviation grows with the inverse root of their error.
    pub acceleration: LastingError,
    /// Error of a contact angle to which `acceleration` belongs, rad: 2 deg, the budget of typical sensors.
    pub coarse_angle: f64,
    /// Correlation time of the acceleration after an impact, s: accelerations estimated before it no longer hold.
    pub acceleration_time_after_impact: f64,
    /// Upper limit of the acceleration's standard deviation, m/s^2. Measured accelerations beyond it are false, and the
    /// covariance must not outgrow its rounding.
    pub largest_acceleration: f64,
    /// Process-noise factor on the acceleration of the rims, which encoders measure.
    pub rim_factor: f64,
    /// Process-noise factor on the acceleration of the axles by the links' rotation, which gyroscopes measure.
    pub link_factor: f64,
    /// Standard deviation of the velocity of a robot at rest, m/s.
    pub velocity_at_rest: f64,
    /// Standard deviation of an unknown velocity, m/s: after a gap between frames.
    pub unknown_velocity: f64,
    /// Speed of penetration at the reference speed, m/s and s: 0.5 mm of penetration changes by 2 % over 50 ms.
    pub penetration_speed: LastingError,
    /// Factor on the gyroscopes' noise. Beside its own term it disturbs the direction about which the rolling constraints
    /// are linearised.
    pub gyro_noise_factor: f64,
    /// Slip speed beyond creep, m/s and s, at the reference speed: the rolling radius, without the changes of the
    /// penetration, errs by 0.1 % of the speed.
    pub slip: LastingError,
    /// Correlation time of the torque observer's error in the slip, s.
    pub observer_time: f64,
    /// Prior of the creep speed, m/s: of the order of 10 mm/s for small hard wheels.
    pub creep: f64,
    /// Standard deviation of that prior, m/s. It is small because a creep of zero explains readings with any torque
    /// offset, and the filter could diverge to it. `docs/estimators.md` lists the errors with other wheels.
    pub creep_sigma: f64,
    /// Least creep speed, m/s: a driven wheel does not creep backwards, and harder wheels act as rigid ones.
    pub least_creep: f64,
    /// Random walk of a torque offset, N m/sqrt(s).
    pub offset_walk: f64,
    /// Random walk of the gear friction, N m/sqrt(s).
    pub friction_walk: f64,
    /// Random walk of the creep speed, m/s/sqrt(s).
    pub creep_walk: f64,
    /// Linearisation error of the parity residual, N, beside the errors of the loads; and the time over which all errors
    /// of that residual last, s, those of the torque observer included.
    pub parity: LastingError,
    /// Random walk of a contact angle while none is given, rad/sqrt(s).
    pub unread_angle_walk: f64,
    /// Least error of a contact angle, rad. With a budget of zero the filter would not correct velocities.
    pub least_angle: f64,
    /// Gate of all innovations, standard deviations.
    pub gate: f64,
    /// Gate of the rolling constraint, standard deviations. A wheel beyond it becomes suspect: it does not roll on the
    /// given ground, but stands on an edge, or on riser and tread.
    pub suspect_gate: f64,
    /// Time for which a wheel then stays suspect, s; all wheels after an impact.
    pub suspect_time: f64,
    /// Velocity error of a suspect wheel, m/s and s.
    pub suspect: LastingError,
    /// Part of the parity residual that is not counted as unexplained load, standard deviations.
    pub explained: f64,
    /// Decay time of the variance of the unexplained load, s.
    pub unexplained_decay: f64,
    /// Floor of that variance, N^2: below it the variance becomes zero.
    pub unexplained_floor: f64,
    /// Cap of that variance, N^2: a load of 10 kN.
    pub unexplained_cap: f64,
}

/// The one tuning.
pub const TUNING: Tuning = Tuning {
    reference_speed: 0.2,
    highest_speed: 10.0,
    acceleration: LastingError::new(0.015, 1.0),
    coarse_angle: 0.0349,
    acceleration_time_after_impact: 0.03,
    largest_acceleration: 1e3,
    rim_factor: 2.0,
    link_factor: 0.3,
    velocity_at_rest: 0.01,
    unknown_velocity: 0.5,
    penetration_speed: LastingError::new(2e-4, 0.05),
    gyro_noise_factor: 3.0,
    slip: LastingError::new(2e-4, 0.3),
    observer_time: 0.05,
    creep: 0.015,
    creep_sigma: 0.003,
    least_creep: 5e-4,
    offset_walk: 1e-3,
    friction_walk: 2e-3,
    creep_walk: 2e-4,
    parity: LastingError::new(0.1, 0.03),
    unread_angle_walk: 0.5,
    least_angle: 1e-3,
    gate: 5.0,
    suspect_gate: 6.0,
    suspect_time: 0.2,
    suspect: LastingError::new(0.1, 0.1),
    explained: 2.0,
    unexplained_decay: 0.02,
    unexplained_floor: 1e-6,
    unexplained_cap: 1e8,
};
