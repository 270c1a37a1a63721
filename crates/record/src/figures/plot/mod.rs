//! Figures of a dataset: a score against what a study varied.
//!
//! | modules | job |
//! |---|---|
//! | `request` | what is to be drawn, and why it cannot be |
//! | `selection` | the rows that are drawn, and their values along an axis |
//! | `scale`, `chart` | axes, shapes between two of them, a sheet with its caption |
//! | `bands`, `heat`, `calibration`, `histogram`, `ladder` | one kind of figure each |
//! | `caption` | study, scene, runs, seeds, failures, version |

mod bands;
mod calibration;
mod caption;
mod chart;
mod heat;
mod histogram;
mod ladder;
mod request;
mod scale;
mod selection;
#[cfg(test)]
mod tests;

pub use caption::runs as runs_in_words;
pub use request::{PlotError, PlotKind, PlotRequest};
pub use scale::{Spacing, label as number_label};

use super::{files, png};
use crate::dataset::Dataset;
use chart::Sheet;
use selection::{SEEDS, Selection, varying_apart};

/// Format of a figure.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FigureFormat {
    /// Scalable Vector Graphics.
    Svg,
    /// PDF, one page as large as the figure.
    Pdf,
    /// PNG at 192 dots an inch; needs a font of the machine.
    Png,
}

/// Draws a figure of a dataset. Returns the bytes of its file.
///
/// # Errors
/// [`PlotError`]: unknown columns or estimators, nothing that varies, no row with the score.
pub fn plot(
    dataset: &Dataset,
    request: &PlotRequest,
    format: FigureFormat,
) -> Result<Vec<u8>, PlotError> {
    let sheet = sheet(dataset, request)?;
    let drawn = match format {
        FigureFormat::Svg => files::svg(&sheet),
        FigureFormat::Pdf => files::pdf(&sheet),
        FigureFormat::Png => files::svg(&sheet).and_then(|svg| png::png(&svg)),
    };
    drawn.map_err(PlotError::Drawing)
}

/// The figures of a page: the score against each key that varies, over the first two of them, its calibration and its
/// distribution. Those that the dataset has no values for are left out.
pub fn overview(dataset: &Dataset) -> Vec<PlotRequest> {
    let bands = PlotRequest::new(PlotKind::Bands);
    let Ok(selection) = Selection::new(dataset, &bands) else {
        return Vec::new();
    };
    let mut keys = varying_apart(&selection);
    keys.retain(|key| !SEEDS.contains(&key.as_str()));
    let against = |key: &String| PlotRequest {
        x: Some(key.clone()),
        ..bands.clone()
    };
    let mut requests: Vec<PlotRequest> = keys.iter().map(against).collect();
    if keys.is_empty() && selection.estimators.len() > 1 {
        requests.push(against(&"estimator".to_owned()));
    }
    if keys.len() > 1 {
        requests.push(PlotRequest::new(PlotKind::Heat));
    }
    if dataset.numbers("stated").iter().any(Option::is_some) {
        requests.push(PlotRequest::new(PlotKind::Calibration));
    }
    requests.push(PlotRequest::new(PlotKind::Histogram));
    requests
}

fn sheet(dataset: &Dataset, request: &PlotRequest) -> Result<Sheet, PlotError> {
    let selection = Selection::new(dataset, request)?;
    match request.kind {
        PlotKind::Bands => bands::bands(&selection, request),
        PlotKind::Heat => heat::heat(&selection, request),
        PlotKind::Calibration => calibration::calibration(&selection, request),
        PlotKind::Histogram => histogram::histogram(&selection, request),
        PlotKind::Ladder => ladder::ladder(&selection, request),
    }
}
