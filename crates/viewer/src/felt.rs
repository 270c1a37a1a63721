//! The ground as an estimator has found it: a line that grows while the robot drives, with two standard deviations.

use crate::ViewerError;
use crate::colours::{Colour, by_index};
use crate::convert::flat;
use crate::writer::Writer;
use rerun::archetypes::LineStrips2D;
use rerun::components::Radius;
use robhaz_estimator::GroundPoint;
use robhaz_model::Vec2;
use robhaz_run::{Frame, RunDescription};
use robhaz_score::ground_origin;

/// Distance between points beyond which the line is not drawn, m.
const GAP: f64 = 0.035;
/// Points that the wheels have left: all rows up to the cursor are shown.
pub(crate) const LEFT: &str = "world/felt/left";
/// Points that a wheel can still correct: only the newest row is shown.
const MEMORY: &str = "world/felt/memory";

/// The ground at one time, in world coordinates, m.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct FeltFrame {
    /// Time, s.
    time: f64,
    /// Points that the wheels have left since the last frame, with the last one before.
    left: Lines,
    /// Points in memory, with the last one that was left.
    memory: Lines,
}

/// Pieces of the line, and of the lines two standard deviations below and above.
#[derive(Clone, Debug, Default, PartialEq)]
struct Lines {
    middle: Vec<Vec<Vec2>>,
    bounds: Vec<Vec<Vec2>>,
}

/// Collects the ground of one estimator.
pub(crate) struct FeltCollector {
    /// Index of the estimator; `None`: nothing is drawn.
    estimator: Option<usize>,
    wheel_radius: f64,
    /// True place of the estimator's origin, m.
    origin: Option<Vec2>,
    /// Points left since the last frame, the last one before first.
    left: Vec<GroundPoint>,
    /// Whether a frame is due.
    is_due: bool,
    frames: Vec<FeltFrame>,
}

impl FeltCollector {
    /// A collector before the first record, for an estimator by its index. Recorded readings have no world to draw in.
    pub(crate) fn new(run: &RunDescription, estimator: Option<usize>) -> Self {
        Self {
            estimator: estimator.filter(|_| run.world.is_some()),
            wheel_radius: run.robot.robot.geometry.wheel_radius,
            origin: None,
            left: Vec::new(),
            is_due: false,
            frames: Vec::new(),
        }
    }

    /// Takes a record; `due` for one that is drawn, or the next that has the ground in memory.
    pub(crate) fn sample(&mut self, frame: &Frame<'_>, due: bool) {
        let (Some(k), Some(truth)) = (self.estimator, frame.truth) else {
            return;
        };
        let origin = *self
            .origin
            .get_or_insert(ground_origin(truth, self.wheel_radius));
        // The origin of a later section is not known.
        let drawn = |p: &GroundPoint| p.section == 0;
        let left = frame.ground.completed(k).iter().filter(|p| drawn(p));
        self.left.extend(left);
        self.is_due |= due;
        if !self.is_due || !frame.ground.has_memory() {
            return;
        }
        self.is_due = false;
        let last = self.left.last().copied();
        let memory = frame.ground.in_memory(k).filter(drawn);
        let memory: Vec<GroundPoint> = last.into_iter().chain(memory).collect();
        if memory.len() > 1 || self.left.len() > 1 {
            self.frames.push(FeltFrame {
                time: frame.time,
                left: Lines::of(&self.left, origin),
                memory: Lines::of(&memory, origin),
            });
        }
        self.left = last.into_iter().collect();
    }

    /// Takes the frames since the last call.
    pub(crate) fn take(&mut self) -> Vec<FeltFrame> {
        std::mem::take(&mut self.frames)
    }
}

impl Lines {
    fn of(points: &[GroundPoint], origin: Vec2) -> Self {
        let mut lines = Self::default();
        let pieces = points.chunk_by(|a, b| (a.x - b.x).abs() < GAP);
        for piece in pieces.filter(|piece| piece.len() > 1) {
            let line = |sigmas: f64| {
                let at =
                    |p: &GroundPoint| origin + Vec2::new(p.x, p.height + sigmas * p.sigma_height);
                piece.iter().map(at).collect::<Vec<_>>()
            };
            lines.middle.push(line(0.0));
            lines.bounds.extend([line(-2.0), line(2.0)]);
        }
        lines
    }
}

/// Logs the look of the lines, for an estimator by its index.
pub(crate) fn declare(out: &mut Writer, estimator: usize) -> Result<(), ViewerError> {
    let colour = by_index(estimator);
    for entity in [LEFT, MEMORY] {
        look(out, entity, colour, 1.25)?;
        look(out, &bounds_of(entity), colour, 0.4)?;
    }
    Ok(())
}

fn look(out: &mut Writer, entity: &str, colour: Colour, width: f32) -> Result<(), ViewerError> {
    out.constant(
        entity,
        &LineStrips2D::update_fields()
            .with_colors([colour])
            .with_radii([Radius::new_ui_points(width)]),
    )
}

/// Entity of the two standard deviations.
pub(crate) fn bounds_of(entity: &str) -> String {
    format!("{entity}/two_sigma")
}

/// Logs frames.
pub(crate) fn log(out: &mut Writer, frames: &[FeltFrame]) -> Result<(), ViewerError> {
    let left: Vec<_> = frames.iter().map(|f| (f.time, &f.left)).collect();
    let left: Vec<_> = left
        .into_iter()
        .filter(|(_, l)| !l.middle.is_empty())
        .collect();
    let memory: Vec<_> = frames.iter().map(|f| (f.time, &f.memory)).collect();
    for (entity, rows) in [(LEFT, left), (MEMORY, memory)] {
        strips(out, entity, rows.iter().map(|(t, l)| (*t, &l.middle)))?;
        let bounds = rows.iter().map(|(t, l)| (*t, &l.bounds));
        strips(out, &bounds_of(entity), bounds)?;
    }
    Ok(())
}

fn strips<'a>(
    out: &mut Writer,
    entity: &str,
    rows: impl Iterator<Item = (f64, &'a Vec<Vec<Vec2>>)>,
) -> Result<(), ViewerError> {
    let rows: Vec<_> = rows.collect();
    let times: Vec<f64> = rows.iter().map(|(time, _)| *time).collect();
    let strip = |strip: &Vec<Vec2>| strip.iter().copied().map(flat).collect::<Vec<_>>();
    out.columns(
        entity,
        &times,
        LineStrips2D::update_fields()
            .with_strips(rows.iter().flat_map(|(_, strips)| strips.iter().map(strip)))
            .columns(rows.iter().map(|(_, strips)| strips.len())),
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use robhaz_estimator::FrictionBounds;

    /// Closed form: points 10 mm apart are one line, a gap of 50 mm makes two; the bounds are two deviations off.
    #[test]
    fn gaps_break_the_line() {
        let point = |x: f64| GroundPoint {
            x,
            sigma_x: 0.0,
            height: 0.1,
            sigma_height: 0.01,
            slope: 0.0,
            friction: FrictionBounds::default(),
            sigma_slope: 0.0,
            section: 0,
        };
        let points = [0.0, 0.01, 0.06, 0.07, 0.2].map(point);
        let lines = Lines::of(&points, Vec2::new(1.0, 2.0));
        assert_eq!((lines.middle.len(), lines.bounds.len()), (2, 4));
        assert_eq!(lines.middle[0], [Vec2::new(1.0, 2.1), Vec2::new(1.01, 2.1)]);
        assert!((lines.bounds[3][0] - Vec2::new(1.06, 2.12)).norm() < 1e-12);
    }
}
