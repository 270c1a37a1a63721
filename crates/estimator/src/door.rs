//! The door of the estimator: readings and settings are converted into the [`Units`] of the robot,
//! in which one tuning holds for all, and estimates back.

use crate::estimate::{Estimate, Parity, ReadingErrors};
use crate::frame::{LinkReading, SensorFrame};
use crate::friction::WheelFriction;
use crate::ground::GroundPoint;
use crate::settings::{EstimatorSettings, Method, NoiseBudget, PaperMethod};
use crate::statics::LOAD_PARAMETERS;
use robhaz_model::{Robot, Units};

/// Converts to and from the units of a robot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Door(Units);

impl Door {
    pub fn of(robot: &Robot) -> Self {
        Self(Units::of(robot))
    }

    /// A robot in these units.
    pub fn robot_in(&self, robot: &Robot) -> Robot {
        self.0.robot_in(robot)
    }

    /// A time in these units, s.
    pub fn time_out(&self, time: f64) -> f64 {
        time * self.0.time
    }

    /// A length (m) in these units.
    pub fn length_in(&self, length: f64) -> f64 {
        length / self.0.length
    }

    /// A length in these units, m.
    pub fn length_out(&self, length: f64) -> f64 {
        length * self.0.length
    }

    /// Settings in these units.
    pub fn settings_in(&self, settings: &EstimatorSettings) -> EstimatorSettings {
        EstimatorSettings {
            masses: settings.masses,
            method: match settings.method {
                Method::Paper(method) => Method::Paper(PaperMethod {
                    observer_pole: method.observer_pole * self.0.time,
                    crossover_time: method.crossover_time / self.0.time,
                }),
                Method::Kalman(method) => Method::Kalman(method),
            },
            viscous_damping: settings.viscous_damping / (self.0.torque() * self.0.time),
            compression: settings.compression / self.0.length,
            moment_lever: settings.moment_lever / self.0.length,
            nonnegative: settings.nonnegative,
            budget: self.budget_in(&settings.budget),
        }
    }

    fn budget_in(&self, budget: &NoiseBudget) -> NoiseBudget {
        NoiseBudget {
            jitter: budget.jitter / self.0.time,
            torque_noise: budget.torque_noise / self.0.torque(),
            torque_offset: budget.torque_offset / self.0.torque(),
            gear_friction: budget.gear_friction / self.0.torque(),
            inclination_lag: budget.inclination_lag / self.0.time,
            inclination_place: budget.inclination_place / self.0.length,
            rate_noise: budget.rate_noise * self.0.time,
            rate_bias: budget.rate_bias * self.0.time,
            rate_walk: budget.rate_walk * self.0.time * robhaz_model::sqrt(self.0.time),
            contact_angle_time: budget.contact_angle_time / self.0.time,
            body_cg: budget.body_cg / self.0.length,
            load_covariance: budget.load_covariance.map(|covariance| {
                let mut units = [self.0.mass * self.0.length; LOAD_PARAMETERS];
                units[0] = self.0.mass;
                covariance.in_units(&units)
            }),
            // Angles, counts and ratios.
            ..*budget
        }
    }

    /// Readings in these units.
    pub fn frame_in(&self, frame: &SensorFrame) -> SensorFrame {
        let torque = 1.0 / self.0.torque();
        let link = |reading: &LinkReading| LinkReading {
            inclination: reading.inclination,
            rate: reading.rate.map(|rate| rate * self.0.time),
        };
        SensorFrame {
            time: frame.time / self.0.time,
            wheel_angle: frame.wheel_angle,
            motor_torque: frame
                .motor_torque
                .map(|reading| reading.map(|t| t * torque)),
            link1: link(&frame.link1),
            link2: link(&frame.link2),
            contact_angle: frame.contact_angle,
        }
    }

    /// Puts an estimate into SI, of the readings at `time`, s.
    pub fn estimate_out(&self, estimate: &mut Estimate, time: f64) {
        estimate.time = time;
        estimate.scale_forces(self.0.force());
        // Moments, where the first two are forces.
        for moment in &mut estimate.residual[2..] {
            *moment *= self.0.length;
        }
        for pin in &mut estimate.pin_from_q {
            *pin *= self.0.length;
        }
        if let Some(Parity { value, sigma }) = &mut estimate.parity {
            *value *= self.0.force();
            *sigma *= self.0.force();
        }
        for wheel in estimate.contact.iter_mut().flatten() {
            wheel.slip *= self.0.speed();
        }
        for wheel in estimate.friction.iter_mut().flatten() {
            self.friction_out(wheel);
        }
        estimate.reading_errors = estimate
            .reading_errors
            .map(|errors| self.errors_out(errors));
    }

    fn errors_out(&self, errors: ReadingErrors) -> ReadingErrors {
        let torque =
            |(value, sigma): (f64, f64)| (value * self.0.torque(), sigma * self.0.torque());
        let rate = |(value, sigma): (f64, f64)| (value / self.0.time, sigma / self.0.time);
        ReadingErrors {
            torque_offset: errors.torque_offset.map(torque),
            gear_friction: torque(errors.gear_friction),
            contact_angle: errors.contact_angle,
            rate_bias: errors.rate_bias.map(rate),
        }
    }

    fn friction_out(&self, wheel: &mut WheelFriction) {
        wheel.slid = wheel.slid.map(|slid| slid * self.0.length);
        if let Some(event) = &mut wheel.slip_event {
            event.load *= self.0.force();
            event.age *= self.0.time;
            event.place = event.place.map(|place| place * self.0.length);
        }
    }

    /// A point of the ground in SI.
    pub fn point_out(&self, mut point: GroundPoint) -> GroundPoint {
        for length in [
            &mut point.x,
            &mut point.sigma_x,
            &mut point.height,
            &mut point.sigma_height,
        ] {
            *length *= self.0.length;
        }
        point
    }
}
