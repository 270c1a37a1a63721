//! Counts of the encoders and white noise of torques and pins, as a log shows them. What `kalman`
//! estimates depends on these: counts that are far fewer than stated make N five times as wrong, pins that
//! count half as noisy as they are up to three times; torques that count three times as noisy widen what is
//! stated by a fifth.

use crate::Channel;
use robhaz_scene::Reading;
use robhaz_score::signals::{deviation, median, white_noise};

/// Least share of the usual noise of torques: a filter in the drive may hide errors that last longer.
const LEAST: f64 = 1.0 / 3.0;
/// The same for a check, which takes torques that are much quieter for those of the motor's side.
const LEAST_OF_CHECK: f64 = 1.0;
/// Most of it: more is a torque in another unit, which is to be found and not to be believed.
const MOST: f64 = 10.0;
/// Least white noise of an encoder that is one, rad: a three-hundredth of a degree.
const LEAST_NOISE: f64 = 5e-5;
/// What a change may differ by from a multiple of the step, in steps: angles written with few digits.
const OF_STEP: f64 = 0.05;
/// Fewest changes of up to five steps that show the step, and fewest of several, or gaps of each length,
/// between them.
const LEAST_STEPS: usize = 50;
const LEAST_COUNT: usize = 10;
/// Parts of a log whose steps are measured each for itself, and their fewest readings.
const PARTS: usize = 8;
const LEAST_PART: usize = 200;
/// Measured noise over the stated one from which on it counts: of 500 readings its standard error
/// is some 5 %.
const EXCEEDS: f64 = 1.25;

/// White noise of the torques, N m a sample, of a log whose description states none, for an estimate or
/// a check; `usual` is that of typical sensors, which counts where the log shows none.
pub fn noise_of_torques(channels: &[Channel], usual: f64, of_check: bool) -> f64 {
    let found = measured(channels, "_motor_torque");
    let least = if of_check { LEAST_OF_CHECK } else { LEAST };
    found.map_or(usual, |noise| noise.clamp(least * usual, MOST * usual))
}

/// Takes what a rounding of the torques leaves for their stated white noise (N m) where it is greater, and says so.
pub fn take_rounding_of_torques(channels: &[Channel], stated: &mut f64) -> Option<String> {
    let all = of_readings(channels, "_motor_torque");
    let found = all.filter_map(|(_, values)| Rounding::of(&values));
    let found = found.max_by(|a, b| a.noise.total_cmp(&b.noise))?;
    let Rounding { unit, noise } = found;
    if noise < EXCEEDS * *stated {
        return None;
    }
    let was = std::mem::replace(stated, noise);
    Some(format!(
        "the torques are whole numbers of {unit:.3} N m, which leaves errors as of {noise:.3} N m a sample; budget.torque_noise is {was:.3} N m: the measured one counts"
    ))
}

/// What a rounding to whole numbers of a unit leaves of torques.
pub struct Rounding {
    /// N m
    pub unit: f64,
    /// White noise that changes a mean over many samples as much, N m a sample: of one sample the deviation is
    /// `unit/sqrt(12)`, and the error lasts until the next step, so that the mean has the variance of as many fewer.
    pub noise: f64,
}

impl Rounding {
    /// `None` of torques that have no unit.
    pub fn of(values: &[f64]) -> Option<Self> {
        let unit = unit(values)?;
        let is_step = |i: &usize| (values[*i] - values[*i - 1]).abs() > 0.5 * unit;
        let mut steps = (1..values.len()).filter(is_step);
        let (first, last) = (steps.next()?, steps.next_back()?);
        // Counts of samples.
        let lasts = (last - first) as f64 / (steps.count() + 1) as f64;
        Some(Self {
            unit,
            noise: unit * (lasts / 12.0).sqrt(),
        })
    }
}

/// The unit of which all values are whole numbers: the least difference of two of them, if they are few
/// and repeat themselves.
fn unit(values: &[f64]) -> Option<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted.dedup();
    let different = sorted.len();
    let steps = sorted.windows(2).map(|w| w[1] - w[0]);
    let unit = steps.fold(f64::INFINITY, f64::min);
    let whole = |value: &f64| (value / unit - (value / unit).round()).abs() < 0.05;
    (different > 2 && 4 * different < values.len() && sorted.iter().all(whole)).then_some(unit)
}

/// Takes the measured white noise of the pins' angles (rad) for the stated one where it is greater, and
/// says so.
pub fn take_noise_of_pins(channels: &[Channel], stated: &mut f64) -> Option<String> {
    let found = measured(channels, "pin_angle").filter(|noise| *noise > EXCEEDS * *stated)?;
    let [shown, was] = [found, *stated].map(f64::to_degrees);
    *stated = found;
    Some(format!(
        "the noise of the pins' angles is {shown:.2} deg, measured; budget.pin_noise is {was:.2} deg: the measured one counts"
    ))
}

/// Takes the counts of the encoders (in a turn of the wheel; 0: exact) for the stated ones where they are
/// fewer, and says so: as their steps show, or their white noise, as that of a magnetic sensor, which errs as much as
/// that many counts.
pub fn take_counts(channels: &[Channel], stated: &mut f64) -> Option<String> {
    let of_wheels = of_readings(channels, "_angle")
        .filter(|(reading, _)| reading.name().contains("wheel") && !reading.is_contact_angle());
    let (mut steps, mut noise) = (0.0_f64, 0.0_f64);
    for (_, values) in of_wheels {
        // Angles that are written with so many significant digits get coarser as the wheels turn on.
        let parts = || values.chunks((values.len() / PARTS).max(LEAST_PART));
        steps = parts().filter_map(step).fold(steps, f64::max);
        noise = noise.max(noise_at_rest(&values).unwrap_or(0.0));
    }
    let [of_steps, of_noise] = [steps, noise * f64::sqrt(12.0)].map(|x| std::f64::consts::TAU / x);
    let is_noisy = noise > LEAST_NOISE;
    let counts = if is_noisy {
        of_steps.min(of_noise)
    } else {
        of_steps
    };
    if !counts.is_finite() || *stated > 0.0 && *stated < EXCEEDS * counts {
        return None;
    }
    let was = std::mem::replace(stated, counts);
    let shown = if of_steps <= of_noise {
        format!("the encoders have {counts:.0} counts in a turn of the wheel, as their steps show")
    } else {
        let noise = noise.to_degrees();
        format!(
            "the encoders have a white noise of {noise:.3} deg, as that of {counts:.0} counts in a turn of the wheel"
        )
    };
    Some(format!(
        "{shown}; budget.encoder_counts is {was}: the measured one counts"
    ))
}

/// The step of which all changes of an angle are multiples, rad; `None` where it is too fine to be seen
/// between readings.
fn step(values: &[f64]) -> Option<f64> {
    /// Least change of an angle that is not rounding, rad, and over the last decimal place: in a difference of two changes
    /// four roundings of half a place meet.
    const LEAST_CHANGE: f64 = 1e-9;
    const OF_DECIMAL: f64 = 3.0;
    let least = LEAST_CHANGE.max(OF_DECIMAL * decimal(values));
    let is_change = |change: &f64| *change > least;
    let changes: Vec<f64> = values.windows(2).map(|w| (w[1] - w[0]).abs()).collect();
    // A wheel that turns by two counts and three shows one count in what its changes differ by.
    let differences = changes.windows(2).map(|w| (w[1] - w[0]).abs());
    let both = changes.iter().copied().chain(differences);
    let steps = || both.clone().filter(is_change);
    let least = steps().fold(f64::INFINITY, f64::min);
    let few: Vec<f64> = steps().filter(|x| *x < 5.5 * least).collect();
    let multiples: f64 = few.iter().map(|x| (x / least).round()).sum();
    let step = few.iter().sum::<f64>() / multiples;
    let is_multiple = |x: &&f64| (*x / step - (*x / step).round()).abs() < OF_STEP;
    let fits =
        few.len() >= LEAST_STEPS && 50 * few.iter().filter(is_multiple).count() >= 49 * few.len();
    // A steady speed has changes of one size, too, without any step.
    let is_several = |x: &&f64| **x > 1.5 * step;
    let has_several = few.iter().filter(is_several).count() >= LEAST_COUNT;
    let moments = (0..changes.len()).filter(|i| is_change(&changes[*i]));
    let moments: Vec<usize> = moments.collect();
    let gaps = moments.windows(2).map(|w| w[1] - w[0]);
    // At a steady speed of some counts a reading all changes are of two sizes, one count apart.
    let whole = || changes.iter().filter(|x| is_change(x)).filter(is_multiple);
    let sizes: Vec<usize> = whole().map(|x| (x / step).round() as usize).collect();
    let are_whole = 50 * sizes.len() >= 49 * moments.len();
    let shows = has_several || vary(gaps.collect()) || are_whole && vary(sizes);
    (fits && shows).then_some(step)
}

/// White noise of an angle whose wheel rests, rad; `None` of one that never does. Of a wheel that turns, uneven ground
/// and uneven times look like noise.
fn noise_at_rest(values: &[f64]) -> Option<f64> {
    /// Values of a rest: enough for [`white_noise`].
    const REST: usize = 60;
    /// White noise over the deviation from the mean: the least share in a rest. Of 60 values it errs by a sixth.
    const SHARE: f64 = 0.7;
    let rests = values.chunks_exact(REST).filter_map(|rest| {
        let all = deviation(rest);
        (white_noise(rest)? > SHARE * all).then_some(all)
    });
    median(rests.collect())
}

/// The last decimal place of values that are written with at most nine; 0 of others.
fn decimal(values: &[f64]) -> f64 {
    // Of 4000 rad in nine places rounding is 5e-4.
    let is_whole = |value: f64| (value - value.round()).abs() < 0.01;
    let scales = (0..10).map(|places| 10_f64.powi(places));
    let mut written = scales.filter(|scale| values.iter().all(|value| is_whole(value * scale)));
    written.next().map_or(0.0, f64::recip)
}

/// Whether two values or more come often.
fn vary(mut values: Vec<usize>) -> bool {
    values.sort_unstable();
    let often = values.chunk_by(|a, b| a == b);
    often.filter(|same| same.len() >= LEAST_COUNT).count() > 1
}

/// White noise of the readings whose name ends so: the root of the mean square of theirs.
fn measured(channels: &[Channel], name: &str) -> Option<f64> {
    let noise = |(_, values): (Reading, Vec<f64>)| white_noise(&values);
    // Coarse counts, and readings that are written again and again, hide it.
    let all = of_readings(channels, name).filter_map(noise);
    let squares: Vec<f64> = all.filter(|noise| *noise > 0.0).map(|x| x * x).collect();
    (!squares.is_empty()).then(|| (squares.iter().sum::<f64>() / squares.len() as f64).sqrt())
}

/// The readings whose name ends so, with the values of the whole log.
fn of_readings(channels: &[Channel], name: &str) -> impl Iterator<Item = (Reading, Vec<f64>)> {
    channels.iter().flat_map(move |channel| {
        let readings = channel.readings.iter();
        let named = readings.filter(move |(r, _)| r.name().ends_with(name));
        named.map(|(reading, formula)| {
            let values = channel.rows().filter_map(|row| formula.value(row));
            (*reading, values.collect())
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Angles at a speed that swings about 2 rad/s, every 10 ms, rounded down to counts (in a turn).
    fn angles(counts: f64, swing: f64) -> Vec<f64> {
        let count = std::f64::consts::TAU / counts;
        let angle = |k: u32| {
            let time = 0.01 * f64::from(k);
            2.0 * time + swing * time.sin()
        };
        (0..1000)
            .map(|k| (angle(k) / count).floor() * count)
            .collect()
    }

    /// Closed form: torques that rise by a fiftieth of a unit between readings have an error of `unit/sqrt(12)` for fifty of
    /// them; those with noise of a unit have none that lasts.
    #[test]
    fn a_rounding_lasts_until_the_next_step() {
        let rounded = |noise: f64| -> Vec<f64> {
            let mut sign = 1.0;
            let torque = |k: u32| {
                sign = -sign;
                0.5 * (0.02 * f64::from(k) + noise * sign).round()
            };
            (0..1000).map(torque).collect()
        };
        for (noise, lasts) in [(0.0, 50.0_f64), (0.6, 1.0)] {
            let found = Rounding::of(&rounded(noise)).map(|found| (found.unit, found.noise));
            let expected = 0.5 * (lasts / 12.0).sqrt();
            assert!(
                found.is_some_and(|(unit, error)| (unit - 0.5).abs() < 1e-9
                    && (error / expected - 1.0).abs() < 0.15),
                "{noise}: {found:?}"
            );
        }
    }

    /// Closed form: the step of counts that are seen one by one, also where each reading has at most one
    /// (100 counts); angles without counts have none, at a steady speed, written twice, or at one that
    /// swings.
    #[test]
    fn counts_show_in_their_steps() {
        let cases = [100.0, 752.0, 1500.0].map(|counts| [(counts, 0.0), (counts, 0.5)]);
        for (counts, swing) in cases.into_iter().flatten().chain([(160_000.0, 0.5)]) {
            let found = step(&angles(counts, swing)).map(|step| std::f64::consts::TAU / step);
            assert!(
                found.is_some_and(|found| (found / counts - 1.0).abs() < 1e-9),
                "{counts}"
            );
        }
        // Written with six and nine places, as by `%f` and many a logger.
        for places in [1e6, 1e9] {
            let written: Vec<f64> = (angles(752.0, 0.5).iter())
                .map(|x| (x * places).round() / places)
                .collect();
            let found = step(&written).map(|step| std::f64::consts::TAU / step);
            // A thousandth: of the roundings of a place in steps of 8 mrad.
            assert!(
                found.is_some_and(|found| (found / 752.0 - 1.0).abs() < 1e-3),
                "{found:?}"
            );
        }
        // As a rover that drives at 0.2 m/s on 50 Hz: 6.4 counts a reading.
        let turned = |k: u32| (0.05333 * f64::from(k) * 752.0 / std::f64::consts::TAU).floor();
        let steady: Vec<f64> = (0..1000).map(|k| turned(k) / 752.0).collect();
        assert!(step(&steady).is_some_and(|step| (step * 752.0 - 1.0).abs() < 1e-9));
        let exact: Vec<f64> = (0..1000).map(|k| 0.02 * f64::from(k)).collect();
        let twice: Vec<f64> = exact.iter().flat_map(|x| [*x, *x]).collect();
        let swings: Vec<f64> = exact.iter().map(|x| x + 0.3 * x.sin()).collect();
        assert_eq!([step(&exact), step(&twice), step(&swings)], [None; 3]);
    }
}
