//! `kalman` on robots of other sizes and on other planets.

use robhaz_estimator::{
    Estimate, EstimateError, Estimator, EstimatorSettings, Flags, LinkReading, Method, NoiseBudget,
    PaperMethod, SensorFrame,
};
use robhaz_model::{GRAVITY, Geometry, MassSet, Outline, PinStop, Pins, Robot};
use robhaz_scene::Scene;
use robhaz_study::TruthRun;
use std::path::Path;

/// A robot `size` times as large, of the same density, under another gravity: Froude's units of
/// length, mass and time.
#[derive(Clone, Copy)]
struct Scale {
    length: f64,
    mass: f64,
    time: f64,
    gravity: f64,
}

impl Scale {
    fn new(size: f64, gravity: f64) -> Self {
        Self {
            length: size,
            mass: size.powi(3),
            time: (size * GRAVITY / gravity).sqrt(),
            gravity,
        }
    }

    fn force(self) -> f64 {
        self.mass * self.length / self.time.powi(2)
    }

    fn torque(self) -> f64 {
        self.force() * self.length
    }

    fn robot(self, robot: &Robot) -> Robot {
        let (geometry, mass) = (&robot.geometry, &robot.mass);
        let (l, m, inertia) = (self.length, self.mass, self.mass * self.length.powi(2));
        let Pins { p, q, r, s } = geometry.pins;
        Robot {
            geometry: Geometry {
                suspension: geometry.suspension,
                wheel_radius: geometry.wheel_radius * l,
                axles: geometry.axles.map(|axle| axle * l),
                pins: Pins {
                    p: p * l,
                    q: q * l,
                    r: r * l,
                    s: s * l,
                },
                body_cg: geometry.body_cg * l,
                link_cg: geometry.link_cg.map(|cg| cg * l),
                stop: PinStop {
                    stiffness: geometry.stop.stiffness * self.torque(),
                    ..geometry.stop
                },
                carriers: geometry.carriers,
                outline: Outline { ..geometry.outline },
            },
            mass: MassSet {
                body: mass.body * m,
                links: mass.links.map(|link| link * m),
                wheel: mass.wheel * m,
                body_inertia: mass.body_inertia * inertia,
                link_inertias: mass.link_inertias.map(|link| link * inertia),
                wheel_inertia: mass.wheel_inertia * inertia,
                rotor_inertia: mass.rotor_inertia * inertia,
            },
            gravity: self.gravity,
        }
    }

    fn settings(self, settings: &EstimatorSettings) -> EstimatorSettings {
        let budget = &settings.budget;
        EstimatorSettings {
            method: match settings.method {
                Method::Paper(method) => Method::Paper(PaperMethod {
                    observer_pole: method.observer_pole / self.time,
                    crossover_time: method.crossover_time * self.time,
                }),
                Method::Kalman(method) => Method::Kalman(method),
            },
            viscous_damping: settings.viscous_damping * self.torque() * self.time,
            compression: settings.compression * self.length,
            moment_lever: settings.moment_lever * self.length,
            budget: NoiseBudget {
                jitter: budget.jitter * self.time,
                torque_noise: budget.torque_noise * self.torque(),
                torque_offset: budget.torque_offset * self.torque(),
                gear_friction: budget.gear_friction * self.torque(),
                inclination_lag: budget.inclination_lag * self.time,
                inclination_place: budget.inclination_place * self.length,
                rate_noise: budget.rate_noise / self.time,
                rate_bias: budget.rate_bias / self.time,
                rate_walk: budget.rate_walk / self.time.powf(1.5),
                contact_angle_time: budget.contact_angle_time * self.time,
                body_cg: budget.body_cg * self.length,
                ..*budget
            },
            ..*settings
        }
    }

    fn frame(self, frame: &SensorFrame) -> SensorFrame {
        let link = |link: LinkReading| LinkReading {
            inclination: link.inclination,
            rate: link.rate.map(|rate| rate / self.time),
            rate_error: 0.0,
        };
        SensorFrame {
            time: frame.time * self.time,
            motor_torque: frame.motor_torque.map(|t| t.map(|t| t * self.torque())),
            link1: link(frame.link1),
            link2: link(frame.link2),
            ..*frame
        }
    }
}

fn estimates(
    robot: &Robot,
    settings: EstimatorSettings,
    frames: &[SensorFrame],
) -> Result<Vec<Estimate>, EstimateError> {
    let mut estimator = Estimator::new(robot, settings);
    let estimates = frames.iter().map(|frame| estimator.update(frame));
    estimates.collect()
}

/// Property: robots that differ by Froude's scale alone have the same estimates over that scale: no
/// constant of the estimator has a dimension that the robot does not scale. A third and three times
/// the size, on the Moon and on Mars; `kalman` with and without contact angles and `paper-wheels`.
/// The poor grade has every kind of error. Rounding of 1e-16 in each of some thousand samples,
/// which the filters converge: 1e-9 of the load.
#[test]
fn estimates_scale_with_the_robot() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/smooth.toml");
    let overrides = [
        "engine.kind=direct",
        "sensors.grade=poor",
        "record.duration=8",
        "estimator=[{name='kalman'},{name='kalman',label='none',contact_angles='none'},{name='paper-wheels'}]",
    ];
    let scene = Scene::load(&path, &overrides.map(str::to_owned)).expect("a shipped scene");
    let truth = TruthRun::of(&scene).expect("a run");
    let mut sensors = scene.sensors();
    let readings = truth.samples().map(|t| sensors.read(t));
    let frames: Vec<SensorFrame> = readings.collect();
    let robot = scene.nominal_robot().expect("small errors");
    for choice in &scene.estimators {
        let settings = scene.nominal_settings(choice).expect("small errors");
        let expected = estimates(&robot, settings, &frames).expect("estimates");
        for (size, gravity) in [
            (1.0 / 3.0, GRAVITY),
            (3.0, GRAVITY),
            (1.0, 1.62),
            (3.0, 3.71),
        ] {
            let scale = Scale::new(size, gravity);
            let scaled: Vec<SensorFrame> = frames.iter().map(|f| scale.frame(f)).collect();
            let found = estimates(&scale.robot(&robot), scale.settings(&settings), &scaled);
            let found = found.expect("estimates");
            let load = robot.mean_wheel_load();
            for (found, expected) in found.iter().zip(&expected) {
                let mut error: f64 = 0.0;
                for i in 0..3 {
                    let of = |found: f64, expected: f64| (found / scale.force() - expected).abs();
                    error = error.max(of(found.normal_force[i], expected.normal_force[i]));
                    error = error.max(of(found.traction[i], expected.traction[i]));
                    let sigmas = found.sigma_normal(i).zip(expected.sigma_normal(i));
                    error = error.max(sigmas.map_or(0.0, |(a, b)| of(a, b)));
                }
                let time = expected.time;
                assert!(error < 1e-9 * load, "{size} {gravity} {time} s: {error} N");
                let unread = Flags::SENSOR_ABSURD;
                assert_eq!(
                    found.flags.contains(unread),
                    expected.flags.contains(unread)
                );
            }
        }
    }
}
