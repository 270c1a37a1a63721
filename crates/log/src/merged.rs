//! Tables that were made of several: rows of drives, and between them rows of inertial sensors, each with the cells
//! of its own. They are channels with times of their own.

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

/// Splits a log of one table that was made of several into their channels, and says so. That of the wheels'
/// angles is the first.
pub fn split(channels: &mut Vec<Channel>) -> Option<String> {
    let mut of_log = (0..channels.len()).filter(|i| channels[*i].truth.is_none());
    let (Some(0), None) = (of_log.next(), of_log.next()) else {
        return None;
    };
    let table = &channels[0];
    if !matches!(table.rows, Rows::Table(..)) {
        return None;
    }
    let rows: Vec<&[f64]> = table.rows().collect();
    let present = |(_, formula): &(Reading, Formula)| -> Vec<bool> {
        let is_there = |row: &&[f64]| formula.value(row).is_some();
        rows.iter().map(is_there).collect()
    };
    let present: Vec<Vec<bool>> = table.readings.iter().map(present).collect();
    let is_wheel = |k: &usize| table.readings[*k].0.is_wheel_angle();
    let parts = parts(&present, rows.len(), is_wheel)?;
    let found = parts.iter().map(|part| of_part(table, part, &rows));
    let mut found: Vec<Channel> = found.collect();
    if found.iter().any(|channel| channel.times.len() < LEAST) {
        return None;
    }
    let notice = format!(
        "{} was made of {} tables: the readings of each count at the times of its own rows, and the rows of the wheels are the frames",
        table.name,
        parts.len()
    );
    channels.remove(0);
    found.append(channels);
    *channels = found;
    Some(notice)
}

/// The readings of each table, that of the wheels first, by the rows in which each reading is present; `None` of one
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
    let has_wheels = |part: &Vec<usize>| part.iter().any(&is_wheel);
    // Drives that are read one after the other are no tables of their own.
    if parts.iter().filter(|part| has_wheels(part)).count() != 1 {
        return None;
    }
    parts.sort_by_key(|part| !has_wheels(part));
    // A slower sensor that is read together with the drives is of their table.
    let count = |k: usize| present[k].iter().filter(|is| **is).count();
    let apart = |a: usize, b: usize| {
        let both = present[a].iter().zip(&present[b]);
        let both = both.filter(|(a, b)| **a && **b);
        2 * both.count() < count(a).min(count(b))
    };
    let mut others = parts.split_off(1);
    let of_wheels = parts[0][0];
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
