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

/// A number of [`ControlSettings`] with which there is no control.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error(
    "{field} is {found}: gains and damping are at least 0, limits and times above 0, all finite"
)]
pub struct ControlSettingsError {
    /// Its name.
    pub field: &'static str,
    /// Its value.
    pub found: f64,
}

impl ControlSettings {
    /// Whether there is a control with these numbers; [`ControlKind::Speed`] needs none of them.
    ///
    /// # Errors
    /// The first number that is negative or not finite, or 0 where that is no limit and no time.
    pub fn check(&self) -> Result<(), ControlSettingsError> {
        let mean_load = self.robot.mean_wheel_load();
        let all = [
            ("viscous_damping", self.viscous_damping, true),
            ("kp", self.kp, true),
            ("ki", self.ki, true),
            ("torque_limit", self.torque_limit, false),
            ("tracking_time", self.tracking_time, false),
            ("robot.mean_wheel_load", mean_load, false),
            ("friction_test.start", self.friction_test.start, true),
            ("friction_test.rate", self.friction_test.rate, false),
        ];
        let is_wrong = |(_, found, may_be_zero): &(&str, f64, bool)| {
            let is_some = *found > 0.0 || *may_be_zero && *found >= 0.0;
            !(is_some && found.is_finite())
        };
        match all.into_iter().find(is_wrong) {
            Some((field, found, _)) if self.kind.is_closed_loop() => {
                Err(ControlSettingsError { field, found })
            }
            _ => Ok(()),
        }
    }
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
    pub const RATE: f64 = 0.35;
    /// Largest rate of robot A, N m/s: at higher ones the wheel runs away before its slip is found.
    pub const FASTEST: f64 = 1.0;

    /// Rate of the torque of a robot that is 1 N m/s of robot A, in the robot's [`Units`], N m/s.
    pub fn unit_rate(robot: &Robot) -> f64 {
        let units = Units::of(robot);
        units.torque() / units.time
    }
}

/// What a control gets at one sample.
#[derive(Clone, Copy, Debug)]
pub struct ControlInput<'a> {
    /// The readings.
    pub frame: &'a SensorFrame,
    /// The estimate of the same sample; `None` where the estimator has none.
    pub estimate: Option<&'a Estimate>,
    /// Set speed of travel over the wheel radius, rad/s; where it is not finite, the last one holds (0 before the first).
    pub set_speed: f64,
}

impl ControlInput<'_> {
    /// The input with the set speed that holds, of which `held` is the last one, rad/s.
    pub(crate) fn holding(mut self, held: &mut f64) -> Self {
        if self.set_speed.is_finite() {
            *held = self.set_speed;
        }
        self.set_speed = *held;
        self
    }

    /// The torques that were read, N m; `None` of one that is no finite number.
    pub(crate) fn torques(&self) -> [Option<f64>; 3] {
        let known = |torque: Option<f64>| torque.filter(|torque| torque.is_finite());
        self.frame.motor_torque.map(known)
    }
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
