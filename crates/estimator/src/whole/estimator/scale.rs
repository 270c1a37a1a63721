//! The torques of both sides against the rover's weight.

use super::WholeEstimator;
use crate::estimate::Estimate;
use crate::flags::{Channels, Flags};
use crate::torque_scale::TorqueScale;
use crate::whole::WholeForces;
use robhaz_model::WholeRover;

impl WholeEstimator {
    /// The torques against the weight, `dt` (s) after the last sample. Where both contradict each other,
    /// all forces have that error.
    pub(super) fn find_scale(
        &mut self,
        sides: &mut [Estimate; 2],
        forces: &mut WholeForces,
        settled: bool,
        dt: f64,
    ) -> TorqueScale {
        /// Turn over the way of a wheel to the place of the one before, rad: in a turn the sides do not
        /// come there together.
        /// Chosen; insensitive.
        const STRAIGHT: f64 = 0.03;
        let [left, right] = &self.sides;
        let axles = &self.rover.side.geometry.axles;
        let between = trailing(&self.rover).map(|i| axles[0].x - axles[i].x);
        let speed = 0.5 * (self.velocity[0].x + self.velocity[1].x);
        let turned = between.map(|between| libm::fabs(self.yaw.mean * between));
        let is_straight = turned.is_some_and(|turned| turned < STRAIGHT * libm::fabs(speed));
        let rolling = left.rolling().zip(right.rolling());
        let rolling = rolling.filter(|_| settled && is_straight);
        let rolling = rolling.map(|(left, right)| left.mean(right));
        let (weight, mass) = left.weight();
        self.scale
            .update(rolling.as_ref(), weight, mass, dt / self.units.time);
        if self.scale.contradicts() {
            let deviation = self.scale.deviation;
            for side in sides {
                side.scale_forces(1.0, deviation);
                side.flags |= Flags::CONTRADICTION;
                if let Some(kalman) = &mut side.kalman {
                    kalman.health.faulty |= Channels::TORQUE_SCALE;
                }
            }
            let common = nalgebra::Vector6::from(forces.normal) * deviation;
            forces.covariance += common * common.transpose();
        }
        self.scale.found(weight)
    }
}

/// The first wheel behind the front one that runs in its track: it passes the same ground.
pub(super) fn trailing(rover: &WholeRover) -> Option<usize> {
    /// Distance of tracks that are one, over the wheel radius.
    /// Chosen; insensitive.
    const SAME: f64 = 0.1;
    let [front, ..] = rover.half_tracks;
    let apart = |i: &usize| libm::fabs(rover.half_tracks[*i] - front);
    [1, 2]
        .into_iter()
        .find(|i| apart(i) < SAME * rover.side.geometry.wheel_radius)
}
