//! Wheels that slide across their planes, by rims, steering and yaw.

use super::yaw::{TURN_TIME, Yaw};
use crate::common::DRIVING_SPEED;
use crate::whole::posture::sign;
use robhaz_model::{Units, WholeRover};

/// Follows the speeds at which the wheels slide across, in a turn of which they do not stand along the
/// circles. All are of the rims: the estimated speed would take some time in a log that begins in a turn, for
/// ever if its wheels counted as dragged.
#[derive(Clone, Debug, Default)]
pub(super) struct Sliding {
    /// Speed of the rover to its left, m/s, in the middle of its middle axles.
    pub sideways: f64,
    /// Way of the fastest rim since the last rest, m.
    pub rolled: f64,
    /// `None` before the first frame: a log may begin in a turn.
    mean: Option<Means>,
    /// Least speed of a rover that drives, m/s.
    least: f64,
    /// What errors of the yaw make of these means, m/s.
    of_noise: f64,
}

/// Deviations of the yaw that count.
const GATE: f64 = 2.0;
/// Sine of the angle to the rover's plane beyond which a wheel does not follow the one ahead: 20 deg.
/// Chosen.
const OFF: f64 = 0.34;

/// Means over [`TURN_TIME`], m/s.
#[derive(Clone, Copy, Debug, Default)]
struct Means {
    /// How fast each wheel slides across its plane.
    across: [f64; 6],
    /// How fast it moves to the left of the rover.
    left: [f64; 6],
    /// Size of the rims' speeds.
    rims: f64,
}

impl Sliding {
    /// Takes the speeds of the `rims` (m/s), the yaw and the steering (rad), `dt` (s) after the last ones.
    pub fn follow(
        &mut self,
        rover: &WholeRover,
        units: &Units,
        rims: &[f64; 6],
        yaw: &Yaw,
        steering: &[f64; 6],
        dt: f64,
    ) {
        self.least = DRIVING_SPEED * units.speed();
        let fastest = rims.iter().fold(0.0_f64, |a, rim| a.max(rim.abs()));
        if fastest < self.least {
            (self.sideways, self.rolled, self.mean) = (0.0, 0.0, Some(Means::default()));
            return;
        }
        self.rolled += fastest * dt;
        let axles = &rover.side.geometry.axles;
        let length = axles[0].x - axles[2].x;
        self.of_noise = GATE * yaw.mean_sigma([dt, units.time]) * length;
        // What the turn adds to the velocity of each wheel, along and to the left.
        let turned: [[f64; 2]; 6] = core::array::from_fn(|i| {
            let y = sign(i / 3) * rover.half_tracks[i % 3];
            [-yaw.rate * y, yaw.rate * (axles[i % 3].x - axles[1].x)]
        });
        let heading = steering.map(libm::sincos);
        let (mut ahead, mut sideways, mut size) = (0.0, 0.0, 0.0);
        for ((rim, (s, c)), [along, left]) in rims.iter().zip(heading).zip(turned) {
            ahead += (rim * c - along) / 6.0;
            sideways += (rim * s - left) / 6.0;
            size += rim.abs() / 6.0;
        }
        self.sideways = sideways;
        let mut now = Means {
            rims: size,
            ..Means::default()
        };
        let of_wheels = now.across.iter_mut().zip(&mut now.left);
        for (((across, left), (s, c)), [along, turn]) in of_wheels.zip(heading).zip(turned) {
            *left = sideways + turn;
            *across = c * *left - s * (ahead + along);
        }
        let mean = self.mean.get_or_insert(now);
        if mean.rims <= 0.0 {
            // The first frame after a rest.
            mean.rims = size;
        }
        let weight = robhaz_model::low_pass_share(dt, TURN_TIME * units.time);
        mean.rims += weight * (size - mean.rims);
        let means = mean.across.iter_mut().chain(&mut mean.left);
        for (mean, now) in means.zip(now.across.into_iter().chain(now.left)) {
            *mean += weight * (now - *mean);
        }
    }

    /// Whether no wheel turns.
    pub fn stands(&self) -> bool {
        self.mean.is_some_and(|mean| mean.rims <= 0.0)
    }

    /// Whether each wheel moves close to along the rover's plane, so that it comes where those ahead were.
    pub fn follows(&self) -> bool {
        self.mean.is_none_or(|mean| {
            let beyond = |left: &f64| left.abs() > OFF * mean.rims.max(self.least) + self.of_noise;
            !mean.left.iter().any(beyond)
        })
    }

    /// Largest speed at which a wheel is dragged across, m/s.
    pub fn dragged(&self) -> Option<f64> {
        /// Sideways over forward speed of a wheel that is dragged: beyond what steering and toe err
        /// by, and what a tyre's elasticity takes.
        /// Chosen; insensitive.
        const DRAGGED: f64 = 0.1;
        let Means { across, rims, .. } = self.mean?;
        let least = DRAGGED * rims.max(self.least) + self.of_noise;
        let sliding = across.into_iter().map(f64::abs);
        sliding.filter(|sliding| *sliding > least).reduce(f64::max)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::NoiseBudget;
    use robhaz_model::{Carrier, Coupling, Robot, Vec2};

    const YAW: f64 = 0.3;

    /// A gyroscope without errors that reads a rate, rad/s.
    fn exact(rate: f64) -> Yaw {
        let mut budget = NoiseBudget::typical();
        budget.rate_noise = 0.0;
        let mut yaw = Yaw::new(&budget);
        yaw.start(rate);
        yaw
    }

    const DT: f64 = 0.01;

    fn rover() -> WholeRover {
        let mut side = Robot::default_a();
        side.geometry.make_bogie(Carrier::Link2);
        WholeRover {
            pivot: Vec2::new(0.0, 0.3),
            half_tracks: [0.3, 0.4, 0.3],
            link_places: [0.3; 2],
            coupling: Coupling::Differential,
            body_place: 0.0,
            coupling_stop: WholeRover::NO_STOP,
            body_inertia: [0.0; 2],
            link_inertias: [[0.0; 2]; 2],
            wheel_inertia: 0.0,
            side,
        }
    }

    /// Rims and steering of wheels that all stand along the circles of a rover with this velocity.
    fn rolling(rover: &WholeRover, ahead: f64, sideways: f64, yaw: f64) -> ([f64; 6], [f64; 6]) {
        let axles = &rover.side.geometry.axles;
        let of = |i: usize| {
            let y = sign(i / 3) * rover.half_tracks[i % 3];
            let x = axles[i % 3].x - axles[1].x;
            let (u, v) = (ahead - yaw * y, sideways + yaw * x);
            // A wheel is steered by a quarter turn at most, and turns backwards beyond.
            let backwards = if u < 0.0 { -1.0 } else { 1.0 };
            (backwards * u.hypot(v), (backwards * v).atan2(backwards * u))
        };
        let all: [(f64, f64); 6] = core::array::from_fn(of);
        (all.map(|(rim, _)| rim), all.map(|(_, angle)| angle))
    }

    /// Closed form: ahead, along a circle, on the spot and sideways no wheel is dragged whose steering is exact,
    /// and the speed sideways is found; without steering a turn drags the outer ones by the yaw rate times their
    /// distance from the middle. Rounding.
    #[test]
    fn steered_wheels_are_not_dragged() {
        let rover = rover();
        let units = Units::of(&rover.side);
        for (ahead, sideways, yaw) in [
            (0.2, 0.0, 0.0),
            (0.2, 0.0, YAW),
            (-0.2, 0.0, YAW),
            (0.0, 0.0, YAW),
            (0.2, 0.1, 0.0),
            (0.2, -0.1, YAW),
        ] {
            let (rims, steering) = rolling(&rover, ahead, sideways, yaw);
            let mut sliding = Sliding::default();
            sliding.follow(&rover, &units, &rims, &exact(yaw), &steering, DT);
            assert!((sliding.sideways - sideways).abs() < 1e-12, "{sliding:?}");
            assert_eq!(sliding.dragged(), None, "{ahead} {sideways} {yaw}");
        }
        let axles = rover.side.geometry.axles.map(|axle| axle.x);
        let mean = axles.iter().sum::<f64>() / 3.0;
        let far = axles.map(|x| YAW * (x - mean).abs());
        let rims = [-0.1, -0.1, -0.1, 0.1, 0.1, 0.1];
        let mut sliding = Sliding::default();
        sliding.follow(&rover, &units, &rims, &exact(YAW), &[0.0; 6], DT);
        let dragged = sliding.dragged().unwrap_or(0.0);
        let farthest = far.into_iter().fold(0.0, f64::max);
        assert!((dragged - farthest).abs() < 1e-12, "{dragged} {farthest}");
    }

    /// A rover that yaws to and fro over rough ground, less than a drive that drags its wheels, does not drag them
    /// while it brakes either, nor after the rest.
    #[test]
    fn a_stop_drags_no_wheel() {
        let rover = rover();
        let units = Units::of(&rover.side);
        let mut sliding = Sliding::default();
        for k in 0..3000 {
            let time = DT * f64::from(k);
            // A drive, two tenths of a second of braking, five seconds of rest, and again.
            let speed = (0.2 - (time.rem_euclid(10.0) - 5.0).max(0.0)).max(0.0);
            let yaw = 0.4 * speed * (3.0 * time).sin();
            let rims =
                core::array::from_fn(|i| speed - yaw * sign(i / 3) * rover.half_tracks[i % 3]);
            sliding.follow(&rover, &units, &rims, &exact(yaw), &[0.0; 6], DT);
            assert_eq!(sliding.dragged(), None, "{time}: {sliding:?}");
        }
    }
}
