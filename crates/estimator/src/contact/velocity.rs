//! Velocity of a wheel's centre relative to the ground.

use robhaz_model::Vec2;

/// Velocity of a wheel's centre, along the ground and away from it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ContactVelocity {
    /// Unit vector along the velocity, forwards.
    pub direction: Vec2,
    /// Speed along it, m/s, negative backwards.
    pub speed: f64,
    /// The same without the noise of the gyroscope.
    pub smooth_speed: f64,
    /// Speed away from the ground, m/s.
    pub away: f64,
}

impl ContactVelocity {
    /// For the velocity `smooth + noise` (m/s) on ground that rises with `slope` (rad), which errs
    /// by `widest` (rad) at most; below `fast` (m/s) the ground's direction is better known.
    ///
    /// A fast velocity is linearised about the direction of the smooth velocity: a wheel that meets
    /// an edge leaves the estimated slope by far. The noise is not in that direction: it would occur
    /// in the innovation and in the measurement matrix, and each correction would change the size of
    /// the velocity.
    ///
    /// Below `fast` its errors across would make the velocity too large, by half of their
    /// variance over the speed: for minutes the same small error of the slip. The ground's direction
    /// makes no such error. It is used, too, for a velocity that points away from the ground by more than
    /// `widest`, which is wrong itself, as after an impact: about a wrong one the corrections by
    /// three wheels lead further away.
    pub fn new(smooth: Vec2, noise: Vec2, slope: f64, widest: f64, fast: f64) -> Self {
        let (sin, cos) = libm::sincos(slope);
        let away = smooth.y * cos - smooth.x * sin;
        let along = smooth.x * cos + smooth.y * sin;
        let size = robhaz_model::sqrt(smooth.norm_squared());
        let angle = libm::atan(away / along);
        let (direction, speed, away) = if size < fast || angle.abs() > widest {
            (Vec2::new(cos, sin), along, away)
        } else {
            let speed = libm::copysign(size, along);
            (smooth / speed, speed, speed * angle)
        };
        Self {
            direction,
            speed: speed + noise.dot(&direction),
            smooth_speed: speed,
            away: away + noise.y * direction.x - noise.x * direction.y,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Closed form: a velocity of 0.3 m/s at 0.1 rad against the ground moves away at 0.03 m/s,
    /// whatever the slope; below 0.1 m/s the components themselves count.
    #[test]
    fn speed_along_and_away_from_the_ground() {
        let velocity = |size: f64, angle: f64| Vec2::new(libm::cos(angle), libm::sin(angle)) * size;
        for slope in [-0.4, 0.0, 0.7] {
            for forwards in [1.0, -1.0] {
                let found = ContactVelocity::new(
                    velocity(0.3 * forwards, slope + 0.1),
                    Vec2::zeros(),
                    slope,
                    0.2,
                    0.1,
                );
                assert!((found.speed - 0.3 * forwards).abs() < 1e-12);
                assert!((found.away - 0.03 * forwards).abs() < 1e-12);
            }
            let slow =
                ContactVelocity::new(velocity(0.05, slope + 0.1), Vec2::zeros(), slope, 0.2, 0.1);
            assert!((slow.speed - 0.05 * libm::cos(0.1)).abs() < 1e-12);
            assert!((slow.away - 0.05 * libm::sin(0.1)).abs() < 1e-12);
        }
    }

    /// Closed form: a velocity that deviates by more than the slope can err has the components
    /// along the ground and across it.
    #[test]
    fn a_wrong_velocity_does_not_give_the_direction() {
        let velocity = Vec2::new(0.1, 0.3);
        let found = ContactVelocity::new(velocity, Vec2::zeros(), 0.0, 0.2, 0.1);
        assert_eq!(found.direction, Vec2::new(1.0, 0.0));
        assert!((found.speed - 0.1).abs() < 1e-12 && (found.away - 0.3).abs() < 1e-12);
        let unknown = ContactVelocity::new(velocity, Vec2::zeros(), 0.0, f64::INFINITY, 0.1);
        assert!((unknown.direction - velocity.normalize()).norm() < 1e-12);
    }
}
