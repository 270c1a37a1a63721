//! Angles of wheels whose speed alone was recorded: the integral of the speed, by the trapezoidal rule.
//!
//! White noise of the speed, sigma of a sample, makes each step of the angle err by sigma times the period. The steps
//! of an encoder with counts of q rad err by q/sqrt(6), the difference of two uniform errors: the integral counts as
//! an encoder with q = sqrt(6) sigma period. The sum of these errors grows with the square root of time, as the slip of a
//! wheel does.

use crate::{Channel, Formula, Source};
use robhaz_scene::Reading;
use robhaz_score::signals::median;
use std::f64::consts::TAU;

/// Second differences of white noise over its deviation.
const OF_NOISE: f64 = 2.449_489_742_783_178;
/// Median of the magnitude of a Gaussian number over its deviation.
const OF_MEDIAN: f64 = 0.674_489_750_196_082;

/// Makes angles of the speeds of wheels. The budget then has an encoder whose steps err as much, if
/// that is coarser: its counts a turn (0: exact). Returns what the user should know.
pub fn of_speeds(channels: &mut [Channel], budget: &mut f64) -> Vec<String> {
    let mut notices = Vec::new();
    for channel in channels {
        for cell in channel.speeds.clone() {
            let of_cell = |(_, formula): &&(Reading, Formula)| formula.source == Source::Cell(cell);
            let Some((reading, formula)) = channel.readings.iter().find(of_cell).copied() else {
                continue;
            };
            let speeds = channel.rows().map(|row| row[cell] * formula.factor);
            let counts = counts(&speeds.collect::<Vec<f64>>(), channel.report.period);
            integrate(channel.column_mut(cell));
            if counts < *budget || *budget <= 0.0 && counts.is_finite() {
                *budget = counts;
            }
            notices.push(format!(
                "{} is the integral of {}, a speed; by its noise it counts as an encoder of {budget:.0} counts a turn",
                reading.name(),
                channel.columns[cell],
            ));
        }
    }
    notices
}

/// Replaces speeds at their times (s) by their integral from the first one on. A row without a speed has no angle; the
/// next one has the turn since the last.
pub fn integrate<'a>(speeds: impl Iterator<Item = (f64, &'a mut f64)>) {
    let (mut angle, mut before) = (0.0, None::<(f64, f64)>);
    for (time, speed) in speeds {
        if let Some((then, last)) = before {
            angle += 0.5 * (last + *speed) * (time - then);
        }
        before = Some((time, std::mem::replace(speed, angle)));
    }
}

/// Counts in a turn of an encoder whose steps err as much as those of the integral of a speed (rad/s, by rows), whose
/// noise the rows show; infinite of a speed without noise.
fn counts(speeds: &[f64], period: f64) -> f64 {
    let second = speeds.windows(3).map(|w| w[0] - 2.0 * w[1] + w[2]);
    let second: Vec<f64> = second.filter(|d| d.is_finite()).collect();
    let by_median = median(second.iter().map(|d| d.abs()).collect()).unwrap_or(0.0) / OF_MEDIAN;
    let mean_square = second.iter().map(|d| d * d).sum::<f64>() / second.len().max(1) as f64;
    // Coarse speeds repeat themselves most of the time.
    let is_coarse = by_median <= 0.0;
    let difference = if is_coarse {
        mean_square.sqrt()
    } else {
        by_median
    };
    let count = 6.0_f64.sqrt() * difference / OF_NOISE * period;
    TAU / count
}

#[cfg(test)]
mod tests {
    use super::*;
    use robhaz_sim::random::Stream;

    /// Closed form: a speed that grows evenly, with a lost row.
    #[test]
    fn a_speed_is_integrated() {
        let times: Vec<f64> = (0..11).map(|k| 0.1 * f64::from(k)).collect();
        let mut cells: Vec<f64> = times.iter().map(|t| 2.0 * t).collect();
        let rows = times.iter().copied().zip(&mut cells);
        integrate(
            rows.enumerate()
                .filter(|(k, _)| *k != 4)
                .map(|(_, row)| row),
        );
        for (k, (time, angle)) in times
            .iter()
            .zip(&cells)
            .enumerate()
            .filter(|(k, _)| *k != 4)
        {
            assert!((angle - time * time).abs() < 1e-12, "{k}");
        }
    }

    /// Closed form: white noise of 0.02 rad/s RMS at 100 Hz; the count of an encoder with as much.
    #[test]
    fn noise_counts_as_an_encoder() {
        let mut random = Stream::new(1, "noise");
        let speeds = (0..20_000).map(|_| 2.0 + 0.02 * random.normal());
        let speeds: Vec<f64> = speeds.collect();
        let expected = TAU / (6_f64.sqrt() * 0.02 * 0.01);
        let found = counts(&speeds, 0.01);
        assert!((found / expected - 1.0).abs() < 0.1, "{found} {expected}");
        assert!(counts(&[1.0; 9], 0.01).is_infinite());
    }
}
