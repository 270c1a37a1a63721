//! N and T as arrows at the contacts: true ones, estimated ones beside them, and bars of two standard deviations.

use crate::ViewerError;
use crate::colours::{Colour, WHEELS, by_index};
use crate::contact::{contact_point, tangent_and_normal};
use crate::convert::{flat, narrow};
use crate::writer::Writer;
use rerun::archetypes::{Arrows2D, LineStrips2D};
use rerun::components::Radius;
use robhaz_estimator::Estimate;
use robhaz_model::{Robot, Vec2, perp};
use robhaz_sim::Truth;

/// Length of the arrow of the mean static wheel load, m.
const MEAN_LOAD_LENGTH: f64 = 0.15;
/// Distance between true and estimated arrows, m.
const BESIDE: f64 = 0.03;
/// Half the length of the cross lines at the ends of a bar, m.
const BAR_END: f64 = 0.009;

/// The scale of forces: length of an arrow by force.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ForceScale {
    mean_load: f64,
}

impl ForceScale {
    /// The scale at which the arrow of a robot's mean static wheel load is 0.15 m long.
    pub(crate) fn new(robot: &Robot) -> Self {
        Self {
            mean_load: robot.mean_wheel_load(),
        }
    }

    /// Mean static load of a wheel, N.
    pub(crate) fn mean_load(self) -> f64 {
        self.mean_load
    }

    /// Length of the arrow of that load, m.
    pub(crate) fn mean_load_length(self) -> f64 {
        MEAN_LOAD_LENGTH
    }

    /// Force per length of arrow, N/m.
    pub(crate) fn newtons_per_metre(self) -> f64 {
        self.mean_load / MEAN_LOAD_LENGTH
    }

    /// Length of the arrow of a force (N), m. Negative for a negative force.
    fn length(self, force: f64) -> f64 {
        force / self.newtons_per_metre()
    }
}

/// The forces of one frame.
pub(crate) struct Shown<'a> {
    /// True forces.
    pub(crate) truth: &'a Truth,
    /// Contact angles that the estimator gets, rad. Without one, no estimate of that wheel is drawn.
    pub(crate) given_angle: &'a [Option<f64>; 3],
    /// Estimated forces. `None`: no estimate.
    pub(crate) estimate: Option<&'a Estimate>,
}

/// The arrows of a run.
pub(crate) struct Forces {
    scale: ForceScale,
    radius: f64,
    /// Index and name of the estimator that is drawn.
    estimator: Option<(usize, String)>,
}

impl Forces {
    /// The arrows of a robot. `estimator` is the index and the name of the estimator that is drawn.
    pub(crate) fn new(robot: &Robot, estimator: Option<(usize, String)>) -> Self {
        Self {
            scale: ForceScale::new(robot),
            radius: robot.geometry.wheel_radius,
            estimator,
        }
    }

    /// Logs the style of the arrows, and a legend whose upper left corner is a point of the frame that moves with the
    /// body (m, y down).
    pub(crate) fn declare(&self, out: &mut Writer, corner: [f64; 2]) -> Result<(), ViewerError> {
        // The colours come with the arrows: a wheel has none, one or two contacts.
        for force in ["normal", "traction"] {
            let style = Arrows2D::update_fields().with_radii([Radius::new_ui_points(2.5)]);
            out.constant(format!("world/forces/true/{force}"), &style)?;
        }
        let load = self.scale.mean_load;
        let mut rows = vec![(
            "true",
            format!("true, {load:.0} N"),
            arrows([crate::colours::NEUTRAL], 2.5),
        )];
        if let Some((index, name)) = &self.estimator {
            let colour = by_index(*index);
            for force in ["normal", "traction"] {
                let entity = format!("world/forces/estimated/{force}");
                out.constant(entity.as_str(), &arrows([colour], 1.25))?;
                out.constant(
                    format!("{entity}/two_sigma"),
                    &LineStrips2D::update_fields()
                        .with_colors([colour])
                        .with_radii([Radius::new_ui_points(1.0)]),
                )?;
            }
            let label = format!("estimated by {name}, {load:.0} N");
            rows.push(("estimated", label, arrows([colour], 1.25)));
        }
        let [x, mut y] = corner;
        for (source, label, style) in rows {
            out.constant(
                format!("world/follow/legend/{source}"),
                &style
                    .with_origins([[narrow(x), narrow(y)]])
                    .with_vectors([[narrow(MEAN_LOAD_LENGTH), 0.0]])
                    .with_labels([label])
                    .with_show_labels(true),
            )?;
            y += 0.06;
        }
        Ok(())
    }

    /// Logs the arrows of several frames, one frame at each of `times` (s).
    pub(crate) fn log<'a>(
        &self,
        out: &mut Writer,
        times: &[f64],
        frames: impl Iterator<Item = Shown<'a>>,
    ) -> Result<(), ViewerError> {
        let [mut true_n, mut true_t, mut estimated_n, mut estimated_t] =
            [const { Arrows::new() }; 4];
        let [mut bars_n, mut bars_t] = [const { Bars::new() }; 2];
        for frame in frames {
            for (i, wheel) in frame.truth.wheels.iter().enumerate() {
                let colour = WHEELS[i];
                for contact in wheel.contact_list.iter() {
                    let (point, n) = (contact.point, contact.normal);
                    let t = Vec2::new(n.y, -n.x);
                    true_n.push_into(point, n * self.scale.length(contact.normal_force));
                    true_t.push_from(point, t * self.scale.length(contact.traction));
                    true_n.colours.push(colour);
                    true_t.colours.push(colour);
                }
                let (Some(estimate), Some(angle)) = (frame.estimate, frame.given_angle[i]) else {
                    continue;
                };
                let point = contact_point(wheel, self.radius);
                let (t, n) = tangent_and_normal(angle);
                let normal = n * self.scale.length(estimate.normal_force[i]);
                let traction = t * self.scale.length(estimate.traction[i]);
                let (head, foot) = (point - t * BESIDE, point - n * BESIDE);
                estimated_n.push_into(head, normal);
                estimated_t.push_from(foot, traction);
                if let Some(sigma) = estimate.sigma_normal(i) {
                    bars_n.push(head - normal, n, self.scale.length(2.0 * sigma));
                }
                if let Some(sigma) = estimate.sigma_traction(i) {
                    bars_t.push(foot + traction, t, self.scale.length(2.0 * sigma));
                }
            }
            for arrows in [&mut true_n, &mut true_t, &mut estimated_n, &mut estimated_t] {
                arrows.end_row();
            }
            bars_n.end_row();
            bars_t.end_row();
        }
        true_n.log(out, "world/forces/true/normal", times)?;
        true_t.log(out, "world/forces/true/traction", times)?;
        if self.estimator.is_some() {
            estimated_n.log(out, "world/forces/estimated/normal", times)?;
            estimated_t.log(out, "world/forces/estimated/traction", times)?;
            bars_n.log(out, "world/forces/estimated/normal/two_sigma", times)?;
            bars_t.log(out, "world/forces/estimated/traction/two_sigma", times)?;
        }
        Ok(())
    }
}

/// Arrows of several times, any number at each.
struct Arrows {
    /// One for each arrow; empty if the style of the entity has the colours.
    colours: Vec<Colour>,
    origins: Vec<[f32; 2]>,
    vectors: Vec<[f32; 2]>,
    rows: Vec<usize>,
    before: usize,
}

impl Arrows {
    const fn new() -> Self {
        Self {
            colours: Vec::new(),
            origins: Vec::new(),
            vectors: Vec::new(),
            rows: Vec::new(),
            before: 0,
        }
    }

    /// Adds an arrow from a point (both m).
    fn push_from(&mut self, origin: Vec2, vector: Vec2) {
        self.origins.push(flat(origin));
        self.vectors.push(flat(vector));
    }

    /// Adds an arrow to a point (both m). An arrow of N thus lies below the ground, where nothing else is drawn.
    fn push_into(&mut self, head: Vec2, vector: Vec2) {
        self.push_from(head - vector, vector);
    }

    fn end_row(&mut self) {
        self.rows.push(self.origins.len() - self.before);
        self.before = self.origins.len();
    }

    fn log(self, out: &mut Writer, entity: &str, times: &[f64]) -> Result<(), ViewerError> {
        let mut arrows = Arrows2D::update_fields()
            .with_origins(self.origins)
            .with_vectors(self.vectors);
        if !self.colours.is_empty() {
            arrows = arrows.with_colors(self.colours);
        }
        out.columns(entity, times, arrows.columns(self.rows))
    }
}

/// Bars of two standard deviations, any number at each of several times.
struct Bars {
    strips: Vec<[[f32; 2]; 6]>,
    rows: Vec<usize>,
    before: usize,
}

impl Bars {
    const fn new() -> Self {
        Self {
            strips: Vec::new(),
            rows: Vec::new(),
            before: 0,
        }
    }

    /// Adds a bar around a centre (m), along a unit vector, with half its length (m).
    fn push(&mut self, centre: Vec2, along: Vec2, half: f64) {
        let across = perp(along) * BAR_END;
        let (near, far) = (centre - along * half, centre + along * half);
        let strip = [
            near - across,
            near + across,
            near,
            far,
            far - across,
            far + across,
        ];
        self.strips.push(strip.map(flat));
    }

    fn end_row(&mut self) {
        self.rows.push(self.strips.len() - self.before);
        self.before = self.strips.len();
    }

    /// Logs the bars. Without any bar it logs nothing.
    fn log(self, out: &mut Writer, entity: &str, times: &[f64]) -> Result<(), ViewerError> {
        if self.strips.is_empty() {
            return Ok(());
        }
        let columns = LineStrips2D::update_fields()
            .with_strips(self.strips)
            .columns(self.rows);
        out.columns(entity, times, columns)
    }
}

/// The style of arrows: colours, and half the width of the shaft in points.
fn arrows(colours: impl IntoIterator<Item = Colour>, radius: f32) -> Arrows2D {
    Arrows2D::update_fields()
        .with_colors(colours)
        .with_radii([Radius::new_ui_points(radius)])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Closed form: the arrow of the mean load is 0.15 m long.
    #[test]
    fn the_mean_load_is_fifteen_centimetres_long() {
        let robot = Robot::default_a();
        let scale = ForceScale::new(&robot);
        assert!((scale.length(robot.mean_wheel_load()) - 0.15).abs() < 1e-12);
    }

    /// Closed form: the ends of a bar are two standard deviations from its centre, along the force.
    #[test]
    fn a_bar_spans_two_sigma_to_both_sides() {
        let mut bars = Bars::new();
        bars.push(Vec2::new(1.0, 0.0), Vec2::new(0.0, 1.0), 0.25);
        let [_, _, near, far, _, _] = bars.strips[0];
        assert!((near[1] + 0.25).abs() < 1e-6 && (far[1] - 0.25).abs() < 1e-6);
        assert!((near[0] - 1.0).abs() < 1e-6 && (far[0] - 1.0).abs() < 1e-6);
    }
}
