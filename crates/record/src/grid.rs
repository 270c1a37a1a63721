//! A table of texts, for the terminal and for a page.

use crate::estimator_rows::{first_cells, heading, right};
use crate::summary::{EstimatorSummary, Summary};
use comfy_table::presets::UTF8_FULL_CONDENSED;
use comfy_table::{ContentArrangement, Table};
use maud::{Markup, html};

/// A table with rows for estimators, of one run or several.
pub struct Grid {
    /// Titles of the figures.
    names: Vec<String>,
    /// The label of the run, if there are several, the name of the estimator, and its figures.
    rows: Vec<(Option<String>, String, Vec<String>)>,
    several: bool,
}

impl Grid {
    /// The rows that `cells` makes of each estimator, under the titles `names`. Label and name are in the first one.
    pub fn new(
        runs: &[(&str, &Summary)],
        several: bool,
        names: &[&str],
        cells: impl Fn(&EstimatorSummary) -> Vec<Vec<String>>,
    ) -> Self {
        let mut rows = Vec::new();
        for (label, summary) in runs {
            let mut label = *label;
            for estimator in &summary.estimators {
                let mut name = estimator.name.as_str();
                for cells in cells(estimator) {
                    let label = several.then(|| std::mem::take(&mut label).to_owned());
                    rows.push((label, std::mem::take(&mut name).to_owned(), cells));
                }
            }
        }
        let names = names.iter().map(|name| (*name).to_owned()).collect();
        Self {
            names,
            rows,
            several,
        }
    }

    /// As text, of a largest width.
    pub fn text(&self, width: u16) -> String {
        let names: Vec<&str> = self.names.iter().map(String::as_str).collect();
        let mut table = Table::new();
        table
            .load_preset(UTF8_FULL_CONDENSED)
            .set_content_arrangement(ContentArrangement::Dynamic)
            .set_width(width)
            .set_header(heading(&names, self.several));
        for (label, name, cells) in &self.rows {
            let mut row = first_cells(label.as_deref(), name);
            for cell in cells {
                row.add_cell(right(cell));
            }
            table.add_row(row);
        }
        table.trim_fmt()
    }

    /// As a table of a page of one run.
    pub fn html(&self) -> Markup {
        html! {
            div class="wide" {
                table {
                    tr { th { "estimator" } @for name in &self.names { th { (name) } } }
                    @for (_, name, cells) in &self.rows {
                        tr { td { (name) } @for cell in cells { td { (cell) } } }
                    }
                }
            }
        }
    }
}
