//! Rows of printed tables with a row for each estimator.

use comfy_table::{Cell, CellAlignment, Row};

/// The heading: the run if there are several, the estimator, and the figures `names`.
pub fn heading(names: &[&str], several: bool) -> Row {
    let mut row = Row::new();
    if several {
        row.add_cell(Cell::new("run"));
    }
    row.add_cell(Cell::new("estimator"));
    for name in names {
        row.add_cell(right(*name));
    }
    row
}

/// A row with the label of its run, if there are several, and the estimator's `name`.
pub fn first_cells(label: Option<&str>, name: &str) -> Row {
    let mut row = Row::new();
    if let Some(label) = label {
        row.add_cell(Cell::new(label));
    }
    row.add_cell(Cell::new(name));
    row
}

/// A cell aligned to the right.
pub fn right(text: impl ToString) -> Cell {
    Cell::new(text).set_alignment(CellAlignment::Right)
}
