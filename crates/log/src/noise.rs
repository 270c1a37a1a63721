//! White noise of torques and pins, as a log shows it. What `kalman` estimates depends on these two: a
//! torque that counts three times as noisy as it is, or a pin half as noisy, makes N two to three times
//! as wrong.

use crate::plan::Plan;
use crate::survey::Survey;
use robhaz_score::signals::white_noise;

/// Least share of the usual noise of torques: a filter in the drive may hide errors that last longer.
const LEAST: f64 = 1.0 / 3.0;
/// The same for a check, which takes torques that are much quieter for those of the motor's side.
const LEAST_OF_CHECK: f64 = 1.0;
/// Most of it: more is a torque in another unit, which is to be found and not to be believed.
const MOST: f64 = 10.0;
/// Measured noise over the stated one from which on it counts: chance is up to 1.1 of 500 readings.
const EXCEEDS: f64 = 1.25;

/// White noise of the torques, N m a sample, of a log whose description states none, for an estimate or
/// a check; `usual` is that of typical sensors, which counts where the log shows none.
pub fn of_torques(plan: &Plan, survey: &Survey, usual: f64, of_check: bool) -> f64 {
    let found = measured(plan, survey, "_motor_torque");
    let least = if of_check { LEAST_OF_CHECK } else { LEAST };
    found.map_or(usual, |noise| noise.clamp(least * usual, MOST * usual))
}

/// Takes the measured white noise of the pins' angles (rad) for the stated one where it is greater, and
/// says so.
pub fn take_pins(plan: &Plan, survey: &Survey, stated: &mut f64) -> Option<String> {
    let found = measured(plan, survey, "pin_angle").filter(|noise| *noise > EXCEEDS * *stated)?;
    let [shown, was] = [found, *stated].map(f64::to_degrees);
    *stated = found;
    Some(format!(
        "the noise of the pins' angles is {shown:.2} deg, measured; budget.pin_noise is {was:.2} deg: the measured one counts"
    ))
}

/// White noise of the readings whose name ends so: the root of the mean square of theirs.
fn measured(plan: &Plan, survey: &Survey, name: &str) -> Option<f64> {
    let mut squares = Vec::new();
    for (channel, found) in plan.channels.iter().zip(&survey.channels) {
        let columns = channel.columns.len().max(1);
        for (_, formula) in channel
            .readings
            .iter()
            .filter(|(r, _)| r.name().ends_with(name))
        {
            let rows = found.cells.chunks(columns);
            let values: Vec<f64> = rows.filter_map(|row| formula.value(row)).collect();
            // Coarse counts, and readings that are written again and again, hide it.
            let noise = white_noise(&values).filter(|noise| *noise > 0.0);
            squares.extend(noise.map(|noise| noise * noise));
        }
    }
    (!squares.is_empty()).then(|| (squares.iter().sum::<f64>() / squares.len() as f64).sqrt())
}
