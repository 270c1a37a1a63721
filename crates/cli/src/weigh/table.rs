//! The table of a weighing as comma-separated text: one posture a line.

use miette::{IntoDiagnostic, Result, WrapErr, miette};
use robhaz_masses::{Blocks, Measurements, Reading};
use robhaz_model::GRAVITY;
use robhaz_terrain::decimals::Decimals;
use robhaz_terrain::text_table::{TextRow, TextTable, name_and_unit};
use std::fmt::Write as _;
use std::fs::File;
use std::ops::Range;
use std::path::Path;

/// Names of the columns. A column is known by its place among them.
const NAMES: &str = "link1 link2 wheel1 wheel2 wheel3 left_wheel1 left_wheel2 left_wheel3 right_wheel1 right_wheel2 right_wheel3 \
                     weight block1 block2 block3";
const LINKS: Range<usize> = 0..2;
const WHEELS: Range<usize> = 2..5;
/// Scales under both sides, the left ones first.
const BOTH: Range<usize> = 5..11;
const WEIGHT: usize = 11;
/// Heights of blocks: they follow from the inclinations, and are for the reader alone.
const BLOCKS: usize = 12;

struct Column {
    /// With its unit.
    name: String,
    place: usize,
    to_si: f64,
}

const ALLOWED: &str = "link1 [deg], link2 [deg], wheel1 [N], wheel2 [N], wheel3 [N], weight [N]; of both sides left_wheel1 [N] to right_wheel3 [N] in their place; also [rad], [kg], [g]; block1 [mm] \
     to block3 [mm] are not read";
/// Largest inclination, rad: beyond, it is in degrees.
const STEEPEST: f64 = 1.6;
/// Largest force, N.
const LARGEST: f64 = 1e6;

/// Reads a table.
///
/// The first line names the columns with their units: `link1 [deg]` and `link2 [deg]` (inclinations
/// from the nominal pose, nose up positive, also `[rad]`), `wheel1 [N]` to `wheel3 [N]` (front,
/// middle, rear; also `[kg]`, `[g]`: mass times 9.81 m/s^2), and if it was measured `weight [N]` of
/// the whole side in one line; of scales under both sides `left_wheel1 [N]` to `right_wheel3 [N]`. A cell is empty where nothing was read. Lines that begin with `#`
/// are comments.
///
/// # Errors
/// File, line and column, what was found, what is allowed.
pub fn read_table(path: &Path) -> Result<Measurements> {
    let shown = path.display();
    let unread = || format!("cannot read {shown}");
    let opened = File::open(path).and_then(TextTable::open);
    let mut table = opened.into_diagnostic().wrap_err_with(unread)?;
    let mut text = TextRow::default();
    let mut next = |text: &mut TextRow| table.read(text).into_diagnostic().wrap_err_with(unread);
    next(&mut text)?;
    let of_header = |message: String| miette!("{shown}, first line: {message}");
    let columns = columns(&text).map_err(of_header)?;
    let mut measurements = Measurements::default();
    let mut decimals = Decimals::default();
    while next(&mut text)? {
        let of_row = |message| miette!("{shown}, line {}{message}", text.line);
        row(&columns, &text, &mut decimals, &mut measurements).map_err(of_row)?;
    }
    if measurements.count() == 0 {
        let message = "no line with a reading of a scale follows; allowed: at least one";
        return Err(of_header(message.to_owned()));
    }
    Ok(measurements)
}

/// The error says what was found and what is allowed.
fn columns(header: &TextRow) -> Result<Vec<Column>, String> {
    let mut columns: Vec<Column> = Vec::new();
    for text in header.texts() {
        let unknown = || format!("found column {text:?}, allowed: {ALLOWED}");
        let column = column(&text).ok_or_else(unknown)?;
        let is_taken = |c: &Column| c.place == column.place && c.place < BLOCKS;
        if columns.iter().any(is_taken) {
            return Err(format!("column {text:?} occurs twice"));
        }
        columns.push(column);
    }
    let has = |place: &usize| columns.iter().any(|c| c.place == *place);
    let count = |places: Range<usize>| places.filter(has).count();
    let (both, one_side) = (count(BOTH), count(WHEELS));
    if !matches!(both, 0 | 6) || both > 0 && one_side > 0 {
        let message =
            "allowed: wheel1 to wheel3 of one side, or all six of left_wheel1 to right_wheel3";
        return Err(format!(
            "found {both} columns of scales of both sides, {message}"
        ));
    }
    let wheels = both + one_side > 0;
    if wheels && count(LINKS) < 2 {
        return Err("the inclinations link1 [deg] and link2 [deg] are missing".to_owned());
    }
    if !wheels && !has(&WEIGHT) {
        return Err(format!("no column of a scale; allowed: {ALLOWED}"));
    }
    Ok(columns)
}

/// `link1 [deg]` and the like.
fn column(text: &str) -> Option<Column> {
    let (name, unit) = name_and_unit(text)?;
    let place = NAMES.split(' ').position(|known| known == name)?;
    let units: &[(&str, f64)] = match place {
        BLOCKS.. => &[(unit, 1.0)],
        0 | 1 => &[("deg", 1_f64.to_radians()), ("rad", 1.0)],
        _ => &[("N", 1.0), ("kg", GRAVITY), ("g", GRAVITY / 1e3)],
    };
    Some(Column {
        name: text.to_owned(),
        place,
        to_si: units.iter().find(|(name, _)| *name == unit)?.1,
    })
}

/// The error continues the place of the line.
fn row(
    columns: &[Column],
    row: &TextRow,
    decimals: &mut Decimals,
    into: &mut Measurements,
) -> Result<(), String> {
    let (found, allowed) = (row.count(), columns.len());
    if found != allowed {
        return Err(format!(
            ": found {found} cells, allowed: {allowed}, as in the first line"
        ));
    }
    let mut cells = [None; BLOCKS];
    for (i, column) in columns.iter().enumerate() {
        let refuse = |message: String| format!(", column {:?}: {message}", column.name);
        let cell = row.text(i);
        if cell.is_empty() || column.place >= BLOCKS {
            continue;
        }
        let found = |allowed: &str| refuse(format!("found {cell:?}, allowed: {allowed}"));
        let read = decimals.read(&cell, row.line);
        let value = read.map_err(|allowed| found(&allowed))? * column.to_si;
        if column.place == WEIGHT && into.weight.is_some() {
            let message = "the weight stands in an earlier line; allowed: once";
            return Err(refuse(message.to_owned()));
        }
        let (range, allowed) = match LINKS.contains(&column.place) {
            true => (
                -STEEPEST..=STEEPEST,
                "an inclination between -91 and 91 deg",
            ),
            false => (0.0..=LARGEST, "a force of at least 0 and at most 1e6 N"),
        };
        if !range.contains(&value) {
            return Err(found(&format!("{allowed}, or an empty cell")));
        }
        cells[column.place] = Some(value);
    }
    into.weight = cells[WEIGHT].or(into.weight);
    let [angle1, angle2, front, middle, rear, both @ .., _] = cells;
    let mut forces = [front, middle, rear];
    let mut differences = [None; 3];
    for i in 0..3 {
        if both[i].is_some() != both[3 + i].is_some() {
            let wheel = i + 1;
            return Err(format!(
                ": one scale of left_wheel{wheel} and right_wheel{wheel} was read; allowed: both or none"
            ));
        }
        if let Some((left, right)) = both[i].zip(both[3 + i]) {
            forces[i] = Some(0.5 * (left + right));
            differences[i] = Some(left - right);
        }
    }
    match (angle1.zip(angle2), forces) {
        (_, [None, None, None]) => {}
        (Some((a, b)), forces) => {
            let reading = Reading {
                line: row.line,
                inclinations: [a, b],
                forces,
            };
            into.readings.push(reading);
            if differences.iter().any(Option::is_some) {
                into.differences.push(Reading {
                    forces: differences,
                    ..reading
                });
            }
        }
        _ => return Err(": a scale was read, but an inclination is missing; allowed: both".into()),
    }
    Ok(())
}

/// The first columns of a table; those of the scales follow.
const FIRST_COLUMNS: &str = "block1 [mm],block2 [mm],block3 [mm],link1 [deg],link2 [deg]";
const ONE_SIDE: &str = "wheel1 [N],wheel2 [N],wheel3 [N]";
const BOTH_SIDES: &str = "left_wheel1 [N],left_wheel2 [N],left_wheel3 [N],right_wheel1 [N],right_wheel2 [N],right_wheel3 [N]";

/// The text of a table for postures on blocks (heights, m), of scales under one side or under
/// both: to fill in, or with measurements, one reading for each posture.
pub fn table(blocks: &[Blocks], both: bool, measurements: Option<&Measurements>) -> String {
    let scales = if both { BOTH_SIDES } else { ONE_SIDE };
    let mut text = format!("{FIRST_COLUMNS},{scales},weight [N]\n");
    for (k, heights) in blocks.iter().enumerate() {
        let reading = measurements.and_then(|m| m.readings.get(k));
        let weight = measurements.and_then(|m| m.weight).filter(|_| k == 0);
        let mut cells: Vec<String> = heights.map(|h| format!("{:.0}", 1e3 * h)).into();
        let angle = |i: usize| Some(format!("{:.3}", reading?.inclinations[i].to_degrees()));
        cells.extend([0, 1].map(|i| angle(i).unwrap_or_default()));
        let force = |force: Option<f64>| force.map_or(String::new(), |n| format!("{n:.2}"));
        let mean = |i: usize| reading?.forces[i];
        if both {
            let difference = measurements.and_then(|m| m.differences.get(k));
            for half in [0.5, -0.5] {
                let of = |i: usize| Some(mean(i)? + half * difference?.forces[i]?);
                cells.extend([0, 1, 2].map(|i| force(of(i))));
            }
        } else {
            cells.extend([0, 1, 2].map(|i| force(mean(i))));
        }
        cells.push(force(weight));
        // Writing into a text cannot fail.
        let _ = writeln!(text, "{}", cells.join(","));
    }
    text
}
