//! Steering, turns and roll in the planes of the wheels.

use super::{WholeEstimator, scale};
use crate::methods::Across;
use crate::whole::posture::sign;
use crate::whole::readings::bogie_of;
use robhaz_model::{Coupling, Vec2};

impl WholeEstimator {
    /// What roll, yaw, steering and the roll of a rear bogie do to the axles of both sides, in the
    /// planes of the wheels.
    pub(super) fn across(&self) -> [Across; 2] {
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
                follow: self.sliding.follows(),
                of_sensor: sign * bogie_place * self.yaw.acceleration
                    - self.yaw.rate * self.yaw.rate * rover.ahead_of_middle(),
                trailing: scale::trailing(rover).unwrap_or(Across::NONE.trailing),
                ..Across::NONE
            };
            for i in 0..3 {
                let y = sign * rover.half_tracks[i];
                let beside = y - sign * bogie_place;
                let steering = self.steering.get(3 * k + i).copied().unwrap_or(0.0);
                let (s, c) = libm::sincos(steering);
                let ahead = speed - self.yaw.rate * y;
                let turned = self.yaw.rate * (geometry.axles[i].x - middle);
                let sideways = self.sliding.sideways + turned;
                let steered = (c - 1.0) * ahead + s * sideways;
                across.slope[i] = [c, s * self.roll.angle()];
                across.slip[i] = libm::fabs(s * ahead) * self.settings.budget.steering;
                let (mut up, mut raised) = (roll_rate * beside, 0.0);
                if rear_bogie && geometry.carriers[i].index() != bogie {
                    (up, raised) = (up + coupled.1 * y, coupled.0 * y);
                }
                across.velocity[i] = Vec2::new(steered - self.yaw.rate * beside, up);
                across.place[i] = Vec2::new(0.0, raised);
            }
            across
        });
        let dragged = self.sliding.dragged();
        for across in &mut both {
            across.settled = dragged.is_none() && self.sliding.rolled > geometry.wheel_radius;
            // Wheels that are dragged hold the others back.
            if let Some(dragged) = dragged {
                across.slip = [dragged; 3];
            }
        }
        both
    }
}
