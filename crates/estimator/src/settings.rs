//! The choices of an estimator, and the standard deviations of the sensors' errors.

use crate::deviation::root_sum_square;
use crate::statics::LoadCovariance;
use robhaz_model::{LoadShift, Robot, Units, Vec2, named};

named! {
    /// Where the estimator takes the linkage's mass to be.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    pub enum Masses {
        /// Concentrated in the body's centre of mass (Fig. 7).
        LumpedToBody = "body",
        /// Shared evenly by the wheels (Fig. 8).
        LumpedToWheels = "wheels",
        /// At the links' own centres of mass.
        True = "true",
    }
}

/// What the equations of one side are of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sides {
    /// All that there is: a robot in the plane, such as a simulated one, or a test rig of one side.
    Plane,
    /// One side of a robot with two. The other one pushes it through the body, and on a cross slope
    /// the weight is not shared evenly.
    OneOfTwo,
}

impl Sides {
    /// What would show what one side of two cannot, for messages.
    pub const REMEDY: &str = "the readings of the other side and the body's roll would show both; of a robot in the plane, or a test rig, state sides = \"plane\"";
}

/// How tractions and link angles follow from the readings, with the choices that only that method
/// has.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Method {
    /// As in the paper: eq. (3), a complementary filter for Fig. 5, gravity alone. States no
    /// covariance.
    Paper(PaperMethod),
    /// Kalman filters. States the covariance of the forces.
    Kalman(KalmanMethod),
}

/// Time constants of the paper's filters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PaperMethod {
    /// Pole omega_c of the traction observer, eq. (3), rad/s.
    pub observer_pole: f64,
    /// Crossover time between gyroscope (shorter times) and inclinometer (longer times), s.
    pub crossover_time: f64,
}

named! {
    /// Where the contact angles come from.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    pub enum ContactAngles {
        /// They are readings, as the paper assumes: [`crate::SensorFrame::contact_angle`].
        Given = "given",
        /// No frame has any: they are estimated from the other readings. Frames may still have
        /// some; they are ignored.
        Unknown = "none",
    }
}

/// Steps that use the Kalman filters' results. Each works without the others.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct KalmanMethod {
    /// Where the contact angles come from. Without readings only the rolling constraints find them:
    /// `rolling` must be on.
    pub contact_angles: ContactAngles,
    /// Whether inertial loads are added to gravity.
    pub inertia: bool,
    /// Whether the equations are weighted by the inverse covariance of their right-hand side.
    pub whitening: bool,
    /// Whether the parity residual corrects torques and contact angles.
    pub parity: bool,
    /// Whether the rolling constraints correct torques and contact angles: a wheel's centre moves
    /// along the ground, and the wheel slips in proportion to T/N.
    pub rolling: bool,
}

impl PaperMethod {
    /// omega_c = 50 rad/s, crossover at 0.5 s.
    pub const DEFAULT: Self = Self {
        observer_pole: 50.0,
        crossover_time: 0.5,
    };
}

impl KalmanMethod {
    /// The filters alone.
    pub const FILTERS_ONLY: Self = Self::with_steps(false);
    /// Every step.
    pub const DEFAULT: Self = Self::with_steps(true);

    const fn with_steps(all: bool) -> Self {
        Self {
            contact_angles: ContactAngles::Given,
            inertia: all,
            whitening: all,
            parity: all,
            rolling: all,
        }
    }
}

/// Standard deviations of the readings' errors, from data sheets or measured at rest.
///
/// Errors that are not white are drawn once (offset, gain, bias) or are random walks; `kalman`
/// estimates them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NoiseBudget {
    /// Encoder counts in a turn of the wheel (motor-side counts times gear ratio); 0 for an exact
    /// angle.
    pub encoder_counts: f64,
    /// Error of the time stamp, s.
    pub jitter: f64,
    /// White noise of the motor torque, N m a sample.
    pub torque_noise: f64,
    /// Constant offset of a motor's torque reading, N m.
    pub torque_offset: f64,
    /// Relative error of a motor's torque reading.
    pub torque_gain: f64,
    /// Unmodelled dry friction in the gears, N m at the wheel; common to all wheels. The torques show its
    /// sum with rolling resistance.
    pub gear_friction: f64,
    /// Deviation of the coefficient of the rolling resistance, -: a moment of this times r N against the
    /// rolling, as if N acted ahead of the axle. Common to all wheels. At 0 there is none.
    pub rolling_resistance: f64,
    /// Moment that a pin of the linkage transmits beside its force, N m: friction, cables across it. Of
    /// both sides, also the bearings of a differential's rockers and the hinge of a rear bogie.
    pub pin_moment: f64,
    /// White noise of an inclinometer, rad a sample.
    pub inclination_noise: f64,
    /// Constant error of an inclinometer, rad.
    pub inclination_bias: f64,
    /// Whether the inclinometers measure acceleration as well as gravity, as real ones do.
    pub specific_force: bool,
    /// Time constant of the inclinometers' low pass, s: 1/(2 pi bandwidth).
    pub inclination_lag: f64,
    /// Distance of an inclinometer from the centre of mass of its link, m, as a standard deviation.
    /// It measures the acceleration of its place.
    pub inclination_place: f64,
    /// White noise of a gyroscope, rad/s a sample.
    pub rate_noise: f64,
    /// Bias of a gyroscope at the start, rad/s.
    pub rate_bias: f64,
    /// Random walk of that bias, rad/s/sqrt(s).
    pub rate_walk: f64,
    /// Error of the given contact angles, rad.
    pub contact_angle: f64,
    /// Correlation time of that error, s.
    pub contact_angle_time: f64,
    /// Error of the position of the body's centre of mass in the nominal parameters, m.
    pub body_cg: f64,
    /// Relative error of each link's mass.
    pub link_mass: f64,
    /// Mass that the body may carry or lack beside the nominal one, kg: cargo, an arm's load, a battery. Of a
    /// robot of one side, what that side carries. Its centre is that of the body, with the error
    /// [`Self::body_cg`].
    pub payload: f64,
    /// Errors of masses, centres of mass and pins together, of a robot that was weighed. They count
    /// in addition to the two above, which are 0 then.
    pub load_covariance: Option<LoadCovariance>,
    /// Relative error of each wheel's rolling radius.
    pub wheel_radius: f64,
    /// Angle by which wheels are not parallel, of a rover with both sides, rad: toe, and play of the axles. It makes
    /// axial forces. [`Self::typical`]: a fifth of a degree.
    pub toe: f64,
    /// Error of each steering angle, of a rover with both sides, rad. [`Self::typical`]: half a degree.
    pub steering: f64,
    /// Standard deviation of the slope across the way, rad, of logs of [`Sides::OneOfTwo`]: it moves
    /// the weight from one side to the other. [`Self::typical`]: that of slopes evenly spread between
    /// -10 and 10 deg, 5.8 deg, rounded.
    pub cross_slope: f64,
}

impl NoiseBudget {
    /// [`Self::typical`] of a robot of another weight and size: what its torques and its gears err by,
    /// in proportion to weight and wheel radius, as the torques that its drives must give.
    pub fn typical_for(robot: &Robot) -> Self {
        let (typical, torque) = (Self::typical(), Units::of(robot).torque());
        Self {
            torque_noise: torque * typical.torque_noise,
            torque_offset: torque * typical.torque_offset,
            gear_friction: torque * typical.gear_friction,
            ..typical
        }
    }

    /// The budget of the angles of links that [`robhaz_model::BodyMount`] makes of an IMU in the body
    /// and the angle of a pin with this white `noise` and `bias`, rad: they add to those of the
    /// inclinometers. What the pin's rate errs by is that of each reading
    /// ([`crate::LinkReading::rate_error`]). The inclinometer measures the acceleration of the body,
    /// as far from each link as both centres of mass are from each other.
    #[must_use]
    pub fn of_body_sensors(self, robot: &Robot, [noise, bias]: [f64; 2]) -> Self {
        let links = &robot.geometry.link_cg[..2];
        let away = |link: &Vec2| robhaz_model::sqrt((link - robot.geometry.body_cg).norm_squared());
        let place = links.iter().map(away).fold(0.0, f64::max);
        Self {
            inclination_noise: root_sum_square(self.inclination_noise, noise),
            inclination_bias: root_sum_square(self.inclination_bias, bias),
            inclination_place: root_sum_square(self.inclination_place, place),
            ..self
        }
    }

    /// White noise of an inclinometer, rad a sample. With a budget of zero the gyroscope would count
    /// for nothing: it is 0.5 mrad at least.
    pub(crate) fn inclinometer_noise(&self) -> f64 {
        /// Guard.
        const LEAST: f64 = 5e-4;
        root_sum_square(self.inclination_noise, LEAST)
    }

    /// Sensors of the class that robot A carries, up to 0.3 N m of gear friction, wheels on firm
    /// ground, exact nominal parameters.
    ///
    /// Rolling resistance of tyres on concrete and asphalt is 0.010 to 0.020 (Wong, Theory of
    /// Ground Vehicles, ch. 1).
    pub const fn typical() -> Self {
        const DEGREE: f64 = core::f64::consts::PI / 180.0;
        Self {
            encoder_counts: 160_000.0,
            jitter: 0.0,
            torque_noise: 0.1,
            torque_offset: 0.1,
            torque_gain: 0.02,
            gear_friction: 0.3,
            rolling_resistance: 0.01,
            pin_moment: 0.0,
            inclination_noise: 0.1 * DEGREE,
            inclination_bias: 0.1 * DEGREE,
            specific_force: true,
            inclination_lag: 0.0,
            inclination_place: 0.1,
            rate_noise: 0.1 * DEGREE,
            rate_bias: 0.0,
            rate_walk: 0.0,
            contact_angle: 2.0 * DEGREE,
            contact_angle_time: 0.3,
            body_cg: 0.0,
            link_mass: 0.0,
            payload: 0.0,
            load_covariance: None,
            wheel_radius: 0.0,
            toe: 0.2 * DEGREE,
            steering: 0.5 * DEGREE,
            cross_slope: 6.0 * DEGREE,
        }
    }
}

/// Choices of an estimator.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EstimatorSettings {
    /// Where the linkage's mass is taken to be.
    pub masses: Masses,
    /// What the robot of one side is a side of. Readings do not show it.
    pub sides: Sides,
    /// How load moves between the sides of a robot of [`Sides::OneOfTwo`].
    pub load_shift: LoadShift,
    /// How tractions and link angles are found.
    pub method: Method,
    /// Nominal viscous damping B of the wheel module, N m s.
    pub viscous_damping: f64,
    /// Efficiency of the gears, of torques that are read before them (as times the gear ratio), -: a wheel
    /// that is driven gets this part of the torque, one that brakes takes the torque over this part of it.
    /// 1 of torques behind the gears.
    pub gear_efficiency: f64,
    /// Nominal compression of wheel and ground at the mean wheel load, m: a wheel rolls with its
    /// radius less this. Measured by driving a known distance. Only the places of the ground use it
    /// ([`crate::Estimator::ground`]).
    pub compression: f64,
    /// Row scaling of eq. (8): moments count as forces at this lever, m. 1 m leaves N and N m as
    /// they are, as the paper does. The result of an unweighted least squares depends on it.
    pub moment_lever: f64,
    /// Whether negative normal forces are excluded.
    pub nonnegative: bool,
    /// Errors of the readings.
    pub budget: NoiseBudget,
}

impl EstimatorSettings {
    /// Part of the mean wheel load below which a wheel counts as unloaded: a twentieth. Such a
    /// wheel does not roll for sure, and its T/N is mostly noise.
    /// Chosen.
    pub(crate) const UNLOADED: f64 = 0.05;

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

    /// `true-mass`: the links' masses at their own places; all else as in the paper. B = 0.15 N m
    /// s.
    pub const fn true_mass() -> Self {
        Self {
            masses: Masses::True,
            sides: Sides::Plane,
            load_shift: LoadShift::UNKNOWN,
            method: Method::Paper(PaperMethod::DEFAULT),
            viscous_damping: 0.15,
            gear_efficiency: 1.0,
            compression: 0.0,
            moment_lever: 1.0,
            nonnegative: false,
            budget: NoiseBudget::typical(),
        }
    }

    /// `kalman`: true masses, Kalman filters with every step, N >= 0.
    pub const fn kalman() -> Self {
        Self {
            method: Method::Kalman(KalmanMethod::DEFAULT),
            moment_lever: 0.2,
            nonnegative: true,
            ..Self::true_mass()
        }
    }

    /// `kalman` on a robot that does not know its contact angles.
    pub const fn kalman_without_angles() -> Self {
        Self {
            method: Method::Kalman(KalmanMethod {
                contact_angles: ContactAngles::Unknown,
                ..KalmanMethod::DEFAULT
            }),
            ..Self::kalman()
        }
    }

    /// Whether frames must have contact angles.
    pub const fn needs_contact_angles(&self) -> bool {
        match self.method {
            Method::Paper(_) => true,
            Method::Kalman(method) => matches!(method.contact_angles, ContactAngles::Given),
        }
    }

    /// Whether the method is one with Kalman filters: its estimates carry a covariance, contact
    /// states and the ground.
    pub const fn states_covariance(&self) -> bool {
        matches!(self.method, Method::Kalman(_))
    }
}
