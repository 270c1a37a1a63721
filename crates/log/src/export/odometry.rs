//! Where the rover is by its wheels, with a covariance that grows with slip.

use crate::messages::{orientation, with_header};
use nalgebra::{Matrix6, Vector3};
use robhaz_estimator::NoiseBudget;
use robhaz_model::WholeRover;
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
    /// Where the left wheels are, ahead of `base_link` and beside it, m; `None` of one side alone, whose yaw is not known.
    wheels: Option<[[f64; 2]; 3]>,
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
    /// Direction in which the wheels point, rad to the left of the heading.
    course: f64,
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
        let wheels = |rover: WholeRover| {
            let axles = rover.side.geometry.axles;
            [0, 1, 2].map(|i: usize| [axles[i].x - rover.pivot.x, rover.half_tracks[i]])
        };
        Self {
            radius: choice.robot.robot.geometry.wheel_radius,
            wheels: rover.map(wheels),
            budget: choice.budget,
            last: None,
            started: 0.0,
            position: Vector3::zeros(),
            attitude: [0.0; 3],
            way: 0.0,
            deviation: 0.0,
            yaw_noise: 0.0,
            course: 0.0,
        }
    }

    /// `Odometry` after a step to a time (s), in the frame `odom`, which is where the rover started, of a frame with x
    /// forward, y to the left, z up.
    pub fn add(&mut self, time: f64, step: &Step) -> Vec<u8> {
        let known = |x: f64| if x.is_finite() { x } else { 0.0 };
        let [roll_rate, rate, yaw_rate] = step.rates.map(known);
        let (velocity, deviation) = self.advance(time, step, yaw_rate);
        let [roll, inclination, yaw] = self.attitude;
        let mut message = with_header(time, "odom");
        message.text(self.wheels.map_or("link1", |_| "base_link"));
        message.array(self.position.as_slice());
        message.array(&orientation(roll, inclination, yaw));
        message.array(self.pose_covariance(time).as_flattened());
        message.array(velocity.as_slice());
        message.array(&[roll_rate, -rate, yaw_rate]);
        let variances = self.twist_variances(deviation);
        message.array(Matrix6::from_diagonal(&variances.into()).as_slice());
        message.0
    }

    /// Adds a step to a time (s) at a yaw rate (rad/s). Returns the velocity along its own axes and its deviation, m/s.
    fn advance(&mut self, time: f64, step: &Step, yaw_rate: f64) -> (Vector3<f64>, f64) {
        for (own, new) in self.attitude.iter_mut().zip(step.attitude) {
            *own = if new.is_finite() { new } else { *own };
        }
        let last = self.last.replace((time, step.angle.clone()));
        let dt = last.as_ref().map_or(0.0, |(before, _)| time - before);
        // A count of wheels.
        self.course = step.steering.iter().sum::<f64>() / step.steering.len() as f64;
        let Some((_, before)) = last.filter(|_| dt > 0.0) else {
            self.started = time;
            return (Vector3::zeros(), 0.0);
        };
        let ([along, across, up], deviation) = self.way_of(step, &before, dt, yaw_rate * dt);
        // The heading in the middle of the step.
        let (sin, cos) = (self.attitude[2] + 0.5 * yaw_rate * dt).sin_cos();
        let moved = [along * cos - across * sin, along * sin + across * cos, up];
        self.position += Vector3::from(moved);
        self.attitude[2] += yaw_rate * dt;
        self.way += along.hypot(across).hypot(up);
        self.deviation += deviation;
        self.yaw_noise += (self.budget.rate_noise * dt).powi(2);
        let [(sr, cr), (sp, cp)] = [0, 1].map(|i: usize| self.attitude[i].sin_cos());
        let raised = up * cp - along * sp;
        let moved = [
            along * cp + up * sp,
            across * cr + raised * sr,
            raised * cr - across * sr,
        ];
        (Vector3::from(moved) / dt, deviation / dt)
    }

    /// Way of the rover in a step, along its heading, across it and up, and its deviation, m: means over the
    /// wheels, each of which rolls where it points. It turns by `turn`, rad.
    fn way_of(&self, step: &Step, before: &[f64], dt: f64, turn: f64) -> ([f64; 3], f64) {
        let (mut sums, mut count) = ([0.0; 4], 0.0);
        let [roll, inclination, _] = self.attitude;
        for (i, (angle, before)) in step.angle.iter().zip(before).enumerate() {
            let (rolled, slid) = (self.radius * (angle - before), step.slip[i] * dt);
            // The left wheels first.
            let side = if i < 3 { 1.0 } else { -1.0 };
            let [ahead, beside] = self.wheels.map_or([0.0; 2], |wheels| wheels[i % 3]);
            let (sin, cos) = step.steering[i].sin_cos();
            // Each wheel's centre goes along its own ground.
            let slope = Some(step.slope[i]).filter(|x| x.is_finite());
            let slope = slope.unwrap_or(inclination * cos + roll * sin);
            let (level, up) = ((rolled - slid) * slope.cos(), (rolled - slid) * slope.sin());
            let deviation = slid.hypot(self.budget.wheel_radius * rolled);
            if level.is_finite() {
                let along = level * cos + turn * side * beside;
                let across = level * sin - turn * ahead;
                let parts = [along, across, up, deviation];
                sums.iter_mut().zip(parts).for_each(|(sum, x)| *sum += x);
                count += 1.0;
            }
        }
        let [along, across, up, deviation] = sums.map(|sum| sum / f64::max(count, 1.0));
        ([along, across, up], deviation)
    }

    /// Covariance of x, y, z, roll, pitch, yaw in the frame `odom`: along where the rover goes the way, across
    /// it also what the yaw errs by.
    fn pose_covariance(&self, time: f64) -> [[f64; 6]; 6] {
        let budget = &self.budget;
        let along = self.deviation.powi(2);
        let inclination = budget.inclination_noise.powi(2) + budget.inclination_bias.powi(2);
        let up = along + (budget.inclination_bias * self.way).powi(2);
        let mut all = [[0.0; 6]; 6];
        let (across, diagonal) = match self.wheels {
            Some(_) => {
                let yaw = (budget.rate_bias * (time - self.started)).powi(2) + self.yaw_noise;
                let across = along + yaw * self.way * self.way;
                (across, [up, inclination, inclination, yaw])
            }
            None => (UNKNOWN, [up, UNKNOWN, inclination, UNKNOWN]),
        };
        let (sin, cos) = (self.attitude[2] + self.course).sin_cos();
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
        let speed = deviation.powi(2);
        let rate = self.budget.rate_noise.powi(2) + self.budget.rate_bias.powi(2);
        match self.wheels {
            // Wheels that slide do so across, too.
            Some(_) => [speed, speed, speed, rate, rate, rate],
            None => [speed, UNKNOWN, speed, UNKNOWN, rate, UNKNOWN],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use robhaz_model::Robot;

    /// 1000 steps of 10 ms of wheels of 0.1 m, whose middle axles are 0.05 m behind `base_link`.
    fn driven(speeds: [f64; 6], steering: [f64; 6], yaw_rate: f64) -> (Odometry, Vector3<f64>) {
        let axles = Robot::default_a().geometry.axles;
        let mut odometry = Odometry::new(&LogChoice::default(), false);
        odometry.radius = 0.1;
        odometry.wheels = Some(axles.map(|axle| [axle.x - 0.05, 0.3]));
        let mut step = |k: u32| {
            let time = 0.01 * f64::from(k);
            let step = Step {
                angle: speeds.map(|speed| speed * time / 0.1).to_vec(),
                steering: steering.to_vec(),
                slip: vec![0.0; 6],
                slope: vec![0.0; 6],
                attitude: [0.0; 2],
                rates: [0.0, 0.0, yaw_rate],
            };
            odometry.advance(time, &step, yaw_rate).0
        };
        let velocity = (0..=1000).map(&mut step).last();
        (odometry, velocity.unwrap_or_default())
    }

    /// Closed form: wheels that are all steered alike go where they point, 1 m, and what the yaw errs by counts
    /// across that.
    #[test]
    fn steered_wheels_go_sideways() {
        let (found, velocity) = driven([0.1; 6], [0.5; 6], 0.0);
        let (sin, cos) = 0.5_f64.sin_cos();
        let apart = [found.position[0] - cos, found.position[1] - sin];
        assert!(apart[0].hypot(apart[1]) < 1e-9, "{apart:?}");
        assert!((velocity - Vector3::new(cos, sin, 0.0) * 0.1).norm() < 1e-9);
        let covariance = found.pose_covariance(10.0);
        let [[xx, xy, ..], [_, yy, ..], ..] = covariance;
        let along = xx * cos * cos + 2.0 * xy * sin * cos + yy * sin * sin;
        let across = xx * sin * sin - 2.0 * xy * sin * cos + yy * cos * cos;
        let expected = along + covariance[5][5];
        assert!(across > along && (across - expected).abs() < 1e-6 * expected);
    }

    /// Closed form: a quarter turn about a point 1 m to the left of the middle axles, all wheels along their own
    /// circles; `base_link` goes round on its own.
    #[test]
    fn a_turn_is_about_its_centre() {
        let axles = Robot::default_a().geometry.axles;
        let rate = 0.05 * std::f64::consts::PI;
        let lever = |i: usize| (axles[i % 3].x, if i < 3 { 0.7 } else { 1.3 });
        let speeds = core::array::from_fn(|i| rate * lever(i).0.hypot(lever(i).1));
        let steering = core::array::from_fn(|i| lever(i).0.atan2(lever(i).1));
        let (found, _) = driven(speeds, steering, rate);
        let apart = [found.position[0] - 0.95, found.position[1] - 1.05];
        // Steps of 1.6 mrad.
        assert!(apart[0].hypot(apart[1]) < 1e-5, "{:?}", found.position);
    }
}
