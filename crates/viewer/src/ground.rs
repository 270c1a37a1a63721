//! The ground in the scene, as far as the robot gets; stretches with friction of their own are told apart.

use crate::ViewerError;
use crate::colours;
use crate::convert::flat;
use crate::writer::Writer;
use rerun::archetypes::LineStrips2D;
use rerun::components::Radius;
use robhaz_scene::Scene;
use robhaz_sim::Truth;
use robhaz_sim::friction::Stretch;
use robhaz_terrain::Terrain;

/// Spacing of the ground's points, m.
const SPACING: f64 = 0.005;
/// Ground is drawn this far beyond where the wheels' axles go, m.
const MARGIN: f64 = 0.4;

/// The ground of a run.
pub(crate) struct Ground {
    terrain: Terrain,
    stretches: Vec<Stretch>,
    /// Static coefficient outside of the stretches, -.
    mu_s: f64,
    /// Stretch of the ground that is drawn so far, and the one that the robot covers; m.
    drawn: (f64, f64),
    covered: (f64, f64),
}

impl Ground {
    /// The ground that a scene's robot is planned to cover.
    pub(crate) fn new(scene: &Scene) -> Self {
        let axles = &scene.robot.robot.geometry.axles;
        let (rear, front) = (axles[2].x - MARGIN, axles[0].x + MARGIN);
        let travel = planned_travel(scene);
        let drawn = (rear + travel.min(0.0), front + travel.max(0.0));
        Self {
            terrain: Terrain::new(scene.terrain.profile.clone()),
            stretches: scene.terrain.stretches.clone(),
            mu_s: scene.friction.mu_s,
            drawn,
            covered: drawn,
        }
    }

    /// The ground that is planned to be covered, m: from, to, lowest, highest.
    pub(crate) fn box_of(&self) -> [f64; 4] {
        let (from, to) = self.drawn;
        let points = self.terrain.outline(from, to, SPACING);
        let (low, high) = points
            .into_iter()
            .fold((f64::MAX, f64::MIN), |(low, high), p| {
                (low.min(p.y), high.max(p.y))
            });
        [from, to, low, high]
    }

    /// Somewhere it has a corner.
    pub(crate) fn has_corners(&self) -> bool {
        self.terrain.has_corners()
    }

    /// Takes note of where the robot is.
    pub(crate) fn cover(&mut self, truth: &Truth) {
        for wheel in &truth.wheels {
            self.covered.0 = self.covered.0.min(wheel.position.x - MARGIN);
            self.covered.1 = self.covered.1.max(wheel.position.x + MARGIN);
        }
    }

    /// Draws more ground where the robot went farther than planned; more than needed, so that this stays rare.
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

    /// Draws what is to be drawn so far.
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
        out.constant(
            "world/ground/stretches",
            &LineStrips2D::new(seen().map(|s| strip(s.from.max(from), s.to.min(to))))
                .with_colors(seen().map(|s| colours::stretch(s.mu_s, self.mu_s)))
                .with_labels(seen().map(|s| format!("mu_s {}, mu_d {}", s.mu_s, s.mu_d)))
                .with_show_labels(true)
                .with_radii([Radius::new_ui_points(4.0)]),
        )
    }
}

/// How far the robot goes if its wheels do what they are told, m; backward negative.
fn planned_travel(scene: &Scene) -> f64 {
    let time = scene.record.duration - scene.drive.start_time - 0.5 * scene.drive.ramp_time;
    scene.drive.speed * time.max(0.0)
}
