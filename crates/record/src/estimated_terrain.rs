//! The ground that the estimators of a run have found, beside the true one.

use robhaz_estimator::GroundPoint;
use robhaz_model::Vec2;
use robhaz_run::{RunDescription, RunEnd};
use robhaz_score::{TrueGround, extremes, ground_origin};
use robhaz_terrain::{Surveyed, Terrain};

/// Largest distance of places at which the true ground is computed, m. Between them it is taken as
/// straight: at a curvature of 10/m that errs by 1.3 um.
const SPACING: f64 = 1e-3;
/// Points whose ground is computed together: some 10 m. That of an hour's path would take 30 MB.
const SURVEYED_AT_ONCE: usize = 1024;

/// A point and the true ground there; `None` where it is not known.
pub type ComparedPoint = (GroundPoint, Option<TrueGround>);

/// The points of an estimator at the end of the run, in the order in which it completed them, with the
/// true ground, which a simulation has. Only the origin of the first section is known: later sections
/// have no truth.
pub fn compared(
    run: &RunDescription,
    end: &RunEnd,
    estimator: usize,
    terrain: Option<&Terrain>,
) -> Vec<ComparedPoint> {
    let radius = run.robot.robot.geometry.wheel_radius;
    let origin = end.start.as_ref().map(|truth| ground_origin(truth, radius));
    let points = end.ground.get(estimator).map_or(&[][..], |points| points);
    let chunks = points.chunks(SURVEYED_AT_ONCE);
    let with_truth = chunks.flat_map(|points| {
        let places = points.iter().filter(|p| p.section == 0).map(|p| p.x);
        let (low, high) = extremes(places);
        let truth = terrain.zip(origin).filter(|_| low <= high);
        let truth = truth.map(|(terrain, origin)| {
            let (from, to) = (origin.x + low - SPACING, origin.x + high + SPACING);
            (origin, terrain.survey(from, to, SPACING))
        });
        points.iter().map(move |point| {
            let known = truth.as_ref().filter(|_| point.section == 0);
            let truth = known.and_then(|(origin, s)| true_at(s, *origin, point.x));
            (*point, truth)
        })
    });
    with_truth.collect()
}

/// The true ground at a place `x` (m) relative to the origin, between two points of a survey.
fn true_at(surveyed: &[Surveyed], origin: Vec2, x: f64) -> Option<TrueGround> {
    let place = origin.x + x;
    let next = surveyed.partition_point(|p| p.x <= place);
    let after = surveyed.get(next)?;
    let before = surveyed.get(next.checked_sub(1)?)?;
    let share = (place - before.x) / (after.x - before.x);
    let between = |a: f64, b: f64| a + share * (b - a);
    let slope = before.slope.zip(after.slope);
    Some(TrueGround {
        height: between(before.height, after.height) - origin.y,
        slope: slope.map(|(a, b)| between(a, b).atan()),
    })
}
