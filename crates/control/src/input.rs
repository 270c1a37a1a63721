//! What a control gets: its settings once, readings and estimate at every sample.

use robhaz_estimator::{Estimate, SensorFrame};
use robhaz_model::{Robot, Units, named};

/// What a control is designed for. SI.
#[derive(Clone, Debug, PartialEq)]
pub struct ControlSettings {
    /// Kind of control.
    pub kind: ControlKind,
    /// The nominal robot.
    pub robot: Robot,
    /// Nominal viscous damping B of a drive, N m s.
    pub viscous_damping: f64,
    /// Proportional gain Kp of one wheel, N m s.
    pub kp: f64,
    /// Integral gain Ki of one wheel, N m.
    pub ki: f64,
    /// Largest motor torque of a wheel, N m.
    pub torque_limit: f64,
    /// Tracking time constant T_t of the anti-windup, s.
    pub tracking_time: f64,
    /// What the kind `friction-test` does.
    pub friction_test: FrictionTestPlan,
}

/// What a friction test is asked to do.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrictionTestPlan {
    /// The wheels (0 to 2) in the order of their tests; `None` where the list has ended.
    pub wheels: [Option<usize>; 3],
    /// Start of the first ramp, s.
    pub start: f64,
    /// Rate at which the torque grows, N m/s.
    pub rate: f64,
    /// Whether each wheel is tested in both directions.
    pub both_ways: bool,
}

impl Default for FrictionTestPlan {
    /// Each wheel in turn from 6 s on, both ways: the robot has rolled for a metre, by which the
    /// errors of the readings are found, at the rate of robot A.
    fn default() -> Self {
        Self {
            wheels: [Some(0), Some(1), Some(2)],
            start: 6.0,
            rate: Self::RATE,
            both_ways: true,
        }
    }
}

impl FrictionTestPlan {
    /// Rate of robot A, N m/s: a wheel slips within 10 s even at mu = 0.9, where it needs 3.5 N m.
    const RATE: f64 = 0.35;
    /// Largest rate of robot A, N m/s: at higher ones the wheel runs away before its slip is found.
    const FASTEST: f64 = 1.0;

    /// The default rate of a robot, N m/s: that of robot A in the robot's [`Units`].
    pub fn usual_rate(robot: &Robot) -> f64 {
        Self::RATE * torque_rate(robot)
    }

    /// The largest rate of a robot, N m/s.
    pub fn fastest_rate(robot: &Robot) -> f64 {
        Self::FASTEST * torque_rate(robot)
    }
}

/// Rate of the torque of a robot that is 1 N m/s of robot A, N m/s.
fn torque_rate(robot: &Robot) -> f64 {
    let units = Units::of(robot);
    units.torque() / units.time
}

/// What a control gets at one sample.
#[derive(Clone, Copy, Debug)]
pub struct ControlInput<'a> {
    /// The readings.
    pub frame: &'a SensorFrame,
    /// The estimate of the same sample; `None` where the estimator has none.
    pub estimate: Option<&'a Estimate>,
    /// Set speed of travel over the wheel radius, rad/s.
    pub set_speed: f64,
}

named! {
    /// Kind of control of the wheels.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
    pub enum ControlKind {
        /// Every drive follows its own plan with its continuous PI control. It needs no readings.
        #[default]
        Speed = "speed",
        /// One speed control, its torque shared so that every wheel needs the same T/N:
        /// [`crate::shared`].
        Shared = "shared",
        /// Torque ramps on one wheel after the other, which find mu_max: [`crate::friction_test`].
        FrictionTest = "friction-test",
    }
}

impl ControlKind {
    /// Whether its commands depend on readings and estimates.
    pub const fn is_closed_loop(self) -> bool {
        match self {
            Self::Speed => false,
            Self::Shared | Self::FrictionTest => true,
        }
    }
}
