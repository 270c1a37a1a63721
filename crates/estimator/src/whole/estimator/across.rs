//! Steering, turns and roll in the planes of the wheels.

use super::{TURN_TIME, WholeEstimator, scale};
use crate::common::DRIVING_SPEED;
use crate::methods::Across;
use crate::whole::posture::sign;
use crate::whole::readings::bogie_of;
use robhaz_model::{Coupling, Vec2};

impl WholeEstimator {
    /// What roll, yaw, steering and the roll of a rear bogie do to the axles of both sides, in the
    /// planes of the wheels.
    pub(super) fn across(&self) -> [Across; 2] {
        /// Error of a steering angle, rad: half a degree.
        /// Textbook.
        const STEERING: f64 = 8.7e-3;
        let [left, right] = self.velocity;
        let speed = 0.5 * (left.x + right.x);
        let (rover, geometry) = (&self.rover, &self.rover.side.geometry);
        let bogie = bogie_of(geometry);
        let coupled = self.readings.coupled();
        let bogie_place = rover.link_places[bogie];
        let roll_rate = self.roll.smooth_rate / self.units.time;
        let middle = geometry.axles[1].x;
        let rear_bogie = rover.coupling == Coupling::RearBogie;
        let mut both = [0, 1].map(|k: usize| {
            let sign = sign(k);
            let mut across = Across {
                shares: true,
                trailing: scale::trailing(rover).unwrap_or(Across::NONE.trailing),
                ..Across::NONE
            };
            for i in 0..3 {
                let y = sign * rover.half_tracks[i];
                let beside = y - sign * bogie_place;
                let steering = self.steering.get(3 * k + i).copied().unwrap_or(0.0);
                let (s, c) = libm::sincos(steering);
                let ahead = speed - self.yaw_rate * y;
                let sideways = self.yaw_rate * (geometry.axles[i].x - middle);
                let steered = (c - 1.0) * ahead + s * sideways;
                across.slip[i] = libm::fabs(s * ahead) * STEERING;
                let (mut up, mut raised) = (roll_rate * beside, 0.0);
                if rear_bogie && geometry.carriers[i].index() != bogie {
                    (up, raised) = (up + coupled.1 * y, coupled.0 * y);
                }
                across.velocity[i] = Vec2::new(steered - self.yaw_rate * beside, up);
                across.place[i] = Vec2::new(0.0, raised);
            }
            across
        });
        let dragged = self.dragged();
        for across in &mut both {
            across.settled = dragged.is_none() && self.rolled > geometry.wheel_radius;
            // Wheels that are dragged hold the others back.
            if let Some(dragged) = dragged {
                across.slip = [dragged; 3];
            }
        }
        both
    }

    /// Follows the speeds at which the wheels slide across their planes, in a turn of which they do not
    /// stand along the circles.
    pub(super) fn follow_sliding(&mut self, dt: f64) {
        let fastest = self.rims.iter().fold(0.0_f64, |a, rim| a.max(rim.abs()));
        if fastest < DRIVING_SPEED * self.units.speed() {
            (self.sliding, self.rolled) = (None, 0.0);
            return;
        }
        self.rolled += fastest * dt;
        let (rover, axles) = (&self.rover, &self.rover.side.geometry.axles);
        let speed = self.speed_of_rims();
        let now: [f64; 6] = core::array::from_fn(|i| {
            let (s, c) = libm::sincos(self.steering[i]);
            let along = speed - self.yaw_rate * sign(i / 3) * rover.half_tracks[i % 3];
            c * self.yaw_rate * (axles[i % 3].x - axles[1].x) - s * along
        });
        let mean = self.sliding.get_or_insert(now);
        let weight = robhaz_model::low_pass_share(dt, TURN_TIME * self.units.time);
        for (mean, now) in mean.iter_mut().zip(now) {
            *mean += weight * (now - *mean);
        }
    }

    /// Largest speed at which a wheel is dragged across, m/s.
    pub(super) fn dragged(&self) -> Option<f64> {
        /// Sideways over forward speed of a wheel that is dragged: beyond what steering and toe err
        /// by, and what a tyre's elasticity takes.
        /// Chosen; insensitive.
        const DRAGGED: f64 = 0.1;
        let speed = self.speed_of_rims().abs();
        let least = DRAGGED * speed.max(DRIVING_SPEED * self.units.speed());
        let sliding = self.sliding?.into_iter().map(f64::abs);
        sliding.filter(|sliding| *sliding > least).reduce(f64::max)
    }

    /// Mean speed of the rims along the rover, m/s. The estimated one of a log that begins in a turn takes
    /// some time, for ever if its wheels count as dragged.
    fn speed_of_rims(&self) -> f64 {
        let along = self.rims.iter().zip(&self.steering);
        along
            .map(|(rim, angle)| rim * libm::cos(*angle))
            .sum::<f64>()
            / 6.0
    }
}
