//! How fast a log drives, and how often its pin is read: what the error of the pin's rate depends
//! on.

use crate::check::median;
use crate::plan::Plan;
use crate::survey::Survey;
use robhaz_estimator::DRIVING_SPEED;
use robhaz_model::{Robot, Units};

/// Time over which a speed is measured, s: counts of an encoder may be coarse.
const STEP: f64 = 0.1;

/// Median speed of a wheel while it drives (m/s), of the first one that the log has, and the period
/// of the pin's angle, s; 0 where the log has none.
pub fn pace(plan: &Plan, survey: &Survey, robot: &Robot) -> (f64, f64) {
    let radius = robot.geometry.wheel_radius;
    let least = DRIVING_SPEED * Units::of(robot).speed();
    let find = |name: &str| {
        plan.channels.iter().enumerate().find_map(|(i, channel)| {
            let mut readings = channel.readings.iter();
            let (_, formula) = readings.find(|(r, _)| r.name() == name)?;
            Some((&survey.channels[i], channel.columns.len(), formula))
        })
    };
    let period = find("pin_angle").map_or(0.0, |(channel, ..)| channel.report.period);
    let angles = ["wheel1_angle", "wheel2_angle", "wheel3_angle"];
    let Some((channel, columns, formula)) = angles.into_iter().find_map(find) else {
        return (0.0, period);
    };
    let rows = channel.times.iter().zip(channel.cells.chunks(columns));
    let angles = rows.filter_map(|(time, cells)| Some((*time, formula.value(cells)?)));
    let angles: Vec<(f64, f64)> = angles.collect();
    // At least one row, and a whole number of them.
    let step = (STEP / channel.report.period).ceil().max(1.0) as usize;
    let pairs = angles.iter().zip(angles.iter().skip(step));
    let speeds = pairs.map(|(a, b)| radius * ((b.1 - a.1) / (b.0 - a.0)).abs());
    let speed = median(speeds.filter(|speed| speed.is_finite() && *speed > least));
    (speed.unwrap_or(0.0), period)
}
