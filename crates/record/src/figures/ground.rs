//! The ground as an estimator has found it, beside the true one.

use super::page::{Column, Entry, Header, Mark, Page, Scale};
use super::panel::{Axis, Layer, Panel};
use super::run::RunTraces;
use super::style::{TERRAIN, band_color, estimate_line, truth_line};
use super::trace::Point;
use crate::estimated_terrain::ComparedPoint;
use crate::quantile::extremes;
use robhaz_score::GroundErrors;

const MM: f64 = 1e3;
/// Distance between points beyond which the line is not drawn, m: the spacing is 10 mm for a robot
/// of 0.8 m.
const GAP: f64 = 0.035;

/// The figure of the longest section of an estimator; `None` with fewer than two points. Without
/// truth it has the profile alone.
pub fn ground(run: &RunTraces, name: &str, points: &[ComparedPoint]) -> Option<Page> {
    let sections = || points.chunk_by(|(a, _), (b, _)| a.section == b.section);
    let longest = sections().max_by_key(|section| section.len())?;
    let (from, to) = extremes(longest.iter().map(|(p, _)| p.x));
    let range = from..to;
    let compared = longest.iter().filter_map(|(p, t)| Some((*p, (*t)?)));
    let errors = GroundErrors::of(compared).filter(|_| run.has_truth());
    let mut profile = vec![estimate(longest, |(p, _)| {
        Some((p.height, p.height, p.sigma_height))
    })];
    if errors.is_some() {
        let truth = lines(longest, |(_, t)| t.map(|t| t.height));
        profile.insert(0, Layer::line(truth, truth_line()));
    }
    let height = estimate(longest, |(p, t)| {
        Some((MM * (p.height - (*t)?.height), 0.0, MM * p.sigma_height))
    });
    let slope = estimate(longest, |(p, t)| {
        let error = (p.slope - (*t)?.slope?).to_degrees();
        Some((error, 0.0, p.sigma_slope.to_degrees()))
    });
    let errors_of = [
        ("Error of the height", "error (mm)", height),
        ("Error of the slope", "error (deg)", slope),
    ];
    let errors_of = errors_of.into_iter().filter(|_| errors.is_some());
    let errors_of = errors_of.map(|(title, y_label, error)| {
        let layers = vec![Layer::level(0.0, &range), error];
        Panel::new(title, y_label, (0.2, 150.0), layers)
    });
    let profile = Panel::new("Profile", "height y (m)", (0.01, 210.0), profile);
    let panels = [profile].into_iter().chain(errors_of);
    let (section, count) = (longest.first()?.0.section, sections().count());
    (to > from).then(|| Page {
        header: header(name, errors, (section, count)),
        axis: Axis::of_places("place along the path, x (m)", range.clone()),
        columns: vec![Column::new(Scale::Own, panels)],
    })
}

/// Pieces of the line of a quantity, without those where points are missing.
fn lines(
    points: &[ComparedPoint],
    value: impl Fn(&ComparedPoint) -> Option<f64>,
) -> Vec<Vec<Point>> {
    let pieces = points.chunk_by(|(a, _), (b, _)| (a.x - b.x).abs() <= GAP);
    let point = |p: &ComparedPoint| Some((p.0.x, value(p)?));
    pieces
        .map(|piece| piece.iter().filter_map(point).collect())
        .collect()
}

/// A quantity, with two standard deviations around a centre.
fn estimate(
    points: &[ComparedPoint],
    get: impl Fn(&ComparedPoint) -> Option<(f64, f64, f64)>,
) -> Layer {
    let bound = |side: f64| {
        lines(points, |p| {
            get(p).map(|(_, centre, sigma)| centre + side * sigma)
        })
    };
    let bounds = bound(-2.0).into_iter().zip(bound(2.0));
    let area = |(low, high): (Vec<Point>, Vec<Point>)| {
        low.into_iter().chain(high.into_iter().rev()).collect()
    };
    let lines = lines(points, |p| get(p).map(|(value, ..)| value));
    Layer::banded(lines, bounds.map(area).collect(), TERRAIN)
}

fn header(name: &str, errors: Option<GroundErrors>, (section, count): (u32, usize)) -> Header {
    let mut subtitle =
        "origin: the middle wheel's contact at the start; x and y have different scales".to_owned();
    if count > 1 {
        subtitle.push_str(&format!("; section {section} of {count}"));
    }
    let truth = errors.map(|_| Entry::new(Mark::line(truth_line()), "true"));
    let estimated = match errors {
        Some(errors) => format!("estimated: RMSE {:.2} mm", MM * errors.height_rmse_m),
        None => "estimated".to_owned(),
    };
    let estimated = Entry::new(Mark::line(estimate_line(TERRAIN)), estimated);
    let band = Entry::new(Mark::area(band_color(TERRAIN)), "two standard deviations");
    Header {
        title: format!("The ground that the wheels have passed, estimator {name}"),
        subtitle,
        key: truth.into_iter().chain([estimated, band]).collect(),
    }
}
