//! Momentum and energy of a run, from its records alone.

use robhaz_model::{Bar, GRAVITY, Vec2};
use robhaz_scene::Scene;
use robhaz_sim::{Truth, WheelTruth, mechanical_energy};

fn momentum(scene: &Scene, truth: &Truth) -> Vec2 {
    let robot = &scene.robot.robot;
    let of_bars: Vec2 = Bar::ALL
        .iter()
        .map(|bar| truth.bar(*bar).velocity * robot.mass.of(*bar).0)
        .sum();
    let of_wheels: Vec2 = (0..3)
        .map(|i| truth.wheel_velocity(robot, i) * robot.mass.wheel)
        .sum();
    of_bars + of_wheels
}

/// Ground and gravity together, N.
fn outer_force(scene: &Scene, truth: &Truth) -> Vec2 {
    let weight = Vec2::new(0.0, -scene.robot.robot.mass.total() * GRAVITY);
    truth.wheels.iter().fold(weight, |sum, w| {
        let (sin, cos) = w.contact_angle.sin_cos();
        sum + Vec2::new(cos, sin) * w.traction + Vec2::new(-sin, cos) * w.normal_force
    })
}

/// What the impulse of ground and gravity leaves unexplained of the robot's momentum, of weight times time, -.
///
/// Impulses by the trapezoidal rule over the records. Where wheels touch at two places or N peaks between records, it says
/// nothing.
pub fn momentum_error(scene: &Scene, truth: &[Truth]) -> f64 {
    let (Some(first), Some(last)) = (truth.first(), truth.last()) else {
        return f64::NAN;
    };
    let impulse: Vec2 = truth
        .windows(2)
        .map(|pair| {
            let mean = 0.5 * (outer_force(scene, &pair[0]) + outer_force(scene, &pair[1]));
            mean * (pair[1].time - pair[0].time)
        })
        .sum();
    let left = impulse - (momentum(scene, last) - momentum(scene, first));
    let weight = scene.robot.robot.mass.total() * GRAVITY;
    left.norm() / (weight * (last.time - first.time))
}

/// Where the motors' work went, J.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Energy {
    /// Work of the motors.
    pub motors: f64,
    /// What damping and friction in the gear, friction on the ground and the contacts took.
    pub losses: f64,
    /// Kinetic and potential energy gained by bars, wheels and rotors.
    pub gain: f64,
}

impl Energy {
    /// What is left unexplained, of the motors' work, -.
    pub fn relative_error(&self) -> f64 {
        (self.motors - self.losses - self.gain) / self.motors
    }
}

/// Where the motors' work went over a run.
///
/// Work by the trapezoidal rule over the records: the penetration works against N, the slip against T. As
/// [`momentum_error`] it says nothing where N peaks between records.
pub fn energy(scene: &Scene, truth: &[Truth]) -> Energy {
    let (mut motors, mut losses) = (0.0, 0.0);
    for pair in truth.windows(2) {
        let dt = pair[1].time - pair[0].time;
        for (a, b) in pair[0].wheels.iter().zip(&pair[1].wheels) {
            let work = |power: &dyn Fn(&WheelTruth) -> f64| 0.5 * dt * (power(a) + power(b));
            motors += work(&|w| w.torque * w.omega);
            losses += work(&|w| scene.drive.loss_torque(w.omega) * w.omega);
            losses += work(&|w| w.traction * w.slip_speed);
            losses += 0.5 * (a.normal_force + b.normal_force) * (b.penetration - a.penetration);
        }
        // The stops take what they give back.
        let opening = |t: &Truth| t.links[0].angle - t.links[1].angle;
        losses -= 0.5
            * (pair[0].stop_torque + pair[1].stop_torque)
            * (opening(&pair[1]) - opening(&pair[0]));
    }
    let gain = match (truth.first(), truth.last()) {
        (Some(first), Some(last)) => {
            let robot = &scene.robot.robot;
            mechanical_energy(robot, last) - mechanical_energy(robot, first)
        }
        _ => f64::NAN,
    };
    Energy {
        motors,
        losses,
        gain,
    }
}
