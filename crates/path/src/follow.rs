//! The robot driven along its path: where is it stuck?
//!
//! The control holds the set speed while it can. Where the traction does not suffice, all wheels
//! slide, T = mu N, and the robot slows down; where it has lost all its speed it is stuck. Between
//! two places d sigma apart
//!
//! ```text
//! sigma'^2 <= sigma'^2 + 2 d sigma a_max,     sigma'^2 >= sigma'^2 + 2 d sigma a_min
//! ```
//!
//! where a_max and a_min are the accelerations with all wheels sliding or at the torque limit
//! ([`crate::motion::Motion::thrust`]). When a wheel meets a second contact, such as the edge of a kerb, an impact
//! takes some of the speed.
//!
//! The friction of a sliding wheel falls with its slip speed, which is the set speed less the speed
//! of the robot. The shared control slows down to a crawl while wheels slide, and recovers in
//! seconds ([`robhaz_control::shared`]).

use crate::route::Posed;
use crate::setup::{DriveKind, PathSetup, Tractions};
use robhaz_control::shared::{CRAWL, RECOVERY_TIME, SLOWING_TIME};
use robhaz_model::Units;

/// The share of the set speed a time (of robot A, s) after it was `share`: the shared control slows
/// down to a crawl while wheels slide.
fn share_after(share: f64, slides: bool, time: f64) -> f64 {
    if slides {
        CRAWL + (share - CRAWL) * (-time / SLOWING_TIME).exp()
    } else {
        (share + time * (1.0 - CRAWL) / RECOVERY_TIME).min(1.0)
    }
}

/// Steps of the bisection for a speed at the torque limit: to 1e-9 of the set speed, since what it
/// lacks adds up from place to place.
const HALVINGS: u32 = 30;
/// Slowest speed with which the time between two places is computed, m/s.
const SLOWEST: f64 = 1e-3;

/// Where a robot gets stuck.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stuck {
    /// Index of the place.
    pub place: usize,
    /// Whether no forces balance the robot there: a wheel lifts or it tips over.
    pub tips: bool,
}

/// Drives along the places with the robot, control and set speed of a setup, tractions within
/// `limits` at a speed of the rim (m/s), and `shift` added to every friction coefficient. Speeds
/// (m/s) at the places go to `speeds`.
pub fn follow(
    setup: &PathSetup,
    limits: &dyn Fn(f64) -> Tractions,
    places: &[Posed],
    shift: f64,
    speeds: &mut Vec<f64>,
) -> Option<Stuck> {
    speeds.clear();
    let unit_of_time = Units::of(setup.robot()).time;
    let (mut speed, mut share) = (setup.scene.drive.speed, 1.0);
    speeds.push(speed);
    for (place, pair) in places.windows(2).enumerate() {
        let (from, to) = (&pair[0], &pair[1]);
        let (Some(motion), Some(next)) = (&from.motion, &to.motion) else {
            return Some(Stuck { place, tips: true });
        };
        let set = share * setup.scene.drive.speed;
        let friction = |slip: f64| {
            let factor = setup.sliding(slip);
            move |mean: f64| ((mean + shift) * factor).max(0.0)
        };
        if to.impact {
            // The rims keep their speed while the impact takes that of the robot.
            speed = next.after_impact(motion, speed, &friction(set));
            speeds.push(speed);
            continue;
        }
        let mu = friction((set - speed).abs());
        let square = |a: f64| speed * speed + 2.0 * (to.sigma - from.sigma) * a;
        // A wheel that lifts at speed is no obstacle; one that lifts at rest is.
        let thrust = |rim: f64| {
            let limits = limits(rim);
            let at = |speed| motion.thrust(1.0, &mu, speed, &limits);
            at(speed).or_else(|| at(0.0)).map(square)
        };
        let Some(most) = fastest(&thrust, set) else {
            return Some(Stuck { place, tips: true });
        };
        // Square of the least speed at the next place; 0 where the robot does not get faster without
        // brakes.
        let slowest = match motion.coasting(speed) {
            Some(coasts) if square(coasts) <= set * set => 0.0,
            _ => (motion.thrust(-1.0, &mu, speed, &limits(speed))).map_or(0.0, square),
        };
        let reached = (set * set).max(slowest).min(most);
        if reached <= 0.0 {
            return Some(Stuck { place, tips: false });
        }
        // The shared control slows down while wheels slide.
        if setup.options.drive == DriveKind::Shared {
            let mean = 0.5 * (speed + reached.sqrt());
            let time = (to.sigma - from.sigma) / mean.max(SLOWEST);
            let slides = most < set * set || slowest > set * set;
            share = share_after(share, slides, time / unit_of_time);
        }
        speed = reached.sqrt();
        speeds.push(speed);
    }
    None
}

/// Square of the largest speed at the next place, m^2/s^2, of what `thrust` gives for a speed of the
/// rims up to `set` (m/s). At the torque limit the thrust falls with the speed by viscous damping:
/// the speed that goes with its own thrust. `None` where no forces balance the robot.
fn fastest(thrust: &dyn Fn(f64) -> Option<f64>, set: f64) -> Option<f64> {
    let (at_set, at_rest) = (thrust(set)?, thrust(0.0)?);
    if at_set >= set * set || at_rest <= at_set {
        return Some(at_set);
    }
    if at_rest <= 0.0 {
        return Some(at_rest);
    }
    let (mut slow, mut fast) = (0.0, set);
    for _ in 0..HALVINGS {
        let middle = 0.5 * (slow + fast);
        if thrust(middle)? > middle * middle {
            slow = middle;
        } else {
            fast = middle;
        }
    }
    Some(slow * slow)
}
