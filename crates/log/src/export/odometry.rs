//! Where the rover is by its wheels, with a covariance that grows with slip.

use crate::messages::{orientation, with_header};
use nalgebra::{Matrix6, Vector3};
use robhaz_estimator::NoiseBudget;
use robhaz_scene::LogChoice;

/// Variance of what is not known, as nodes of ROS state it.
const UNKNOWN: f64 = 1e6;

/// The way that the wheels have rolled, added up.
///
/// In a step a wheel's way is that of its rim less its slip, along its own ground. Its deviation is as
/// large as what it slid, and `budget.wheel_radius` of what it rolled. Errors of slip are alike for all
/// wheels and last, so deviations add up, and not their squares. Slip that all wheels have in common on a
/// slippery slope shows in no reading, and is not in it.
pub struct Odometry {
    radius: f64,
    /// Half tracks of the wheels of a side, m; `None` of one side alone, whose yaw is not known.
    across: Option<[f64; 3]>,
    budget: NoiseBudget,
    /// Time (s) and angles of the wheels of the frame before, rad.
    last: Option<(f64, Vec<f64>)>,
    started: f64,
    position: Vector3<f64>,
    /// Roll (left side up), inclination (nose up), yaw (to the left), rad.
    attitude: [f64; 3],
    /// Way, its standard deviation, m; sum of the squared noise of the yaw, rad^2.
    way: f64,
    deviation: f64,
    yaw_noise: f64,
}

/// What a frame says, of the wheels of one side or of both.
pub struct Step {
    /// Angles of the wheels, rad.
    pub angle: Vec<f64>,
    /// Their steering, rad, to the left; 0 of a wheel that is not steered.
    pub steering: Vec<f64>,
    /// Slip, rim less ground, m/s.
    pub slip: Vec<f64>,
    /// Slope of the ground under each, rad.
    pub slope: Vec<f64>,
    /// Roll and inclination, rad; rates of roll, inclination and yaw, rad/s.
    pub attitude: [f64; 2],
    /// See there.
    pub rates: [f64; 3],
}

impl Odometry {
    /// At its start.
    pub fn new(choice: &LogChoice, both: bool) -> Self {
        let rover = choice.robot.whole_rover().filter(|_| both);
        Self {
            radius: choice.robot.robot.geometry.wheel_radius,
            across: rover.map(|rover| rover.half_tracks),
            budget: choice.budget,
            last: None,
            started: 0.0,
            position: Vector3::zeros(),
            attitude: [0.0; 3],
            way: 0.0,
            deviation: 0.0,
            yaw_noise: 0.0,
        }
    }

    /// `Odometry` after a step to a time (s), in the frame `odom`, which is where the rover started, of a frame with x
    /// forward, y to the left, z up.
    pub fn add(&mut self, time: f64, step: &Step) -> Vec<u8> {
        let known = |x: f64| if x.is_finite() { x } else { 0.0 };
        let [roll_rate, rate, yaw_rate] = step.rates.map(known);
        for (own, new) in self.attitude.iter_mut().zip(step.attitude) {
            *own = if new.is_finite() { new } else { *own };
        }
        let last = self.last.replace((time, step.angle.clone()));
        let dt = last.as_ref().map_or(0.0, |(before, _)| time - before);
        let ([mut forward, mut upward], mut speed_deviation) = ([0.0; 2], 0.0);
        if let Some((_, before)) = last.filter(|_| dt > 0.0) {
            let ([along, up], deviation) = self.way_of(step, &before, dt, yaw_rate * dt);
            // The heading in the middle of the step.
            let yaw = self.attitude[2] + 0.5 * yaw_rate * dt;
            self.position += Vector3::new(along * yaw.cos(), along * yaw.sin(), up);
            self.attitude[2] += yaw_rate * dt;
            self.way += along.hypot(up);
            self.deviation += deviation;
            self.yaw_noise += (self.budget.rate_noise * dt).powi(2);
            let (sin, cos) = self.attitude[1].sin_cos();
            forward = (along * cos + up * sin) / dt;
            upward = (up * cos - along * sin) / dt;
            speed_deviation = deviation / dt;
        } else {
            self.started = time;
        }
        let [roll, inclination, yaw] = self.attitude;
        let mut message = with_header(time, "odom");
        message.text(self.across.map_or("link1", |_| "base_link"));
        message.array(self.position.as_slice());
        message.array(&orientation(roll, inclination, yaw));
        message.array(self.pose_covariance(time).as_flattened());
        message.array(&[forward, 0.0, upward, roll_rate, -rate, yaw_rate]);
        let variances = self.twist_variances(speed_deviation);
        message.array(Matrix6::from_diagonal(&variances.into()).as_slice());
        message.0
    }

    /// Way of the rover's middle in a step, level and up, and its deviation along, m: means over the
    /// wheels. It turns by `turn`, rad.
    fn way_of(&self, step: &Step, before: &[f64], dt: f64, turn: f64) -> ([f64; 2], f64) {
        let (mut sums, mut count) = ([0.0; 3], 0.0);
        for (i, (angle, before)) in step.angle.iter().zip(before).enumerate() {
            let (rolled, slid) = (self.radius * (angle - before), step.slip[i] * dt);
            // The left wheels first.
            let side = if i < 3 { 1.0 } else { -1.0 };
            let y = self.across.map_or(0.0, |half| side * half[i % 3]);
            let way = (rolled - slid) * step.steering[i].cos() + turn * y;
            // Each wheel's centre goes along its own ground.
            let slope = Some(step.slope[i]).filter(|x| x.is_finite());
            let (sin, cos) = slope.unwrap_or(self.attitude[1]).sin_cos();
            let deviation = slid.hypot(self.budget.wheel_radius * rolled);
            if way.is_finite() {
                let parts = [way * cos, way * sin, deviation];
                sums.iter_mut().zip(parts).for_each(|(sum, x)| *sum += x);
                count += 1.0;
            }
        }
        let [along, up, deviation] = sums.map(|sum| sum / f64::max(count, 1.0));
        ([along, up], deviation)
    }

    /// Variance of the yaw, rad^2.
    fn yaw_variance(&self, time: f64) -> f64 {
        (self.budget.rate_bias * (time - self.started)).powi(2) + self.yaw_noise
    }

    /// Covariance of x, y, z, roll, pitch, yaw in the frame `odom`: along the heading the way, across
    /// it also what the yaw errs by.
    fn pose_covariance(&self, time: f64) -> [[f64; 6]; 6] {
        let budget = &self.budget;
        let along = self.deviation.powi(2);
        let inclination = budget.inclination_noise.powi(2) + budget.inclination_bias.powi(2);
        let up = along + (budget.inclination_bias * self.way).powi(2);
        let mut all = [[0.0; 6]; 6];
        let (across, diagonal) = match self.across {
            Some(_) => {
                let yaw = self.yaw_variance(time);
                (
                    along + yaw * self.way * self.way,
                    [up, inclination, inclination, yaw],
                )
            }
            None => (UNKNOWN, [up, UNKNOWN, inclination, UNKNOWN]),
        };
        let (sin, cos) = self.attitude[2].sin_cos();
        all[0][0] = along * cos * cos + across * sin * sin;
        all[1][1] = along * sin * sin + across * cos * cos;
        all[0][1] = (along - across) * sin * cos;
        all[1][0] = all[0][1];
        for (i, variance) in diagonal.into_iter().enumerate() {
            all[i + 2][i + 2] = variance;
        }
        all
    }

    /// Variances of the velocity along x, y, z and of the rates about them.
    fn twist_variances(&self, deviation: f64) -> [f64; 6] {
        let [speed, rate] = [
            deviation.powi(2),
            self.budget.rate_noise.powi(2) + self.budget.rate_bias.powi(2),
        ];
        match self.across {
            // Wheels that slide do so across, too.
            Some(_) => [speed, speed, speed, rate, rate, rate],
            None => [speed, UNKNOWN, speed, UNKNOWN, rate, UNKNOWN],
        }
    }
}
