//! The layout of one run: the scene on the left; on the right forces, errors, and who is to be trusted.

use super::{ContainerKind, Layout, Part, Playing, parts};
use crate::ViewerError;
use crate::writer::Writer;
use rerun::components::Range1D;
use robhaz_scene::Scene;

/// Logs the layout and makes it the one to be used.
pub(crate) fn log(out: &mut Writer, scene: &Scene, playing: Playing) -> Result<(), ViewerError> {
    let mut layout = Layout::new(out);
    let left = left(&mut layout, scene)?;
    let right = right(&mut layout, scene)?;
    let root = layout.container(
        ContainerKind::Horizontal,
        "robhaz",
        &[(left, 1.0), (right, 1.0)],
    )?;
    layout.finish(root, playing)
}

fn left(layout: &mut Layout<'_>, scene: &Scene) -> Result<Part, ViewerError> {
    let overview = parts::overview(layout, "Whole run [m]", "/", scene)?;
    let name = "Along with the body [m]: N and T at the contacts";
    let following = parts::following(layout, name, "/", true)?;
    let events = layout.text_log("Events", "/events")?;
    let wheels = layout.lanes("Wheels", "/wheels")?;
    let about = layout.page("About", "/about")?;
    let words = layout.tabs("Words", &[events, wheels, about])?;
    let trust = layout.lanes("Flags of the estimators", "/trust")?;
    let below = layout.container(
        ContainerKind::Horizontal,
        "What happens",
        &[(words, 1.4), (trust, 1.0)],
    )?;
    layout.container(
        ContainerKind::Vertical,
        "Scene",
        &[(overview, 1.0), (following, 2.5), (below, 1.0)],
    )
}

fn right(layout: &mut Layout<'_>, scene: &Scene) -> Result<Part, ViewerError> {
    let key = parts::key(layout, "/key", scene.estimators.len() + 1)?;
    let normal = parts::normal_force(layout, "Normal force N", "/", scene)?;
    let error = parts::per_wheel(
        layout,
        "Error of N",
        "/",
        "error_of_normal_force",
        parts::range_of_loads(scene, -1.0, 1.0),
    )?;
    let traction = parts::per_wheel(
        layout,
        "Traction T",
        "/",
        "traction",
        parts::range_of_loads(scene, -2.0, 2.0),
    )?;
    let forces = layout.tabs("Forces", &[normal, error, traction])?;

    let most = 1.25 * largest_friction(scene);
    let mut plot = |title: &str, quantity: &str, range: Option<Range1D>| {
        parts::plot(layout, title, "/", quantity, range)
    };
    let rms = plot(
        "Error of N, RMS of the wheels [N]",
        "error_of_normal_force/rms",
        parts::range_of_loads(scene, 0.0, 1.0),
    )?;
    let angle = plot("Contact angle [deg]", "contact_angle", None)?;
    let needed = Range1D::new(-most, most);
    let friction = plot("Needed friction T/N [-]", "friction", Some(needed))?;
    let left_over = Range1D::new(-0.25 * most, most);
    let margin = plot("Slip margin [-]", "slip_margin", Some(left_over))?;
    let residual_force = plot("Residual [N]", "residual/force", None)?;
    let residual_moment = plot("Residual [N m]", "residual/moment", None)?;
    let parity = plot("Parity [N]", "parity", None)?;
    let others = layout.tabs(
        "Derived",
        &[
            rms,
            angle,
            friction,
            margin,
            residual_force,
            residual_moment,
            parity,
        ],
    )?;
    layout.container(
        ContainerKind::Vertical,
        "Time series",
        &[(key, 0.4), (forces, 3.2), (others, 1.1)],
    )
}

/// The largest static coefficient anywhere, -.
fn largest_friction(scene: &Scene) -> f64 {
    let stretches = scene.terrain.stretches.iter().map(|s| s.mu_s);
    stretches.fold(scene.friction.mu_s, f64::max)
}
