//! The estimate of one instant.

use crate::contact::ContactEstimate;
use crate::flags::Flags;
use crate::friction::WheelFriction;
use crate::health::Health;
use crate::torque_scale::TorqueScale;
use robhaz_model::{Posture, PostureError, Vec2};

/// Wheel forces of one instant, with covariance and flags.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// Time of the readings, s.
    pub time: f64,
    /// Normal force N of each wheel, N.
    pub normal_force: [f64; 3],
    /// Traction T of each wheel, N, driving forward positive.
    pub traction: [f64; 3],
    /// Contact angle gamma of each wheel, rad: given (the paper's methods), given minus its
    /// estimated error, or estimated.
    pub contact_angle: [f64; 3],
    /// Angles of the four bars, rad (Fig. 5).
    pub posture: Posture,
    /// Positions of P, Q, R, S relative to Q in world axes, m (Fig. 5).
    pub pin_from_q: [Vec2; 4],
    /// Forces in P, Q, R, S on the first bar of [`robhaz_model::Pin::bars`], N.
    pub pin_force: [Vec2; 4],
    /// Residual of eq. (8): horizontal and vertical force (N), moments of links 1 and 2 about Q (N
    /// m).
    pub residual: [f64; 4],
    /// Parity residual of eq. (8), before it corrects any state; `None` where the contacts leave it
    /// undefined.
    pub parity: Option<Parity>,
    /// What Kalman filters state beside the forces; `None` from the paper's filters.
    pub kalman: Option<KalmanReport>,
    /// Warnings.
    pub flags: Flags,
}

/// What Kalman filters state beside the forces of one instant.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct KalmanReport {
    /// Covariance of `x' = [T1 N1 T2 N2 T3 N3]`, N^2.
    pub covariance: [[f64; 6]; 6],
    /// Standard deviation of the contact angles, rad.
    pub contact_angle_sigma: [f64; 3],
    /// Standard deviation of the angles of links 1 and 2, rad.
    pub angle_sigma: [f64; 2],
    /// Estimated errors of the readings.
    pub reading_errors: ReadingErrors,
    /// Contact state of each wheel.
    pub contact: [ContactEstimate; 3],
    /// Friction that each wheel needs, and what is known of the ground. Its T/N can differ from that
    /// of `traction` and `normal_force`: it takes the slope from the estimated terrain, too.
    pub friction: [WheelFriction; 3],
    /// Whether the readings agree with each other.
    pub health: Health,
    /// The torques against the weight; `None` of one side of two.
    pub torque_scale: Option<TorqueScale>,
}

impl Estimate {
    /// Standard deviation of N of wheel `i` (0 to 2), N.
    pub fn sigma_normal(&self, i: usize) -> Option<f64> {
        self.sigma(2 * i + 1)
    }

    /// Standard deviation of T of wheel `i` (0 to 2), N.
    pub fn sigma_traction(&self, i: usize) -> Option<f64> {
        self.sigma(2 * i)
    }

    /// Multiplies all forces by a factor, with what belongs to them, and adds an error of all of
    /// them by one factor, whose relative standard deviation is `deviation`.
    pub(crate) fn scale_forces(&mut self, factor: f64, deviation: f64) {
        let forces = self.normal_force.iter_mut().chain(&mut self.traction);
        for force in forces.chain(&mut self.residual) {
            *force *= factor;
        }
        for force in &mut self.pin_force {
            *force *= factor;
        }
        let ([t1, t2, t3], [n1, n2, n3]) = (self.traction, self.normal_force);
        let common = [t1, n1, t2, n2, t3, n3].map(|force| deviation * force);
        let Some(report) = &mut self.kalman else {
            return;
        };
        for (row, a) in report.covariance.iter_mut().zip(common) {
            for (entry, b) in row.iter_mut().zip(common) {
                *entry = *entry * (factor * factor) + a * b;
            }
        }
    }

    /// NaN where the variance is.
    fn sigma(&self, k: usize) -> Option<f64> {
        let variance = self.kalman.as_ref()?.covariance.get(k)?.get(k)?;
        Some(robhaz_model::sqrt(variance.clamp(0.0, f64::INFINITY)))
    }
}

/// Parity residual: the combination of the rows of eq. (8) without normal forces. It is zero for
/// exact torques, contact angles and loads.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parity {
    /// The residual, N (moments at the lever).
    pub value: f64,
    /// Predicted standard deviation, N. 0 from the paper's filters, which predict none.
    pub sigma: f64,
}

impl Parity {
    /// Normalised innovation squared. Not finite where no deviation is predicted.
    pub(crate) fn nis(&self) -> f64 {
        self.value * self.value / (self.sigma * self.sigma)
    }
}

/// Errors of the readings as `kalman` estimates them: pairs of value and standard deviation.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ReadingErrors {
    /// Offsets of the torque readings, N m.
    pub torque_offset: [(f64, f64); 3],
    /// Dry friction in the gears, N m at the wheel.
    pub gear_friction: (f64, f64),
    /// Coefficient of the rolling resistance, -.
    pub rolling_resistance: (f64, f64),
    /// Errors of the given contact angles, rad; `None` where none are given.
    pub contact_angle: Option<[(f64, f64); 3]>,
    /// Biases of the gyroscopes on links 1 and 2, rad/s.
    pub rate_bias: [(f64, f64); 2],
}

/// Why there is no estimate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum EstimateError {
    /// A reading has been missing from all frames so far, or was never within what a robot can do.
    Missing {
        /// Which field of [`crate::SensorFrame`].
        field: &'static str,
    },
    /// Time did not increase by at least half a microsecond, or is not a number.
    Time {
        /// Time of the last frame, s.
        last: f64,
        /// Time of this frame, s.
        now: f64,
    },
    /// The four-bar cannot close at these link angles.
    Linkage(PostureError),
    /// The statics are singular in this posture: P lies on the line RS, or the contacts leave a
    /// normal force undetermined.
    Singular,
}

impl core::fmt::Display for EstimateError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Missing { field } => {
                write!(
                    f,
                    "no frame so far has the reading {field}, or none within its limits"
                )
            }
            Self::Time { last, now } => write!(
                f,
                "time must increase by at least 0.5 us: the last frame was at {last} s, this one at {now} s"
            ),
            Self::Linkage(e) => e.fmt(f),
            Self::Singular => write!(
                f,
                "a normal force is undetermined: the statics are singular in this posture, or readings are wrong"
            ),
        }
    }
}

impl core::error::Error for EstimateError {}
