//! The figure of the study: needed friction and slip on `smooth`, steepest ramps.

use super::{DRIVES, Drive, Trip, followed, load, steepest_ramp};
use plotters::coord::Shift;
use plotters::prelude::*;
use rayon::prelude::*;
use std::error::Error;
use std::path::Path;

/// Colours of the drives: vermilion, bluish green and blue of Okabe and Ito.
const COLOURS: [RGBColor; 3] = [
    RGBColor(0xD5, 0x5E, 0x00),
    RGBColor(0x00, 0x9E, 0x73),
    RGBColor(0x00, 0x72, 0xB2),
];
const NAMES: [&str; 3] = ["speed, PI", "speed, soft", "shared"];
const FONT: &str = "Helvetica, Arial, sans-serif";
const SIZE: (u32, u32) = (1320, 560);
/// Way over which the largest value is shown, m: peaks stay visible.
const WAY: f64 = 0.01;

type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;
/// Travel (m) and a value there.
type Line = Vec<(f64, f64)>;

/// Needed friction and slip (m) of a drive over the travel of `smooth`.
fn lines(drive_keys: Drive) -> [Line; 2] {
    let (mut needed, mut slip): (Line, Line) = (Vec::new(), Vec::new());
    let mut next = 0.0;
    followed(
        &load("smooth", drive_keys, &[]),
        f64::INFINITY,
        &mut |trip: &Trip| match needed.last_mut() {
            Some((_, largest)) if trip.travel < next => *largest = largest.max(trip.needed_now),
            _ => {
                needed.push((trip.travel, trip.needed_now));
                slip.push((trip.travel, trip.slip));
                next = trip.travel + WAY;
            }
        },
    );
    [needed, slip]
}

/// A panel with one line for each drive.
fn panel(
    area: &Area<'_>,
    title: &str,
    axes: [&str; 2],
    most: (f64, f64),
    lines: &[&Line],
    points: bool,
) -> Result<(), Box<dyn Error>> {
    let mut chart = ChartBuilder::on(area)
        .caption(title, (FONT, 20))
        .margin(12)
        .x_label_area_size(44)
        .y_label_area_size(58)
        .build_cartesian_2d(0.0..most.0, 0.0..most.1)?;
    chart
        .configure_mesh()
        .light_line_style(TRANSPARENT)
        .bold_line_style(RGBColor(0xE0, 0xE0, 0xE0))
        .x_desc(axes[0])
        .y_desc(axes[1])
        .x_labels(6)
        .y_labels(6)
        .label_style((FONT, 16))
        .axis_desc_style((FONT, 17))
        .draw()?;
    if points {
        let angle = (0..=90).map(|k| {
            let mu = 0.01 * f64::from(k);
            (mu, mu.atan().to_degrees())
        });
        let grey = RGBColor(0xB4, 0xB4, 0xB4);
        chart
            .draw_series(LineSeries::new(angle, grey.stroke_width(4)))?
            .label("friction angle")
            .legend(move |(x, y)| PathElement::new([(x, y), (x + 24, y)], grey.stroke_width(4)));
    }
    for ((line, colour), name) in lines.iter().zip(COLOURS).zip(NAMES) {
        let style = colour.stroke_width(2);
        let series = if points {
            let circles = line
                .iter()
                .map(|at| Circle::new(*at, 7, colour.stroke_width(3)));
            chart.draw_series(circles)?
        } else {
            chart.draw_series(LineSeries::new(line.iter().copied(), style))?
        };
        series
            .label(name)
            .legend(move |(x, y)| PathElement::new([(x, y), (x + 24, y)], colour.stroke_width(4)));
    }
    chart
        .configure_series_labels()
        .position(SeriesLabelPosition::UpperLeft)
        .background_style(WHITE.mix(0.9))
        .border_style(RGBColor(0xE0, 0xE0, 0xE0))
        .label_font((FONT, 16))
        .draw()?;
    Ok(())
}

fn draw(path: &Path) -> Result<(), Box<dyn Error>> {
    let smooth: Vec<[Line; 2]> = DRIVES.par_iter().map(|keys| lines(*keys)).collect();
    let climbed: Vec<Line> = DRIVES
        .par_iter()
        .map(|keys| {
            [0.3, 0.5, 0.8]
                .map(|mu| (mu, steepest_ramp(*keys, mu)))
                .to_vec()
        })
        .collect();
    let root = SVGBackend::new(path, SIZE).into_drawing_area();
    root.fill(&WHITE)?;
    let panels = root.split_evenly((1, 3));
    let needed: Vec<&Line> = smooth.iter().map(|[needed, _]| needed).collect();
    let slip: Vec<&Line> = smooth.iter().map(|[_, slip]| slip).collect();
    let title = "Largest needed friction T/N on smooth";
    panel(
        &panels[0],
        title,
        ["travel, m", "T/N of the worst wheel"],
        (3.8, 1.0),
        &needed,
        false,
    )?;
    let title = "Slip distance on smooth";
    panel(
        &panels[1],
        title,
        ["travel, m", "sum of the wheels, m"],
        (3.8, 0.6),
        &slip,
        false,
    )?;
    let climbed: Vec<&Line> = climbed.iter().collect();
    let axes = ["friction coefficient mu_s", "angle, deg"];
    panel(
        &panels[2],
        "Steepest ramp climbed",
        axes,
        (0.9, 45.0),
        &climbed,
        true,
    )?;
    root.present()?;
    Ok(())
}

#[test]
#[ignore = "a study of some minutes"]
fn figure() {
    let path = std::env::var("ROBHAZ_FIGURE").unwrap_or_else(|_| "driving.svg".to_owned());
    draw(Path::new(&path)).unwrap();
}
