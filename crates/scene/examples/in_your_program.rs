//! The snippets of docs/in-your-program.md in one program: a test compares them.
//!
//! `cargo run --release -p robhaz-scene --example in_your_program robots/open-source-rover.toml`

use robhaz_control::{ControlInput, ControlKind, ControlSettings, Controller, FrictionTestPlan};
use robhaz_estimator::NoiseBudget;
use robhaz_estimator::whole::{WholeEstimator, WholeFrame};
use robhaz_estimator::{Estimator, EstimatorSettings, LinkReading, SensorFrame};
use robhaz_masses::Tolerances;
use robhaz_model::{BodyMount, BodyReading, Robot, WheelCommand, WholeRover};
use robhaz_scene::LogChoice;
use std::error::Error;
use std::path::Path;

fn main() -> Result<(), Box<dyn Error>> {
    let file = std::env::args().nth(1);
    let file = file.as_deref().unwrap_or("rover.toml");
    let sensors = None; // or Some(Path::new("SENSORS.toml"))
    let (choice, notice) = LogChoice::default().described(sensors, Some(Path::new(file)))?;
    notice.iter().for_each(|notice| eprintln!("{notice}"));
    let robot = &choice.robot.robot;
    let settings = choice.stated(EstimatorSettings::kalman_without_angles());
    let mut estimator = Estimator::new(robot, settings);
    for k in 0..1000 {
        let frame = read_sensors(1e-2 * f64::from(k));
        match estimator.update(&frame) {
            Ok(estimate) => {
                let names: Vec<_> = estimate.flags.names().collect();
                let sigma = estimate.sigma_normal(0).unwrap_or(f64::NAN);
                println!("{:.1} +- {sigma:.1} N {names:?}", estimate.normal_force[0]);
            }
            Err(error) => eprintln!("{error}"), // no number for this instant; go on
        }
    }
    with_a_sensor_in_the_body(robot, settings)?;
    if let Some(rover) = choice.robot.whole_rover() {
        println!("{:.1?} N", of_both_sides(&choice, rover)?);
    }
    println!("{:?}", as_built(robot)?.wheel_radius);
    println!("{}", ground_and_control(robot, settings)?);
    Ok(())
}

/// Your drivers; here a robot that stands on level ground.
fn read_sensors(time: f64) -> SensorFrame {
    let still = LinkReading {
        inclination: Some(0.0),
        rate: Some(0.0),
        ..LinkReading::default()
    };
    SensorFrame {
        time,
        wheel_angle: [Some(0.0); 3],
        motor_torque: [Some(0.01 * (1e3 * time).sin()); 3],
        link1: still,
        link2: still,
        ..SensorFrame::default()
    }
}

/// Normal forces of a rover with both sides, which stands on level ground.
fn of_both_sides(choice: &LogChoice, rover: WholeRover) -> Result<[f64; 6], Box<dyn Error>> {
    let settings = choice.stated(EstimatorSettings::kalman());
    let mut estimator = WholeEstimator::new(&rover, settings, choice.pin)?; // makes the budget that of the body's sensor
    let estimate = estimator.update(&WholeFrame {
        time: 0.0,
        wheel_angle: [Some(0.0); 6],
        motor_torque: [Some(0.0); 6],
        steering: [None; 6],
        pins: [Some(0.0); 2],
        coupling: Some(0.0),
        inclination: Some(0.0),
        roll: Some(0.0),
        rates: [Some(0.0); 3],
    })?;
    Ok(estimate.normal_force)
}

/// The robot as built, in the budget.
fn as_built(robot: &Robot) -> Result<NoiseBudget, Box<dyn Error>> {
    let budget = NoiseBudget {
        load_covariance: Some(Tolerances::built(robot).loads(robot)?),
        wheel_radius: Tolerances::RADIUS,
        ..NoiseBudget::typical_for(robot)
    };
    Ok(budget)
}

fn with_a_sensor_in_the_body(
    robot: &Robot,
    settings: EstimatorSettings,
) -> Result<(), Box<dyn Error>> {
    let pin = [1e-3, 2e-3]; // noise and constant error of its angle, rad
    let budget = settings.budget.of_body_sensors(robot, pin);
    let mut estimator = Estimator::new(robot, EstimatorSettings { budget, ..settings });
    let mut mount = BodyMount::new(&robot.geometry, pin[0]);
    for k in 0..1000 {
        let mut frame = read_sensors(1e-2 * f64::from(k));
        let body = BodyReading {
            inclination: Some(0.0), // nose up positive
            rate: Some(0.0),
            pin: Some(0.0), // theta_1 - theta_2
            wheels: frame.wheel_angle,
        };
        [frame.link1, frame.link2] = mount.links(frame.time, &body);
        estimator.update(&frame)?;
    }
    Ok(())
}

fn ground_and_control(robot: &Robot, settings: EstimatorSettings) -> Result<usize, Box<dyn Error>> {
    let mut estimator = Estimator::new(robot, settings);
    let mut controller = Controller::new(&ControlSettings {
        kind: ControlKind::Shared,
        robot: robot.clone(),
        viscous_damping: settings.viscous_damping,
        kp: 5.0,            // N m s, of one wheel's speed control
        ki: 50.0,           // N m
        torque_limit: 10.0, // N m at the wheel
        tracking_time: 0.1, // s, of the anti-windup
        friction_test: FrictionTestPlan::default(),
    })?;
    let mut profile = Vec::new();
    for k in 0..1000 {
        let frame = read_sensors(1e-2 * f64::from(k));
        let estimate = estimator.update(&frame);
        let commands = controller.update(&ControlInput {
            frame: &frame,
            estimate: estimate.as_ref().ok(),
            set_speed: 2.0, // rad/s: the speed of travel over the wheel radius; change it smoothly
        });
        drive(commands);
        profile.extend(estimator.completed_ground()); // points that the robot has left, in their final form
    }
    profile.extend(estimator.ground()); // those that a wheel may still correct, from rear to front
    let slope = estimator.ground_slope(0.5); // at a place, with its standard deviation
    let places = estimator.wheel_places(); // of the contacts, in the same frame
    println!("{slope:?} {places:?}");
    Ok(profile.len())
}

fn drive(_: [WheelCommand; 3]) {}
