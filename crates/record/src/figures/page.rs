//! Columns of panels over a common axis, below a header.

use super::files::{Drawn, Picture};
use super::header::{Header, MARGIN, WIDTH};
use super::panel::{Axis, PANEL_TITLE, Panel, X_LABELS};
use super::style::units;
use plotters::coord::Shift;
use plotters::prelude::*;
use std::ops::Range;

/// Distance between columns, px.
const GAP: f64 = 12.0;

/// Panels from top to bottom.
pub struct Column<'a> {
    /// The panels.
    pub panels: Vec<Panel<'a>>,
    /// Whether all have one range, so that their heights can be compared.
    pub one_scale: bool,
}

impl<'a> Column<'a> {
    /// Panels whose heights can be compared.
    pub fn of_one_scale(panels: impl Iterator<Item = Panel<'a>>) -> Self {
        Self {
            panels: panels.collect(),
            one_scale: true,
        }
    }

    /// Panels each with a range of its own.
    pub fn of_own_scales(panels: impl Iterator<Item = Panel<'a>>) -> Self {
        Self {
            panels: panels.collect(),
            one_scale: false,
        }
    }

    /// The range of each panel, in the unit of the data.
    fn ranges(&self, axis: &Axis) -> Vec<Range<f64>> {
        if self.one_scale {
            vec![Panel::shared_range(&self.panels, axis); self.panels.len()]
        } else {
            let each = self.panels.chunks(1);
            each.map(|panel| Panel::shared_range(panel, axis)).collect()
        }
    }

    fn height(&self) -> f64 {
        let panels: f64 = self.panels.iter().map(|p| PANEL_TITLE + p.height).sum();
        panels + X_LABELS
    }
}

/// A figure of panels.
pub struct Page<'a> {
    /// Title and key.
    pub header: Header,
    /// The horizontal axis of all panels.
    pub axis: Axis,
    /// The columns from left to right.
    pub columns: Vec<Column<'a>>,
}

impl Picture for Page<'_> {
    fn size(&self) -> (u32, u32) {
        let panels = self.columns.iter().map(Column::height).fold(0.0, f64::max);
        (WIDTH, whole(self.header.bottom() + panels + 0.5 * MARGIN))
    }

    fn draw<DB>(&self, page: &DrawingArea<DB, Shift>) -> Drawn
    where
        DB: DrawingBackend,
        DB::ErrorType: 'static,
    {
        self.header.draw(page)?;
        #[expect(clippy::cast_precision_loss, reason = "a few columns")]
        let count = self.columns.len() as f64;
        let width = (f64::from(WIDTH) - 2.0 * MARGIN - (count - 1.0) * GAP) / count;
        let mut left = MARGIN;
        for column in &self.columns {
            let mut top = self.header.bottom();
            for (r, (panel, range)) in column
                .panels
                .iter()
                .zip(column.ranges(&self.axis))
                .enumerate()
            {
                let last = r + 1 == column.panels.len();
                let height = PANEL_TITLE + panel.height;
                let with_labels = height + if last { X_LABELS } else { 0.0 };
                let area = page.clone().shrink(
                    (units(left), units(top)),
                    (units(width), units(with_labels)),
                );
                panel.draw(&area, &self.axis, &range, last)?;
                top += height;
            }
            left += width + GAP;
        }
        Ok(())
    }
}

/// The next whole number of px.
pub fn whole(px: f64) -> u32 {
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "the height of a picture"
    )]
    let px = px.ceil() as u32;
    px
}
