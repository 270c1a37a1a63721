//! The ground as an estimator has found it: a line that grows while the robot drives, with two
//! standard deviations.

use crate::colours::by_index;
use crate::draw::{Strips, lines};
use crate::error::Result;
use crate::writer::Writer;
use robhaz_estimator::GroundPoint;
use robhaz_model::Vec2;
use robhaz_run::{Frame, RunDescription};
use robhaz_score::ground_origin;

/// Distance between points beyond which the line is not drawn, over the wheel radius.
const GAP: f64 = 0.35;
/// Points that the wheels have left: all rows up to the cursor are shown.
pub(crate) const LEFT: &str = "world/estimated_terrain/left";
/// Points that a wheel can still correct: only the newest row is shown.
const MEMORY: &str = "world/estimated_terrain/memory";

/// Pieces of the line at several times, and of the lines two standard deviations below and above.
#[derive(Default)]
struct Lines {
    middle: Strips,
    bounds: Strips,
}

/// Draws the ground of one estimator.
#[derive(Default)]
pub(crate) struct Terrain {
    /// Index of the estimator; `None`: nothing is drawn.
    estimator: Option<usize>,
    wheel_radius: f64,
    /// True place of the estimator's origin, m.
    origin: Option<Vec2>,
    /// Points left since the lines were last written, after the last one before.
    points: Vec<GroundPoint>,
    /// Whether the lines are to be written.
    is_due: bool,
    left: Lines,
    memory: Lines,
}

impl Terrain {
    /// Before the first record, for an estimator by its index. Recorded readings have no world to
    /// draw in.
    pub(crate) fn new(run: &RunDescription, estimator: Option<usize>) -> Self {
        let finds_ground = |k: &usize| run.estimators[*k].settings.states_covariance();
        Self {
            estimator: estimator.filter(|k| run.world.is_some() && finds_ground(k)),
            wheel_radius: run.robot.robot.geometry.wheel_radius,
            ..Self::default()
        }
    }

    /// Logs the look of the lines.
    pub(crate) fn declare(&self, out: &mut Writer) -> Result {
        let Some(estimator) = self.estimator else {
            return Ok(());
        };
        for entity in [LEFT, MEMORY] {
            for (entity, width) in [(entity.to_owned(), 1.25), (bounds_of(entity), 0.4)] {
                out.constant(entity, &lines(by_index(estimator), width))?;
            }
        }
        Ok(())
    }

    /// Takes a record; `due` for one that is drawn, or the next that has the ground in memory.
    pub(crate) fn sample(&mut self, frame: &Frame<'_>, due: bool) {
        let (Some(k), Some(truth)) = (self.estimator, frame.truth) else {
            return;
        };
        let radius = self.wheel_radius;
        let origin = *(self.origin).get_or_insert_with(|| ground_origin(truth, radius));
        // The origin of a later section is not known.
        let drawn = |p: &GroundPoint| p.section == 0;
        let left = frame.ground.completed(k).iter().filter(|p| drawn(p));
        self.points.extend(left);
        self.is_due |= due;
        if !self.is_due || !frame.ground.has_memory() {
            return;
        }
        self.is_due = false;
        let last = self.points.last().copied();
        let memory = frame.ground.in_memory(k).iter().filter(|p| drawn(p));
        let memory: Vec<GroundPoint> = last.into_iter().chain(memory.copied()).collect();
        if self.points.len() > 1 {
            self.left.push(frame.time, &self.points, origin, radius);
        }
        if memory.len() > 1 || self.points.len() > 1 {
            self.memory.push(frame.time, &memory, origin, radius);
        }
        self.points = last.into_iter().collect();
    }

    /// Logs what was drawn since the last call.
    pub(crate) fn flush(&mut self, out: &mut Writer) -> Result {
        for (lines, entity) in [(&mut self.left, LEFT), (&mut self.memory, MEMORY)] {
            let Lines { middle, bounds } = std::mem::take(lines);
            middle.log(out, entity)?;
            bounds.log(out, &bounds_of(entity))?;
        }
        Ok(())
    }
}

impl Lines {
    /// Adds the points that wheels of a radius (m) have found.
    fn push(&mut self, time: f64, points: &[GroundPoint], origin: Vec2, radius: f64) {
        let pieces = points.chunk_by(|a, b| (a.x - b.x).abs() < GAP * radius);
        let pieces: Vec<_> = pieces.filter(|piece| piece.len() > 1).collect();
        let line = |piece: &[GroundPoint], sigmas: f64| -> Vec<Vec2> {
            let at = |p: &GroundPoint| origin + Vec2::new(p.x, p.height + sigmas * p.sigma_height);
            piece.iter().map(at).collect()
        };
        let bounds = |piece: &&[GroundPoint]| [line(piece, -2.0), line(piece, 2.0)];
        self.middle.push(time, pieces.iter().map(|p| line(p, 0.0)));
        self.bounds.push(time, pieces.iter().flat_map(bounds));
    }
}

/// Entity of the two standard deviations.
pub(crate) fn bounds_of(entity: &str) -> String {
    format!("{entity}/two_sigma")
}

#[cfg(test)]
mod tests {
    use super::*;
    use robhaz_estimator::FrictionBounds;

    /// Closed form: points 10 mm apart are one line, a gap of 50 mm makes two; the bounds are two
    /// deviations off.
    #[test]
    fn gaps_break_the_line() {
        let point = |x: f64| GroundPoint {
            x,
            axle_x: x,
            sigma_x: 0.0,
            height: 0.1,
            sigma_height: 0.01,
            slope: 0.0,
            friction: FrictionBounds::default(),
            sigma_slope: 0.0,
            section: 0,
        };
        let points = [0.0, 0.01, 0.06, 0.07, 0.2].map(point);
        let mut lines = Lines::default();
        lines.push(0.0, &points, Vec2::new(1.0, 2.0), 0.1);
        let (middle, bounds) = (lines.middle.strips, lines.bounds.strips);
        assert_eq!((middle.len(), bounds.len()), (2, 4));
        assert_eq!(middle[0], [[1.0, 2.1], [1.01, 2.1]]);
        // Single precision.
        assert!((bounds[3][0][0] - 1.06).abs() < 1e-6 && (bounds[3][0][1] - 2.12).abs() < 1e-6);
    }
}
