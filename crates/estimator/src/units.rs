//! Units in which the filters compute: of length, mass and time, so that one tuning holds for
//! robots of every size, on every planet.
//!
//! Robots that differ in size alone move alike where their Froude number v^2/(g r) is equal. In
//! units in which the wheels' radius is 0.1 m, the robot's mass 14 kg and gravity 9.81 m/s^2, they
//! give the same numbers; for robot A on Earth these units are SI. Readings and settings are
//! converted at the door, and estimates back.

use crate::estimate::{Estimate, Parity, ReadingErrors};
use crate::frame::{LinkReading, SensorFrame};
use crate::friction::WheelFriction;
use crate::ground::GroundPoint;
use crate::settings::{EstimatorSettings, Method, NoiseBudget, PaperMethod};
use crate::statics::LOAD_PARAMETERS;
use robhaz_model::{GRAVITY, Geometry, MassSet, Outline, PinStop, Pins, Robot};

/// Radius of a wheel, m, and mass of one side, kg, of the robot whose units are SI.
/// Definition.
const RADIUS: f64 = 0.1;
/// Definition.
const MASS: f64 = 14.0;

/// The units of one robot, in SI.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Units {
    /// m
    length: f64,
    /// kg
    mass: f64,
    /// s
    time: f64,
}

impl Units {
    /// For a robot. SI where a number is not above 0 and finite.
    pub fn of(robot: &Robot) -> Self {
        let length = robot.geometry.wheel_radius / RADIUS;
        let mass = robot.mass.total() / MASS;
        let time = robhaz_model::sqrt(length * (GRAVITY / robot.gravity));
        let is_unit = |unit: f64| unit > 0.0 && unit.is_finite();
        if is_unit(length) && is_unit(mass) && is_unit(time) {
            Self { length, mass, time }
        } else {
            Self {
                length: 1.0,
                mass: 1.0,
                time: 1.0,
            }
        }
    }

    fn speed(&self) -> f64 {
        self.length / self.time
    }

    fn force(&self) -> f64 {
        self.mass * self.length / (self.time * self.time)
    }

    fn torque(&self) -> f64 {
        self.force() * self.length
    }

    fn inertia(&self) -> f64 {
        self.mass * self.length * self.length
    }

    /// A time in these units, s.
    pub fn time_out(&self, time: f64) -> f64 {
        time * self.time
    }

    /// A length (m) in these units.
    pub fn length_in(&self, length: f64) -> f64 {
        length / self.length
    }

    /// A length in these units, m.
    pub fn length_out(&self, length: f64) -> f64 {
        length * self.length
    }

    /// A robot in these units, in which gravity is that of Earth.
    pub fn robot_in(&self, robot: &Robot) -> Robot {
        let (geometry, mass) = (&robot.geometry, &robot.mass);
        let Pins { p, q, r, s } = geometry.pins;
        let l = self.length;
        Robot {
            geometry: Geometry {
                suspension: robot.geometry.suspension,
                wheel_radius: geometry.wheel_radius / l,
                axles: geometry.axles.map(|axle| axle / l),
                carriers: geometry.carriers,
                pins: Pins {
                    p: p / l,
                    q: q / l,
                    r: r / l,
                    s: s / l,
                },
                body_cg: geometry.body_cg / l,
                link_cg: geometry.link_cg.map(|cg| cg / l),
                stop: PinStop {
                    stiffness: geometry.stop.stiffness / self.torque(),
                    damping: geometry.stop.damping / (self.torque() * self.time),
                    ..geometry.stop
                },
                outline: Outline {
                    body_lower: geometry.outline.body_lower / l,
                    body_upper: geometry.outline.body_upper / l,
                    half_width: geometry.outline.half_width / l,
                },
            },
            mass: MassSet {
                body: mass.body / self.mass,
                links: mass.links.map(|link| link / self.mass),
                wheel: mass.wheel / self.mass,
                body_inertia: mass.body_inertia / self.inertia(),
                link_inertias: mass.link_inertias.map(|link| link / self.inertia()),
                wheel_inertia: mass.wheel_inertia / self.inertia(),
                rotor_inertia: mass.rotor_inertia / self.inertia(),
            },
            gravity: GRAVITY,
        }
    }

    /// Settings in these units.
    pub fn settings_in(&self, settings: &EstimatorSettings) -> EstimatorSettings {
        EstimatorSettings {
            masses: settings.masses,
            method: match settings.method {
                Method::Paper(method) => Method::Paper(PaperMethod {
                    observer_pole: method.observer_pole * self.time,
                    crossover_time: method.crossover_time / self.time,
                }),
                Method::Kalman(method) => Method::Kalman(method),
            },
            viscous_damping: settings.viscous_damping / (self.torque() * self.time),
            compression: settings.compression / self.length,
            moment_lever: settings.moment_lever / self.length,
            nonnegative: settings.nonnegative,
            budget: self.budget_in(&settings.budget),
        }
    }

    fn budget_in(&self, budget: &NoiseBudget) -> NoiseBudget {
        NoiseBudget {
            jitter: budget.jitter / self.time,
            torque_noise: budget.torque_noise / self.torque(),
            torque_offset: budget.torque_offset / self.torque(),
            gear_friction: budget.gear_friction / self.torque(),
            inclination_lag: budget.inclination_lag / self.time,
            inclination_place: budget.inclination_place / self.length,
            rate_noise: budget.rate_noise * self.time,
            rate_bias: budget.rate_bias * self.time,
            rate_walk: budget.rate_walk * self.time * robhaz_model::sqrt(self.time),
            contact_angle_time: budget.contact_angle_time / self.time,
            body_cg: budget.body_cg / self.length,
            load_covariance: budget.load_covariance.map(|covariance| {
                let mut units = [self.mass * self.length; LOAD_PARAMETERS];
                units[0] = self.mass;
                covariance.in_units(&units)
            }),
            // Angles, counts and ratios.
            ..*budget
        }
    }

    /// Readings in these units.
    pub fn frame_in(&self, frame: &SensorFrame) -> SensorFrame {
        let torque = 1.0 / self.torque();
        let link = |reading: &LinkReading| LinkReading {
            inclination: reading.inclination,
            rate: reading.rate.map(|rate| rate * self.time),
        };
        SensorFrame {
            time: frame.time / self.time,
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
        estimate.scale_forces(self.force());
        // Moments, where the first two are forces.
        for moment in &mut estimate.residual[2..] {
            *moment *= self.length;
        }
        for pin in &mut estimate.pin_from_q {
            *pin *= self.length;
        }
        if let Some(Parity { value, sigma }) = &mut estimate.parity {
            *value *= self.force();
            *sigma *= self.force();
        }
        for wheel in estimate.contact.iter_mut().flatten() {
            wheel.slip *= self.speed();
        }
        for wheel in estimate.friction.iter_mut().flatten() {
            self.friction_out(wheel);
        }
        estimate.reading_errors = estimate
            .reading_errors
            .map(|errors| self.errors_out(errors));
    }

    fn errors_out(&self, errors: ReadingErrors) -> ReadingErrors {
        let torque = |(value, sigma): (f64, f64)| (value * self.torque(), sigma * self.torque());
        let rate = |(value, sigma): (f64, f64)| (value / self.time, sigma / self.time);
        ReadingErrors {
            torque_offset: errors.torque_offset.map(torque),
            gear_friction: torque(errors.gear_friction),
            contact_angle: errors.contact_angle,
            rate_bias: errors.rate_bias.map(rate),
        }
    }

    fn friction_out(&self, wheel: &mut WheelFriction) {
        wheel.slid = wheel.slid.map(|slid| slid * self.length);
        if let Some(event) = &mut wheel.slip_event {
            event.load *= self.force();
            event.age *= self.time;
            event.place = event.place.map(|place| place * self.length);
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
            *length *= self.length;
        }
        point
    }
}
