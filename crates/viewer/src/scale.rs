//! Scales of the 2-D views, which have no axes of their own: an axis below the whole ground, and a bar that moves with
//! the robot.

use crate::ViewerError;
use crate::colours::{Colour, NEUTRAL};
use crate::convert::{flat, narrow};
use crate::forces::ForceScale;
use crate::writer::Writer;
use rerun::archetypes::{Arrows2D, LineStrips2D, Points2D};
use rerun::components::Radius;
use robhaz_model::Vec2;

/// Distance of the axis below the lowest ground, m. The arrows of N lie between them.
const BELOW: f64 = 0.30;
/// Length of a tick, m.
const TICK: f64 = 0.03;
/// Least number of ticks of an axis.
const LEAST_TICKS: f64 = 4.0;
/// Length of the bar, m.
const BAR: f64 = 0.1;
/// Height that the axis needs below the lowest ground, m.
pub(crate) const ROOM: f64 = 0.55;

/// Logs the axis below a piece of ground (start, end, lowest, highest; m), and above it an arrow of the mean static
/// wheel load.
pub(crate) fn log_axis(
    out: &mut Writer,
    [from, to, low, high]: [f64; 4],
    forces: ForceScale,
) -> Result<(), ViewerError> {
    let y = low - BELOW;
    let ticks = ticks(from, to);
    let (Some(first), Some(last)) = (ticks.first(), ticks.last()) else {
        return Ok(());
    };
    let strip = |a: Vec2, b: Vec2| [flat(a), flat(b)];
    let axis = strip(Vec2::new(*first, y), Vec2::new(*last, y));
    let marks = ticks
        .iter()
        .map(|x| strip(Vec2::new(*x, y), Vec2::new(*x, y + TICK)));
    out.constant("world/scale/axis", &thin(marks.chain([axis])))?;
    let labels = ticks.iter().map(|x| format!("{} m", rounded(*x)));
    out.constant(
        "world/scale/labels",
        &Points2D::new(ticks.iter().map(|x| flat(Vec2::new(*x, y))))
            .with_labels(labels)
            .with_show_labels(true)
            .with_colors([NEUTRAL])
            .with_radii([Radius::new_ui_points(1.0)]),
    )?;
    let origin = flat(Vec2::new(from + 0.1, high + 0.35));
    out.constant(
        "world/scale/force",
        &Arrows2D::from_vectors([[narrow(forces.mean_load_length()), 0.0]])
            .with_origins([origin])
            .with_labels([format!("{:.0} N", forces.mean_load())])
            .with_show_labels(true)
            .with_colors([NEUTRAL])
            .with_radii([Radius::new_ui_points(2.5)]),
    )
}

/// Logs the bar in the frame that moves with the robot. Its left end is at a point of that frame (m, y down).
pub(crate) fn log_bar(out: &mut Writer, [x, y]: [f64; 2]) -> Result<(), ViewerError> {
    let point = |x: f64, y: f64| [narrow(x), narrow(y)];
    let end = x + BAR;
    let bar = [
        point(x, y - 0.5 * TICK),
        point(x, y),
        point(end, y),
        point(end, y - 0.5 * TICK),
    ];
    out.constant(
        "world/follow/scale",
        &LineStrips2D::new([bar])
            .with_labels([format!("{BAR} m")])
            .with_show_labels(true)
            .with_colors([NEUTRAL])
            .with_radii([Radius::new_ui_points(1.0)]),
    )
}

/// Thin lines of the axis.
fn thin(strips: impl Iterator<Item = [[f32; 2]; 2]>) -> LineStrips2D {
    let colour: Colour = NEUTRAL;
    LineStrips2D::new(strips)
        .with_colors([colour])
        .with_radii([Radius::new_ui_points(0.75)])
}

/// Ticks from one place to another, m: multiples of 1, 2 or 5 times a power of ten.
fn ticks(from: f64, to: f64) -> Vec<f64> {
    let most = (to - from) / LEAST_TICKS;
    let decade = 10f64.powf(most.log10().floor());
    let step = [5.0, 2.0, 1.0]
        .map(|m| m * decade)
        .into_iter()
        .find(|step| *step <= most)
        .unwrap_or(decade);
    let mut ticks = Vec::new();
    let mut k = (from / step).ceil();
    while k * step <= to {
        ticks.push(k * step);
        k += 1.0;
    }
    ticks
}

/// Rounds to 1 um, against digits of binary fractions. Adding 0 turns -0 into 0.
fn rounded(x: f64) -> f64 {
    (x * 1e6).round() / 1e6 + 0.0
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Closed form: 5 m are divided by ticks every metre, 1.2 m by ticks every 0.2 m.
    #[test]
    fn ticks_are_round_numbers() {
        assert_eq!(ticks(-0.7, 4.3).len(), 5);
        let fine: Vec<f64> = ticks(-0.1, 1.1).into_iter().map(rounded).collect();
        assert_eq!(fine, [0.0, 0.2, 0.4, 0.6, 0.8, 1.0]);
    }
}
