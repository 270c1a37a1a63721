//! The robot driven along its path: where is it stuck?
//!
//! The control holds the set speed while it can. Where the traction does not suffice, all wheels slide, T = mu N, and the robot
//! slows down; where it has lost all its speed it is stuck. Between two places d sigma apart
//!
//! ```text
//! sigma'^2 <= sigma'^2 + 2 d sigma a_max,     sigma'^2 >= sigma'^2 + 2 d sigma a_min
//! ```
//!
//! where a_max and a_min are the accelerations with all wheels sliding ([`Motion::thrust`]). When a wheel meets a second
//! contact, such as the edge of a kerb, an impact takes some of the speed.
//!
//! The friction of a sliding wheel falls with its slip speed, which is the set speed less the speed of the robot. The shared
//! control crawls while wheels slide ([`robhaz_control::shared::CRAWL`]), so its set speed is that of the crawl.

use crate::motion::Motion;

/// A place of the path as the driven robot passes it.
#[derive(Clone, Debug)]
pub struct Passed {
    /// Mean distance of the wheels' centres along their curve since the start, m.
    pub sigma: f64,
    /// Its equations; `None` where the four-bar cannot close.
    pub motion: Option<Motion>,
    /// Whether a wheel has just changed its contact. The place before has the same posture and the contact before.
    pub impact: bool,
}

/// What bounds the drive.
pub struct DriveLimits<'a> {
    /// Set speed, m/s, above 0.
    pub speed: f64,
    /// Largest traction of a wheel, N.
    pub traction: f64,
    /// Friction at a slip speed (m/s) over the available friction, -.
    pub sliding: &'a dyn Fn(f64) -> f64,
}

/// Where a robot gets stuck.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stuck {
    /// Index of the place.
    pub place: usize,
    /// Whether no forces balance the robot there: a wheel lifts or it tips over.
    pub tips: bool,
}

impl DriveLimits<'_> {
    /// Drives along the places with `shift` added to every friction coefficient. Speeds (m/s) at the places go to `speeds`.
    pub fn follow(&self, places: &[Passed], shift: f64, speeds: &mut Vec<f64>) -> Option<Stuck> {
        speeds.clear();
        let (set, mut speed) = (self.speed, self.speed);
        speeds.push(speed);
        for (place, pair) in places.windows(2).enumerate() {
            let (from, to) = (&pair[0], &pair[1]);
            let (Some(motion), Some(next)) = (&from.motion, &to.motion) else {
                return Some(Stuck { place, tips: true });
            };
            if to.impact {
                speed = next.after_impact(motion, speed, &|mu| (mu + shift).max(0.0));
            } else {
                let factor = (self.sliding)((set - speed).abs());
                let mu = |mean: f64| ((mean + shift) * factor).max(0.0);
                let square = |a: f64| speed * speed + 2.0 * (to.sigma - from.sigma) * a;
                let Some(most) = motion.thrust(1.0, &mu, speed, self.traction) else {
                    return Some(Stuck { place, tips: true });
                };
                let slowest = self.slowest(motion, &mu, speed, &square);
                let reached = (set * set).max(slowest).min(square(most));
                if reached <= 0.0 {
                    return Some(Stuck { place, tips: false });
                }
                speed = reached.sqrt();
            }
            speeds.push(speed);
        }
        None
    }

    /// Square of the least speed at the next place; 0 where the robot does not get faster without brakes.
    fn slowest(
        &self,
        motion: &Motion,
        mu: &dyn Fn(f64) -> f64,
        speed: f64,
        square: &dyn Fn(f64) -> f64,
    ) -> f64 {
        let coasts = motion.coasting(speed);
        if coasts.is_some_and(|a| square(a) <= self.speed * self.speed) {
            return 0.0;
        }
        let brakes = motion.thrust(-1.0, mu, speed, self.traction);
        brakes.map_or(0.0, square)
    }
}
