//! The ground in the animation, as far as the robot drives, with friction stretches in another
//! colour, and an axis below it: the 2-D views have none of their own. The arrows of the legend are
//! the scale beside the robot.

use crate::colours::{GROUND, NEUTRAL, ROUGH, SLIPPERY};
use crate::draw::{flat, lines, rounded};
use crate::error::Result;
use crate::writer::Writer;
use re_sdk_types::archetypes::{LineStrips2D, Points2D};
use re_sdk_types::components::Radius;
use robhaz_model::Vec2;
use robhaz_run::RunDescription;
use robhaz_scene::Scene;
use robhaz_score::extremes;
use robhaz_sim::Truth;
use robhaz_sim::friction::Stretch;
use robhaz_terrain::Terrain;

/// Distance between points of the ground, m.
const SPACING: f64 = 0.005;
// Lengths of robot A; those of others are in proportion to their size.
/// Length of drawn ground beyond the axles, m.
const MARGIN: f64 = 0.4;
/// Distance of the axis below the lowest ground, m. The arrows of N lie between them.
const BELOW: f64 = 0.30;
/// Length of a tick, m.
const TICK: f64 = 0.03;
/// Least number of ticks of an axis.
const LEAST_TICKS: f64 = 4.0;
/// Height that the axis needs below the lowest ground, m.
const ROOM: f64 = 0.55;
/// Height of the robot above the highest ground, m.
const ABOVE: f64 = 0.45;

/// The ground of a run.
pub(crate) struct Ground {
    pub(crate) terrain: Terrain,
    stretches: Vec<Stretch>,
    /// Static coefficient outside of friction stretches, -.
    mu_s: f64,
    /// Of the robot, relative to that of robot A.
    size: f64,
    /// Range that is drawn so far, m.
    drawn: (f64, f64),
    /// Range that must be drawn for the records so far, m.
    covered: (f64, f64),
}

impl Ground {
    /// The ground over which the robot of a simulation drives at its set speed.
    pub(crate) fn new(run: &RunDescription, world: &Scene) -> Self {
        let geometry = &run.robot.robot.geometry;
        let (axles, radius, size) = (&geometry.axles, geometry.wheel_radius, geometry.size());
        let (rear, front) = (axles[2].x - MARGIN * size, axles[0].x + MARGIN * size);
        let [back, ahead] = world.drive.planned_travel(run.record.duration, radius);
        let drawn = (rear + back, front + ahead);
        Self {
            terrain: world.terrain.build(&run.robot.robot),
            stretches: world.terrain.stretches.clone(),
            mu_s: world.friction.mu_s,
            size,
            drawn,
            covered: drawn,
        }
    }

    /// Start, end, lowest and highest point of the drawn range, m.
    pub(crate) fn box_of(&self) -> [f64; 4] {
        let (from, to) = self.drawn;
        let points = self.terrain.outline(from, to, SPACING);
        let (low, high) = extremes(points.iter().map(|p| p.y));
        [from, to, low, high]
    }

    /// What a view of all of it shows, left to right and top to bottom, m, y down: the robot is above
    /// the ground, the arrows of N and the axis are below it.
    pub(crate) fn bounds(&self) -> [[f64; 2]; 2] {
        let [from, to, low, high] = self.box_of();
        [
            [from, to],
            [-(high + ABOVE * self.size), ROOM * self.size - low],
        ]
    }

    /// Extends the range that must be drawn to the wheels of a record.
    pub(crate) fn cover(&mut self, truth: &Truth) {
        let margin = MARGIN * self.size;
        let (from, to) = &mut self.covered;
        for wheel in &truth.wheels {
            *from = from.min(wheel.position.x - margin);
            *to = to.max(wheel.position.x + margin);
        }
    }

    /// Draws the ground again if the robot is outside of the drawn range. The new range is longer
    /// than necessary, so that this happens rarely.
    pub(crate) fn extend(&mut self, out: &mut Writer) -> Result {
        let (from, to) = self.covered;
        let more = 0.25 * (to - from);
        let (backward, forward) = (from < self.drawn.0, to > self.drawn.1);
        if backward {
            self.drawn.0 = from - more;
        }
        if forward {
            self.drawn.1 = to + more;
        }
        if backward || forward {
            self.draw(out)?;
        }
        Ok(())
    }

    /// Draws the ground and its friction stretches over the drawn range.
    pub(crate) fn draw(&self, out: &mut Writer) -> Result {
        let (from, to) = self.drawn;
        let strip = |from: f64, to: f64| {
            let points = self.terrain.outline(from, to, SPACING);
            points.into_iter().map(flat).collect::<Vec<_>>()
        };
        let ground = lines(GROUND, 1.5).with_strips([strip(from, to)]);
        out.constant("world/ground", &ground)?;
        let seen = || self.stretches.iter().filter(|s| s.from < to && s.to > from);
        if seen().next().is_none() {
            return Ok(());
        }
        let colour = |s: &Stretch| match s.mu_s < self.mu_s {
            true => SLIPPERY,
            false => ROUGH,
        };
        out.constant(
            "world/ground/stretches",
            &LineStrips2D::new(seen().map(|s| strip(s.from.max(from), s.to.min(to))))
                .with_colors(seen().map(colour))
                .with_labels(seen().map(|s| format!("mu_s {}, mu_d {}", s.mu_s, s.mu_d)))
                .with_show_labels(true)
                .with_radii([Radius::new_ui_points(4.0)]),
        )
    }
}

/// Logs the axis below a piece of ground (start, end, lowest point; m) of a robot of a size relative to
/// that of robot A.
pub(crate) fn log_axis(out: &mut Writer, [from, to, low]: [f64; 3], size: f64) -> Result {
    let ticks = ticks(from, to);
    let (Some(first), Some(last)) = (ticks.first(), ticks.last()) else {
        return Ok(());
    };
    let at = |x: f64, above: f64| flat(Vec2::new(x, low + (above - BELOW) * size));
    let marks = ticks.iter().map(|x| [at(*x, 0.0), at(*x, TICK)]);
    let axis = marks.chain([[at(*first, 0.0), at(*last, 0.0)]]);
    let axis = lines(NEUTRAL, 0.75).with_strips(axis);
    out.constant("world/scale/axis", &axis)?;
    let labels = Points2D::new(ticks.iter().map(|x| at(*x, 0.0)))
        .with_labels(ticks.iter().map(|x| format!("{} m", rounded(*x, 1e6))))
        .with_show_labels(true)
        .with_colors([NEUTRAL])
        .with_radii([Radius::new_ui_points(1.0)]);
    out.constant("world/scale/labels", &labels)
}

/// Ticks from one place to another, m: multiples of 1, 2 or 5 times a power of ten.
fn ticks(from: f64, to: f64) -> Vec<f64> {
    let most = (to - from) / LEAST_TICKS;
    let decade = 10f64.powf(most.log10().floor());
    let steps = [5.0, 2.0, 1.0].map(|m| m * decade);
    let step = steps.into_iter().find(|step| *step <= most);
    let step = step.unwrap_or(decade);
    let first = (from / step).ceil();
    let ticks = std::iter::successors(Some(first), |k| Some(k + 1.0));
    ticks.map(|k| k * step).take_while(|x| *x <= to).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Closed form: 5 m are divided by ticks every metre, 1.2 m by ticks every 0.2 m.
    #[test]
    fn ticks_are_round_numbers() {
        assert_eq!(ticks(-0.7, 4.3).len(), 5);
        let fine: Vec<f64> = ticks(-0.1, 1.1)
            .into_iter()
            .map(|x| rounded(x, 1e6))
            .collect();
        assert_eq!(fine, [0.0, 0.2, 0.4, 0.6, 0.8, 1.0]);
    }
}
