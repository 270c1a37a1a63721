//! Motion of the robot as encoders and inclinometers show it.

use crate::check::recording::Recording;
use crate::check::signal::{derivative, median, smooth, zip};
use robhaz_estimator::DRIVING_SPEED;
use robhaz_model::{Robot, Units, Vec2, rotate};

/// Time over which speeds and angles are averaged, s.
const SMOOTHING: f64 = 0.05;

/// Motion of the robot, from the readings alone.
pub struct Motion {
    /// Spin speed of each wheel, rad/s.
    pub spin: [Vec<f64>; 3],
    /// Middle one of the three spin speeds, rad/s.
    pub middle_spin: Vec<f64>,
    /// Step, s.
    pub step: f64,
    /// Slope of the line from the rear to the front axle, rad.
    pub slope: Vec<f64>,
    /// Spin speed of a robot that drives, rad/s.
    least_spin: f64,
}

impl Motion {
    /// The motion of a recording.
    pub fn of(recording: &Recording, robot: &Robot) -> Self {
        let half = recording.steps(0.5 * SMOOTHING);
        let angles = recording.wheel_angle.each_ref();
        let spin = angles.map(|angle| derivative(angle, half, recording.dt));
        let middle = |k: usize| median(spin.each_ref().map(|s| s[k])).unwrap_or(f64::NAN);
        let inclination = recording.inclination.each_ref().map(|x| smooth(x, half));
        let geometry = &robot.geometry;
        let axle = |i: usize| -> Vec<Vec2> {
            let arm = geometry.axles[i] - geometry.pins.q;
            let angles = inclination[geometry.carriers[i].index()].iter();
            angles.map(|angle| rotate(arm, *angle)).collect()
        };
        let (front, rear) = (axle(0), axle(2));
        let line = |(f, r): (&Vec2, &Vec2)| (f.y - r.y).atan2(f.x - r.x);
        Self {
            middle_spin: (0..recording.len()).map(middle).collect(),
            slope: front.iter().zip(&rear).map(line).collect(),
            spin,
            step: recording.dt,
            least_spin: DRIVING_SPEED * Units::of(robot).speed() / geometry.wheel_radius,
        }
    }

    /// Rim speed of the robot that drives, in the middle, m/s.
    pub fn speed(&self, robot: &Robot) -> f64 {
        let driving = self.while_driving(&self.middle_spin);
        robot.geometry.wheel_radius * median(driving).unwrap_or(0.0).abs()
    }

    /// Derivative of another channel, averaged as the spin speeds are.
    pub fn derivative(&self, recording: &Recording, x: &[f64]) -> Vec<f64> {
        derivative(x, recording.steps(0.5 * SMOOTHING), self.step)
    }

    /// A signal where the robot drives, at rest a NaN.
    pub fn while_driving(&self, x: &[f64]) -> Vec<f64> {
        let drives = |spin: f64| spin.abs() > self.least_spin;
        zip(x, &self.middle_spin, |x, spin| {
            if drives(spin) { x } else { f64::NAN }
        })
    }
}
