//! The figure of `docs/climbing.md`: the linkages, a robot on the stairs, and the least friction over the riser.

use crate::Outcome;
use crate::limits::{MU, RISER, TREAD, least_mu, load};
use crate::trial::{Control, Trial};
use plotters::coord::Shift;
use plotters::prelude::*;
use robhaz_model::{Bar, Geometry, Pin, Vec2, rotate};
use robhaz_sim::Truth;
use robhaz_terrain::{Profile, Terrain};
use std::path::Path;

/// Colours of body and links: black, vermilion, blue and bluish green of Okabe and Ito.
const COLOURS: [RGBColor; 4] = [
    RGBColor(0x55, 0x55, 0x55),
    RGBColor(0xD5, 0x5E, 0x00),
    RGBColor(0x00, 0x72, 0xB2),
    RGBColor(0x00, 0x9E, 0x73),
];
const GREY: RGBColor = RGBColor(0xB4, 0xB4, 0xB4);
const FONT: &str = "Helvetica, Arial, sans-serif";
const SIZE: (u32, u32) = (1320, 900);
/// Risers of the lower right panel, m.
const RISES: [f64; 6] = [0.03, 0.04, 0.06, 0.08, 0.10, 0.12];
/// Distance that the robot travels between two of its pictures, m.
const APART: f64 = 1.05;

type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;
type Chart<'a, 'b> = ChartContext<
    'a,
    SVGBackend<'b>,
    Cartesian2d<plotters::coord::types::RangedCoordf64, plotters::coord::types::RangedCoordf64>,
>;

/// Where a bar is: its centre of mass (m) and its angle (rad).
type Places = [(Vec2, f64); 4];

fn nominal(geometry: &Geometry) -> Places {
    Bar::ALL.map(|bar| (geometry.cg(bar), 0.0))
}

fn places(truth: &Truth) -> Places {
    let [link1, link2, link3] = truth.links;
    [truth.body, link1, link2, link3].map(|bar| (bar.position, bar.angle))
}

/// Draws a robot.
fn robot(
    chart: &mut Chart<'_, '_>,
    geometry: &Geometry,
    places: &Places,
    labels: bool,
) -> Outcome<()> {
    let at = |bar: Bar, point: Vec2| {
        let (centre, angle) = places[bar as usize];
        let moved = centre + rotate(point - geometry.cg(bar), angle);
        (moved.x, moved.y)
    };
    for (axle, carrier) in geometry.axles.iter().zip(&geometry.carriers) {
        let rim = (0..=60).map(|k| {
            let angle = f64::from(k) * std::f64::consts::TAU / 60.0;
            at(
                carrier.bar(),
                axle + rotate(Vec2::new(geometry.wheel_radius, 0.0), angle),
            )
        });
        chart.draw_series(LineSeries::new(rim, GREY.stroke_width(2)))?;
    }
    for (bar, colour) in Bar::ALL.into_iter().zip(COLOURS) {
        let mut points: Vec<Vec2> = geometry.outline_points(bar).collect();
        if bar == Bar::Body {
            let pins = [Pin::P, Pin::S].map(|pin| geometry.pins.get(pin));
            let (low, high) = (geometry.outline.body_lower, geometry.outline.body_upper);
            let frame = [
                low,
                Vec2::new(high.x, low.y),
                high,
                Vec2::new(low.x, high.y),
                low,
            ];
            let line = frame.map(|point| at(bar, point));
            chart.draw_series(LineSeries::new(line, colour.stroke_width(2)))?;
            points = pins.to_vec();
        }
        points.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
        let line = points.into_iter().map(|point| at(bar, point));
        chart.draw_series(LineSeries::new(line, colour.stroke_width(4)))?;
    }
    for pin in Pin::ALL {
        let place = at(pin.bars().0, geometry.pins.get(pin));
        chart.draw_series([Circle::new(place, 4, BLACK.filled())])?;
        if labels {
            let name = pin.name().to_uppercase();
            let style = (FONT, 17).into_font();
            chart.draw_series([Text::new(name, (place.0 + 0.012, place.1 + 0.035), style)])?;
        }
    }
    Ok(())
}

/// A chart with equal scales of both axes: `width` m from x = `from` on.
fn to_scale<'a, 'b>(
    area: &'a Area<'b>,
    title: &str,
    from: f64,
    width: f64,
) -> Outcome<Chart<'a, 'b>> {
    let (columns, rows) = area.dim_in_pixel();
    // Without margins, title and labels.
    let height = width * (f64::from(rows) - 104.0) / (f64::from(columns) - 82.0);
    let mut chart = ChartBuilder::on(area)
        .caption(title, (FONT, 20))
        .margin(12)
        .x_label_area_size(44)
        .y_label_area_size(58)
        .build_cartesian_2d(from..from + width, -0.04..height - 0.04)?;
    chart
        .configure_mesh()
        .light_line_style(TRANSPARENT)
        .bold_line_style(RGBColor(0xEE, 0xEE, 0xEE))
        .x_desc("x, m")
        // Without the sign of a zero that is rounded.
        .x_label_formatter(&|x| format!("{:.1}", (10.0 * x).round() / 10.0 + 0.0))
        .y_desc("y, m")
        .label_style((FONT, 16))
        .axis_desc_style((FONT, 17))
        .draw()?;
    Ok(chart)
}

/// Pictures of a robot on its way up the stairs.
fn on_the_stairs(area: &Area<'_>, name: &str, geometry: &Geometry) -> Outcome<()> {
    let title = format!("Geometry {name} on stairs of 80 mm, mu = 0.8, speed control PI");
    let mut chart = to_scale(area, &title, -0.55, 3.3)?;
    let ground = Terrain::new(Profile::stairs()).outline(-0.55, 2.75, 0.01);
    let ground = ground.into_iter().map(|p| (p.x, p.y));
    chart.draw_series(LineSeries::new(ground, BLACK.stroke_width(2)))?;
    let trial = Trial {
        control: Control::Pi,
        mu: MU,
        rise: RISER,
        run: TREAD,
    };
    let (mut pictures, mut next) = (Vec::new(), 0.0);
    trial.followed(geometry, &mut |truth| {
        let x = truth.wheels[1].position.x;
        if x >= next {
            pictures.push(places(truth));
            next = x + APART;
        }
    })?;
    for picture in pictures {
        robot(&mut chart, geometry, &picture, false)?;
    }
    Ok(())
}

/// Least mu over the height of the riser.
fn least_friction(area: &Area<'_>, robots: &[(String, Geometry)]) -> Outcome<()> {
    let mut chart = ChartBuilder::on(area)
        .caption("Least friction coefficient that climbs", (FONT, 20))
        .margin(12)
        .x_label_area_size(44)
        .y_label_area_size(58)
        .build_cartesian_2d(20.0..130.0, 0.0..1.25)?;
    chart
        .configure_mesh()
        .light_line_style(TRANSPARENT)
        .bold_line_style(RGBColor(0xE0, 0xE0, 0xE0))
        .x_desc("riser, mm (tread 300 mm)")
        .x_label_formatter(&|x| format!("{x:.0}"))
        .y_desc("mu_s")
        .label_style((FONT, 16))
        .axis_desc_style((FONT, 17))
        .draw()?;
    let lines = robots
        .iter()
        .flat_map(|robot| [Control::Pi, Control::Soft].map(|control| (robot, control)));
    for (((name, geometry), control), colour) in lines.zip(COLOURS) {
        let points: Vec<(f64, f64)> = RISES
            .iter()
            .filter_map(|rise| Some((1e3 * rise, least_mu(geometry, control, *rise, TREAD)?)))
            .collect();
        let style = colour.stroke_width(3);
        chart
            .draw_series(LineSeries::new(points.iter().copied(), style).point_size(5))?
            .label(format!("{name}, {}", control.name()))
            .legend(move |(x, y)| PathElement::new([(x, y), (x + 24, y)], style));
    }
    chart
        .configure_series_labels()
        .position(SeriesLabelPosition::LowerRight)
        .background_style(WHITE.mix(0.9))
        .border_style(RGBColor(0xE0, 0xE0, 0xE0))
        .label_font((FONT, 16))
        .draw()?;
    Ok(())
}

/// Draws the figure of geometries; the last one is shown on the stairs.
pub fn draw(file: &Path, names: &[&str]) -> Outcome<()> {
    let robots: Vec<(String, Geometry)> = names
        .iter()
        .map(|name| Ok((short(name), load(name)?)))
        .collect::<Outcome<_>>()?;
    let Some((last, shown)) = robots.last() else {
        return Err("no geometry".into());
    };
    let root = SVGBackend::new(file, SIZE).into_drawing_area();
    root.fill(&WHITE)?;
    let (top, bottom) = root.split_vertically(470);
    on_the_stairs(&top, last, shown)?;
    let (linkage, friction) = bottom.split_horizontally(700);
    let title = format!("Geometry {last}");
    let mut chart = to_scale(&linkage, &title, -0.62, 1.24)?;
    robot(&mut chart, shown, &nominal(shown), true)?;
    least_friction(&friction, &robots)?;
    root.present()?;
    Ok(())
}

/// Name of a geometry in the figure: `C` of `robots/geometry-c.toml`.
fn short(name: &str) -> String {
    let stem = Path::new(name).file_stem().and_then(|s| s.to_str());
    let letter = stem.and_then(|s| s.strip_prefix("geometry-"));
    letter.map_or_else(|| name.to_owned(), str::to_uppercase)
}
