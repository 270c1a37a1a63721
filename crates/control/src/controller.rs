//! The control of any kind.

use crate::friction_test::{FrictionTestPlan, FrictionTests};
use crate::kind::ControlKind;
use crate::shared::Shared;
use robhaz_estimator::{Estimate, FrictionTestResult, SensorFrame};
use robhaz_model::{Robot, WheelCommand};

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

/// A control with its state from sample to sample.
#[derive(Clone, Debug)]
pub struct Controller {
    state: State,
}

#[derive(Clone, Debug)]
enum State {
    Speed,
    Shared(Shared),
    FrictionTest(FrictionTests),
}

impl Controller {
    /// A control before its first sample.
    pub fn new(settings: &ControlSettings) -> Self {
        Self {
            state: match settings.kind {
                ControlKind::Speed => State::Speed,
                ControlKind::Shared => State::Shared(Shared::new(settings)),
                ControlKind::FrictionTest => State::FrictionTest(FrictionTests::new(settings)),
            },
        }
    }

    /// The commands of front, middle and rear wheel, from the next sample on.
    pub fn update(&mut self, input: &ControlInput<'_>) -> [WheelCommand; 3] {
        match &mut self.state {
            State::Speed => [WheelCommand::Planned; 3],
            State::Shared(shared) => shared.update(input).map(WheelCommand::Torque),
            State::FrictionTest(tests) => tests.update(input),
        }
    }

    /// Results of the friction tests so far, in their order; those of other kinds have none.
    pub fn friction_tests(&self) -> [Option<FrictionTestResult>; 3] {
        match &self.state {
            State::FrictionTest(tests) => tests.results(),
            State::Speed | State::Shared(_) => [None; 3],
        }
    }
}
