//! The layout of one run: animation, events and flags on the left, time series on the right.

use super::{ContainerKind, Layout, Part, Playing, parts};
use crate::ViewerError;
use crate::ground::Ground;
use crate::key;
use crate::writer::Writer;
use rerun::components::Range1D;
use robhaz_run::{EstimatorDescription, RunDescription, World};

/// Logs the layout and makes it the active one.
pub(crate) fn log(
    out: &mut Writer,
    run: &RunDescription,
    playing: Playing,
) -> Result<(), ViewerError> {
    let mut layout = Layout::new(out);
    let left = left(&mut layout, run)?;
    let right = right(&mut layout, run)?;
    let root = layout.container(
        ContainerKind::Horizontal,
        "robhaz",
        &[(left, 1.0), (right, 1.0)],
    )?;
    layout.finish(root, playing)
}

fn left(layout: &mut Layout<'_>, run: &RunDescription) -> Result<Part, ViewerError> {
    let mut rows = Vec::new();
    if let Some(world) = &run.world {
        let ground = Ground::new(run, world);
        rows.push((parts::overview(layout, "Whole run [m]", "/", &ground)?, 1.0));
        let name = "Along with the body [m]: N and T at the contacts";
        rows.push((parts::following(layout, name, "/", false)?, 2.5));
    }
    let mut tabs = vec![layout.text_log("Events", "/events")?];
    let states = |e: &EstimatorDescription| e.settings.states_contacts();
    if run.world.is_some() || run.estimators.iter().any(states) {
        tabs.push(layout.lanes("Wheels", "/wheels")?);
    }
    tabs.push(layout.page("About", "/about")?);
    let tabs = layout.tabs("Events, wheels, about", &tabs)?;
    let trust = layout.lanes("Flags of the estimators", "/trust")?;
    let below = layout.container(
        ContainerKind::Horizontal,
        "What happens",
        &[(tabs, 1.4), (trust, 1.0)],
    )?;
    rows.push((below, 1.0));
    layout.container(ContainerKind::Vertical, "Scene", &rows)
}

fn right(layout: &mut Layout<'_>, run: &RunDescription) -> Result<Part, ViewerError> {
    let key = parts::key(layout, "/key", key::of_run(run).len())?;
    let forces = forces(layout, run)?;
    let others = others(layout, run)?;
    layout.container(
        ContainerKind::Vertical,
        "Time series",
        &[(key, 0.4), (forces, 3.2), (others, 1.1)],
    )
}

/// N, its error and T of each wheel.
fn forces(layout: &mut Layout<'_>, run: &RunDescription) -> Result<Part, ViewerError> {
    let mut tabs = vec![parts::normal_force(layout, "Normal force N", "/", run)?];
    if run.has_truth {
        let range = parts::range_of_loads(run, -1.0, 1.0);
        tabs.push(parts::per_wheel(
            layout,
            "Error of N",
            "/",
            "error_of_normal_force",
            range,
        )?);
    }
    let range = parts::range_of_loads(run, -2.0, 2.0);
    tabs.push(parts::per_wheel(
        layout,
        "Traction T",
        "/",
        "traction",
        range,
    )?);
    layout.tabs("Forces", &tabs)
}

/// What follows from the forces, and residuals.
fn others(layout: &mut Layout<'_>, run: &RunDescription) -> Result<Part, ViewerError> {
    let most = run.world.as_ref().map(|w| 1.25 * largest_friction(w));
    let mut tabs = Vec::new();
    let mut plot = |title: &str, quantity: &str, range: Option<Range1D>| {
        tabs.push(parts::plot(layout, title, "/", quantity, range)?);
        Ok::<(), ViewerError>(())
    };
    if run.has_truth {
        let range = parts::range_of_loads(run, 0.0, 1.0);
        let quantity = "error_of_normal_force/rms";
        plot("Error of N, RMS of the wheels [N]", quantity, range)?;
    }
    plot("Contact angle [deg]", "contact_angle", None)?;
    let needed = most.map(|most| Range1D::new(-most, most));
    plot("Needed friction T/N [-]", "friction", needed)?;
    if let Some(most) = most {
        let left_over = Range1D::new(-0.25 * most, most);
        plot("Slip margin [-]", "slip_margin", Some(left_over))?;
    }
    if run.takes_commands() {
        plot("Commanded torque [N m]", "commanded_torque", None)?;
    }
    plot("Residual [N]", "residual/force", None)?;
    plot("Residual [N m]", "residual/moment", None)?;
    plot("Parity [N]", "parity", None)?;
    layout.tabs("Derived", &tabs)
}

/// The largest static coefficient of the ground, -.
fn largest_friction(world: &World) -> f64 {
    let stretches = world.terrain.stretches.iter().map(|s| s.mu_s);
    stretches.fold(world.friction.mu_s, f64::max)
}
