//! Inclinometers against gyroscopes, whatever the wheels do.

use super::smoothing::WINDOW;
use crate::deviation::SIGNIFICANT;
use robhaz_model::GRAVITY;

/// Compares the inclinometer of one link with its gyroscope over times in which accelerations
/// average out.
///
/// The angle of a complementary filter follows the gyroscope, and the inclinometer within
/// [`WINDOW`]. What remains between it and the inclinometer is averaged over [`Self::MEAN`].
/// An inclinometer shows the acceleration of its link, and a mean over the time t of an
/// acceleration is the change of the speed over t: it is limited by the robot's speed v, however
/// hard it hits a kerb. With g the gravity, the mean is within
///
/// ```text
/// v/(g t) + bias of the gyroscope * time of the complementary filter + margin
/// ```
///
/// A wrong sign of one of both makes twice the angle by which the link turns, a wrong unit more.
/// Unlike the innovations of the filters, this needs no model of the contacts, and holds while
/// wheels slide or are at an edge. It begins with the drive: while the wheels of a robot have not
/// turned, its speed is not theirs, as when it is put down and settles.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Turning {
    started: bool,
    /// Angle of the complementary filter, rad.
    angle: f64,
    /// Mean of the inclination less that angle, rad.
    difference: f64,
    /// Whether gyroscope and inclinometer contradict each other.
    pub apart: bool,
}

impl Turning {
    /// Time of the mean, s: longer than impacts.
    /// Chosen; held by the faults and honest logs of `tests/check`.
    const MEAN: f64 = 0.5;
    /// Margin, rad: speeds of links that turn, noise, lag of an inclinometer.
    /// Chosen; held by the faults and honest logs of `tests/check`.
    const MARGIN: f64 = 0.04;

    /// Takes the readings of gyroscope (rad/s) and inclinometer (rad), `dt` (s) after the last;
    /// starts anew without them. `speed` (m/s) is the largest of a rim of the last time, `bias`
    /// (rad/s) the standard deviation of a gyroscope's bias.
    pub fn update(&mut self, readings: Option<(f64, f64)>, speed: f64, bias: f64, dt: f64) {
        let Some((rate, inclination)) = readings else {
            self.started = false;
            return;
        };
        if !self.started {
            (self.started, self.angle, self.difference) = (true, inclination, 0.0);
        }
        let predicted = self.angle + dt * rate;
        let difference = inclination - predicted;
        self.angle = predicted + robhaz_model::low_pass_share(dt, WINDOW) * difference;
        self.difference +=
            robhaz_model::low_pass_share(dt, Self::MEAN) * (difference - self.difference);
        let of_speed = speed / (GRAVITY * Self::MEAN);
        let allowed = Self::MARGIN + of_speed + SIGNIFICANT * WINDOW * bias;
        // Half the limit is well within it again.
        let part = if self.apart { 0.5 } else { 1.0 };
        self.apart = self.difference.abs() > part * allowed;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const DT: f64 = 1e-3;

    /// Feeds 10 s of readings of a link that turns to and fro at up to `rate` (rad/s), whose
    /// gyroscope has a `scale`.
    fn turn(turning: &mut Turning, scale: f64, rate: f64) -> Option<f64> {
        let mut found = None;
        for k in 0..10_000 {
            let t = f64::from(k) * DT;
            let readings = (
                scale * rate * libm::sin(t),
                rate * (1.0 - libm::cos(t)) + 0.3,
            );
            turning.update(Some(readings), 0.2, 0.0, DT);
            if turning.apart && found.is_none() {
                found = Some(t);
            }
        }
        found
    }

    /// Closed form: the limit at 0.2 m/s is 0.04 + 0.2/(9.81 * 0.5) = 0.081 rad. A wrong sign makes
    /// twice the angle, so a link that turns by less than 0.04 rad within the mean can never be
    /// found; one that turns by 0.2 rad/s is, within 2 s. The right sign says nothing at any rate,
    /// and repairs.
    #[test]
    fn a_wrong_sign_is_found_and_its_repair_too() {
        let mut turning = Turning::default();
        assert_eq!(turn(&mut turning, 1.0, 2.0), None);
        assert_eq!(turn(&mut Turning::default(), -1.0, 0.02), None);
        assert!(turn(&mut turning, -1.0, 0.2).is_some_and(|t| t < 2.0));
        turn(&mut turning, 1.0, 0.2);
        assert!(!turning.apart);
    }

    /// Closed form: a robot of 0.2 m/s that stops within a sample is shown as 0.2 m/s / (1 ms *
    /// 9.81 m/s^2) = 20 rad for one sample, whose mean is 0.041 rad: within the limit, however hard
    /// the impact.
    #[test]
    fn an_impact_is_no_contradiction() {
        let mut turning = Turning::default();
        for k in 0..2000 {
            let impact = if k == 1000 { 0.2 / (DT * GRAVITY) } else { 0.0 };
            let readings = (0.0, impact);
            turning.update(Some(readings), 0.2, 0.0, DT);
            assert!(!turning.apart);
        }
    }

    /// Readings after a gap begin anew.
    #[test]
    fn a_gap_is_no_contradiction() {
        let mut turning = Turning::default();
        turn(&mut turning, 1.0, 0.2);
        turning.update(None, 0.2, 0.0, DT);
        let readings = (0.0, -1.0);
        turning.update(Some(readings), 0.2, 0.0, DT);
        assert!(!turning.apart);
    }
}
