//! The ground that the estimators of a run have found, beside the true one.

use crate::quantile::extremes;
use robhaz_estimator::GroundPoint;
use robhaz_model::Vec2;
use robhaz_run::{Frame, RunDescription, RunEnd};
use robhaz_score::{GroundErrors, TrueGround, ground_origin};
use robhaz_terrain::{Surveyed, Terrain};
use std::sync::Arc;

/// Largest distance of places at which the true ground is computed, m. Between them it is taken as straight: at a curvature of
/// 10/m that errs by 1.3 um.
const SPACING: f64 = 1e-3;
/// Points whose ground is computed together: some 10 m. That of an hour's path would take 30 MB.
const SURVEYED_AT_ONCE: usize = 1024;

/// Collects the ground of every estimator.
#[derive(Clone, Debug, Default)]
pub struct EstimatedTerrains {
    /// The points of each estimator, in the order in which it completed them; none before the end of the run.
    points: Vec<Arc<[GroundPoint]>>,
    wheel_radius: f64,
    /// True place of the origin of the first section, m.
    origin: Option<Vec2>,
}

/// A point and the true ground there; `None` where it is not known.
pub type ComparedPoint = (GroundPoint, Option<TrueGround>);

impl EstimatedTerrains {
    /// Before the first record of a run.
    pub fn new(run: &RunDescription) -> Self {
        Self {
            points: Vec::new(),
            wheel_radius: run.robot.robot.geometry.wheel_radius,
            origin: None,
        }
    }

    /// Takes the origin from the first record.
    pub fn add(&mut self, frame: &Frame<'_>) {
        if self.origin.is_none() {
            let radius = self.wheel_radius;
            self.origin = frame.truth.map(|truth| ground_origin(truth, radius));
        }
    }

    /// Takes the points at the end of the run.
    pub fn finish(&mut self, end: Option<&RunEnd>) {
        self.points = end.map_or(Vec::new(), |end| end.ground.clone());
    }

    /// The points of an estimator with the true ground, which a simulation has. Only the origin of the first section is known:
    /// later sections have no truth.
    pub fn compared(&self, estimator: usize, terrain: Option<&Terrain>) -> Vec<ComparedPoint> {
        let points = self.points.get(estimator).map_or(&[][..], |p| &p[..]);
        let chunks = points.chunks(SURVEYED_AT_ONCE);
        let with_truth = chunks.flat_map(|points| {
            let places = points.iter().filter(|p| p.section == 0).map(|p| p.x);
            let (low, high) = extremes(places);
            let truth = terrain.zip(self.origin).filter(|_| low <= high);
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

    /// Errors of the ground of an estimator; `None` where nothing can be compared. Points behind the origin count, too.
    pub fn errors(&self, estimator: usize, terrain: Option<&Terrain>) -> Option<GroundErrors> {
        let compared = self.compared(estimator, terrain).into_iter();
        GroundErrors::of(compared.filter_map(|(point, truth)| Some((point, truth?))))
    }
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

#[cfg(test)]
mod tests {
    use super::*;
    use robhaz_estimator::FrictionBounds;
    use robhaz_terrain::Profile;

    /// Closed form: on the kerb of 50 mm at 0.7 m, with the origin at x = 0.2 m on the lower level, places from 0.5 m on are
    /// 50 mm high; without an origin, and in a later section, nothing is compared.
    #[test]
    fn the_truth_is_that_of_the_place() {
        let point = |x: f64, section: u32| GroundPoint {
            x,
            sigma_x: 0.0,
            height: 0.05,
            sigma_height: 0.001,
            slope: 0.0,
            friction: FrictionBounds::default(),
            sigma_slope: 0.01,
            section,
        };
        let terrain = Terrain::new(Profile::step());
        let mut grounds = EstimatedTerrains {
            points: vec![Arc::new([point(0.4, 0), point(0.6, 0), point(0.0, 1)])],
            wheel_radius: 0.1,
            origin: Some(Vec2::new(0.2, 0.0)),
        };
        let truth: Vec<_> = grounds.compared(0, Some(&terrain));
        let heights: Vec<_> = truth.iter().map(|(_, t)| t.map(|t| t.height)).collect();
        assert_eq!(heights, [Some(0.0), Some(0.05), None]);
        let errors = grounds.errors(0, Some(&terrain)).expect("two points");
        assert_eq!((errors.points, errors.slope_rmse_rad), (2, Some(0.0)));
        // Errors of 50 mm and 0.
        assert!((errors.height_rmse_m - 0.05 / 2.0_f64.sqrt()).abs() < 1e-15);
        grounds.origin = None;
        assert_eq!(grounds.errors(0, Some(&terrain)), None);
        assert_eq!(grounds.errors(1, Some(&terrain)), None);
    }
}
