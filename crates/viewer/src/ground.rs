//! The ground in the animation, as far as the robot drives, with friction stretches in another
//! colour.

use crate::ViewerError;
use crate::colours;
use crate::convert::flat;
use crate::writer::Writer;
use rerun::archetypes::LineStrips2D;
use rerun::components::Radius;
use robhaz_run::RunDescription;
use robhaz_scene::Scene;
use robhaz_sim::Truth;
use robhaz_sim::friction::Stretch;
use robhaz_terrain::Terrain;

/// Distance between points of the ground, m.
const SPACING: f64 = 0.005;
/// Length of drawn ground beyond the axles, m.
const MARGIN: f64 = 0.4;

/// The ground of a run.
pub(crate) struct Ground {
    terrain: Terrain,
    stretches: Vec<Stretch>,
    /// Static coefficient outside of friction stretches, -.
    mu_s: f64,
    /// Range that is drawn so far, m.
    drawn: (f64, f64),
    /// Range that must be drawn for the records so far, m.
    covered: (f64, f64),
}

impl Ground {
    /// The ground over which the robot of a simulation drives at its set speed.
    pub(crate) fn new(run: &RunDescription, world: &Scene) -> Self {
        let axles = &run.robot.robot.geometry.axles;
        let (rear, front) = (axles[2].x - MARGIN, axles[0].x + MARGIN);
        let radius = run.robot.robot.geometry.wheel_radius;
        let [back, ahead] = world.drive.planned_travel(run.record.duration, radius);
        let drawn = (rear + back, front + ahead);
        Self {
            terrain: world.terrain.build(&run.robot.robot),
            stretches: world.terrain.stretches.clone(),
            mu_s: world.friction.mu_s,
            drawn,
            covered: drawn,
        }
    }

    /// Start, end, lowest and highest point of the drawn range, m.
    pub(crate) fn box_of(&self) -> [f64; 4] {
        let (from, to) = self.drawn;
        let points = self.terrain.outline(from, to, SPACING);
        let heights = || points.iter().map(|p| p.y);
        let (low, high) = (
            heights().fold(f64::MAX, f64::min),
            heights().fold(f64::MIN, f64::max),
        );
        [from, to, low, high]
    }

    /// Whether the ground has a corner anywhere.
    pub(crate) fn has_corners(&self) -> bool {
        self.terrain.has_corners()
    }

    /// Extends the range that must be drawn to the wheels of a record.
    pub(crate) fn cover(&mut self, truth: &Truth) {
        for wheel in &truth.wheels {
            self.covered.0 = self.covered.0.min(wheel.position.x - MARGIN);
            self.covered.1 = self.covered.1.max(wheel.position.x + MARGIN);
        }
    }

    /// Draws the ground again if the robot is outside of the drawn range. The new range is longer
    /// than necessary, so that this happens rarely.
    pub(crate) fn extend(&mut self, out: &mut Writer) -> Result<(), ViewerError> {
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
    pub(crate) fn draw(&self, out: &mut Writer) -> Result<(), ViewerError> {
        let (from, to) = self.drawn;
        let strip = |from: f64, to: f64| {
            let points = self.terrain.outline(from, to, SPACING);
            points.into_iter().map(flat).collect::<Vec<_>>()
        };
        out.constant(
            "world/ground",
            &LineStrips2D::new([strip(from, to)])
                .with_colors([colours::GROUND])
                .with_radii([Radius::new_ui_points(1.5)]),
        )?;
        let seen = || self.stretches.iter().filter(|s| s.from < to && s.to > from);
        if seen().next().is_none() {
            return Ok(());
        }
        let colour = |s: &Stretch| match s.mu_s < self.mu_s {
            true => colours::SLIPPERY,
            false => colours::ROUGH,
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
