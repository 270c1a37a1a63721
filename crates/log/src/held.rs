//! Readings that a table repeats: drives or gyroscopes that are read at a fifth of the rate of the rows, say, all at
//! once or one after the other, with the last value in each row. An estimator would take a repeated angle for a
//! wheel that stands, and the next one for a jump; rows between new readings count as without.

use crate::{Channel, Source};
use robhaz_scene::Reading;
use robhaz_score::signals::median;
use std::collections::BTreeSet;

/// Fewest new readings that show a rate.
const LEAST_READINGS: usize = 20;
/// Share of the new readings that come as often as usual, within a row, and of the cells that change
/// with them: coarse encoders and torques repeat values, too, but each on its own.
const REGULAR: f64 = 0.8;

/// Leaves out the repeated readings of wheels and of links, and says so. What is not new all at once
/// may be so kind by kind, wheel by wheel and link by link, or each on its own.
pub fn leave_out(channels: &mut [Channel]) -> Vec<String> {
    let mut notices = Vec::new();
    for channel in channels {
        let mut done = BTreeSet::new();
        let readings = || channel.readings.iter().map(|(r, _)| *r);
        let parts: BTreeSet<&str> = readings().filter_map(part_of).collect();
        // Counts of one encoder alone are new as regularly as it turns.
        let is_alone = |r: &Reading| kind_of(*r).is_some_and(|kind| kind != KINDS[0]);
        let alone = readings().filter(is_alone).map(Reading::name);
        let groups = KINDS.into_iter().chain(OF_LINKS).chain(parts);
        let groups = groups.map(|group| (group, 2));
        let groups: Vec<_> = groups.chain(alone.map(|name| (name, 1))).collect();
        for (group, least) in groups {
            let cells = cells(channel, group);
            let is_done = cells.iter().any(|cell| done.contains(cell));
            if is_done || cells.len() < least {
                continue;
            }
            let Some((every, rows)) = repeated(channel, &cells) else {
                continue;
            };
            let rate = 1.0 / (every as f64 * channel.report.period);
            for row in rows {
                for cell in &cells {
                    channel.cells[row * channel.columns.len() + cell] = f64::NAN;
                }
            }
            done.extend(cells);
            notices.push(format!(
                "the readings of {group} are new in every {every}th row only, at {rate:.0} Hz: the rows between repeat them and count as without"
            ));
        }
    }
    notices
}

/// What is read at one time: wheel angles, torques, or links, body and pins.
const KINDS: [&str; 3] = ["wheel angles", "torques", "links"];

fn kind_of(reading: Reading) -> Option<&'static str> {
    let [angles, torques, links] = KINDS;
    let kind = match reading.name() {
        _ if reading.is_torque() => torques,
        name if name.contains("wheel") => angles,
        _ => links,
    };
    (!reading.is_contact_angle() && !reading.is_optional()).then_some(kind)
}

/// What both links, or body and pins, show of one kind.
const OF_LINKS: [&str; 2] = ["inclinometers", "gyroscopes"];

fn kind_of_link(reading: Reading) -> Option<&'static str> {
    let is_of_links = kind_of(reading) == Some(KINDS[2]);
    is_of_links.then(|| OF_LINKS[usize::from(reading.name().ends_with("_rate"))])
}

/// `wheel1` of its angle and its torque, `link1` of its inclination and its rate.
fn part_of(reading: Reading) -> Option<&'static str> {
    let ends = ["_motor_torque", "_angle", "_inclination", "_rate"];
    let part = ends.iter().find_map(|end| reading.name().strip_suffix(end));
    part.filter(|_| kind_of(reading).is_some())
}

/// The cells that are readings of a group as they are; speeds, which are integrated, are
/// none.
fn cells(channel: &Channel, group: &str) -> Vec<usize> {
    let readings = channel.readings.iter();
    let is_own = |reading: Reading| {
        let groups = [kind_of(reading), kind_of_link(reading), part_of(reading)];
        groups.contains(&Some(group)) || reading.name() == group
    };
    let own = readings.filter(|(reading, _)| is_own(*reading));
    let cell = own.filter_map(|(_, formula)| match formula.source {
        Source::Cell(cell) => Some(cell),
        _ => None,
    });
    cell.filter(|cell| !channel.speeds.contains(cell)).collect()
}

/// Rows from one new reading of these cells to the next, and the rows between, which repeat those before.
/// `None` unless new ones come regularly and all together. One cell alone must be new in every n-th row to the
/// row: of values that change by chance at most a quarter come so.
fn repeated(channel: &Channel, cells: &[usize]) -> Option<(usize, Vec<usize>)> {
    let early = usize::from(cells.len() > 1);
    let rows: Vec<&[f64]> = channel.rows().collect();
    let changed = |row: usize| {
        let is_new = |cell: &&usize| rows[row][**cell].to_bits() != rows[row - 1][**cell].to_bits();
        cells.iter().filter(is_new).count()
    };
    let changes: Vec<usize> = (1..rows.len()).map(changed).collect();
    let new: Vec<usize> = (0..changes.len()).filter(|&k| changes[k] > 0).collect();
    let gaps: Vec<usize> = new.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let every = median(gaps.iter().map(|gap| *gap as f64).collect())?.round() as usize;
    let share = |count: usize, of: usize| count as f64 / of as f64;
    let regular = gaps.iter().filter(|gap| gap.abs_diff(every) <= early);
    let together: usize = new.iter().map(|k| changes[*k]).sum();
    let is_repeated = every >= 2
        && gaps.len() >= LEAST_READINGS
        && share(regular.count(), gaps.len()) >= REGULAR
        && share(together, new.len() * cells.len()) >= REGULAR;
    let mut last = 0;
    let mut left_out = Vec::new();
    for (k, changed) in changes.iter().enumerate() {
        if *changed > 0 {
            last = k;
        } else if k - last <= every {
            left_out.push(k + 1);
        }
    }
    is_repeated.then_some((every, left_out))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::channel::Rows;
    use crate::mcap_events::Clock;
    use std::path::Path;

    fn channel(row: impl Fn(usize) -> [f64; 3]) -> Channel {
        let topic = Rows::Topic(String::new(), Clock::Log);
        Channel {
            columns: vec![String::new(); 3],
            cells: (0..300).flat_map(row).collect(),
            ..Channel::new(String::new(), Path::new(""), topic)
        }
    }

    /// A made-up reading with noise.
    fn reading(k: usize, i: usize) -> f64 {
        (k as f64).mul_add(0.1, ((k * 7 + i * 13) % 11) as f64 * 0.01)
    }

    /// Property: readings that are new in every third or fourth row, all together, are found, and those
    /// rows alone are kept.
    #[test]
    fn held_readings_are_left_out() {
        let new = |k: usize| k * 3 / 10;
        let held = channel(|k| [0, 1, 2].map(|i| reading(new(k), i)));
        let (every, rows) = repeated(&held, &[0, 1, 2]).expect("held");
        assert_eq!(every, 3);
        for k in 1..300 {
            assert_eq!(rows.contains(&k), new(k) == new(k - 1), "{k}");
        }
    }

    /// Property: readings that are new in each row, an encoder of few counts beside such ones, and a
    /// robot at rest without noise repeat nothing.
    #[test]
    fn other_readings_stay() {
        let new = channel(|k| [0, 1, 2].map(|i| reading(k, i)));
        let coarse = channel(|k| [(k / 4) as f64, reading(k, 1), reading(k, 2)]);
        let at_rest = channel(|_| [1.0, 2.0, 3.0]);
        for log in [new, coarse, at_rest] {
            assert!(repeated(&log, &[0, 1, 2]).is_none());
        }
    }

    /// Property: one reading alone counts as held where it is new in every third row, and stays where a resolution
    /// as coarse as its noise repeats values by chance.
    #[test]
    fn one_reading_alone_is_held_to_the_row() {
        let held = channel(|k| [0, 1, 2].map(|i| reading(k / 3, i)));
        let found = repeated(&held, &[1]).expect("held");
        assert_eq!((found.0, found.1.len()), (3, 200));
        let by_chance = |k: usize| {
            if (k * k * 7 + k * 3) % 13 > 5 {
                1.0
            } else {
                0.0
            }
        };
        let rounded = channel(|k| [0, 1, 2].map(|i| by_chance(k + i)));
        assert!(repeated(&rounded, &[1]).is_none());
    }
}
