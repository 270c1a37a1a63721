//! N and T as arrows at the contacts: true ones, estimated ones beside them, and bars of two
//! standard deviations.

use crate::colours::{NEUTRAL, WHEELS, by_index};
use crate::draw::{Arrows, Strips, contact_point, lines, narrow, rounded, tangent_and_normal};
use crate::error::Result;
use crate::writer::Writer;
use re_sdk_types::archetypes::Arrows2D;
use re_sdk_types::components::Radius;
use robhaz_model::{Robot, Vec2, perp};
use robhaz_run::Frame;
use robhaz_sim::Truth;

// Lengths of robot A; those of others are in proportion to their size.
/// Length of the arrow of the mean static wheel load, m.
const MEAN_LOAD_LENGTH: f64 = 0.15;
/// Distance between true and estimated arrows, m.
const BESIDE: f64 = 0.03;
/// Half the length of the cross lines at the ends of a bar, m.
const BAR_END: f64 = 0.009;
/// Distance between the rows of the legend, m.
const ROW: f64 = 0.06;

/// Length of the arrow of the mean static wheel load of a robot, m: whole millimetres.
fn mean_load_length(robot: &Robot) -> f64 {
    rounded(MEAN_LOAD_LENGTH * robot.geometry.size(), 1e3)
}

/// Force per length of arrow of a robot, N/m.
pub(crate) fn newtons_per_metre(robot: &Robot) -> f64 {
    robot.mean_wheel_load() / mean_load_length(robot)
}

/// The arrows of a run.
#[derive(Default)]
pub(crate) struct Forces {
    /// Mean static wheel load, N, and the length of its arrow, m.
    mean_load: f64,
    length: f64,
    radius: f64,
    /// Of the robot, relative to that of robot A.
    size: f64,
    /// Index and name of the estimator that is drawn.
    estimator: Option<(usize, String)>,
    /// Not logged yet: N and T.
    truth: [Arrows; 2],
    estimated: [Arrows; 2],
    bars: [Strips; 2],
}

/// Names of N and T in entities.
const NAMES: [&str; 2] = ["normal", "traction"];

impl Forces {
    /// The arrows of a robot. `estimator` is the index and the name of the estimator that is drawn.
    pub(crate) fn new(robot: &Robot, estimator: Option<(usize, String)>) -> Self {
        Self {
            mean_load: robot.mean_wheel_load(),
            length: mean_load_length(robot),
            size: robot.geometry.size(),
            radius: robot.geometry.wheel_radius,
            estimator,
            ..Self::default()
        }
    }

    /// Logs the style of the arrows, and a legend whose upper left corner is a point of the frame
    /// that moves with the body (m, y down).
    pub(crate) fn declare(&self, out: &mut Writer, corner: [f64; 2]) -> Result {
        let load = format!("{:.0} N, {} m", self.mean_load, self.length);
        let mut rows = vec![("true", format!("true, {load}"), NEUTRAL, 2.5)];
        if let Some((index, name)) = &self.estimator {
            let (label, colour) = (format!("estimated by {name}, {load}"), by_index(*index));
            rows.push(("estimated", label, colour, 1.25));
            for force in NAMES {
                let entity = format!("world/forces/estimated/{force}/two_sigma");
                out.constant(entity, &lines(colour, 1.0))?;
            }
        }
        let [x, mut y] = corner;
        for (source, label, colour, width) in rows {
            let style = Arrows2D::update_fields().with_radii([Radius::new_ui_points(width)]);
            for force in NAMES {
                out.constant(format!("world/forces/{source}/{force}"), &style)?;
            }
            let sample = style
                .with_colors([colour])
                .with_origins([[narrow(x), narrow(y)]])
                .with_vectors([[narrow(self.length), 0.0]])
                .with_labels([label])
                .with_show_labels(true);
            out.constant(format!("world/follow/legend/{source}"), &sample)?;
            y += ROW * self.size;
        }
        Ok(())
    }

    /// Adds the arrows of a frame: true forces; and those of an estimate, along the contact angles
    /// that it has, with bars of two standard deviations.
    pub(crate) fn push(&mut self, frame: &Frame<'_>, truth: &Truth) {
        // Negative for a negative force.
        let length = |force: f64| force * self.length / self.mean_load;
        let (beside, end) = (BESIDE * self.size, BAR_END * self.size);
        let [mut true_n, mut true_t, mut estimated_n, mut estimated_t] = [const { Vec::new() }; 4];
        let (mut bars_n, mut bars_t) = (Vec::new(), Vec::new());
        let estimator = self.estimator.as_ref();
        let estimate = estimator.and_then(|(k, _)| Some((frame.estimate(*k)?, *k)));
        for (i, wheel) in truth.wheels.iter().enumerate() {
            for contact in wheel.contact_list.iter() {
                let (point, n) = (contact.point, contact.normal);
                let (normal, t) = (n * length(contact.normal_force), Vec2::new(n.y, -n.x));
                // The arrow of N ends at the contact: it lies below the ground, where nothing else
                // is drawn.
                true_n.push((WHEELS[i], point - normal, normal));
                true_t.push((WHEELS[i], point, t * length(contact.traction)));
            }
            let Some((estimate, k)) = estimate else {
                continue;
            };
            let colour = by_index(k);
            let point = contact_point(wheel, self.radius);
            let (t, n) = tangent_and_normal(estimate.contact_angle[i]);
            let normal = n * length(estimate.normal_force[i]);
            let traction = t * length(estimate.traction[i]);
            let (head, foot) = (point - t * beside, point - n * beside);
            estimated_n.push((colour, head - normal, normal));
            estimated_t.push((colour, foot, traction));
            let sigma = estimate.sigma_normal(i);
            bars_n.extend(sigma.map(|sigma| bar(head - normal, n, length(2.0 * sigma), end)));
            let sigma = estimate.sigma_traction(i);
            bars_t.extend(sigma.map(|sigma| bar(foot + traction, t, length(2.0 * sigma), end)));
        }
        self.truth[0].push(true_n);
        self.truth[1].push(true_t);
        self.estimated[0].push(estimated_n);
        self.estimated[1].push(estimated_t);
        self.bars[0].push(truth.time, bars_n);
        self.bars[1].push(truth.time, bars_t);
    }

    /// Logs what was added since the last call, at its times (s).
    pub(crate) fn flush(&mut self, out: &mut Writer, times: &[f64]) -> Result {
        for (k, force) in NAMES.into_iter().enumerate() {
            let arrows = std::mem::take(&mut self.truth[k]);
            arrows.log(out, &format!("world/forces/true/{force}"), times)?;
            let entity = format!("world/forces/estimated/{force}");
            let arrows = std::mem::take(&mut self.estimated[k]);
            let bars = std::mem::take(&mut self.bars[k]);
            if self.estimator.is_some() {
                arrows.log(out, &entity, times)?;
            }
            // An estimator without covariance has none.
            if !bars.strips.is_empty() {
                bars.log(out, &format!("{entity}/two_sigma"))?;
            }
        }
        Ok(())
    }
}

/// A bar around a centre (m), along a unit vector, with half its length and half that of the lines
/// across its ends (m).
fn bar(centre: Vec2, along: Vec2, half: f64, end: f64) -> [Vec2; 6] {
    let across = perp(along) * end;
    let (near, far) = (centre - along * half, centre + along * half);
    [
        near - across,
        near + across,
        near,
        far,
        far - across,
        far + across,
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Closed form: the arrow of the mean load is 0.15 m long.
    #[test]
    fn the_mean_load_is_fifteen_centimetres_long() {
        let robot = Robot::default_a();
        let load = robot.mean_wheel_load();
        assert!((load / newtons_per_metre(&robot) - 0.15).abs() < 1e-12);
    }

    /// Closed form: a robot that is four times as large has arrows of four times the length.
    #[test]
    fn arrows_are_in_proportion_to_the_robot() {
        let mut robot = Robot::default_a();
        for axle in &mut robot.geometry.axles {
            *axle *= 4.0;
        }
        let load = robot.mean_wheel_load();
        assert!((load / newtons_per_metre(&robot) - 0.6).abs() < 1e-12);
    }

    /// Closed form: the ends of a bar are two standard deviations from its centre, along the force.
    #[test]
    fn a_bar_spans_two_sigma_to_both_sides() {
        let [_, _, near, far, _, _] = bar(Vec2::new(1.0, 0.0), Vec2::new(0.0, 1.0), 0.25, 0.01);
        assert_eq!((near, far), (Vec2::new(1.0, -0.25), Vec2::new(1.0, 0.25)));
    }
}
