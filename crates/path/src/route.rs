//! The path's places: postures of the robot with all contacts, from the start on.

use crate::balance::GroundContact;
use crate::curve::CentreCurve;
use crate::mechanism::{Mechanism, OnGround, Reached, Tangent, Walk};
use crate::motion::Motion;
use crate::report::{Failure, Reason};
use crate::setup::{PathError, PathSetup};
use robhaz_model::{Bar, perp};
use robhaz_sim::clearance::{BarPlace, ClearanceMeter, Clearances};

/// Ground before and behind the path, over the wheelbase.
const BESIDE: f64 = 0.6;
/// The walk ends when the middle wheel has gone back by this share of the wheelbase: the robot
/// turns round in a hole.
const BACK: f64 = 0.5;
/// Largest mean number of steps per metre: several times what the shipped grounds need.
const STEPS_PER_METRE: f64 = 20_000.0;
/// Least distance of two places whose tangents are compared, m: above it the accuracy of the curve
/// does not count.
const APART: f64 = 1e-4;

/// A posture with its contacts, before its forces are known.
pub struct Posed {
    /// Where wheels and links are.
    pub on_ground: OnGround,
    /// All contacts.
    pub contacts: Vec<GroundContact>,
    /// Clearance of body and links.
    pub clearances: Clearances,
    /// Places of the wheels along their curve, m.
    s: [f64; 3],
    /// Direction in which the path comes to a kink, otherwise in which it goes on.
    tangent: Tangent,
    /// Whether a wheel has just changed its contact. The place before has the same posture and the
    /// contact before.
    pub impact: bool,
    /// Of a driven robot the mean distance of the wheels' centres along their curve since the start,
    /// m.
    pub sigma: f64,
    /// Of a driven robot its equations; `None` where the four-bar cannot close.
    pub motion: Option<Motion>,
}

/// All postures from the start on, and the reason why they end too early.
pub fn walk(setup: &PathSetup) -> Result<(Vec<Posed>, Option<Failure>), PathError> {
    let geometry = &setup.robot().geometry;
    let axles = &geometry.axles;
    let start = axles[1].x;
    let (beside, ahead) = (BESIDE * geometry.wheelbase(), setup.distance);
    let (from, to) = (axles[2].x - beside, axles[0].x + ahead + beside);
    let curve = CentreCurve::new(&setup.terrain, geometry.wheel_radius, from, to);
    let mechanism = Mechanism::new(geometry, &curve);
    let no_start = || {
        PathError(format!(
            "at the start, with the middle wheel at x = {start} m, there is no posture in which all wheels touch the ground: \
             [terrain] must be smooth and not too steep there"
        ))
    };
    let wheels = mechanism.start(start).ok_or_else(no_start)?;
    check_stops(setup, start, mechanism.on_ground(&wheels).opening())?;
    let mut walk = Walk::new(&mechanism, wheels).ok_or_else(no_start)?;
    let mut meter = ClearanceMeter::new(geometry, setup.terrain.clone());
    let mut pose = |walk: &Walk<'_>, alone| pose(setup, walk, alone, &mut meter);
    let mut posed = vec![pose(&walk, None)];
    let mut farthest = start;
    // A walk that needs more steps does not get ahead. The distance is checked.
    let most_steps = (setup.distance * STEPS_PER_METRE) as usize + 10_000;
    for _ in 0..most_steps {
        let before = walk.wheels;
        let reached = walk.step();
        let alone = match reached {
            Reached::End => {
                let x = mechanism.on_ground(&before).axles[1].x;
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
        if x < farthest - BACK * geometry.wheelbase() {
            return Ok((posed, Some(Failure::new(x, Reason::Posture, None))));
        }
    }
    let x = mechanism.on_ground(&walk.wheels).axles[1].x;
    Ok((posed, Some(Failure::new(x, Reason::Posture, None))))
}

fn check_stops(setup: &PathSetup, x: f64, opening: f64) -> Result<(), PathError> {
    let stop = &setup.robot().geometry.stop;
    if (stop.lower..=stop.upper).contains(&opening) {
        return Ok(());
    }
    let [angle, lower, upper] = [opening, stop.lower, stop.upper].map(f64::to_degrees);
    Err(PathError(format!(
        "at the start, with the middle wheel at x = {x} m, pin Q would have to be at {angle:.1} deg; its end stops allow \
         {lower:.1} to {upper:.1} deg: [terrain] must be flatter there"
    )))
}

/// The present posture; the wheel `alone` has the contact of its own piece only.
fn pose(
    setup: &PathSetup,
    walk: &Walk<'_>,
    alone: Option<usize>,
    meter: &mut ClearanceMeter,
) -> Posed {
    let on_ground = walk.mechanism.on_ground(&walk.wheels);
    let radius = setup.robot().geometry.wheel_radius;
    let mut contacts = Vec::with_capacity(4);
    for wheel in 0..3 {
        let (piece, other) = walk.pieces_of(wheel);
        let other = other.filter(|_| alone != Some(wheel));
        for piece in [Some(piece), other].into_iter().flatten() {
            let at = walk.mechanism.curve.at(piece, walk.wheels.s[wheel]);
            let tangent = at.slope / at.slope.norm();
            let point = on_ground.axles[wheel] - perp(tangent) * radius;
            contacts.push(GroundContact {
                wheel,
                point,
                tangent,
                mu: setup.mu_at(point.x),
            });
        }
    }
    Posed {
        s: walk.wheels.s,
        tangent: match (alone, walk.approach) {
            (None, Some(approach)) => approach,
            _ => walk.tangent(),
        },
        impact: alone.is_some(),
        sigma: 0.0,
        motion: None,
        clearances: clearances(setup, &on_ground, meter),
        on_ground,
        contacts,
    }
}

/// Clearance of the bars; not known where the four-bar cannot close.
fn clearances(setup: &PathSetup, on_ground: &OnGround, meter: &mut ClearanceMeter) -> Clearances {
    let geometry = &setup.robot().geometry;
    match on_ground.posture(geometry) {
        Ok(posture) => meter.measure(&Bar::ALL.map(|bar| BarPlace {
            centre: on_ground.q + posture.cg_from_q(geometry, bar),
            angle: posture.angle(bar),
        })),
        Err(_) => Clearances::of([f64::NAN; 4]),
    }
}

/// Adds the way and the equations of a driven robot to the places.
pub fn add_motions(setup: &PathSetup, posed: &mut [Posed]) {
    for k in 1..posed.len() {
        let moved = posed[k].s.iter().zip(&posed[k - 1].s);
        let moved: f64 = moved.map(|(s, before)| (s - before).abs()).sum();
        posed[k].sigma = posed[k - 1].sigma + moved / 3.0;
    }
    for k in 0..posed.len() {
        let place = &posed[k];
        let path = [&place.tangent, &turn(posed, k)];
        let motion = Motion::new(setup.robot(), &place.on_ground, path, &place.contacts);
        posed[k].motion = motion;
    }
}

/// Derivative of the tangent by sigma at place `k`, from its neighbours on the same smooth piece.
fn turn(posed: &[Posed], k: usize) -> Tangent {
    let starts = posed[k].impact || k == 0;
    let ends = posed.get(k + 1).is_none_or(|next| next.impact);
    let (before, after) = (k - usize::from(!starts), k + usize::from(!ends));
    let step = posed[after].sigma - posed[before].sigma;
    if step < APART {
        return Tangent::default();
    }
    let (a, b) = (&posed[before].tangent, &posed[after].tangent);
    Tangent {
        q: (b.q - a.q) / step,
        angles: [0, 1].map(|i| (b.angles[i] - a.angles[i]) / step),
        centres: [0, 1, 2].map(|i| (b.centres[i] - a.centres[i]) / step),
    }
}
