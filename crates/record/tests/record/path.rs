//! The robot on the ground.

use crate::drawn::{Pixel, areas, lines};
use crate::testing::{Record, described, failed_frame, scene};
use plotters::style::RGBColor;
use robhaz_model::Vec2;
use robhaz_record::FigureSink;
use robhaz_record::figures::style::WHEELS;
use robhaz_run::Sink;
use robhaz_sim::{ContactTruth, Truth};

/// A robot on level ground, every wheel with its mean load.
fn pose(x: f64) -> Truth {
    let robot = described(&scene()).robot.robot;
    let load = robot.mean_wheel_load();
    let mut truth = Truth::default();
    truth.body.position = Vec2::new(x, 0.3);
    for (wheel, axle) in truth.wheels.iter_mut().zip([0.35, 0.0, -0.35]) {
        wheel.position = Vec2::new(x + axle, robot.geometry.wheel_radius);
        wheel.normal_force = load;
        wheel.contacts = 1;
        wheel.force = Vec2::new(0.0, load);
        wheel.contact_list.push(ContactTruth {
            point: Vec2::new(x + axle, 0.0),
            normal: Vec2::y(),
            normal_force: load,
            ..ContactTruth::default()
        });
    }
    truth
}

/// The figure of the path through these places.
fn path(places: impl Iterator<Item = f64>) -> String {
    let folder = tempfile::tempdir().expect("a folder");
    let mut sink = FigureSink::new(folder.path());
    sink.begin(&described(&scene())).expect("begins");
    for (k, x) in (0_u32..).zip(places) {
        let time = f64::from(k) / 100.0;
        let truth = Truth { time, ..pose(x) };
        let record = Record {
            truth,
            ..failed_frame(time)
        };
        sink.frame(&record.frame()).expect("a record");
    }
    sink.end(None).expect("ends");
    std::fs::read_to_string(folder.path().join("path.svg")).expect("a figure")
}

/// The outlines of a wheel.
fn circles(svg: &str, color: RGBColor) -> Vec<Vec<Pixel>> {
    let mut lines = lines(svg, color);
    lines.retain(|line| line.len() == 65 && line.first() == line.last());
    lines
}

/// Lowest and highest of some numbers.
fn extremes(numbers: impl Iterator<Item = i32> + Clone) -> (i32, i32) {
    let low = numbers.clone().min().expect("a number");
    (low, numbers.max().expect("a number"))
}

/// Closed form: on level ground the arrow of N points up, its tip is where the wheel touches, and
/// for a mean load it is 0.12 m long, as the key says.
#[test]
fn the_arrow_of_a_normal_force_ends_at_the_contact() {
    let svg = path([2.0, 2.0].into_iter());
    for color in WHEELS {
        let circle = &circles(&svg, color)[0];
        let (left, right) = extremes(circle.iter().map(|p| p.0));
        let (_, bottom) = extremes(circle.iter().map(|p| p.1));
        let head = &areas(&svg, color)[0];
        let tip = head.iter().min_by_key(|p| p.1).expect("a corner");
        // Rounded to units of the drawing.
        assert!((tip.0 - (left + right) / 2).abs() <= 1 && (tip.1 - bottom).abs() <= 1);
        let shaft = lines(&svg, color).into_iter().find(|line| {
            line.len() == 2 && line[0].0 == line[1].0 && line[0].1 > bottom && line[1].1 > bottom
        });
        let foot = shaft.expect("an arrow")[0];
        let length = f64::from(foot.1 - tip.1) / f64::from(right - left) * 0.2;
        assert!(
            (foot.0 - tip.0).abs() <= 1 && (length - 0.12).abs() < 1e-3,
            "{length}"
        );
    }
}

/// Robots do not overlap: they are 0.2 m high at the wheels and stand 0.85 m apart. One that does
/// not move is drawn once.
#[test]
fn robots_stand_apart() {
    let svg = path((0..=40).map(|k| 0.1 * f64::from(k)));
    for color in WHEELS {
        let circles = circles(&svg, color);
        let ends: Vec<_> = circles
            .iter()
            .map(|c| extremes(c.iter().map(|p| p.0)))
            .collect();
        assert_eq!(ends.len(), 5);
        for pair in ends.windows(2) {
            let metres = f64::from(pair[1].0 - pair[0].0) / f64::from(pair[0].1 - pair[0].0) * 0.2;
            assert!(metres > 0.85 && metres < 0.95, "{metres}");
        }
    }
    let svg = path([1.0, 1.0].into_iter());
    assert_eq!(circles(&svg, WHEELS[0]).len(), 1);
}
