//! The layout of one run: animation, events and flags on the left, time series on the right.

use super::{ContainerKind, Part};
use crate::estimated_terrain::{LEFT, bounds_of};
use crate::ground::Ground;
use crate::key;
use crate::scale::ROOM;
use crate::scene_view::FOLLOWED;
use crate::series::WHEEL_NAMES;
use rerun::components::Range1D;
use robhaz_run::{EstimatorDescription, RunDescription};
use robhaz_scene::Scene;

/// The layout.
pub(crate) fn layout(run: &RunDescription) -> Part {
    Part::equal(ContainerKind::Horizontal, "robhaz", [left(run), right(run)])
}

fn left(run: &RunDescription) -> Part {
    let mut rows = Vec::new();
    if let Some(world) = &run.world {
        rows.push((overview(&Ground::new(run, world)), 1.0));
        rows.push((following(), 2.5));
    }
    let lanes =
        |name, entity| Part::of_class("StateTimeline", name, entity, &format!("+ {entity}/**"));
    let mut tabs = vec![Part::text_log("Events", "/events")];
    let states = |e: &EstimatorDescription| e.settings.states_covariance();
    if run.world.is_some() || run.estimators.iter().any(states) {
        tabs.push(lanes("Wheels", "/wheels"));
    }
    tabs.push(Part::of_class(
        "TextDocument",
        "About",
        "/about",
        "+ /about",
    ));
    let tabs = Part::tabs("Events, wheels, about", tabs);
    let trust = lanes("Flags of the estimators", "/trust");
    let below = vec![(tabs, 1.4), (trust, 1.0)];
    let name = "What happens".to_owned();
    rows.push((Part::Container(ContainerKind::Horizontal, name, below), 1.0));
    Part::column("Scene", rows)
}

/// The whole ground of a simulation, with the robot and the paths of its pins.
fn overview(ground: &Ground) -> Part {
    let [from, to, low, high] = ground.box_of();
    let contents = [
        "+ /world/**",
        "- /world/follow/**",
        // The robot is too small here for labels, end stops and a second set of arrows.
        "- /world/robot/pins",
        "- /world/robot/link2/stops",
        "- /world/forces/estimated/**",
    ];
    // The view has y down. The robot is above the ground; the arrows of N and the axis are below
    // it.
    let bounds = [[from, to], [-(high + 0.45), ROOM - low]];
    Part::spatial("Whole run [m]", "/", &contents, bounds, paths())
}

/// The robot in a view that moves with its body.
fn following() -> Part {
    let [half_width, above, below] = FOLLOWED;
    // The axis of the whole ground is left out.
    let contents = ["+ /world/**", "- /world/scale/**"];
    let name = "Along with the body [m]: N and T at the contacts";
    let bounds = [[-half_width, half_width], [-above, below]];
    Part::spatial(name, "/world/follow", &contents, bounds, paths())
}

/// The paths of the pins and the ground that was found, shown up to the cursor.
fn paths() -> Vec<String> {
    let entities = ["world/trails".to_owned(), LEFT.to_owned(), bounds_of(LEFT)];
    entities.map(|entity| format!("/{entity}")).into()
}

fn right(run: &RunDescription) -> Part {
    let bounds = [[0.0, key::width(run)], [0.0, key::HEIGHT]];
    let key = Part::spatial("Lines", "/key", &["+ /key/**"], bounds, Vec::new());
    let rows = vec![(key, 0.4), (forces(run), 3.2), (others(run), 1.1)];
    Part::column("Time series", rows)
}

/// N, its error and T of each wheel.
fn forces(run: &RunDescription) -> Part {
    let per_wheel = |title: &str, quantity: &str, range| {
        let plots = WHEEL_NAMES.iter().enumerate().map(|(i, wheel)| {
            let title = format!("{title}, {wheel} wheel [N]");
            Part::plot(&title, &format!("/series/{quantity}/wheel{}", i + 1), range)
        });
        Part::equal(ContainerKind::Vertical, title, plots)
    };
    let range = range_of_loads(run, -0.5, 3.0).unwrap_or_else(|| {
        let load = run.robot.robot.mean_wheel_load();
        Range1D::new(-0.1 * load, 3.0 * load)
    });
    let mut tabs = vec![per_wheel("Normal force N", "normal_force", Some(range))];
    if run.has_truth {
        let range = range_of_loads(run, -1.0, 1.0);
        tabs.push(per_wheel("Error of N", "error_of_normal_force", range));
    }
    let range = range_of_loads(run, -2.0, 2.0);
    tabs.push(per_wheel("Traction T", "traction", range));
    Part::tabs("Forces", tabs)
}

/// The range of an axis on ground with corners, from two multiples of the mean static wheel load,
/// N. Peaks at corners are shorter than a millisecond and would compress all other values. `None`
/// on other ground: the range of the data.
fn range_of_loads(run: &RunDescription, from: f64, to: f64) -> Option<Range1D> {
    let load = run.robot.robot.mean_wheel_load();
    let world = run.world.as_ref()?;
    Ground::new(run, world)
        .has_corners()
        .then(|| Range1D::new(from * load, to * load))
}

/// What follows from the forces, and residuals.
fn others(run: &RunDescription) -> Part {
    let most = run.world.as_ref().map(|w| 1.25 * largest_friction(w));
    let mut tabs = Vec::new();
    let mut plot = |title: &str, quantity: &str, range: Option<Range1D>| {
        tabs.push(Part::plot(title, &format!("/series/{quantity}"), range));
    };
    if run.has_truth {
        let range = range_of_loads(run, 0.0, 1.0);
        plot(
            "Error of N, RMS of the wheels [N]",
            "error_of_normal_force/rms",
            range,
        );
    }
    plot("Contact angle [deg]", "contact_angle", None);
    let needed = most.map(|most| Range1D::new(-most, most));
    plot("Needed friction T/N [-]", "friction", needed);
    if let Some(most) = most {
        let left_over = Range1D::new(-0.25 * most, most);
        plot("Slip margin [-]", "slip_margin", Some(left_over));
    }
    if run.takes_commands() {
        plot("Commanded torque [N m]", "commanded_torque", None);
    }
    plot("Residual [N]", "residual/force", None);
    plot("Residual [N m]", "residual/moment", None);
    plot("Parity [N]", "parity", None);
    Part::tabs("Derived", tabs)
}

/// The largest static coefficient of the ground, -.
fn largest_friction(world: &Scene) -> f64 {
    let stretches = world.terrain.stretches.iter().map(|s| s.mu_s);
    stretches.fold(world.friction.mu_s, f64::max)
}
