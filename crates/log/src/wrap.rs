//! Columns that start anew after a range: counts of 16 or 32 bits, one turn.

use crate::{Channel, Source};
use std::f64::consts::TAU;

/// Continues the values of the cells that start anew after a range: of all that fit, each is the nearest
/// to the one before. Between two rows they may change by less than half of the range.
pub fn go_on(channel: &mut Channel) {
    for (cell, range) in channel.wraps.clone() {
        continue_cells(channel.column_mut(cell).map(|(_, cell)| cell), range);
    }
}

/// Takes inclinations from 0 to a turn, as headings are written, as directions: 359 deg are -1 deg. No robot stands
/// between.
pub fn take_directions(channel: &mut Channel) {
    /// Inclination on which no robot stands, rad.
    const STEEPEST: f64 = 1.05;
    const ROUNDING: f64 = 0.01;
    let of = |name: &str| name.ends_with("_inclination") || name == "body_roll";
    let (rows, columns) = (&channel.cells, channel.columns.len().max(1));
    for (reading, formula) in &mut channel.readings {
        if !of(reading.name()) || !matches!(formula.source, Source::Cell(_)) {
            continue;
        }
        let values = || rows.chunks(columns).filter_map(|row| formula.value(row));
        let is_near = |value: f64| (-ROUNDING..STEEPEST).contains(&value);
        let is_below = |value: f64| (TAU - STEEPEST..TAU + ROUNDING).contains(&value);
        let is_turn = values().all(|v| is_near(v) || is_below(v)) && values().any(is_below);
        formula.is_direction |= is_turn;
    }
}

fn continue_cells<'a>(cells: impl Iterator<Item = &'a mut f64>, range: f64) {
    let (mut ranges, mut last) = (0.0, None::<f64>);
    for cell in cells {
        ranges -= last.map_or(0.0, |last| ((*cell - last) / range).round());
        last = Some(*cell);
        *cell += ranges * range;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Closed form: counts of 16 bits, signed and unsigned, forward and backward, with a lost row.
    #[test]
    fn counts_go_on() {
        for (low, sign) in [(0, 1), (-32_768, 1), (0, -1)] {
            let counts = |k: i64| sign * 1000 * k + 5;
            let wrapped = |k: i64| (counts(k) - low).rem_euclid(65_536) + low;
            let mut cells: Vec<f64> = (0..300).map(|k| wrapped(k) as f64).collect();
            cells[100] = f64::NAN;
            let first = cells[0];
            let known = cells.iter_mut().filter(|cell| cell.is_finite());
            continue_cells(known, 65_536.0);
            for (k, found) in (0..).zip(&cells).filter(|(k, _)| *k != 100) {
                let expected = first + (counts(k) - counts(0)) as f64;
                assert!((found - expected).abs() < 1e-9, "{k}: {found} {expected}");
            }
        }
    }
}
