//! Follows the path and judges its places.

use crate::balance::{Balance, Distribution, GroundContact, Unsolved};
use crate::curve::CentreCurve;
use crate::mechanism::{Mechanism, OnGround, Reached, Walk};
use crate::report::{Failure, PathReport, Place, Reason};
use crate::setup::{PathError, PathSetup};
use rayon::prelude::*;
use robhaz_clearance::{BarPlace, ClearanceMeter, Clearances};
use robhaz_model::{Bar, Vec2};

/// Ground before and behind the path, over the wheelbase.
const BESIDE: f64 = 0.6;
/// The walk ends when the middle wheel has gone back by this share of the wheelbase: the robot turns round in a hole.
const BACK: f64 = 0.5;
/// Largest mean number of steps per metre: several times what the shipped grounds need.
const STEPS_PER_METRE: f64 = 20_000.0;
/// Number of places at which the search of mu_n starts anew: independent of the number of threads.
const CHUNK: usize = 64;
/// First guess of the needed friction, -.
const GUESS: f64 = 0.5;

/// A posture with its contacts, before its forces are known.
struct Posed {
    on_ground: OnGround,
    contacts: Vec<GroundContact>,
    clearances: Clearances,
}

/// Judges a path.
///
/// # Errors
/// [`PathError`] when the robot cannot stand at the start.
pub fn judge(setup: &PathSetup) -> Result<PathReport, PathError> {
    let (posed, end) = walk(setup)?;
    let places: Vec<Place> = posed
        .par_chunks(CHUNK)
        .map(|chunk| {
            let mut guess = GUESS;
            let judged = chunk.iter().map(|place| judged(setup, place, &mut guess));
            judged.collect::<Vec<_>>()
        })
        .flatten()
        .collect();
    let options = &setup.options;
    Ok(PathReport::new(
        setup.name.clone(),
        options.drive.name(),
        (options.mu, options.mu_sigma),
        setup.distance,
        places,
        end,
    ))
}

/// All postures from the start on, and the reason why they end too early.
fn walk(setup: &PathSetup) -> Result<(Vec<Posed>, Option<Failure>), PathError> {
    let geometry = &setup.robot.geometry;
    let axles = &geometry.axles;
    let start = axles[1].x;
    let wheelbase = axles[0].x - axles[2].x;
    let (from, to) = (axles[2].x, axles[0].x + setup.distance);
    let curve = CentreCurve::new(
        &setup.terrain,
        geometry.wheel_radius,
        from - BESIDE * wheelbase,
        to + BESIDE * wheelbase,
    );
    let mechanism = Mechanism::new(geometry);
    let no_start = PathError::Start { x: start };
    let wheels = mechanism.start(&curve, start).ok_or(no_start)?;
    check_stops(setup, start, mechanism.on_ground(&curve, &wheels).opening())?;
    let mut walk = Walk::new(&mechanism, &curve, wheels).ok_or(no_start)?;
    let mut meter = ClearanceMeter::new(geometry, setup.terrain.clone());
    let mut pose =
        |walk: &Walk<'_>, alone| pose(setup, &mechanism, &curve, walk, alone, &mut meter);
    let mut posed = vec![pose(&walk, None)];
    let mut farthest = start;
    for _ in 0..most_steps(setup.distance) {
        let before = walk.wheels;
        let reached = walk.step();
        let alone = match reached {
            Reached::End => {
                let x = mechanism.on_ground(&curve, &before).axles[1].x;
                return Ok((posed, Some(Failure::new(x, Reason::Posture, None))));
            }
            Reached::Place => None,
            Reached::Kink { wheel } => {
                // The wheel rests on both contacts, before it goes on with the one in front alone.
                posed.push(pose(&walk, None));
                Some(wheel)
            }
        };
        let place = pose(&walk, alone);
        let x = place.on_ground.axles[1].x;
        posed.push(place);
        farthest = farthest.max(x);
        if x >= start + setup.distance {
            return Ok((posed, None));
        }
        if x < farthest - BACK * wheelbase {
            return Ok((posed, Some(Failure::new(x, Reason::Posture, None))));
        }
    }
    let x = mechanism.on_ground(&curve, &walk.wheels).axles[1].x;
    Ok((posed, Some(Failure::new(x, Reason::Posture, None))))
}

/// Largest number of steps for a distance (m): a walk that needs more does not get ahead.
fn most_steps(distance: f64) -> usize {
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a checked distance"
    )]
    let steps = (distance * STEPS_PER_METRE) as usize;
    steps + 10_000
}

fn check_stops(setup: &PathSetup, x: f64, opening: f64) -> Result<(), PathError> {
    let stop = &setup.robot.geometry.stop;
    if (stop.lower..=stop.upper).contains(&opening) {
        return Ok(());
    }
    Err(PathError::StartStops {
        x,
        angle: opening.to_degrees(),
        lower: stop.lower.to_degrees(),
        upper: stop.upper.to_degrees(),
    })
}

/// The present posture; the wheel `alone` has the contact of its own piece only.
fn pose(
    setup: &PathSetup,
    mechanism: &Mechanism,
    curve: &CentreCurve,
    walk: &Walk<'_>,
    alone: Option<usize>,
    meter: &mut ClearanceMeter,
) -> Posed {
    let on_ground = mechanism.on_ground(curve, &walk.wheels);
    let radius = setup.robot.geometry.wheel_radius;
    let mut contacts = Vec::with_capacity(4);
    for wheel in 0..3 {
        let (piece, other) = walk.pieces_of(wheel);
        let other = other.filter(|_| alone != Some(wheel));
        for piece in [Some(piece), other].into_iter().flatten() {
            let at = curve.at(piece, walk.wheels.s[wheel]);
            let tangent = at.slope / at.slope.norm();
            let point = on_ground.axles[wheel] - Vec2::new(-tangent.y, tangent.x) * radius;
            contacts.push(GroundContact {
                wheel,
                point,
                tangent,
                mu: setup.mu_at(point.x),
            });
        }
    }
    Posed {
        clearances: clearances(setup, &on_ground, meter),
        on_ground,
        contacts,
    }
}

/// Clearance of the bars; not a number where the four-bar cannot close.
fn clearances(setup: &PathSetup, on_ground: &OnGround, meter: &mut ClearanceMeter) -> Clearances {
    let geometry = &setup.robot.geometry;
    match on_ground.posture(geometry) {
        Ok(posture) => meter.measure(&Bar::ALL.map(|bar| BarPlace {
            centre: on_ground.q + posture.cg_from_q(geometry, bar),
            angle: posture.angle(bar),
        })),
        Err(_) => Clearances([f64::NAN; 4]),
    }
}

/// Forces and failure at a place. `guess` is the needed friction of the place before.
fn judged(setup: &PathSetup, posed: &Posed, guess: &mut f64) -> Place {
    let OnGround { axles, q, .. } = posed.on_ground;
    let opening = posed.on_ground.opening();
    let count = |wheel| posed.contacts.iter().filter(|c| c.wheel == wheel).count();
    let mut place = Place {
        wheel_x: axles.map(|a| a.x),
        wheel_y: axles.map(|a| a.y),
        contacts: [0, 1, 2].map(count),
        opening,
        needed_mu: None,
        margin: None,
        normal_force: None,
        traction: None,
        clearance: posed.clearances.least().1,
        nearest_bar: posed.clearances.least().0.name(),
        failure: None,
    };
    let x = place.x();
    let robot = &setup.robot;
    let balance = posed
        .on_ground
        .posture(&robot.geometry)
        .ok()
        .and_then(|posture| {
            let masses = robot.mass.true_points();
            let contacts = posed.contacts.clone();
            Balance::new(
                &robot.geometry,
                &masses,
                &posture,
                q,
                contacts,
                setup.limits(),
            )
            .ok()
        });
    let Some(balance) = balance else {
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
            if margin < 0.0 {
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
    let radius = setup.robot.geometry.wheel_radius;
    let torque = balance.least_traction().map(|traction| traction * radius);
    match torque {
        Ok(torque) if torque > setup.torque_limit => {
            Failure::new(x, Reason::Torque, Some(torque - setup.torque_limit))
        }
        _ => unknown,
    }
}
