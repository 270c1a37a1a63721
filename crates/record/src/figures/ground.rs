//! The ground as an estimator has found it, beside the true one.

use super::header::{Entry, Header, Mark};
use super::page::{Column, Page};
use super::panel::{Axis, Layer, Panel};
use super::run::RunTraces;
use super::style::{FELT, band_color, estimate_line, truth_line};
use super::trace::{Band, Trace};
use crate::felt_ground::ComparedPoint;
use robhaz_score::GroundErrors;

const MM: f64 = 1e3;
/// Distance between points beyond which the line is not drawn, m: the spacing is 10 mm for a robot of 0.8 m.
const GAP: f64 = 0.035;

/// The lines of the figure.
pub struct GroundTraces {
    name: String,
    truth: Trace,
    height: Trace,
    height_band: Band,
    error: Trace,
    error_band: Band,
    slope_error: Trace,
    slope_band: Band,
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
        let places = || longest.iter().map(|(p, _)| p.x);
        let from = places().fold(f64::INFINITY, f64::min);
        let to = places().fold(f64::NEG_INFINITY, f64::max);
        let count = longest.len() as u64;
        let compared = longest.iter().filter_map(|(p, t)| Some((*p, (*t)?)));
        let mut traces = Self {
            name: name.to_owned(),
            truth: Trace::new(count),
            height: Trace::new(count),
            height_band: Band::new(count),
            error: Trace::new(count),
            error_band: Band::new(count),
            slope_error: Trace::new(count),
            slope_band: Band::new(count),
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
        let x = point.x;
        let half = 2.0 * point.sigma_height;
        let slope_half = 2.0 * point.sigma_slope;
        let angle = truth.and_then(|t| t.slope);
        self.truth.add(x, truth.map(|t| t.height));
        self.height.add(x, Some(point.height));
        self.height_band.add(x, Some((point.height, half)));
        self.error
            .add(x, truth.map(|t| MM * (point.height - t.height)));
        self.error_band.add(x, Some((0.0, MM * half)));
        self.slope_error
            .add(x, angle.map(|a| (point.slope - a).to_degrees()));
        self.slope_band.add(x, Some((0.0, slope_half.to_degrees())));
    }

    /// Breaks the lines: there is no point.
    fn interrupt(&mut self) {
        for trace in [
            &mut self.truth,
            &mut self.height,
            &mut self.error,
            &mut self.slope_error,
        ] {
            trace.interrupt();
        }
        for band in [
            &mut self.height_band,
            &mut self.error_band,
            &mut self.slope_band,
        ] {
            band.interrupt();
        }
    }

    /// Stem of the file.
    pub fn stem(&self) -> String {
        format!("ground_{}", self.name)
    }

    /// The figure. Without truth it has the profile alone.
    pub fn page(&self, run: &RunTraces) -> Page<'_> {
        let panel = |title: &str, y_label, least_span, height, layers| Panel {
            title: title.to_owned(),
            note: String::new(),
            y_label,
            least_span,
            logarithmic: false,
            height,
            layers,
        };
        let mut profile = vec![
            Layer::Band(&self.height_band, FELT),
            Layer::Estimate(&self.height, FELT),
        ];
        let mut panels = Vec::new();
        if run.has_truth() && self.errors.is_some() {
            profile.push(Layer::Truth(&self.truth));
            let error = |error, band| {
                vec![
                    Layer::Band(band, FELT),
                    Layer::Estimate(error, FELT),
                    Layer::Level(0.0),
                ]
            };
            let height = error(&self.error, &self.error_band);
            let slope = error(&self.slope_error, &self.slope_band);
            panels.push(panel(
                "Error of the height",
                "error (mm)",
                0.2,
                150.0,
                height,
            ));
            panels.push(panel(
                "Error of the slope",
                "error (deg)",
                0.2,
                150.0,
                slope,
            ));
        }
        panels.insert(0, panel("Profile", "height y (m)", 0.01, 210.0, profile));
        Page {
            header: self.header(run),
            axis: Axis {
                label: "place along the path, x (m)",
                range: self.range.clone(),
                compare_from: self.range.start,
            },
            columns: vec![Column::of_own_scales(panels.into_iter())],
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
