//! The choices of an estimator, and what it is told of the sensors' errors.

/// Where the estimator thinks the linkage's mass is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Masses {
    /// Concentrated in the body's centre of mass (Fig. 7).
    LumpedToBody,
    /// Shared evenly by the wheels (Fig. 8).
    LumpedToWheels,
    /// Where it is.
    True,
}

/// How traction comes from motor torque and wheel angle, and link angles from gyro and inclinometer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Filters {
    /// As in the paper: eq. (3), and a complementary filter for Fig. 5.
    Paper,
    /// Kalman filters, with covariance.
    Kalman,
}

/// How large the errors of the readings are: standard deviations, from data sheets or measured at rest.
///
/// What is not white is drawn once (offset, gain, bias) or walks; the estimator looks for it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NoiseBudget {
    /// Encoder counts in a turn of the wheel (motor-side counts times gear ratio); 0 for an exact angle.
    pub encoder_counts: f64,
    /// Error of the time stamp, s.
    pub jitter: f64,
    /// White noise of the motor torque, N m a sample.
    pub torque_noise: f64,
    /// Constant offset of a motor's torque reading, N m.
    pub torque_offset: f64,
    /// Relative error of a motor's torque reading.
    pub torque_gain: f64,
    /// Dry friction in the gears that nobody told of, N m at the wheel; common to all wheels.
    pub gear_friction: f64,
    /// White noise of an inclinometer, rad a sample.
    pub inclination_noise: f64,
    /// Constant error of an inclinometer, rad.
    pub inclination_bias: f64,
    /// Whether the inclinometers feel acceleration as well as gravity, as real ones do.
    pub specific_force: bool,
    /// White noise of a gyroscope, rad/s a sample.
    pub rate_noise: f64,
    /// Bias of a gyroscope at the start, rad/s.
    pub rate_bias: f64,
    /// Random walk of that bias, rad/s/sqrt(s).
    pub rate_walk: f64,
    /// Error of the contact angles given, rad.
    pub contact_angle: f64,
    /// Time over which that error is correlated, s.
    pub contact_angle_time: f64,
    /// How far the body's centre of mass may be from where the drawings put it, m.
    pub body_cg: f64,
    /// Relative error of each link's mass.
    pub link_mass: f64,
}

impl NoiseBudget {
    /// Sensors of the class that a robot of this size carries, with 0.3 N m of gear friction held possible. Exact drawings.
    pub const fn typical() -> Self {
        const DEGREE: f64 = core::f64::consts::PI / 180.0;
        Self {
            encoder_counts: 160_000.0,
            jitter: 0.0,
            torque_noise: 0.1,
            torque_offset: 0.1,
            torque_gain: 0.02,
            gear_friction: 0.3,
            inclination_noise: 0.1 * DEGREE,
            inclination_bias: 0.1 * DEGREE,
            specific_force: true,
            rate_noise: 0.1 * DEGREE,
            rate_bias: 0.0,
            rate_walk: 0.0,
            contact_angle: 2.0 * DEGREE,
            contact_angle_time: 0.3,
            body_cg: 0.0,
            link_mass: 0.0,
        }
    }
}

/// Choices of an estimator.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EstimatorSettings {
    /// Where the linkage's mass is taken to be.
    pub masses: Masses,
    /// Traction and link angles.
    pub filters: Filters,
    /// Pole omega_c of the paper's traction observer, eq. (3), rad/s.
    pub observer_pole: f64,
    /// Crossover time between gyro and inclinometer of the paper's filter, s.
    pub crossover_time: f64,
    /// Viscous damping B of the wheel module, N m s.
    pub viscous_damping: f64,
    /// Row scaling of eq. (8): moments count as forces at this lever, m. 1 m leaves N and N m as they stand, as the paper
    /// does; the answer of an unweighted least squares depends on it.
    pub moment_lever: f64,
    /// Whether inertial loads are added to gravity. Needs [`Filters::Kalman`].
    pub inertia: bool,
    /// Whether the equations are weighed by the covariance of what goes into them. Needs [`Filters::Kalman`].
    pub whitening: bool,
    /// Whether negative normal forces are excluded.
    pub nonnegative: bool,
    /// Whether the parity residual corrects torques and contact angles. Needs [`Filters::Kalman`].
    pub parity: bool,
    /// Whether rolling does: a wheel's centre moves along the ground, and slips in proportion to T/N. Needs
    /// [`Filters::Kalman`].
    pub rolling: bool,
    /// Errors of the readings.
    pub budget: NoiseBudget,
}

impl EstimatorSettings {
    /// `paper-body`: the linkage's mass in the body (Fig. 7).
    pub const fn paper_body() -> Self {
        Self {
            masses: Masses::LumpedToBody,
            ..Self::true_mass()
        }
    }

    /// `paper-wheels`: the linkage's mass in the wheels (Fig. 8).
    pub const fn paper_wheels() -> Self {
        Self {
            masses: Masses::LumpedToWheels,
            ..Self::true_mass()
        }
    }

    /// `true-mass`: the links' masses where they are; all else as in the paper. omega_c = 50 rad/s, B = 0.15 N m s.
    pub const fn true_mass() -> Self {
        Self {
            masses: Masses::True,
            filters: Filters::Paper,
            observer_pole: 50.0,
            crossover_time: 0.5,
            viscous_damping: 0.15,
            moment_lever: 1.0,
            inertia: false,
            whitening: false,
            nonnegative: false,
            parity: false,
            rolling: false,
            budget: NoiseBudget::typical(),
        }
    }

    /// `best`: everything that the readings say, with its covariance.
    pub const fn best() -> Self {
        Self {
            filters: Filters::Kalman,
            moment_lever: 0.2,
            inertia: true,
            whitening: true,
            nonnegative: true,
            parity: true,
            rolling: true,
            ..Self::true_mass()
        }
    }
}
