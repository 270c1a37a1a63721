//! Judges the places of the path, and the path as a whole.

use crate::balance::{Balance, Distribution, GroundContact, Unsolved};
use crate::follow::follow;
use crate::report::{Failure, PathReport, Place, Reason};
use crate::route::{Posed, add_motions, walk};
use crate::setup::{DriveKind, LARGEST_MU, PathError, PathSetup, Tractions};
use crate::tractions::{controlled, first_guess};
use rayon::prelude::*;

/// Number of places at which the search of mu_n starts anew: independent of the number of threads.
const CHUNK: usize = 64;
/// First guess of the needed friction, -.
const GUESS: f64 = 0.5;
/// Accuracy of the margin of a driven robot, -.
const MARGIN: f64 = 1e-4;
/// A needed friction below this is none, -: contact angles are exact to 1e-8.
const NO_FRICTION: f64 = 1e-7;

/// Judges a path.
///
/// # Errors
/// [`PathError`] when the robot cannot stand at the start.
pub fn judge(setup: &PathSetup) -> Result<PathReport, PathError> {
    let (mut posed, end) = walk(setup)?;
    let is_driven = setup.options.drive != DriveKind::Ideal;
    if is_driven {
        add_motions(setup, &mut posed);
    }
    let contacts = posed.iter().flat_map(|place| &place.contacts);
    let largest = contacts.map(|contact| contact.mu).fold(0.0, f64::max);
    let mut places: Vec<Place> = posed
        .par_chunks(CHUNK)
        .map(|chunk| {
            let mut guesses = (GUESS, first_guess(setup));
            let place = |posed: &Posed| {
                let mut place = match is_driven {
                    false => judged(setup, posed, &mut guesses.0),
                    true => with_control(setup, posed, &mut guesses),
                };
                // Where none is needed all friction of the path can fall away.
                if place.needed_mu.is_some_and(|needed| needed < NO_FRICTION) {
                    place.margin = Some(largest);
                }
                place
            };
            chunk.iter().map(place).collect::<Vec<_>>()
        })
        .flatten()
        .collect();
    let driven = is_driven.then(|| drive(setup, &posed, &mut places, largest));
    Ok(PathReport::new(setup, places, end, driven))
}

/// Drives along the places, and notes where the robot gets stuck. Returns how far all friction
/// coefficients can fall before it does, -, at most the `largest` one; `None` where no friction
/// helps.
fn drive(setup: &PathSetup, posed: &[Posed], places: &mut [Place], largest: f64) -> Option<f64> {
    let limits = |rim| setup.tractions(rim);
    let mut speeds = Vec::with_capacity(posed.len());
    let stuck = follow(setup, &limits, posed, 0.0, &mut speeds);
    for (place, speed) in places.iter_mut().zip(&speeds) {
        place.speed = Some(*speed);
    }
    let mut passes = |shift: f64| follow(setup, &limits, posed, shift, &mut speeds).is_none();
    let margin = bracket(&mut passes).map(|(mut fails, mut holds)| {
        while holds - fails > MARGIN {
            let middle = 0.5 * (fails + holds);
            if passes(middle) {
                holds = middle;
            } else {
                fails = middle;
            }
        }
        // Without friction there is nothing left to fall.
        (-holds).min(largest)
    });
    if let Some(stuck) = stuck {
        let place = &mut places[stuck.place];
        let (reason, by) = if stuck.tips {
            (Reason::Tipping, None)
        } else if follow(setup, &|_| Tractions::FREE, posed, 0.0, &mut speeds).is_none() {
            (Reason::Torque, None)
        } else {
            (Reason::Friction, margin.map(|m| -m))
        };
        place.failure = Some(Failure::new(place.x(), reason, by));
    }
    margin
}

/// A shift of all friction coefficients with which the robot is stuck, and a larger one with which
/// it passes; `None` where no friction helps.
fn bracket(passes: &mut dyn FnMut(f64) -> bool) -> Option<(f64, f64)> {
    let (mut at, mut step) = (0.0, 0.125);
    let sign = if passes(at) { -1.0 } else { 1.0 };
    loop {
        let next = at + sign * step;
        if passes(next) != (sign < 0.0) {
            return Some((at.min(next), at.max(next)));
        }
        // Without friction there is nothing to fall any more.
        if next.abs() >= LARGEST_MU {
            return (sign < 0.0).then_some((next, next));
        }
        (at, step) = (next, 2.0 * step);
    }
}

/// A place without forces.
fn bare(posed: &Posed) -> Place {
    let axles = posed.on_ground.axles;
    let count = |wheel| posed.contacts.iter().filter(|c| c.wheel == wheel).count();
    Place {
        wheel_x: axles.map(|a| a.x),
        wheel_y: axles.map(|a| a.y),
        contacts: [0, 1, 2].map(count),
        opening: posed.on_ground.opening(),
        clearance: posed.clearances.least.1,
        nearest_bar: posed.clearances.least.0.name(),
        ..Place::default()
    }
}

/// A place with the tractions of a control. Where a wheel has two contacts statics leaves their
/// shares open: the best distribution is taken.
fn with_control(setup: &PathSetup, posed: &Posed, guesses: &mut (f64, f64)) -> Place {
    let Some(motion) = &posed.motion else {
        let mut place = bare(posed);
        place.failure = Some(Failure::new(place.x(), Reason::Posture, None));
        return place;
    };
    if motion.contacts.len() > 3 {
        let mut place = judged(setup, posed, &mut guesses.0);
        place.failure = None;
        return place;
    }
    let mut place = bare(posed);
    let mut from = guesses.1;
    let found = controlled(setup, motion, &mut from).or_else(|| {
        from = first_guess(setup);
        controlled(setup, motion, &mut from)
    });
    if let Some(found) = found {
        guesses.1 = from;
        place.needed_mu = Some(found.needed);
        place.margin = Some(found.margin);
        place.normal_force = Some(found.forced.normal_force);
        place.traction = Some(found.forced.traction);
    }
    if posed.clearances.touches() {
        place.failure = Some(Failure::new(place.x(), Reason::Clearance, None));
    }
    place
}

/// Forces and failure at a place. `guess` is the needed friction of the place before.
fn judged(setup: &PathSetup, posed: &Posed, guess: &mut f64) -> Place {
    let mut place = bare(posed);
    let (opening, q) = (place.opening, posed.on_ground.q);
    let x = place.x();
    let robot = setup.robot();
    let posture = posed.on_ground.posture(&robot.geometry);
    let balance = posture.and_then(|posture| {
        let contacts = posed.contacts.clone();
        Balance::new(robot, &posture, q, contacts, setup.tractions(0.0))
    });
    let Ok(balance) = balance else {
        place.failure = Some(Failure::new(x, Reason::Posture, None));
        return place;
    };
    match forces(&posed.contacts, &balance, guess) {
        Ok((needed, best)) => {
            let margin = -best.excess;
            place.needed_mu = Some(needed);
            place.margin = Some(margin);
            place.normal_force = Some(best.normal_force);
            place.traction = Some(best.traction);
            if margin < 0.0 && needed >= NO_FRICTION {
                place.failure = Some(Failure::new(x, Reason::Friction, Some(-margin)));
            }
        }
        Err(_) => place.failure = Some(without_balance(setup, x, &balance)),
    }
    if posed.clearances.touches() {
        place.failure = Some(Failure::new(x, Reason::Clearance, None));
    }
    let stop = &robot.geometry.stop;
    let beyond = (opening - stop.upper).max(stop.lower - opening);
    if beyond > 0.0 {
        place.failure = Some(Failure::new(x, Reason::EndStop, Some(beyond)));
    }
    place
}

/// The needed friction, and the distribution with the largest margin.
fn forces(
    contacts: &[GroundContact],
    balance: &Balance,
    guess: &mut f64,
) -> Result<(f64, Distribution), Unsolved> {
    // A little above the last value it is allowed in most cases.
    let needed = balance.least_excess(false, 1.1 * *guess + 0.01)?;
    *guess = needed.excess;
    let mu = contacts.first().map_or(0.0, |c| c.mu);
    if contacts.iter().all(|c| c.mu.to_bits() == mu.to_bits()) {
        // With one coefficient at all contacts the margin is mu - mu_n.
        let excess = needed.excess - mu;
        return Ok((needed.excess, Distribution { excess, ..needed }));
    }
    let least = contacts.iter().map(|c| c.mu).fold(f64::INFINITY, f64::min);
    let best = balance.least_excess(true, needed.excess - least)?;
    Ok((needed.excess, best))
}

/// Why no allowed forces balance the robot, with any friction.
fn without_balance(setup: &PathSetup, x: f64, balance: &Balance) -> Failure {
    let unknown = Failure::new(x, Reason::Solver, None);
    let Ok(load) = balance.largest_least_load() else {
        return unknown;
    };
    if load < 0.0 {
        return Failure::new(x, Reason::Tipping, Some(-load));
    }
    let radius = setup.robot().geometry.wheel_radius;
    // What drives the robot and the gears.
    let torque = balance.least_traction();
    let torque = torque.map(|traction| (traction + setup.losses(0.0)) * radius);
    let beyond = torque.map_or(0.0, |torque| torque - setup.scene.drive.torque_limit);
    if beyond > 0.0 {
        Failure::new(x, Reason::Torque, Some(beyond))
    } else {
        unknown
    }
}
