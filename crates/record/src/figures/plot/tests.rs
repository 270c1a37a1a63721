//! Figures of datasets that are known in closed form.

use super::chart::{Chart, Point, Shape};
use super::*;
use crate::dataset::{DatasetColumn, DatasetValues};
use robhaz_scene::{SceneError, StudyChoice};

const AXES: &str = "scene = \"flat.toml\"\n[[axis]]\nkeys = [\"drive.speed\", \"record.duration\"]\nvalues = [[0.1, 9], [0.2, 5], \
    [0.4, 3]]\n[[axis]]\nkey = \"terrain.kind\"\nvalues = [\"flat\", \"step\"]\n[[axis]]\nkey = \"seed\"\ncount = 21\n";
/// Three speeds, two grounds, 21 seeds.
const RUNS: usize = 3 * 2 * 21;

type Numbers = Vec<Option<f64>>;

fn numbers(name: &str, unit: &str, values: Numbers) -> DatasetColumn {
    DatasetColumn {
        name: name.to_owned(),
        unit: unit.to_owned(),
        description: format!("what {name} means"),
        values: DatasetValues::Numbers(values),
    }
}

fn words(name: &str, values: Vec<Option<&str>>) -> DatasetColumn {
    let words = values.into_iter().map(|w| w.map(str::to_owned));
    DatasetColumn {
        name: name.to_owned(),
        unit: String::new(),
        description: format!("what {name} means"),
        values: DatasetValues::Words(words.collect()),
    }
}

/// Estimators `one` and `two` with nrmse = speed + seed / 1000 and twice as much; `two` states half of its error. Runs with
/// an index in `failed` fail.
fn dataset(failed: std::ops::Range<usize>) -> Result<Dataset, SceneError> {
    let speeds = [0.1, 0.2, 0.4];
    let mut rows = Vec::new();
    for run in 0..RUNS {
        let of = |factor: f64| {
            let value = speeds[run / 42] + (run % 21) as f64 / 1000.0;
            (!failed.contains(&run)).then_some(factor * value)
        };
        rows.push((run, Some("one"), of(1.0), None));
        match failed.contains(&run) {
            true => {
                *rows.last_mut().unwrap_or(&mut (0, None, None, None)) = (run, None, None, None)
            }
            false => rows.push((run, Some("two"), of(2.0), of(1.0))),
        }
    }
    let of_run = |of: fn(usize) -> f64| rows.iter().map(|r| Some(of(r.0))).collect::<Numbers>();
    let error = |r: &(usize, Option<&'static str>, Option<f64>, Option<f64>)| {
        r.1.is_none().then_some("it cannot stand")
    };
    Ok(Dataset {
        columns: vec![
            numbers("index", "", of_run(|run| run as f64)),
            numbers(
                "drive.speed",
                "m/s",
                of_run(|run| [0.1, 0.2, 0.4][run / 42]),
            ),
            numbers(
                "record.duration",
                "s",
                of_run(|run| [9.0, 5.0, 3.0][run / 42]),
            ),
            words(
                "terrain.kind",
                rows.iter()
                    .map(|r| Some(["flat", "step"][r.0 / 21 % 2]))
                    .collect(),
            ),
            numbers("seed", "", of_run(|run| (run % 21) as f64)),
            words("estimator", rows.iter().map(|r| r.1).collect()),
            numbers("nrmse", "", rows.iter().map(|r| r.2).collect()),
            numbers("stated", "", rows.iter().map(|r| r.3).collect()),
            numbers(
                "coverage",
                "",
                rows.iter().map(|r| r.3.map(|_| 0.7)).collect(),
            ),
            words("error", rows.iter().map(error).collect()),
        ],
        study: StudyChoice::parse(AXES, "known.toml")?,
        runs: RUNS as u64,
        version: "robhaz 9.8.7".to_owned(),
        scene: String::new(),
    })
}

/// 200 runs of one estimator with a gain that is drawn logarithmically from 1 to 10, nrmse = gain.
fn drawn() -> Result<Dataset, SceneError> {
    let study = "scene = \"flat.toml\"\n[[axis]]\nkey = \"drive.kp\"\nlog_uniform = [1, 10]\n[draw]\ncount = 200\n";
    let gain = |run: i32| Some(10f64.powf(f64::from(run) / 199.0));
    Ok(Dataset {
        columns: vec![
            numbers(
                "index",
                "",
                (0..200).map(|run| Some(f64::from(run))).collect(),
            ),
            numbers("drive.kp", "", (0..200).map(gain).collect()),
            words("estimator", vec![Some("one"); 200]),
            numbers("nrmse", "", (0..200).map(gain).collect()),
            words("error", vec![None; 200]),
        ],
        study: StudyChoice::parse(study, "drawn.toml")?,
        runs: 200,
        version: "robhaz 9.8.7".to_owned(),
        scene: String::new(),
    })
}

fn with_x(kind: PlotKind, x: &str) -> PlotRequest {
    PlotRequest {
        x: Some(x.to_owned()),
        ..PlotRequest::new(kind)
    }
}

fn dots(chart: &Chart) -> Vec<Point> {
    let dots = chart.shapes.iter().filter_map(|shape| match shape {
        Shape::Dot(point, _, _) => Some(*point),
        _ => None,
    });
    dots.collect()
}

fn cells(chart: &Chart) -> Vec<[Point; 2]> {
    let cells = chart.shapes.iter().filter_map(|shape| match shape {
        Shape::Cell(corners, _) => Some(*corners),
        _ => None,
    });
    cells.collect()
}

fn areas(chart: &Chart) -> Vec<Vec<Point>> {
    let areas = chart.shapes.iter().filter_map(|shape| match shape {
        Shape::Area(points, _) => Some(points.clone()),
        _ => None,
    });
    areas.collect()
}

fn near(found: &[Point], expected: &[Point]) -> bool {
    // Rounding of sums of decimal fractions.
    let same = |(f, e): (&Point, &Point)| (f.0 - e.0).abs() < 1e-12 && (f.1 - e.1).abs() < 1e-12;
    found.len() == expected.len() && found.iter().zip(expected).all(same)
}

/// Closed form: seeds 0 to 20 add 0 to 0.02, so that the quantile of a share adds 0.02 times the share. The default axis is
/// the first key that varies.
#[test]
fn bands_are_the_quantiles_at_each_value() -> Result<(), Box<dyn std::error::Error>> {
    let sheet = sheet(&dataset(0..0)?, &PlotRequest::new(PlotKind::Bands))?;
    let chart = &sheet.rows[0][0];
    assert_eq!(chart.x_label, "drive.speed (m/s)");
    let medians = [(0.1, 0.11), (0.2, 0.21), (0.4, 0.41)];
    let twice = medians.map(|(x, y)| (x, 2.0 * y));
    assert!(
        near(&dots(chart), &[medians, twice].concat()),
        "{:?}",
        dots(chart)
    );
    let outer = [
        (0.1, 0.101),
        (0.2, 0.201),
        (0.4, 0.401),
        (0.4, 0.419),
        (0.2, 0.219),
        (0.1, 0.119),
    ];
    let inner = [
        (0.1, 0.105),
        (0.2, 0.205),
        (0.4, 0.405),
        (0.4, 0.415),
        (0.2, 0.215),
        (0.1, 0.115),
    ];
    let areas = areas(chart);
    assert_eq!(areas.len(), 4);
    assert!(
        near(&areas[0], &outer) && near(&areas[2], &inner),
        "{areas:?}"
    );
    let caption = sheet.caption.join(" ");
    for part in [
        "nrmse: what nrmse means.",
        "of 42 runs of each drive.speed",
        "scene flat.toml: 126 runs, seed 0 to 20; none failed",
        "robhaz 9.8.7",
    ] {
        assert!(caption.contains(part), "{part}: {caption}");
    }
    Ok(())
}

/// Words are places beside each other, with a box for each estimator; the estimators themselves can be the axis.
#[test]
fn words_have_boxes() -> Result<(), Box<dyn std::error::Error>> {
    let dataset = dataset(0..0)?;
    let by_ground = sheet(&dataset, &with_x(PlotKind::Bands, "terrain.kind"))?;
    assert_eq!(cells(&by_ground.rows[0][0]).len(), 2 * 2);
    let ladder = sheet(&dataset, &with_x(PlotKind::Bands, "estimator"))?;
    let boxes = cells(&ladder.rows[0][0]);
    let middles: Vec<f64> = boxes.iter().map(|[a, b]| 0.5 * (a.0 + b.0)).collect();
    assert!(near(
        &[(middles[0], 0.0), (middles[1], 0.0)],
        &[(0.0, 0.0), (1.0, 0.0)]
    ));
    Ok(())
}

/// Of drawn values each run is a point, neighbours make groups, and the axis is spaced as the study drew it.
#[test]
fn drawn_values_are_grouped_and_all_shown() -> Result<(), Box<dyn std::error::Error>> {
    let sheet = sheet(&drawn()?, &PlotRequest::new(PlotKind::Bands))?;
    let chart = &sheet.rows[0][0];
    assert_eq!(chart.x.spacing(), Spacing::Logarithmic);
    // 200 runs, and the medians of 12 groups.
    assert_eq!(dots(chart).len(), 200 + 12);
    let caption = sheet.caption.join(" ");
    assert!(
        caption.contains("of 16 to 17 runs of each group of neighbouring drive.kp"),
        "{caption}"
    );
    assert!(caption.contains("one seed"), "{caption}");
    Ok(())
}

/// Each place of the grid is a cell, with its own colour; a place whose runs all failed is white and counted.
#[test]
fn a_heat_map_has_a_cell_for_each_place() -> Result<(), Box<dyn std::error::Error>> {
    let heat = PlotRequest::new(PlotKind::Heat);
    let whole = sheet(&dataset(0..0)?, &heat)?;
    // Two maps and the bar of colours; linked keys are one axis.
    assert_eq!(whole.rows[0].len(), 3);
    assert_eq!(whole.rows[0][0].x_label, "drive.speed (m/s)");
    assert_eq!(whole.rows[0][0].y_label, "terrain.kind");
    assert_eq!(cells(&whole.rows[0][0]).len(), 6);
    let with_hole = sheet(&dataset(0..21)?, &heat)?;
    assert_eq!(cells(&with_hole.rows[0][1]).len(), 5);
    let caption = with_hole.caption.join(" ");
    assert!(
        caption.contains("white: no run, 2 of 12 cells"),
        "{caption}"
    );
    assert!(
        caption.contains("21 of them failed and are not drawn"),
        "{caption}"
    );
    Ok(())
}

/// Every run with a stated deviation is a point; who states none is named.
#[test]
fn calibration_shows_each_stated_deviation() -> Result<(), Box<dyn std::error::Error>> {
    let sheet = sheet(&dataset(0..3)?, &PlotRequest::new(PlotKind::Calibration))?;
    let points = dots(&sheet.rows[0][0]);
    assert_eq!(points.len(), RUNS - 3);
    assert!(points.iter().all(|p| (p.1 - 2.0 * p.0).abs() < 1e-12));
    assert!(
        sheet
            .caption
            .join(" ")
            .contains("No standard deviation is stated by: one.")
    );
    assert!(matches!(
        super::sheet(&drawn()?, &PlotRequest::new(PlotKind::Calibration)),
        Err(PlotError::Nothing { name, .. }) if name == "stated"
    ));
    Ok(())
}

/// Conservation: the bars of an estimator hold all its runs.
#[test]
fn the_bars_of_a_histogram_hold_all_runs() -> Result<(), Box<dyn std::error::Error>> {
    let sheet = sheet(&dataset(5..8)?, &PlotRequest::new(PlotKind::Histogram))?;
    assert_eq!(sheet.rows.len(), 2);
    for row in &sheet.rows {
        let heights = cells(&row[0]).into_iter().map(|[top, _]| top.1);
        assert!((heights.sum::<f64>() - (RUNS - 3) as f64).abs() < 1e-9);
    }
    Ok(())
}

/// Closed form: the rungs of a ladder, the first on top, have the median over all runs and one at each speed.
#[test]
fn a_ladder_has_the_medians() -> Result<(), Box<dyn std::error::Error>> {
    let dataset = dataset(0..0)?;
    let mut request = with_x(PlotKind::Ladder, "drive.speed");
    let of_estimators = sheet(&dataset, &request)?;
    let [chart] = of_estimators.rows[0].as_slice() else {
        return Err("one chart".into());
    };
    let mut dots: Vec<Point> = Vec::new();
    for shape in &chart.shapes {
        if let Shape::Dot(at, ..) = shape {
            dots.push(*at);
        }
    }
    let expected = [0.22, 0.42, 0.82, 0.11, 0.21, 0.41];
    assert_eq!(dots.len(), expected.len());
    for (k, ((x, y), expected)) in dots.iter().zip(expected).enumerate() {
        assert!((x - expected).abs() < 1e-12, "{x} {expected}");
        assert!((y - (k / 3) as f64).abs() < 1e-12);
    }
    let labels = chart.y.ticks();
    assert!(labels[0].1.starts_with("two  0.42") && labels[1].1.starts_with("one  0.21"));
    // Grounds as rungs: a chart for each estimator, in which both grounds have the same median.
    request.x2 = Some("terrain.kind".to_owned());
    let of_grounds = sheet(&dataset, &request)?;
    assert_eq!(of_grounds.rows[0].len(), 2);
    let labels = of_grounds.rows[0][0].y.ticks();
    assert_eq!(
        (labels[0].1.as_str(), labels[1].1.as_str()),
        ("step  0.21", "flat  0.21")
    );
    Ok(())
}

/// A PNG file has twice the pixels of the figure, some of them not white; without a font there is a message.
#[test]
fn a_figure_as_png() -> Result<(), Box<dyn std::error::Error>> {
    let dataset = dataset(0..0)?;
    let request = PlotRequest::new(PlotKind::Ladder);
    match plot(&dataset, &request, FigureFormat::Png) {
        Ok(bytes) => {
            let pixels = resvg::tiny_skia::Pixmap::decode_png(&bytes)?;
            assert_eq!(pixels.width(), 2 * 880);
            let dark = pixels.pixels().iter().filter(|p| p.red() < 128).count();
            assert!(dark > 1000, "{dark}");
        }
        Err(error) => assert!(error.to_string().contains("none of the fonts"), "{error}"),
    }
    Ok(())
}

/// Each kind is a whole file in each format, with its caption in it, and no number that is none.
#[test]
fn every_kind_is_a_whole_file() -> Result<(), Box<dyn std::error::Error>> {
    let dataset = dataset(0..3)?;
    for kind in PlotKind::ALL {
        let request = PlotRequest::new(kind);
        let svg = plot(&dataset, &request, FigureFormat::Svg)?;
        let svg = String::from_utf8(svg)?;
        assert!(svg.starts_with("<svg ") && svg.trim_end().ends_with("</svg>"));
        let pdf = plot(&dataset, &request, FigureFormat::Pdf)?;
        let pdf = String::from_utf8_lossy(&pdf);
        assert!(pdf.starts_with("%PDF-") && pdf.trim_end().ends_with("%%EOF"));
        for text in [&svg, pdf.as_ref()] {
            assert!(text.contains("3 of them failed"), "{kind:?}");
            assert!(!text.contains("NaN") && !text.contains("inf "), "{kind:?}");
        }
    }
    Ok(())
}

/// Mistakes name what was found and what is allowed.
#[test]
fn mistakes_name_what_is_allowed() -> Result<(), Box<dyn std::error::Error>> {
    let some = dataset(0..3)?;
    let message = |dataset: &Dataset, request: PlotRequest| match sheet(dataset, &request) {
        Ok(_) => "drawn".to_owned(),
        Err(error) => error.to_string(),
    };
    let bands = || PlotRequest::new(PlotKind::Bands);
    let y = |y: &str| PlotRequest {
        y: y.to_owned(),
        ..bands()
    };
    let of = |e: &str| PlotRequest {
        estimators: vec![e.to_owned()],
        ..bands()
    };
    let cases = [
        (
            with_x(PlotKind::Bands, "speed"),
            "no column speed; allowed: index, drive.speed, ",
        ),
        (
            y("nrms"),
            "no column nrms; allowed: index, drive.speed, record.duration, seed, nrmse, ",
        ),
        (
            y("terrain.kind"),
            "terrain.kind holds words, numbers are needed; allowed: index, ",
        ),
        (of("three"), "no estimator three; allowed: one, two"),
        (
            with_x(PlotKind::Bands, "coverage"),
            "coverage is 0.7 in all rows: nothing to draw against; these vary: drive.speed, ",
        ),
        (
            PlotRequest {
                x_spacing: Some(Spacing::Logarithmic),
                ..with_x(PlotKind::Bands, "seed")
            },
            "seed has the value 0: a logarithmic axis needs values above zero",
        ),
    ];
    for (request, expected) in cases {
        let found = message(&some, request);
        assert!(found.contains(expected), "{found}");
    }
    let found = message(&dataset(0..RUNS)?, bands());
    let expected = "no row has a value of nrmse: all 126 runs failed, run 0: it cannot stand";
    assert_eq!(found, expected);
    let found = message(&drawn()?, PlotRequest::new(PlotKind::Heat));
    assert_eq!(found, "2 axes that vary are needed; found: drive.kp");
    Ok(())
}

/// A page has the scores, the reasons of failures and the figures of what varies, and needs no other file.
#[test]
fn a_page_shows_what_varies() -> Result<(), Box<dyn std::error::Error>> {
    let page = crate::sweep_page(&dataset(0..3)?)?;
    // Against speed, against ground, over both, calibration, distribution: linked keys once, seeds not.
    assert_eq!(page.matches("<img ").count(), 5);
    assert!(page.contains("it cannot stand") && page.contains("<th>two</th>"));
    assert!(!page.contains("http") && !page.contains("href"));
    let failed = crate::sweep_page(&dataset(0..RUNS)?)?;
    assert!(failed.contains("No run has scores.") && !failed.contains("<img "));
    Ok(())
}
