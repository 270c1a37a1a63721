//! Views of one run, for the layouts of a run and of a comparison. `root` is the entity above those of the run, such as
//! `/` or `/run1/`.

use super::{ContainerKind, Layout, Part};
use crate::ViewerError;
use crate::felt::{LEFT, bounds_of};
use crate::ground::Ground;
use crate::key::PLACE;
use crate::scale::ROOM;
use crate::scene_view::FOLLOWED;
use crate::series::WHEEL_NAMES;
use rerun::components::Range1D;
use robhaz_run::RunDescription;

/// The whole ground of a simulation, with the robot and the paths of its pins.
pub(crate) fn overview(
    layout: &mut Layout<'_>,
    name: &str,
    root: &str,
    ground: &Ground,
) -> Result<Part, ViewerError> {
    let [from, to, low, high] = ground.box_of();
    let contents = [
        format!("+ {root}world/**"),
        format!("- {root}world/follow/**"),
        // The robot is too small here for labels, end stops and a second set of arrows.
        format!("- {root}world/robot/pins"),
        format!("- {root}world/robot/link2/stops"),
        format!("- {root}world/forces/estimated/**"),
    ];
    // The view has y down. The robot is above the ground; the arrows of N and the axis are below it.
    let bounds = [[from, to], [-(high + 0.45), ROOM - low]];
    let view = layout.spatial(name, root, &contents, bounds)?;
    show_paths(layout, view, root)?;
    Ok(view)
}

/// Makes a view show the paths of the pins and the ground that was found, up to the cursor.
fn show_paths(layout: &mut Layout<'_>, view: Part, root: &str) -> Result<(), ViewerError> {
    layout.show_past(view, &format!("{root}world/trails"))?;
    layout.show_past(view, &format!("{root}{LEFT}"))?;
    layout.show_past(view, &format!("{root}{}", bounds_of(LEFT)))
}

/// The robot in a view that moves with its body. A small view has no legend of the estimated arrows.
pub(crate) fn following(
    layout: &mut Layout<'_>,
    name: &str,
    root: &str,
    is_small: bool,
) -> Result<Part, ViewerError> {
    let [half_width, above, below] = FOLLOWED;
    // The axis of the whole ground is left out.
    let mut contents = vec![
        format!("+ {root}world/**"),
        format!("- {root}world/scale/**"),
    ];
    if is_small {
        contents.push(format!("- {root}world/follow/legend/estimated"));
    }
    let view = layout.spatial(
        name,
        &format!("{root}world/follow"),
        &contents,
        [[-half_width, half_width], [-above, below]],
    )?;
    show_paths(layout, view, root)?;
    Ok(view)
}

/// The key to the plots, with a number of entries, from an entity.
pub(crate) fn key(
    layout: &mut Layout<'_>,
    entity: &str,
    entries: usize,
) -> Result<Part, ViewerError> {
    #[expect(clippy::cast_precision_loss, reason = "a few entries")]
    let width = PLACE[0] * entries as f64;
    let bounds = [[0.0, width], [0.0, PLACE[1]]];
    layout.spatial("Lines", entity, &[format!("+ {entity}/**")], bounds)
}

/// A plot for each wheel, one below the other. `range` is that of the vertical axis, N.
pub(crate) fn per_wheel(
    layout: &mut Layout<'_>,
    title: &str,
    root: &str,
    quantity: &str,
    range: Option<Range1D>,
) -> Result<Part, ViewerError> {
    let mut views = Vec::new();
    for (i, wheel) in WHEEL_NAMES.iter().enumerate() {
        let entity = format!("+ {root}series/{quantity}/wheel{}/**", i + 1);
        let view = layout.plot(&format!("{title}, {wheel} wheel [N]"), &[entity], range)?;
        views.push((view, 1.0));
    }
    layout.container(ContainerKind::Vertical, title, &views)
}

/// True and estimated N of each wheel.
pub(crate) fn normal_force(
    layout: &mut Layout<'_>,
    title: &str,
    root: &str,
    run: &RunDescription,
) -> Result<Part, ViewerError> {
    let range = range_of_loads(run, -0.5, 3.0).unwrap_or_else(|| {
        let load = run.robot.robot.mean_wheel_load();
        Range1D::new(-0.1 * load, 3.0 * load)
    });
    per_wheel(layout, title, root, "normal_force", Some(range))
}

/// The range of an axis on ground with corners, from two multiples of the mean static wheel load, N. Peaks at corners
/// are shorter than a millisecond and would compress all other values. `None` on other ground: the range of the data.
pub(crate) fn range_of_loads(run: &RunDescription, from: f64, to: f64) -> Option<Range1D> {
    let load = run.robot.robot.mean_wheel_load();
    let world = run.world.as_ref()?;
    Ground::new(run, world)
        .has_corners()
        .then(|| Range1D::new(from * load, to * load))
}

/// A plot of one quantity. `range` is that of the vertical axis; `None`: the range of the data.
pub(crate) fn plot(
    layout: &mut Layout<'_>,
    title: &str,
    root: &str,
    quantity: &str,
    range: Option<Range1D>,
) -> Result<Part, ViewerError> {
    layout.plot(title, &[format!("+ {root}series/{quantity}/**")], range)
}
