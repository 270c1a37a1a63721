//! The tractions that a control comes to at one place: forces at rest that balance the robot.

use crate::motion::{Forced, Motion};
use crate::setup::{DriveKind, PathSetup};

/// Most steps of the secant method; five usually suffice.
const MOST_STEPS: u32 = 40;
/// Acceleration below which the robot counts as balanced, m/s^2: 1e-11 of gravity.
const BALANCED: f64 = 1e-10;

/// Tractions of the control of a setup at a place, and the largest |T|/N of the wheels; `None` where they do not balance the robot with
/// all N >= 0, where a wheel has two contacts, and for the ideal control, which has no law.
///
/// - `shared`: T = m N at every wheel, with one m.
/// - `speed`: all wheels turn with the set speed. Each creeps, `T = N (slip speed)/c`, and the
///   speed of the robot is the one at which the sum of the tractions holds it.
pub fn controlled(setup: &PathSetup, motion: &Motion, guess: &mut f64) -> Option<(Forced, f64)> {
    let (speed, creep) = (setup.speed, setup.creep_speed);
    let equal = |m: f64| [m; 3];
    let rates = motion.rates;
    let by_slip = |v: f64| rates.map(|(centre, link)| (speed - v * (centre + link)) / creep);
    let (ratios, step): (&dyn Fn(f64) -> [f64; 3], f64) = match setup.options.drive {
        DriveKind::Ideal => return None,
        DriveKind::Shared => (&equal, 0.05),
        DriveKind::Speed => (&by_slip, 0.05 * creep),
    };
    let (root, forced) = balanced(setup, motion, ratios, *guess, step)?;
    *guess = root;
    let loaded = (0..3).filter(|i| forced.normal_force[*i] > 0.0);
    let ratio = loaded.map(|i| (forced.traction[i] / forced.normal_force[i]).abs());
    Some((forced, ratio.fold(0.0, f64::max)))
}

/// The first guess of the quantity that is searched for: m, or the speed of the robot (m/s).
pub fn first_guess(setup: &PathSetup) -> f64 {
    match setup.options.drive {
        DriveKind::Speed => setup.speed,
        DriveKind::Ideal | DriveKind::Shared => 0.0,
    }
}

/// Root of the acceleration by the secant method.
fn balanced(
    setup: &PathSetup,
    motion: &Motion,
    ratios: &dyn Fn(f64) -> [f64; 3],
    guess: f64,
    step: f64,
) -> Option<(f64, Forced)> {
    let traction = setup.traction_limit();
    let at = |x: f64| motion.at_rest(ratios(x), traction);
    let (mut x, mut last) = (guess, at(guess)?);
    let (mut next_x, mut next) = (guess + step, at(guess + step)?);
    for _ in 0..MOST_STEPS {
        if next.acceleration.abs() < BALANCED {
            return Some((next_x, next));
        }
        let slope = (next.acceleration - last.acceleration) / (next_x - x);
        let moved = -next.acceleration / slope;
        if !moved.is_finite() {
            return None;
        }
        (x, last) = (next_x, next);
        next_x += moved;
        next = at(next_x)?;
    }
    None
}
