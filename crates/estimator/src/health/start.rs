//! Late torques, from the way the robot answers them when it starts.

use super::smoothing::{Smoothing, Step};
use crate::deviation::SIGNIFICANT;
use crate::filters::Kalman;

/// Delay from which on torques are late, s: a speed control answers its encoders sooner, and
/// filters of a motor's current are shorter.
/// Chosen; held by the faults and honest logs of `tests/check`.
pub const LATE_TORQUE: f64 = 0.008;

/// What the nominal parameters say of a robot whose wheels all roll, per rad of a wheel.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RollingRobot {
    /// Inertia of all wheels and rotors and of the robot's mass, `3 (J_wheel + J_rotor) + m r^2`,
    /// kg m^2.
    pub inertia: f64,
    /// Viscous damping of all wheels, `3 B`, N m s.
    pub damping: f64,
}

/// Fits the sum of the motor torques to the motion of a robot that starts.
///
/// With the means over the wheels of acceleration alpha, speed omega and angle phi since the start,
/// Newton's law of the whole robot is
///
/// ```text
/// sum tau = J alpha + B omega + k phi + c
/// ```
///
/// c holds the offsets, dry friction and the slope of the ground, k its curvature. Torques that are
/// late by d are those of d before: `sum tau(t - d) = sum tau(t) - d dsum tau/dt` to first order.
/// The fit (recursive least squares) has the unknowns `[d, J, B, k, c]`. It is about the delay of
/// one step, between that of good torques and that of late ones.
///
/// No control is in this law: the delay is that of the readings alone, whatever drives the wheels.
/// It holds while all wheels roll and the ground is even. Where they do not, J and B are not those
/// of the nominal parameters, or the fit leaves a part of the torques: then the start says nothing.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Start {
    /// Time for which the robot has stood, s; at most [`Self::STANDS`].
    stood: f64,
    /// Time since it began to move, s; 0 while no start is followed.
    moving: f64,
    /// `[d (s), J (kg m^2), B (N m s), k (N m/rad), c (N m)]`, for torques with noise of
    /// [`Self::REFERENCE`].
    fit: Kalman<5>,
    /// Sum of the squared residuals in units of [`Self::REFERENCE`], their number, and sum of the
    /// squared accelerations.
    sums: [f64; 3],
    /// Means of acceleration, speed and angle at the step before.
    before: [f64; 3],
    /// Mean angle at the start, rad.
    origin: f64,
    /// Whether the last start that showed it found the torques late.
    pub late: bool,
}

impl Start {
    /// Mean speed of the wheels from which on the robot moves, rad/s: dry friction then has its
    /// direction.
    /// Chosen; held by the faults and honest logs of `tests/check`.
    const MOVES: f64 = 0.05;
    /// Time of rest before a start, s: what was before has left the smoothing.
    /// Definition.
    const STANDS: f64 = 3.0 * Smoothing::TIME;
    /// Time of the fit, s: a robot is at its speed, and has rolled no further than some wheel
    /// radii.
    /// Chosen; held by the faults and honest logs of `tests/check`.
    const LASTS: f64 = 0.8;
    /// Noise of a sum of torques to which the fit's covariance refers, N m. The residuals scale it.
    /// Definition.
    const REFERENCE: f64 = 0.02;
    /// Standard deviations of d (s), k (N m/rad) and c (N m) before the fit; J and B have those of
    /// J, and J over [`Self::LASTS`], of the nominal parameters. All are wide: the least squares
    /// without them are the same.
    /// Guard.
    const PRIOR: [f64; 3] = [0.1, 10.0, 20.0];
    /// Error of J over J: payload, nominal parameters, gains of the torques. And of what grows with the
    /// speed over the mean torque of the acceleration: the ground's curvature where it is larger.
    /// Chosen; held by the faults and honest logs of `tests/check`.
    const INERTIA: f64 = 0.2;
    /// Part of the squared torque of the acceleration that the fit leaves at most.
    /// Chosen; held by the faults and honest logs of `tests/check`.
    const LEFT: f64 = 0.02;

    /// Reset, for readings that have a gap.
    pub fn interrupt(&mut self) {
        (self.stood, self.moving) = (0.0, 0.0);
    }

    /// Takes a step.
    pub fn update(&mut self, step: &Step, robot: &RollingRobot) {
        let mean = |values: &[f64; 3]| values.iter().sum::<f64>() / 3.0;
        let [acceleration, speed, angle] = self.before;
        self.before = [&step.acceleration, &step.speed, &step.angle].map(mean);
        if speed.abs() < Self::MOVES {
            self.stood = (self.stood + step.dt).min(Self::STANDS);
            self.moving = 0.0;
            return;
        }
        if self.moving == 0.0 && self.stood < Self::STANDS {
            return;
        }
        let torque = 3.0 * mean(&step.torque);
        if self.moving == 0.0 {
            let RollingRobot { inertia, damping } = *robot;
            let [delay, curvature, constant] = Self::PRIOR;
            self.fit = Kalman::new(
                [0.0, inertia, damping, 0.0, torque],
                [delay, inertia, inertia / Self::LASTS, curvature, constant],
            );
            self.sums = [0.0; 3];
            self.origin = angle;
        }
        self.stood = 0.0;
        self.moving += step.dt;
        let motion = [acceleration, speed, angle - self.origin];
        self.add(motion, torque, 3.0 * mean(&step.torque_rate));
        if self.moving > Self::LASTS {
            self.judge(step.dt, robot);
            self.moving = 0.0;
        }
    }

    /// Adds the motion (rad/s^2, rad/s, rad) of one step and the sum of the torques (N m) of the
    /// next one with its rate (N m/s).
    fn add(&mut self, [acceleration, speed, angle]: [f64; 3], torque: f64, rate: f64) {
        let row = [
            (0, -rate),
            (1, acceleration),
            (2, speed),
            (3, angle),
            (4, 1.0),
        ];
        let [d, j, b, k, c] = self.fit.x;
        let expected = j * acceleration + b * speed + k * angle + c - d * rate;
        let noise = Self::REFERENCE * Self::REFERENCE;
        let left = torque - expected;
        let innovation = self.fit.update(&row, left, noise);
        let added = [innovation.nis(), 1.0, acceleration * acceleration];
        for (sum, added) in self.sums.iter_mut().zip(added) {
            *sum += added;
        }
    }

    /// Delay of the torques and its standard deviation, s, of a fit in which torques are one step
    /// of `dt` (s) later than the motion. `None` where this is not a rolling robot on even ground.
    fn delay(&self, dt: f64, robot: &RollingRobot) -> Option<(f64, f64)> {
        let [residual, number, squared] = self.sums;
        let [delay, inertia, damping, ..] = self.fit.x;
        let noise = Self::REFERENCE * Self::REFERENCE;
        let is_robot = (inertia - robot.inertia).abs() < Self::INERTIA * robot.inertia
            && (damping - robot.damping).abs() * Self::LASTS < Self::INERTIA * robot.inertia;
        let holds = residual * noise < Self::LEFT * inertia * inertia * squared;
        let [[variance, ..], ..] = self.fit.p;
        // The smoothing correlates the noise of steps.
        let steps = 2.0 * Smoothing::TIME / dt;
        let scale = residual / number * steps.max(1.0);
        (is_robot && holds).then(|| (delay + dt, robhaz_model::sqrt(variance * scale)))
    }

    fn judge(&mut self, dt: f64, robot: &RollingRobot) {
        let Some((delay, sigma)) = self.delay(dt, robot) else {
            return;
        };
        let beyond = delay - LATE_TORQUE;
        if beyond > SIGNIFICANT * sigma {
            self.late = true;
        } else if beyond < -sigma {
            self.late = false;
        }
    }
}

#[cfg(test)]
mod tests;
