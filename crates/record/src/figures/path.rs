//! The robot on the ground, and N over the position of the wheels.

use super::files::{Drawn, Picture};
use super::header::{Entry, Header, MARGIN, Mark, WIDTH, write};
use super::page::whole;
use super::panel::{Axis, Layer, PANEL_TITLE, Panel, X_LABELS, Y_LABELS, tick};
use super::run::RunTraces;
use super::strips::{MEAN_LOAD_LENGTH, SPACING, Strip, robots, strips};
use super::style::{
    GROUND, ROBOT, SURFACE, WHEELS, frame_line, grid_line, line, text, units, upward_text,
};
use super::trace::{Point, Trace};
use plotters::coord::Shift;
use plotters::coord::types::RangedCoordf64;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, VPos};
use robhaz_model::{Bar, Pin, Vec2};
use robhaz_sim::{ContactTruth, Truth, WheelTruth};
use robhaz_terrain::Terrain;

/// Longest arrow, m: the arrow of an impact must stay in the picture.
const LONGEST: f64 = 3.0 * MEAN_LOAD_LENGTH;
/// Ground shown beside the wheels, m.
const BESIDE: f64 = 0.15;
/// Room for the labels below a strip, px.
const STRIP_LABELS: f64 = 38.0;

type Chart<'a, DB> = ChartContext<'a, DB, Cartesian2d<RangedCoordf64, RangedCoordf64>>;

/// The figure of the path.
pub struct Path<'a> {
    header: Header,
    run: &'a RunTraces,
    ground: &'a Terrain,
    /// The robots that are drawn.
    robots: Vec<&'a Truth>,
    strips: Vec<Strip>,
    /// px in a metre.
    scale: f64,
    /// N over the position of the wheels.
    axis: Axis,
    panel: Panel<'a>,
}

/// The figure of a run's path; `None` without ground or pose, as for recorded readings.
pub fn path(run: &RunTraces) -> Option<Path<'_>> {
    let ground = run.ground.as_ref()?;
    let wheels = || run.poses.iter().flat_map(|pose| &pose.wheels);
    let first = wheels().map(|w| w.position.x).fold(f64::INFINITY, f64::min);
    let last = wheels()
        .map(|w| w.position.x)
        .fold(f64::NEG_INFINITY, f64::max);
    if first > last {
        return None;
    }
    let reach = first - BESIDE..last + BESIDE;
    let width = plot_width();
    let (strips, scale) = strips(&run.poses, ground, &reach, width);
    let arrow = MEAN_LOAD_LENGTH * scale;
    let mut key: Vec<Entry> = ["front wheel", "middle wheel", "rear wheel"]
        .into_iter()
        .zip(WHEELS)
        .map(|(name, color)| Entry::new(Mark::Line(line(color, 1.8)), name))
        .collect();
    let label = format!("N at the contact, {:.0} N", run.mean_load);
    key.push(Entry::new(Mark::Arrow(line(ROBOT, 1.6), arrow), label));
    Some(Path {
        header: Header {
            title: "The robot on the ground, and its true normal forces".to_owned(),
            subtitle:
                "lines through the robots: paths of the wheels' centres; equal scales of x and y"
                    .to_owned(),
            key,
        },
        run,
        ground,
        robots: robots(&run.poses, reach.end - reach.start),
        strips,
        scale,
        axis: Axis {
            label: "place of the wheel's centre, x (m)",
            range: reach.clone(),
            compare_from: reach.start,
        },
        panel: Panel {
            title: "Normal force over the place of each wheel".to_owned(),
            note: String::new(),
            y_label: "normal force N (N)",
            least_span: 2.0,
            logarithmic: false,
            height: 190.0,
            layers: run
                .normal_force_at
                .iter()
                .zip(WHEELS)
                .map(|(trace, color)| Layer::Colored(trace, color))
                .collect(),
        },
    })
}

fn plot_width() -> f64 {
    f64::from(WIDTH) - 2.0 * MARGIN - Y_LABELS - 2.0
}

impl Picture for Path<'_> {
    fn size(&self) -> (u32, u32) {
        let strips: f64 = self.strips.iter().map(|s| self.height(s)).sum();
        let panel = PANEL_TITLE + self.panel.height + X_LABELS;
        (
            WIDTH,
            whole(self.header.bottom() + strips + panel + 0.5 * MARGIN),
        )
    }

    fn draw<DB>(&self, page: &DrawingArea<DB, Shift>) -> Drawn
    where
        DB: DrawingBackend,
        DB::ErrorType: 'static,
    {
        self.header.draw(page)?;
        let width = units(f64::from(WIDTH) - 2.0 * MARGIN);
        let mut top = self.header.bottom();
        for strip in &self.strips {
            let height = self.height(strip);
            let corner = (units(MARGIN), units(top));
            let area = page.clone().shrink(corner, (width, units(height)));
            self.draw_strip(&area, strip)?;
            top += height;
        }
        let height = PANEL_TITLE + self.panel.height + X_LABELS;
        let corner = (units(MARGIN), units(top));
        let area = page.clone().shrink(corner, (width, units(height)));
        let range = Panel::shared_range(std::slice::from_ref(&self.panel), &self.axis);
        self.panel.draw(&area, &self.axis, &range, true)
    }
}

impl Path<'_> {
    /// Height of a strip with its labels, px.
    fn height(&self, strip: &Strip) -> f64 {
        self.scale * (strip.y.end - strip.y.start) + STRIP_LABELS
    }

    fn draw_strip<DB>(&self, area: &DrawingArea<DB, Shift>, strip: &Strip) -> Drawn
    where
        DB: DrawingBackend,
        DB::ErrorType: 'static,
    {
        let mut chart = ChartBuilder::on(area)
            .margin_right(units(2.0))
            .set_label_area_size(LabelAreaPosition::Left, units(Y_LABELS))
            .set_label_area_size(LabelAreaPosition::Bottom, units(STRIP_LABELS))
            .build_cartesian_2d(strip.x.clone(), strip.y.clone())?;
        chart
            .configure_mesh()
            .light_line_style(TRANSPARENT)
            .bold_line_style(grid_line())
            .axis_style(frame_line())
            .x_labels(11)
            .y_labels(5)
            .x_label_formatter(&tick)
            .y_label_formatter(&tick)
            .label_style(text(11.5, FontStyle::Normal, HPos::Center, VPos::Center))
            .set_all_tick_mark_size(units(4.0))
            .draw()?;
        self.draw_ground(&mut chart, strip)?;
        self.draw_paths(&mut chart, strip)?;
        for robot in &self.robots {
            if strip.x.contains(&robot.body.position.x) {
                self.draw_robot(&mut chart, robot)?;
            }
        }
        let plot = self.scale * (strip.y.end - strip.y.start);
        let name = text(12.5, FontStyle::Normal, HPos::Center, VPos::Bottom);
        let middle = Y_LABELS + 0.5 * plot_width();
        write(area, "x (m)", (middle, plot + STRIP_LABELS - 3.0), name)?;
        write(area, "y (m)", (9.0, 0.5 * plot), upward_text(12.0))
    }

    fn draw_ground<DB>(&self, chart: &mut Chart<'_, DB>, strip: &Strip) -> Drawn
    where
        DB: DrawingBackend,
        DB::ErrorType: 'static,
    {
        let surface = reduced(&self.ground.outline(strip.x.start, strip.x.end, SPACING));
        let mut area = surface.clone();
        area.extend([(strip.x.end, strip.y.start), (strip.x.start, strip.y.start)]);
        chart.draw_series([Polygon::new(area, GROUND.filled())])?;
        chart.draw_series([PathElement::new(surface, line(SURFACE, 1.6))])?;
        Ok(())
    }

    /// The paths of the three centres nearly coincide: the later ones are thinner.
    fn draw_paths<DB>(&self, chart: &mut Chart<'_, DB>, strip: &Strip) -> Drawn
    where
        DB: DrawingBackend,
        DB::ErrorType: 'static,
    {
        for (i, width) in [3.0, 1.8, 0.8].into_iter().enumerate() {
            let centres = self.run.poses.iter().map(|pose| pose.wheels[i].position);
            let path: Vec<_> = centres.collect();
            for part in path.chunk_by(|a, b| strip.x.contains(&a.x) == strip.x.contains(&b.x)) {
                if part.iter().all(|p| strip.x.contains(&p.x)) {
                    let part: Vec<_> = part.iter().map(pair).collect();
                    chart.draw_series([PathElement::new(part, line(WHEELS[i], width))])?;
                }
            }
        }
        Ok(())
    }

    fn draw_robot<DB>(&self, chart: &mut Chart<'_, DB>, robot: &Truth) -> Drawn
    where
        DB: DrawingBackend,
        DB::ErrorType: 'static,
    {
        let body = self.body(robot);
        chart.draw_series([Polygon::new(body.clone(), WHITE.filled())])?;
        chart.draw_series([PathElement::new(body, line(ROBOT, 1.0))])?;
        let radius = self.run.geometry.wheel_radius;
        for (wheel, color) in robot.wheels.iter().zip(WHEELS) {
            chart.draw_series([PathElement::new(circle(wheel, radius), line(color, 1.6))])?;
        }
        for bar in [Bar::Link1, Bar::Link2, Bar::Link3] {
            chart.draw_series([PathElement::new(self.link(robot, bar), line(ROBOT, 2.0))])?;
        }
        for (wheel, color) in robot.wheels.iter().zip(WHEELS) {
            for contact in wheel.contact_list.iter() {
                let length = contact.normal_force / self.run.mean_load * MEAN_LOAD_LENGTH;
                let (shaft, head) = arrow(contact, length.min(LONGEST), 7.0 / self.scale);
                chart.draw_series([PathElement::new(shaft, line(color, 1.6))])?;
                chart.draw_series([Polygon::new(head, color.filled())])?;
            }
        }
        let parts = robot.pins.iter().map(|p| p.position.y);
        let top = parts.fold(robot.body.position.y, f64::max);
        let place = (robot.body.position.x, top + 0.05);
        let style = text(11.0, FontStyle::Normal, HPos::Center, VPos::Bottom);
        let label = format!("{:.1} s", robot.time);
        chart.draw_series([Text::new(label, place, style)])?;
        Ok(())
    }

    /// The closed outline of the body: its pins and its centre of mass.
    fn body(&self, robot: &Truth) -> Vec<(f64, f64)> {
        let pins = pins_of(Bar::Body).map(|pin| robot.pin(pin).position);
        let mut corners: Vec<_> = pins.chain([robot.body.position]).collect();
        corners.extend(corners.first().copied());
        corners.iter().map(pair).collect()
    }

    /// A link as a line through its own pins and axles, from rear to front of the nominal pose.
    fn link(&self, robot: &Truth, bar: Bar) -> Vec<(f64, f64)> {
        let geometry = &self.run.geometry;
        let pins = pins_of(bar).map(|pin| (geometry.pins.get(pin).x, robot.pin(pin).position));
        let axles = (0..3)
            .filter(|i| geometry.carriers[*i].bar() == bar)
            .map(|i| (geometry.axles[i].x, robot.wheels[i].position));
        let mut points: Vec<_> = pins.chain(axles).collect();
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        points.iter().map(|(_, position)| pair(position)).collect()
    }
}

fn pins_of(bar: Bar) -> impl Iterator<Item = Pin> {
    let on_bar = move |pin: &Pin| pin.bars().0 == bar || pin.bars().1 == bar;
    Pin::ALL.into_iter().filter(on_bar)
}

/// A line over x at the resolution of a figure: its ends, and the extremes between. A short one is kept whole.
fn reduced(line: &[Vec2]) -> Vec<Point> {
    let mut trace = Trace::new(line.len() as u64);
    for point in line {
        trace.add(point.x, Some(point.y));
    }
    let mut points = trace.extremes().concat();
    if let (Some(first), Some(last)) = (line.first().map(pair), line.last().map(pair)) {
        if points.first() != Some(&first) {
            points.insert(0, first);
        }
        if points.last() != Some(&last) {
            points.push(last);
        }
    }
    points
}

fn pair(point: &Vec2) -> (f64, f64) {
    (point.x, point.y)
}

fn circle(wheel: &WheelTruth, radius: f64) -> Vec<(f64, f64)> {
    let at = |k: u32| {
        let (sin, cos) = (std::f64::consts::TAU * f64::from(k) / 64.0).sin_cos();
        pair(&(wheel.position + Vec2::new(cos, sin) * radius))
    };
    (0..=64).map(at).collect()
}

/// Shaft and head of an arrow along a contact's normal whose tip is at the contact, m.
fn arrow(contact: &ContactTruth, length: f64, head: f64) -> ([Point; 2], Vec<Point>) {
    let (tip, normal) = (contact.point, contact.normal);
    let tangent = Vec2::new(normal.y, -normal.x);
    let foot = tip - normal * length;
    let neck = tip - normal * head;
    let corners = [
        tip,
        neck + tangent * (0.5 * head),
        neck - tangent * (0.5 * head),
    ];
    (
        [pair(&foot), pair(&neck)],
        corners.iter().map(pair).collect(),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Property: the ground of a short path keeps its points, that of a long one its ends and its highest point.
    #[test]
    fn the_ground_of_a_long_path_is_reduced() {
        let wave = |k: u32| Vec2::new(0.005 * f64::from(k), (0.1 * f64::from(k)).sin());
        let short: Vec<Vec2> = (0..1200).map(wave).collect();
        let whole: Vec<Point> = short.iter().map(pair).collect();
        assert_eq!(reduced(&short), whole);
        let mut long: Vec<Vec2> = (0..100_000).map(wave).collect();
        long[54_321].y = 9.0;
        let points = reduced(&long);
        assert!(points.len() <= 1202 && points.is_sorted_by(|a, b| a.0 < b.0));
        assert!(points.contains(&pair(&long[54_321])));
        assert_eq!(points.first(), long.first().map(pair).as_ref());
        assert_eq!(points.last(), long.last().map(pair).as_ref());
    }

    /// Closed form: on level ground the arrow of N points up, and its tip is where the wheel touches.
    #[test]
    fn the_arrow_of_a_normal_force_ends_at_the_contact() {
        let contact = ContactTruth {
            point: Vec2::new(2.0, 0.0),
            normal: Vec2::y(),
            ..ContactTruth::default()
        };
        let ([foot, _], head) = arrow(&contact, 0.3, 0.02);
        assert!((foot.0 - 2.0).abs() < 1e-12 && (foot.1 + 0.3).abs() < 1e-12);
        assert!((head[0].0 - 2.0).abs() < 1e-12 && head[0].1.abs() < 1e-12);
    }
}
