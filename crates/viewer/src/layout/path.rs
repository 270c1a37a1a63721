//! The layout of a judged path: the wheels on the ground, and below them friction and margin over the distance.

use super::{ContainerKind, Layout, Playing};
use crate::ViewerError;
use crate::writer::Writer;
use robhaz_model::Vec2;

/// Visible height above and below the ground, m.
const ROOM: [f64; 2] = [0.45, 0.15];

/// Logs the layout and makes it the active one. `ground` are the points of the ground that is drawn, m.
pub(crate) fn log(out: &mut Writer, ground: &[Vec2]) -> Result<(), ViewerError> {
    let mut layout = Layout::new(out);
    let [above, below] = ROOM;
    let from = ground.first().map_or(0.0, |p| p.x);
    let to = ground.last().map_or(1.0, |p| p.x);
    let (low, high) = ground.iter().fold((0.0_f64, 0.0_f64), |(low, high), p| {
        (low.min(p.y), high.max(p.y))
    });
    let bounds = [[from, to], [-(high + above), below - low]];
    let view = layout.spatial("Path [m]", "/", &["+ world/**".to_owned()], bounds)?;
    let plot = |layout: &mut Layout<'_>, title: &str, quantity: &str| {
        let contents = [format!("+ series/path/{quantity}")];
        let title = format!("{title}; 1 s of the axis is 1 m of the path");
        layout.plot(&title, &contents, None)
    };
    let title = "Needed mu_n (narrow) and available mu [-]";
    let friction = plot(&mut layout, title, "friction")?;
    let margin = plot(&mut layout, "Margin [-]", "margin")?;
    let page = layout.page("About", "/about")?;
    let root = layout.container(
        ContainerKind::Vertical,
        "Path",
        &[(view, 1.2), (friction, 1.0), (margin, 0.8), (page, 1.2)],
    )?;
    layout.finish(root, Playing::FromStart)
}
