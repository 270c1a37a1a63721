//! Shared traction in closed loop: a robot climbs a slope of 10 deg and shares its torque so that
//! every wheel needs the same friction. Beside it the same climb with equal torques.
//!
//! `cargo run --release --example closed_loop`
//!
//! The robot here rolls without slip up an even slope, so its motion follows in closed form. Readings
//! have no errors.

use robhaz_control::{
    ControlInput, ControlKind, ControlSettings, Controller, FrictionTestPlan, WheelCommand,
};
use robhaz_estimator::{Estimator, EstimatorSettings, LinkReading, SensorFrame};
use robhaz_model::Robot;

/// Angle of the slope, rad.
const SLOPE: f64 = 10.0 * std::f64::consts::PI / 180.0;
/// Time between samples, s.
const STEP: f64 = 1e-3;
/// Set speed of the wheels, rad/s: 0.2 m/s.
const SPEED: f64 = 2.0;
/// Viscous damping of a drive, N m s.
const DAMPING: f64 = 0.15;

/// A robot that rolls up the slope.
struct Plant {
    robot: Robot,
    /// Turn (rad) and speed (rad/s) of the wheels, which all turn alike.
    turn: f64,
    spin: f64,
    /// Motor torques, N m.
    torque: [f64; 3],
}

impl Plant {
    /// Spin acceleration, rad/s^2: `(m + 3 J/r^2) r domega/dt = sum(tau - B omega)/r - m g sin`.
    fn acceleration(&self) -> f64 {
        let (mass, r) = (&self.robot.mass, self.robot.geometry.wheel_radius);
        let inertia = 3.0 * (mass.wheel_inertia + mass.rotor_inertia) + mass.total() * r * r;
        let weight = mass.total() * self.robot.gravity * SLOPE.sin() * r;
        let torque: f64 = self.torque.iter().sum();
        (torque - 3.0 * DAMPING * self.spin - weight) / inertia
    }

    fn advance(&mut self) {
        self.spin += STEP * self.acceleration();
        self.turn += STEP * self.spin;
    }

    /// What sensors without errors read.
    fn readings(&self, time: f64) -> SensorFrame {
        let link = LinkReading {
            // An inclinometer measures the direction of the specific force.
            inclination: {
                let along = self.robot.geometry.wheel_radius * self.acceleration();
                let (sin, cos) = SLOPE.sin_cos();
                Some((along + self.robot.gravity * sin).atan2(self.robot.gravity * cos))
            },
            rate: Some(0.0),
            rate_error: 0.0,
        };
        SensorFrame {
            time,
            wheel_angle: [Some(self.turn); 3],
            motor_torque: self.torque.map(Some),
            link1: link,
            link2: link,
            contact_angle: [Some(SLOPE); 3],
            ..SensorFrame::default()
        }
    }
}

/// Largest over smallest estimate of T/N of the wheels after 6 s. Torques are shared, or equal.
fn climb(robot: &Robot, shared: bool) -> Result<f64, Box<dyn std::error::Error>> {
    let settings = ControlSettings {
        kind: ControlKind::Shared,
        robot: robot.clone(),
        viscous_damping: DAMPING,
        kp: 2.0,
        ki: 10.0,
        torque_limit: 10.0,
        tracking_time: 0.1,
        friction_test: FrictionTestPlan::default(),
    };
    let mut controller = Controller::new(&settings)?;
    let mut estimator = Estimator::new(robot, EstimatorSettings::kalman());
    let weight = robot.mass.total() * robot.gravity * SLOPE.sin();
    // At rest the motors hold the robot.
    let holding = weight * robot.geometry.wheel_radius / 3.0;
    let mut plant = Plant {
        robot: robot.clone(),
        turn: 0.0,
        spin: 0.0,
        torque: [holding; 3],
    };
    let mut ratio = [0.0; 3];
    for k in 0..6000 {
        let time = STEP * f64::from(k);
        let frame = plant.readings(time);
        let estimate = estimator.update(&frame)?;
        ratio = [0, 1, 2].map(|i| estimate.traction[i] / estimate.normal_force[i]);
        let commands = controller.update(&ControlInput {
            frame: &frame,
            estimate: Some(&estimate),
            set_speed: SPEED * (time / 2.0).min(1.0),
        });
        let torque = commands.map(|command| match command {
            WheelCommand::Torque(torque) => torque,
            // This kind of control commands torques alone.
            _ => 0.0,
        });
        let mean = torque.iter().sum::<f64>() / 3.0;
        plant.torque = if shared { torque } else { [mean; 3] };
        plant.advance();
    }
    let name = if shared { "shared" } else { "equal" };
    let [front, middle, rear] = ratio;
    println!(
        "{name:>7}: T/N {front:.3}, {middle:.3}, {rear:.3}; {:.3} m/s",
        plant.spin * robot.geometry.wheel_radius
    );
    let largest = ratio.into_iter().fold(f64::MIN, f64::max);
    Ok(largest / ratio.into_iter().fold(f64::MAX, f64::min))
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let robot = Robot::default_a();
    println!(
        "friction that each wheel needs on a slope of 10 deg, whose tangent is {:.3}",
        SLOPE.tan()
    );
    let equal = climb(&robot, false)?;
    let shared = climb(&robot, true)?;
    println!("largest over smallest T/N: {equal:.3} with equal torques, {shared:.3} shared");
    Ok(())
}
