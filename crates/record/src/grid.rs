//! Tables of texts, for the terminal and for a page.

use crate::summary::{EstimatorSummary, Summary};
use comfy_table::presets::UTF8_FULL_CONDENSED;
use comfy_table::{Cell, CellAlignment, ContentArrangement, Table};
use maud::{Markup, html};

/// A table of texts: words to the left of their cells, numbers to the right.
#[derive(Clone, Debug, Default)]
pub struct Grid {
    pub(crate) header: Vec<String>,
    pub(crate) rows: Vec<Vec<String>>,
    /// Places of the columns of words.
    pub(crate) words: &'static [usize],
}

impl Grid {
    /// A table without rows. `words` are the places of the columns that hold words.
    pub fn new(words: &'static [usize], header: &[&str]) -> Self {
        Self {
            header: header.iter().map(|name| (*name).to_owned()).collect(),
            rows: Vec::new(),
            words,
        }
    }

    /// Adds a row.
    pub fn row(&mut self, cells: impl IntoIterator<Item = String>) {
        self.rows.push(cells.into_iter().collect());
    }

    /// The rows that `cells` makes of each estimator, under the titles `names`. If there are
    /// several runs their labels come first. Label and name are in the first row of each.
    pub(crate) fn of_estimators(
        runs: &[(&str, &Summary)],
        several: bool,
        names: &[&str],
        cells: impl Fn(&EstimatorSummary) -> Vec<Vec<String>>,
    ) -> Self {
        let mut grid = match several {
            true => Self::new(&[0, 1], &[&["run", "estimator"], names].concat()),
            false => Self::new(&[0], &[&["estimator"], names].concat()),
        };
        for (label, summary) in runs {
            let mut label = *label;
            for (name, estimator) in &summary.estimators {
                let mut name = name.as_str();
                for cells in cells(estimator) {
                    let label = several.then(|| std::mem::take(&mut label));
                    let words = label.into_iter().chain([std::mem::take(&mut name)]);
                    grid.row(words.map(str::to_owned).chain(cells));
                }
            }
        }
        grid
    }

    /// As text, with lines broken at a largest width; `None` breaks none.
    pub fn text(&self, width: Option<u16>) -> String {
        let cells = |cells: &[String]| {
            let cell = |(i, text): (usize, &String)| match self.words.contains(&i) {
                true => Cell::new(text),
                false => Cell::new(text).set_alignment(CellAlignment::Right),
            };
            cells.iter().enumerate().map(cell).collect::<Vec<_>>()
        };
        let mut table = Table::new();
        table.load_preset(UTF8_FULL_CONDENSED);
        table.set_header(cells(&self.header));
        table.add_rows(self.rows.iter().map(|row| cells(row)));
        if let Some(width) = width {
            table.set_content_arrangement(ContentArrangement::Dynamic);
            table.set_width(width);
        }
        table.trim_fmt()
    }

    /// As a table of a page.
    pub(crate) fn html(&self) -> Markup {
        wide(&html! {
            tr { @for name in &self.header { th { (name) } } }
            @for row in &self.rows { tr { @for cell in row { td { (cell) } } } }
        })
    }
}

/// A table of a page with these rows, which scrolls by itself.
pub(crate) fn wide(rows: &Markup) -> Markup {
    html! { div class="wide" { table { (rows) } } }
}
