//! Tables that were made of several: rows of drives, and between them rows of inertial sensors, each with the cells
//! of its own; and topics whose messages hold some joints each, with stamps of their own. They are channels with times
//! of their own.

use crate::survey::{count_gaps, period};
use crate::{Channel, Formula, Rows};
use robhaz_run::ChannelReport;
use robhaz_scene::Reading;

/// Share of the rows with all readings below which a table was made of several.
const WHOLE: f64 = 0.5;
/// Share of the rows in which two readings of one table may differ: single lost ones.
const ALIKE: f64 = 0.02;
/// Fewest rows of a part.
const LEAST: usize = 20;

/// Splits channels that were made of several, and says so. Of the first one, that of wheels' angles stays the first.
pub fn split(channels: &mut Vec<Channel>) -> Vec<String> {
    let (mut notices, mut all) = (Vec::new(), Vec::new());
    for channel in channels.drain(..) {
        match split_one(&channel, all.is_empty()) {
            Some((parts, notice)) => {
                all.extend(parts);
                notices.push(notice);
            }
            None => all.push(channel),
        }
    }
    *channels = all;
    notices
}

/// The parts of a channel, and what is said of them; `None` of one that is whole. `is_base`: its rows are the frames.
fn split_one(table: &Channel, is_base: bool) -> Option<(Vec<Channel>, String)> {
    if table.truth.is_some() {
        return None;
    }
    let is_topic = matches!(table.rows, Rows::Topic(..));
    let rows: Vec<&[f64]> = table.rows().collect();
    let present = |(_, formula): &(Reading, Formula)| -> Vec<bool> {
        let is_there = |row: &&[f64]| formula.value(row).is_some();
        rows.iter().map(is_there).collect()
    };
    let present: Vec<Vec<bool>> = table.readings.iter().map(present).collect();
    let is_wheel = |k: &usize| table.readings[*k].0.is_wheel_angle();
    let parts = parts(&present, rows.len(), is_wheel)?;
    let with_wheels = parts.iter().filter(|part| part.iter().any(is_wheel));
    match with_wheels.count() {
        0 if is_base => return None,
        // Rows of drives that are read one after the other are no tables of their own.
        2.. if !is_topic => return None,
        _ => {}
    }
    let found = parts.iter().map(|part| of_part(table, part, &rows));
    let found: Vec<Channel> = found.collect();
    if found.iter().any(|channel| channel.times.len() < LEAST) {
        return None;
    }
    let (name, count) = (&table.name, parts.len());
    let frames = match is_base {
        true => format!(
            ", and those of {} are the frames",
            found[0].readings[0].0.name()
        ),
        false => String::new(),
    };
    let notice = match is_topic {
        true => format!(
            "{name} has {count} kinds of messages with readings of their own: these count at the times of their own messages{frames}"
        ),
        false => format!(
            "{name} was made of {count} tables: the readings of each count at the times of its own rows{frames}"
        ),
    };
    Some((found, notice))
}

/// The readings of each table, those of wheels first, by the rows in which each reading is present; `None` of one
/// table.
fn parts(
    present: &[Vec<bool>],
    rows: usize,
    is_wheel: impl Fn(&usize) -> bool,
) -> Option<Vec<Vec<usize>>> {
    // Counts of rows.
    let share = |count: usize| count as f64 / rows as f64;
    let read = (0..present.len()).filter(|k| present[*k].contains(&true));
    let read: Vec<usize> = read.collect();
    let whole = (0..rows).filter(|row| read.iter().all(|k| present[*k][*row]));
    if share(whole.count()) >= WHOLE {
        return None;
    }
    let is_alike = |a: usize, b: usize| {
        let differ = present[a].iter().zip(&present[b]).filter(|(a, b)| a != b);
        share(differ.count()) < ALIKE
    };
    let mut parts: Vec<Vec<usize>> = Vec::new();
    for k in read {
        match parts.iter_mut().find(|part| is_alike(part[0], k)) {
            Some(part) => part.push(k),
            None => parts.push(vec![k]),
        }
    }
    parts.sort_by_key(|part| !part.iter().any(&is_wheel));
    // A slower sensor that is read together with the drives is of their table.
    let count = |k: usize| present[k].iter().filter(|is| **is).count();
    let apart = |a: usize, b: usize| {
        let both = present[a].iter().zip(&present[b]);
        let both = both.filter(|(a, b)| **a && **b);
        2 * both.count() < count(a).min(count(b))
    };
    let mut others = parts.split_off(parts.len().min(1));
    let of_wheels = *parts.first()?.first()?;
    for part in others.extract_if(.., |part| !apart(part[0], of_wheels)) {
        parts[0].extend(part);
    }
    parts.append(&mut others);
    (parts.len() >= 2).then_some(parts)
}

/// The channel of some readings of a table, with the rows that have one of them.
fn of_part(table: &Channel, part: &[usize], rows: &[&[f64]]) -> Channel {
    let readings: Vec<_> = part.iter().map(|k| table.readings[*k]).collect();
    let is_own = |row: &[f64]| readings.iter().any(|(_, of)| of.value(row).is_some());
    let own: Vec<usize> = (0..rows.len()).filter(|row| is_own(rows[*row])).collect();
    let times: Vec<f64> = own.iter().map(|row| table.times[*row]).collect();
    let (start, _) = readings[0];
    let mut report = ChannelReport {
        name: format!("{}, {}", table.name, start.name()),
        period: period(&times).unwrap_or(table.report.period),
        rows: own.len() as u64,
        ..table.report.clone()
    };
    count_gaps(&times, &mut report);
    Channel {
        name: report.name.clone(),
        cells: own.iter().flat_map(|row| rows[*row]).copied().collect(),
        times,
        readings,
        report,
        // What it is read from is that of the table.
        ..table.clone()
    }
}
