//! Views of one run, for the layouts of a run and of a comparison. `root` is the entity above those of the run, such as
//! `/` or `/run1/`.

use super::{ContainerKind, Part};
use crate::estimated_terrain::{LEFT, bounds_of};
use crate::ground::Ground;
use crate::key::PLACE;
use crate::scale::ROOM;
use crate::scene_view::FOLLOWED;
use crate::series::WHEEL_NAMES;
use rerun::components::Range1D;
use robhaz_run::RunDescription;

/// The whole ground of a simulation, with the robot and the paths of its pins.
pub(crate) fn overview(name: &str, root: &str, ground: &Ground) -> Part {
    let [from, to, low, high] = ground.box_of();
    let contents = vec![
        format!("+ {root}world/**"),
        format!("- {root}world/follow/**"),
        // The robot is too small here for labels, end stops and a second set of arrows.
        format!("- {root}world/robot/pins"),
        format!("- {root}world/robot/link2/stops"),
        format!("- {root}world/forces/estimated/**"),
    ];
    // The view has y down. The robot is above the ground; the arrows of N and the axis are below it.
    let bounds = [[from, to], [-(high + 0.45), ROOM - low]];
    Part::spatial(name, root, contents, bounds, paths(root))
}

/// The paths of the pins and the ground that was found, shown up to the cursor.
fn paths(root: &str) -> Vec<String> {
    let entities = ["world/trails".to_owned(), LEFT.to_owned(), bounds_of(LEFT)];
    entities.map(|entity| format!("{root}{entity}")).into()
}

/// The robot in a view that moves with its body. A small view has no legend of the estimated arrows.
pub(crate) fn following(name: &str, root: &str, is_small: bool) -> Part {
    let [half_width, above, below] = FOLLOWED;
    // The axis of the whole ground is left out.
    let mut contents = vec![
        format!("+ {root}world/**"),
        format!("- {root}world/scale/**"),
    ];
    if is_small {
        contents.push(format!("- {root}world/follow/legend/estimated"));
    }
    let bounds = [[-half_width, half_width], [-above, below]];
    let origin = format!("{root}world/follow");
    Part::spatial(name, &origin, contents, bounds, paths(root))
}

/// The key to the plots, with a number of entries, from an entity.
pub(crate) fn key(entity: &str, entries: usize) -> Part {
    #[expect(clippy::cast_precision_loss, reason = "a few entries")]
    let width = PLACE[0] * entries as f64;
    let bounds = [[0.0, width], [0.0, PLACE[1]]];
    let contents = vec![format!("+ {entity}/**")];
    Part::spatial("Lines", entity, contents, bounds, Vec::new())
}

/// A plot for each wheel of entities below `above` and the wheel's name. `range` is that of the vertical axis, N.
pub(crate) fn per_wheel(
    kind: ContainerKind,
    title: &str,
    above: &str,
    range: Option<Range1D>,
) -> Part {
    let plots = WHEEL_NAMES.iter().enumerate().map(|(i, wheel)| {
        let title = format!("{title}, {wheel} wheel [N]");
        Part::plot(&title, &format!("{above}/wheel{}", i + 1), range)
    });
    Part::equal(kind, title, plots)
}

/// True and estimated N of each wheel.
pub(crate) fn normal_force(title: &str, root: &str, run: &RunDescription) -> Part {
    let range = range_of_loads(run, -0.5, 3.0).unwrap_or_else(|| {
        let load = run.robot.robot.mean_wheel_load();
        Range1D::new(-0.1 * load, 3.0 * load)
    });
    let above = format!("{root}series/normal_force");
    per_wheel(ContainerKind::Vertical, title, &above, Some(range))
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
