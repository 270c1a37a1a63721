//! The layout of one run: animation, events and flags on the left, time series on the right.

use super::{ContainerKind, Part, parts};
use crate::ground::Ground;
use crate::key;
use rerun::components::Range1D;
use robhaz_run::{EstimatorDescription, RunDescription, World};

/// The layout.
pub(crate) fn layout(run: &RunDescription) -> Part {
    Part::equal(ContainerKind::Horizontal, "robhaz", [left(run), right(run)])
}

fn left(run: &RunDescription) -> Part {
    let mut rows = Vec::new();
    if let Some(world) = &run.world {
        let ground = Ground::new(run, world);
        rows.push((parts::overview("Whole run [m]", "/", &ground), 1.0));
        let name = "Along with the body [m]: N and T at the contacts";
        rows.push((parts::following(name, "/", false), 2.5));
    }
    let mut tabs = vec![Part::text_log("Events", "/events")];
    let states = |e: &EstimatorDescription| e.settings.states_contacts();
    if run.world.is_some() || run.estimators.iter().any(states) {
        tabs.push(Part::lanes("Wheels", "/wheels"));
    }
    tabs.push(Part::page("About", "/about"));
    let tabs = Part::tabs("Events, wheels, about", tabs);
    let trust = Part::lanes("Flags of the estimators", "/trust");
    let below = vec![(tabs, 1.4), (trust, 1.0)];
    let name = "What happens".to_owned();
    rows.push((Part::Container(ContainerKind::Horizontal, name, below), 1.0));
    Part::column("Scene", rows)
}

fn right(run: &RunDescription) -> Part {
    let key = parts::key("/key", key::of_run(run).len());
    let rows = vec![(key, 0.4), (forces(run), 3.2), (others(run), 1.1)];
    Part::column("Time series", rows)
}

/// N, its error and T of each wheel.
fn forces(run: &RunDescription) -> Part {
    let per_wheel = |title: &str, entity: &str, range| {
        parts::per_wheel(ContainerKind::Vertical, title, entity, range)
    };
    let mut tabs = vec![parts::normal_force("Normal force N", "/", run)];
    if run.has_truth {
        let range = parts::range_of_loads(run, -1.0, 1.0);
        tabs.push(per_wheel(
            "Error of N",
            "/series/error_of_normal_force",
            range,
        ));
    }
    let range = parts::range_of_loads(run, -2.0, 2.0);
    tabs.push(per_wheel("Traction T", "/series/traction", range));
    Part::tabs("Forces", tabs)
}

/// What follows from the forces, and residuals.
fn others(run: &RunDescription) -> Part {
    let most = run.world.as_ref().map(|w| 1.25 * largest_friction(w));
    let mut tabs = Vec::new();
    let mut plot = |title: &str, quantity: &str, range: Option<Range1D>| {
        tabs.push(Part::plot(title, &format!("/series/{quantity}"), range));
    };
    if run.has_truth {
        let range = parts::range_of_loads(run, 0.0, 1.0);
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
fn largest_friction(world: &World) -> f64 {
    let stretches = world.terrain.stretches.iter().map(|s| s.mu_s);
    stretches.fold(world.friction.mu_s, f64::max)
}
