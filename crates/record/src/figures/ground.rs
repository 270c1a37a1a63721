//! The ground as an estimator has found it, beside the true one.

use super::header::{Entry, Header, Mark};
use super::page::{Column, Page, Scale};
use super::panel::{Axis, Layer, Panel};
use super::run::RunTraces;
use super::style::{FELT, band_color, estimate_line, truth_line};
use super::trace::{Estimated, Trace};
use crate::felt_ground::ComparedPoint;
use crate::quantile::extremes;
use robhaz_score::GroundErrors;

const MM: f64 = 1e3;
/// Distance between points beyond which the line is not drawn, m: the spacing is 10 mm for a robot of 0.8 m.
const GAP: f64 = 0.035;

/// The lines of the figure.
pub struct GroundTraces {
    name: String,
    truth: Trace,
    height: Estimated,
    error: Estimated,
    slope_error: Estimated,
    errors: Option<GroundErrors>,
    /// First and last place, m.
    range: std::ops::Range<f64>,
    /// Number of the section that is drawn, and how many there are.
    sections: (u32, usize),
}

impl GroundTraces {
    /// The lines of an estimator: those of its longest section. `None` with fewer than two points.
    pub fn new(name: &str, points: &[ComparedPoint]) -> Option<Self> {
        let sections: Vec<&[ComparedPoint]> = points
            .chunk_by(|(a, _), (b, _)| a.section == b.section)
            .collect();
        let longest = *sections.iter().max_by_key(|section| section.len())?;
        let (first, _) = longest.first()?;
        let (from, to) = extremes(longest.iter().map(|(p, _)| p.x));
        let count = longest.len() as u64;
        let compared = longest.iter().filter_map(|(p, t)| Some((*p, (*t)?)));
        let mut traces = Self {
            name: name.to_owned(),
            truth: Trace::new(count),
            height: Estimated::new(count),
            error: Estimated::new(count),
            slope_error: Estimated::new(count),
            errors: GroundErrors::of(compared),
            range: from..to,
            sections: (first.section, sections.len()),
        };
        let mut last = first.x;
        for point in longest {
            if (point.0.x - last).abs() > GAP {
                traces.interrupt();
            }
            traces.add(point);
            last = point.0.x;
        }
        (to > from).then_some(traces)
    }

    fn add(&mut self, (point, truth): &ComparedPoint) {
        let (x, height) = (point.x, point.height);
        let (sigma, slope_sigma) = (point.sigma_height, point.sigma_slope.to_degrees());
        let error = truth.map(|t| MM * (height - t.height));
        let slope_error = truth
            .and_then(|t| t.slope)
            .map(|s| (point.slope - s).to_degrees());
        self.truth.add(x, truth.map(|t| t.height));
        self.height.add(x, Some(height), Some(sigma));
        self.error.add_error(x, error, Some(MM * sigma));
        self.slope_error
            .add_error(x, slope_error, Some(slope_sigma));
    }

    /// Breaks the lines: there is no point.
    fn interrupt(&mut self) {
        self.truth.interrupt();
        for estimated in [&mut self.height, &mut self.error, &mut self.slope_error] {
            estimated.interrupt();
        }
    }

    /// Stem of the file.
    pub fn stem(&self) -> String {
        format!("ground_{}", self.name)
    }

    /// The figure. Without truth it has the profile alone.
    pub fn page(&self, run: &RunTraces) -> Page {
        let mut profile = vec![Layer::estimate(&self.height, FELT)];
        let errors = [
            ("Error of the height", "error (mm)", &self.error),
            ("Error of the slope", "error (deg)", &self.slope_error),
        ];
        let is_compared = run.has_truth() && self.errors.is_some();
        if is_compared {
            profile.insert(0, Layer::truth(&self.truth));
        }
        let errors = errors.into_iter().filter(|_| is_compared);
        let errors = errors.map(|(title, y_label, error)| {
            let zero = Layer::level(0.0, &self.range);
            let layers = vec![zero, Layer::estimate(error, FELT)];
            Panel::new(title, y_label, (0.2, 150.0), layers)
        });
        let profile = Panel::new("Profile", "height y (m)", (0.01, 210.0), profile);
        let panels = [profile].into_iter().chain(errors);
        Page {
            header: self.header(run),
            axis: Axis::of_places("place along the path, x (m)", self.range.clone()),
            columns: vec![Column::new(Scale::Own, panels)],
        }
    }

    fn header(&self, run: &RunTraces) -> Header {
        let mut subtitle =
            "origin: the middle wheel's contact at the start; x and y have different scales"
                .to_owned();
        if self.sections.1 > 1 {
            let (section, count) = self.sections;
            subtitle.push_str(&format!("; section {section} of {count}"));
        }
        let mut key = Vec::new();
        if run.has_truth() {
            key.push(Entry::new(Mark::Line(truth_line()), "true"));
        }
        let rmse = match self.errors {
            Some(errors) => format!("estimated: RMSE {:.2} mm", MM * errors.height_rmse_m),
            None => "estimated".to_owned(),
        };
        key.push(Entry::new(Mark::Line(estimate_line(FELT)), rmse));
        key.push(Entry::new(
            Mark::Area(band_color(FELT)),
            "two standard deviations",
        ));
        Header {
            title: format!(
                "The ground that the wheels have passed, estimator {}",
                self.name
            ),
            subtitle,
            key,
        }
    }
}
