//! An axis below the whole ground: the 2-D views have none of their own. The arrows of the legend
//! are the scale beside the robot.

use crate::ViewerError;
use crate::colours::NEUTRAL;
use crate::convert::flat;
use crate::writer::Writer;
use rerun::archetypes::{LineStrips2D, Points2D};
use rerun::components::Radius;
use robhaz_model::Vec2;

/// Distance of the axis below the lowest ground, m. The arrows of N lie between them.
const BELOW: f64 = 0.30;
/// Length of a tick, m.
const TICK: f64 = 0.03;
/// Least number of ticks of an axis.
const LEAST_TICKS: f64 = 4.0;
/// Height that the axis needs below the lowest ground, m.
pub(crate) const ROOM: f64 = 0.55;

/// Logs the axis below a piece of ground (start, end, lowest point; m).
pub(crate) fn log_axis(out: &mut Writer, [from, to, low]: [f64; 3]) -> Result<(), ViewerError> {
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
    let lines = LineStrips2D::new(marks.chain([axis]))
        .with_colors([NEUTRAL])
        .with_radii([Radius::new_ui_points(0.75)]);
    out.constant("world/scale/axis", &lines)?;
    let labels = ticks.iter().map(|x| format!("{} m", rounded(*x)));
    out.constant(
        "world/scale/labels",
        &Points2D::new(ticks.iter().map(|x| flat(Vec2::new(*x, y))))
            .with_labels(labels)
            .with_show_labels(true)
            .with_colors([NEUTRAL])
            .with_radii([Radius::new_ui_points(1.0)]),
    )
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
