//! What does not move in the recording of a rover with both sides.

use super::{HALF_WIDTH, mean_load_length, quaternion, sign, wheel_entity};
use crate::colours::{self, WHEELS, dark, light};
use crate::draw::{narrow, solid};
use crate::error::Result;
use crate::writer::Writer;
use nalgebra::UnitQuaternion;
use re_sdk_types::archetypes::{Arrows3D, Boxes3D, Cylinders3D, LineStrips3D, ViewCoordinates};
use re_sdk_types::components::{FillMode, Radius};
use robhaz_estimator::whole::Vec3;
use robhaz_model::{Vec2, WholeRover};
use robhaz_run::RunDescription;

/// Spokes of a wheel: its turning is visible.
const SPOKES: usize = 5;

/// Logs everything that does not move.
pub(super) fn declare(out: &mut Writer, rover: &WholeRover, has_truth: bool) -> Result {
    let thin = |points| [Radius::new_ui_points(points)];
    out.constant("world", &ViewCoordinates::RIGHT_HAND_Z_UP())?;
    let outline = &rover.side.geometry.outline;
    let half = (outline.body_upper - outline.body_lower) * 0.5;
    let centre: Vec2 = outline.body_lower + half - rover.pivot;
    let narrowest = rover.half_tracks.into_iter().fold(f64::INFINITY, f64::min);
    let body = Boxes3D::update_fields()
        .with_centers([solid(&Vec3::new(centre.x, 0.0, centre.y))])
        .with_half_sizes([solid(&Vec3::new(half.x, 0.7 * narrowest, half.y))])
        .with_colors([colours::BODY])
        .with_fill_mode(FillMode::Solid);
    out.constant("world/rover/body", &body)?;
    let [rocker, bogie, _] = colours::LINKS;
    let links = LineStrips3D::update_fields()
        .with_colors([rocker, bogie, rocker, bogie])
        .with_radii([Radius::new_scene_units(narrow(outline.half_width))]);
    out.constant("world/rover/links", &links)?;
    let radius = rover.side.geometry.wheel_radius;
    let half_width = HALF_WIDTH * radius;
    for i in 0..6 {
        let (entity, colour) = (wheel_entity(i), WHEELS[i % 3]);
        // The viewer's cylinder has its axis along z.
        let along_y = UnitQuaternion::from_axis_angle(&Vec3::x_axis(), std::f64::consts::FRAC_PI_2);
        let tyre = Cylinders3D::update_fields()
            .with_lengths([narrow(2.0 * half_width)])
            .with_radii([narrow(radius)])
            .with_quaternions([quaternion(&along_y.to_rotation_matrix().into_inner())])
            .with_colors([dark(colour)])
            .with_fill_mode(FillMode::Solid);
        out.constant(format!("{entity}/tyre"), &tyre)?;
        let spokes = (0..SPOKES).map(|k| {
            let angle = std::f64::consts::TAU * k as f64 / SPOKES as f64;
            let y = sign(i) * 1.05 * half_width;
            let end = Vec3::new(radius * angle.cos(), y, radius * angle.sin());
            [solid(&Vec3::new(0.0, y, 0.0)), solid(&end)]
        });
        let spokes = LineStrips3D::update_fields()
            .with_strips(spokes)
            .with_colors([colour])
            .with_radii(thin(1.0));
        out.constant(format!("{entity}/spokes"), &spokes)?;
    }
    let colours = || WHEELS.into_iter().chain(WHEELS);
    let arrows = Arrows3D::update_fields().with_radii(thin(2.5));
    let found = arrows.clone().with_colors(colours().map(light));
    out.constant("world/rover/forces", &found)?;
    if has_truth {
        out.constant("world/rover/true_forces", &arrows.with_colors(colours()))?;
    }
    // The scale of the arrows, above the body.
    let scale = Arrows3D::from_vectors([[0.0, 0.0, narrow(mean_load_length(rover))]])
        .with_origins([solid(&Vec3::new(centre.x, 0.0, centre.y + 1.5 * half.y))])
        .with_colors([colours::PIN])
        .with_radii(thin(2.5))
        .with_labels([format!("{:.0} N", rover.mean_wheel_load())])
        .with_show_labels(true);
    out.constant("world/follow/scale", &scale)?;
    let bars = LineStrips3D::update_fields()
        .with_colors(colours().map(light))
        .with_radii(thin(1.0));
    out.constant("world/rover/forces/two_sigma", &bars)?;
    let tracks = LineStrips3D::update_fields()
        .with_colors(colours())
        .with_radii(thin(1.5));
    out.constant("world/tracks", &tracks)
}

/// How to read the recording, as Markdown.
pub(super) fn page(rover: &WholeRover, run: &RunDescription) -> String {
    let truth = match run.has_truth {
        true => {
            "- True forces have the full colours: thick lines, and the outer arrows, which stand on the \
             contacts found.\n"
        }
        false => "",
    };
    // What is known before any estimate; the command prints what the estimates add.
    let contradiction = run.both.as_ref().and_then(|b| b.contradiction.as_ref());
    let contradiction = contradiction.map_or(String::new(), |why| {
        format!("**Readings contradict each other**: {why}\n\n")
    });
    format!(
        include_str!("about.md"),
        name = run.name,
        contradiction = contradiction,
        newtons = rover.mean_wheel_load() / mean_load_length(rover),
        truth = truth,
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use robhaz_run::BothDescription;
    use robhaz_scene::{LogChoice, RecordChoice, RobotChoice};
    use std::path::Path;

    /// Readings that contradict each other are the first that the page says.
    #[test]
    fn the_page_says_that_readings_contradict_each_other() {
        let robots = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../robots");
        let robot = RobotChoice::load(&robots.join("open-source-rover.toml"));
        let choice = LogChoice {
            robot: robot.unwrap_or_else(|e| panic!("{e}")),
            ..LogChoice::default()
        };
        let rover = choice
            .robot
            .whole_rover()
            .unwrap_or_else(|| panic!("a rover"));
        let mut run = RunDescription::of_log("both", 1, RecordChoice::default(), &choice);
        let mut said = |contradiction: Option<String>| {
            run.both = Some(BothDescription {
                label: "kalman".to_owned(),
                coupling: rover.coupling,
                contradiction,
                unconfirmed: Vec::new(),
            });
            page(&rover, &run)
        };
        assert!(!said(None).contains("contradict"));
        let page = said(Some("signs of the torques".to_owned()));
        let start =
            "# both\n\n**Readings contradict each other**: signs of the torques\n\nSix wheels";
        assert!(page.starts_with(start), "{page}");
    }
}
