//! Structure of the files: their names, texts, numbers of lines and areas.

use crate::testing::{Record, described, frame_of, log, records, scene};
use plotters::style::RGBColor;
use robhaz_record::FigureSink;
use robhaz_record::figures::style;
use robhaz_run::{Frame, RunDescription, Sink};
use robhaz_scene::Scene;
use std::collections::BTreeMap;

/// Files of a folder: their names and bytes.
type Files = BTreeMap<String, Vec<u8>>;

/// Draws some records of a scene.
fn draw_scene(scene: &Scene, records: &[Record]) -> Files {
    draw_run(&described(scene), records.iter().map(Record::frame))
}

/// Draws the records of a run.
fn draw_run<'a>(run: &RunDescription, frames: impl Iterator<Item = Frame<'a>>) -> Files {
    let folder = tempfile::tempdir().expect("a folder");
    let mut sink = FigureSink::new(&folder.path().join("figures"));
    sink.begin(run).expect("begins");
    for frame in frames {
        sink.frame(&frame).expect("a record");
    }
    sink.end(None).expect("ends");
    std::fs::read_dir(folder.path().join("figures"))
        .expect("files")
        .map(|entry| {
            let path = entry.expect("a file").path();
            let name = path.file_name().expect("a name").to_string_lossy();
            let bytes = std::fs::read(&path).expect("bytes");
            (name.into_owned(), bytes)
        })
        .collect()
}

/// The records of the test scene; its last estimator states a standard deviation of 1 N.
fn banded_records() -> Vec<Record> {
    let mut records = records();
    for record in &mut records {
        if let Some(Ok(estimate)) = record.estimates.last_mut() {
            let mut covariance = [[0.0; 6]; 6];
            (0..6).for_each(|k| covariance[k][k] = 1.0);
            estimate.kalman = Some(robhaz_estimator::KalmanReport {
                covariance,
                ..Default::default()
            });
        }
    }
    records
}

/// The SVG files of the test scene's first records.
fn draw(records: usize) -> BTreeMap<String, String> {
    let all = banded_records();
    let files = draw_scene(&scene(), &all[..records.min(all.len())]);
    let svgs = files.into_iter().filter(|(name, _)| name.ends_with(".svg"));
    svgs.map(|(name, bytes)| (name, String::from_utf8(bytes).expect("text")))
        .collect()
}

#[test]
fn every_figure_is_there() {
    let names: Vec<_> = draw_scene(&scene(), &records()).into_keys().collect();
    let stems = [
        "fig5_linkage",
        "fig6_forces",
        "fig7_paper-body",
        "normal_force_mine",
        "normal_force_true-mass",
        "path",
    ];
    assert_eq!(names, stems.map(|stem| format!("{stem}.svg")));
    let estimators = ["paper-body", "true-mass", "mine"];
    let can_write = |name: &str| FigureSink::can_write(name, &estimators);
    assert!(names.iter().all(|name| can_write(name)));
    for other in [
        "notes.txt",
        "fig5.svg",
        "mine.pdf",
        "path.png",
        "fig7_thesis.svg",
        "comparison.svg",
    ] {
        assert!(!can_write(other), "{other}");
    }
}

/// Recorded readings: the figures show the estimates alone; there is none of the path.
#[test]
fn without_truth_the_estimates_are_drawn_alone() {
    let records = banded_records();
    let files = draw_run(&log(), records.iter().map(Record::without_truth));
    let names: Vec<&str> = files.keys().map(String::as_str).collect();
    let stems = [
        "fig5_linkage",
        "fig6_forces",
        "fig7_paper-body",
        "normal_force_mine",
        "normal_force_true-mass",
    ];
    assert_eq!(names, stems.map(|stem| format!("{stem}.svg")));
    for (name, bytes) in files.iter().filter(|(name, _)| name.ends_with(".svg")) {
        let svg = String::from_utf8_lossy(bytes);
        assert_well_formed(name, &svg);
        assert!(svg.contains("estimated ("), "{name}");
        for word in [
            "\ntrue\n",
            "RMSE",
            "error",
            "NaN",
            "inf",
            &stroke(style::TRUTH),
        ] {
            assert!(!svg.contains(word), "{name}: {word}");
        }
    }
}

/// An estimator that the user calls `paper-body`, but which is another, is not the paper's Fig. 7.
#[test]
fn a_label_does_not_make_an_estimator_the_papers() {
    let mut scene = scene();
    scene.estimators[0].name = "mine".to_owned();
    scene.estimators[2].name = "paper-body".to_owned();
    let files = draw_scene(&scene, &records());
    let text = |name: &str| String::from_utf8_lossy(&files[name]).into_owned();
    assert!(text("fig7_mine.svg").contains("Fig. 7"));
    assert!(!text("normal_force_paper-body.svg").contains("Fig."));
    assert!(!files.contains_key("fig7_paper-body.svg"));
}

/// Every tag that opens is closed in its turn, and attributes stand in pairs of quotes.
fn assert_well_formed(name: &str, svg: &str) {
    let mut open = Vec::new();
    for tag in svg.split('<').skip(1) {
        let (tag, text) = tag.split_once('>').expect("a tag ends");
        assert!(!text.contains('&') || text.contains(';'), "{name}: {text}");
        assert!(tag.matches('"').count().is_multiple_of(2), "{name}: {tag}");
        if let Some(closed) = tag.strip_prefix('/') {
            assert_eq!(open.pop(), Some(closed.to_owned()), "{name}");
        } else if !tag.ends_with('/') {
            open.push(tag.split_whitespace().next().unwrap_or_default().to_owned());
        }
    }
    assert!(open.is_empty(), "{name}: {open:?}");
}

#[test]
fn figures_are_well_formed_and_hold_only_finite_numbers() {
    for (name, svg) in draw(usize::MAX) {
        assert_well_formed(&name, &svg);
        for word in ["NaN", "inf"] {
            assert!(!svg.contains(word), "{name}: {word}");
        }
    }
}

/// Axes have units; key and error are there.
#[test]
fn figures_say_what_they_show() {
    let figures = draw(usize::MAX);
    let expected: [(&str, &[&str]); 3] = [
        (
            "fig5_linkage.svg",
            &[
                "x from Q (mm)",
                "y from Q (mm)",
                "Pin S",
                "RMSE 0.00 mm",
                "estimated (true-mass)",
            ],
        ),
        (
            "fig6_forces.svg",
            &[
                "normal force N (N)",
                "traction T (N)",
                "Wheel 2 (middle)",
                "RMSE 1.00 N",
                "RMSE 0.50 N",
                "estimated (true-mass)",
            ],
        ),
        (
            "fig7_paper-body.svg",
            &[
                "Normal forces, linkage mass lumped to the body (as the paper&apos;s Fig. 7)",
                "normal force N (N)",
                "Wheel 3 (rear)",
                "RMSE over the three wheels 2.00 N",
                "estimated (paper-body)",
            ],
        ),
    ];
    for (name, texts) in expected {
        for text in texts.iter().chain(&["time (s)", "true"]) {
            assert!(
                figures[name].contains(&format!("\n{text}")),
                "{name}: {text}"
            );
        }
    }
}

/// True and estimated can be distinguished on a grey print: one is wide, the other thin, and
/// neither is dashed.
#[test]
fn lines_differ_without_colour() {
    for (name, svg) in draw(usize::MAX) {
        if !name.starts_with("fig") {
            continue;
        }
        assert!(!svg.contains("stroke-dasharray"), "{name}");
        let widths = |colors: &[RGBColor]| -> Vec<u32> {
            let strokes: Vec<String> = colors.iter().map(|c| stroke(*c)).collect();
            let lines = svg.lines().filter(|l| l.starts_with("<polyline"));
            let of_colors = lines.filter(|l| strokes.iter().any(|s| l.contains(s)));
            of_colors.map(width).collect()
        };
        let truth = widths(&[style::TRUTH]);
        let estimates = widths(&[style::WHEELS.as_slice(), &[style::LINKAGE]].concat());
        assert!(truth.len() >= 3 && estimates.len() >= 3, "{name}");
        let (thinnest, thickest) = (truth.iter().min(), estimates.iter().max());
        assert!(thinnest > thickest.map(|w| 2 * w).as_ref(), "{name}");
    }
}

fn stroke(RGBColor(r, g, b): RGBColor) -> String {
    format!("stroke=\"#{r:02X}{g:02X}{b:02X}\"")
}

fn fill(RGBColor(r, g, b): RGBColor) -> String {
    format!("fill=\"#{r:02X}{g:02X}{b:02X}\"")
}

fn width(line: &str) -> u32 {
    let (_, rest) = line.split_once("stroke-width=\"").expect("a width");
    let number = rest.split('"').next().expect("a number");
    number.parse().expect("a number")
}

/// Polygons of a colour.
fn areas(svg: &str, color: RGBColor) -> usize {
    let polygons = svg.lines().filter(|l| l.starts_with("<polygon"));
    polygons.filter(|l| l.contains(&fill(color))).count()
}

/// Two standard deviations are an area a wheel around N and one around no error, each with the gap
/// in the estimates; an estimator without a covariance has none.
#[test]
fn a_covariance_is_a_band() {
    let figures = draw(usize::MAX);
    for color in style::WHEELS.map(style::band_color) {
        assert_eq!(areas(&figures["normal_force_mine.svg"], color), 4);
        assert_eq!(areas(&figures["fig7_paper-body.svg"], color), 0);
    }
    let said = |name: &str| figures[name].contains("two standard deviations");
    assert!(said("normal_force_mine.svg") && !said("fig7_paper-body.svg"));
    assert!(figures["normal_force_mine.svg"].contains("error of N (N)"));
}

/// Of a long run the line of an estimate goes through its extremes, so that no peak is lost.
#[test]
fn a_peak_of_a_long_run_is_drawn() {
    let mut scene = scene();
    scene.record.duration = 20.0;
    let mut records: Vec<Record> = (0..=2000).map(|k| frame_of(f64::from(k) / 100.0)).collect();
    let draw = |records: &[Record]| draw_scene(&scene, records)["fig7_paper-body.svg"].clone();
    let calm = draw(&records);
    if let Ok(estimate) = &mut records[1001].estimates[0] {
        estimate.normal_force[0] += 1.0;
    }
    let peaked = draw(&records);
    let lines = |svg: &[u8]| String::from_utf8_lossy(svg).lines().count();
    assert_eq!(lines(&calm), lines(&peaked));
    assert_ne!(calm, peaked);
}

/// The way has ground, robots with three wheels each, and paths of the three centres.
#[test]
fn the_way_shows_ground_robots_and_paths() {
    let svg = &draw(usize::MAX)["path.svg"];
    assert!(areas(svg, style::GROUND) >= 1);
    for color in style::WHEELS {
        let stroke = stroke(color);
        let circles = svg
            .lines()
            .filter(|l| l.starts_with("<polyline") && l.contains(&stroke))
            .filter(|l| l.matches(' ').count() > 64);
        assert!(circles.count() >= 2);
        // Heads of the arrows of N.
        assert!(areas(svg, color) >= 1);
    }
    for text in [
        "x (m)",
        "y (m)",
        "normal force N (N)",
        "0.0 s",
        "arrows: N, 0.12 m are",
    ] {
        assert!(svg.contains(text), "{text}");
    }
}

/// Closed form: the arrows of a robot of four times the size have four times the length.
#[test]
fn arrows_on_the_way_are_in_proportion_to_the_robot() {
    let records = records();
    let mut run = described(&scene());
    for axle in &mut run.robot.robot.geometry.axles {
        *axle *= 4.0;
    }
    let files = draw_run(&run, records.iter().map(Record::frame));
    let svg = String::from_utf8_lossy(&files["path.svg"]);
    assert!(svg.contains("arrows: N, 0.48 m are"));
}

/// Where there was no estimate the line has a gap: two pieces a panel and not one.
#[test]
fn a_gap_in_the_estimates_stays_a_gap() {
    assert!(records().iter().any(|r| r.estimates[0].is_err()));
    let svg = &draw(usize::MAX)["fig7_paper-body.svg"];
    let strokes = style::WHEELS.map(stroke);
    let pieces = svg
        .lines()
        .filter(|l| l.starts_with("<polyline") && strokes.iter().any(|s| l.contains(s)))
        .filter(|l| l.split_whitespace().count() > 15);
    assert_eq!(pieces.count(), 6);
}

/// A run that broke off is drawn as far as it went; one that never began leaves no figures.
#[test]
fn a_broken_run_is_drawn_as_far_as_it_went() {
    let figures = draw(30);
    assert_eq!(figures.len(), 6);
    assert!(figures["fig7_paper-body.svg"].contains("no true forces"));
    for (name, svg) in &figures {
        assert_well_formed(name, svg);
    }
    assert!(draw(0).is_empty());
}

#[test]
fn the_same_records_leave_the_same_figures() {
    let draw = || draw_scene(&scene(), &records());
    assert_eq!(draw(), draw());
}
