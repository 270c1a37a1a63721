//! The tractions that a control comes to at one place: forces at rest that balance the robot.

use crate::motion::{Forced, Motion};
use crate::setup::{DriveKind, PathSetup};
use robhaz_sim::friction::Slip;

/// Most steps of the search; ten usually suffice.
const MOST_STEPS: u32 = 100;
/// Times that the first step is doubled until the acceleration changes its sign.
const DOUBLINGS: u32 = 8;
/// Acceleration below which the robot counts as balanced, m/s^2: 1e-11 of gravity.
const BALANCED: f64 = 1e-10;

/// What a control comes to at a place.
pub struct Controlled {
    /// Forces at rest.
    pub forced: Forced,
    /// The needed friction: the largest |T|/N of the wheels, and of one that slides its mu.
    pub needed: f64,
    /// How much the friction coefficients can fall until a wheel slides; 0 where one does, below 0
    /// where all of them slide and do not hold the robot.
    pub margin: f64,
}

/// Tractions of the control of a setup at a place; `None` where they do not balance the robot with
/// all N >= 0, where a wheel has two contacts, and for the ideal control, which has no law.
///
/// - `shared`: T = m N at every wheel, with one m.
/// - `speed`: all wheels turn with the set speed. Each creeps, or slides, as the friction law of the
///   scene says, and the speed of the robot is the one at which the sum of the tractions holds it.
///   Where all wheels slide and do not hold it, T = m N with the friction m that would.
pub fn controlled(setup: &PathSetup, motion: &Motion, guess: &mut f64) -> Option<Controlled> {
    let mu = |i: usize| motion.contacts.iter().find(|c| c.wheel == i).map(|c| c.mu);
    let mu = [mu(0)?, mu(1)?, mu(2)?];
    let speed = setup.scene.drive.speed;
    let equal = |m: f64| [(m, false); 3];
    let by_slip = |v: f64| {
        [0, 1, 2].map(|i| {
            let (centre, link) = motion.rates[i];
            let slip = Slip {
                rim: speed - v * link,
                centre: v * centre,
            };
            setup.creeping(mu[i], &slip)
        })
    };
    let found = match setup.options.drive {
        DriveKind::Ideal => None,
        DriveKind::Shared => balanced(setup, motion, &equal, *guess, 0.05),
        // The tractions fall with the speed of the robot.
        DriveKind::Speed => balanced(setup, motion, &by_slip, *guess, -0.01 * speed)
            .or_else(|| balanced(setup, motion, &by_slip, speed, -0.01 * speed))
            .or_else(|| {
                let sliding = balanced(setup, motion, &equal, 0.0, 0.05)?;
                Some(Root {
                    at: *guess,
                    ..sliding
                })
            }),
    }?;
    *guess = found.at;
    let (mut needed, mut margin) = (0.0_f64, f64::INFINITY);
    for i in (0..3).filter(|i| found.forced.normal_force[*i] > 0.0) {
        let own = match found.slides[i] {
            true => mu[i],
            false => (found.forced.traction[i] / found.forced.normal_force[i]).abs(),
        };
        needed = needed.max(own);
        margin = margin.min(mu[i] - own);
    }
    Some(Controlled {
        forced: found.forced,
        needed,
        margin,
    })
}

/// The first guess of the quantity that is searched for: m, or the speed of the robot (m/s).
pub fn first_guess(setup: &PathSetup) -> f64 {
    match setup.options.drive {
        DriveKind::Speed => setup.scene.drive.speed,
        DriveKind::Ideal | DriveKind::Shared => 0.0,
    }
}

/// Where the acceleration is 0.
struct Root {
    /// m, or the speed of the robot, m/s.
    at: f64,
    forced: Forced,
    /// Which wheels slide.
    slides: [bool; 3],
}

/// Root of the acceleration, which grows in the direction of `step`: steps that double until it
/// changes its sign, then false position (Illinois).
fn balanced(
    setup: &PathSetup,
    motion: &Motion,
    ratios: &dyn Fn(f64) -> [(f64, bool); 3],
    guess: f64,
    step: f64,
) -> Option<Root> {
    let limits = setup.tractions(0.0);
    let at = |x: f64| {
        let found = ratios(x);
        let forced = motion.at_rest(found.map(|(ratio, _)| ratio), &limits)?;
        let slides = found.map(|(_, slides)| slides);
        Some(Root {
            at: x,
            forced,
            slides,
        })
    };
    let of = |root: &Root| root.forced.acceleration;
    let is_balanced = |root: &Root| of(root).abs() < BALANCED;
    let mut a = at(guess)?;
    if is_balanced(&a) {
        return Some(a);
    }
    // Where the acceleration is too small it has to grow.
    let step = if of(&a) < 0.0 { step } else { -step };
    let mut tries = (0..DOUBLINGS).map(|k| f64::from((1 << (k + 1)) - 1));
    let mut b = loop {
        let next = at(guess + step * tries.next()?)?;
        if is_balanced(&next) {
            return Some(next);
        }
        if of(&next) * of(&a) < 0.0 {
            break next;
        }
        a = next;
    };
    let (mut weight_a, mut weight_b) = (of(&a), of(&b));
    for _ in 0..MOST_STEPS {
        let x = (a.at * weight_b - b.at * weight_a) / (weight_b - weight_a);
        let next = at(x)?;
        if is_balanced(&next) {
            return Some(next);
        }
        // An end that stays for a second time counts half.
        if of(&next) * of(&b) < 0.0 {
            (a, weight_a) = (b, weight_b);
        } else {
            weight_a *= 0.5;
        }
        weight_b = of(&next);
        b = next;
    }
    None
}
