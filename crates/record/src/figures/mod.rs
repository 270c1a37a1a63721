//! Figs. 5 to 8 of the paper, drawn from a run.

mod canvas;
mod clip;
mod style;
mod trace;

use crate::accuracy::{Accuracy, Rms};
use crate::error::{RecordError, check_name, io_error};
use crate::summary::EstimatorSummary;
use canvas::{Column, Figure, Panel};
use robhaz_model::{Pin, Vec2};
use robhaz_run::{Frame, RunEnd, Sink, SinkError};
use robhaz_scene::{Scene, is_compared};
use robhaz_sim::Truth;
use std::path::{Path, PathBuf};
use style::{LINKAGE, WHEELS};
use trace::Trace;

/// Estimator whose linkage and forces are shown in Figs. 5 and 6, if the scene has it; else its last one.
const SHOWN: &str = "true-mass";
const WHEEL_TITLES: [&str; 3] = ["Wheel 1 (front)", "Wheel 2 (middle)", "Wheel 3 (rear)"];
const PINS: [(Pin, &str); 3] = [(Pin::P, "Pin P"), (Pin::R, "Pin R"), (Pin::S, "Pin S")];
const MM: f64 = 1e3;

/// Draws a run: the linkage, the forces, and the normal forces of every estimator.
///
/// | file | shows |
/// |---|---|
/// | `fig5_linkage.svg` | pins P, R and S from Q, true and estimated |
/// | `fig6_forces.svg` | N and T of every wheel, true and estimated |
/// | `fig7_paper-body.svg`, `fig8_paper-wheels.svg` | N of every wheel, true and estimated |
/// | `normal_force_NAME.svg` | the same of any other estimator |
///
/// A run that breaks off is drawn as far as it went. Of the records only what a figure can show is kept.
pub struct FigureSink {
    folder: PathBuf,
    run: Option<Traces>,
}

/// What is kept of a run, thinned out.
struct Traces {
    compare_from: f64,
    end: f64,
    /// True N and T of each wheel.
    normal_force: [Trace; 3],
    traction: [Trace; 3],
    /// True x and y of each of [`PINS`] from Q, mm.
    pins: [[Trace; 2]; 3],
    estimators: Vec<EstimatorTraces>,
    /// Which estimator Figs. 5 and 6 show.
    shown: Option<Shown>,
}

struct EstimatorTraces {
    name: String,
    normal_force: [Trace; 3],
    accuracy: Accuracy,
}

struct Shown {
    index: usize,
    traction: [Trace; 3],
    pins: [[Trace; 2]; 3],
    /// Errors of x and y of each of [`PINS`], mm.
    pin_errors: [[Rms; 2]; 3],
}

impl FigureSink {
    /// A sink for a folder, which is made if need be.
    pub fn new(folder: &Path) -> Self {
        Self {
            folder: folder.to_path_buf(),
            run: None,
        }
    }

    fn draw(&self) -> Result<(), RecordError> {
        let Some(run) = self.run.as_ref().filter(|run| run.end > 0.0) else {
            return Ok(());
        };
        self.write("fig5_linkage.svg", &run.linkage())?;
        self.write("fig6_forces.svg", &run.forces())?;
        for estimator in &run.estimators {
            let (file, title) = titles(&estimator.name);
            self.write(&file, &run.normal_forces(estimator, title))?;
        }
        Ok(())
    }

    fn write(&self, file: &str, figure: &Figure<'_>) -> Result<(), RecordError> {
        let path = self.folder.join(file);
        let svg = canvas::svg(figure).map_err(|reason| RecordError::Figure {
            path: path.clone(),
            reason,
        })?;
        std::fs::write(&path, svg).map_err(io_error("write", &path))
    }
}

/// File and title of an estimator's figure. The paper's two go by the paper's numbers.
fn titles(name: &str) -> (String, String) {
    match name {
        "paper-body" => (
            format!("fig7_{name}.svg"),
            "Normal forces, linkage mass lumped to the body (the paper's Fig. 7)".to_owned(),
        ),
        "paper-wheels" => (
            format!("fig8_{name}.svg"),
            "Normal forces, linkage mass lumped to the wheels (the paper's Fig. 8)".to_owned(),
        ),
        _ => (
            format!("normal_force_{name}.svg"),
            format!("Normal forces, estimator {name}"),
        ),
    }
}

impl Sink for FigureSink {
    fn begin(&mut self, scene: &Scene) -> Result<(), SinkError> {
        for estimator in &scene.estimators {
            check_name(&estimator.name, &self.folder)?;
        }
        std::fs::create_dir_all(&self.folder).map_err(io_error("create", &self.folder))?;
        self.run = Some(Traces::new(scene));
        Ok(())
    }

    fn frame(&mut self, frame: &Frame<'_>) -> Result<(), SinkError> {
        if let Some(run) = &mut self.run {
            run.add(frame);
        }
        Ok(())
    }

    fn end(&mut self, _: Option<&RunEnd>) -> Result<(), SinkError> {
        Ok(self.draw()?)
    }
}

impl Traces {
    fn new(scene: &Scene) -> Self {
        let records = scene.record_count();
        let three = || [(); 3].map(|()| Trace::new(records));
        let pins = || [(); 3].map(|()| [Trace::new(records), Trace::new(records)]);
        let names = || scene.estimators.iter().map(|e| e.name.as_str());
        let shown = names()
            .position(|name| name == SHOWN)
            .or_else(|| scene.estimators.len().checked_sub(1));
        Self {
            compare_from: scene.record.compare_from,
            end: 0.0,
            normal_force: three(),
            traction: three(),
            pins: pins(),
            estimators: names()
                .map(|name| EstimatorTraces {
                    name: name.to_owned(),
                    normal_force: three(),
                    accuracy: Accuracy::new(name, scene.record.compare_from),
                })
                .collect(),
            shown: shown.map(|index| Shown {
                index,
                traction: three(),
                pins: pins(),
                pin_errors: Default::default(),
            }),
        }
    }

    fn add(&mut self, frame: &Frame<'_>) {
        let (truth, time) = (frame.truth, frame.truth.time);
        self.end = time;
        for (i, wheel) in truth.wheels.iter().enumerate() {
            self.normal_force[i].add(time, Some(wheel.normal_force));
            self.traction[i].add(time, Some(wheel.traction));
        }
        for (traces, (pin, _)) in self.pins.iter_mut().zip(PINS) {
            let from_q = true_from_q(truth, pin);
            traces[0].add(time, Some(from_q.x));
            traces[1].add(time, Some(from_q.y));
        }
        for (index, estimator) in self.estimators.iter_mut().enumerate() {
            let estimate = frame.estimates.get(index);
            estimator.accuracy.add(truth, estimate);
            let estimate = estimate.and_then(|e| e.as_ref().ok());
            for (i, trace) in estimator.normal_force.iter_mut().enumerate() {
                trace.add(time, estimate.map(|e| e.normal_force[i]));
            }
        }
        let compared = is_compared(time, self.compare_from);
        if let Some(shown) = &mut self.shown {
            shown.add(frame, compared);
        }
    }

    fn figure<'a>(&self, title: String, columns: Vec<Column<'a>>) -> Figure<'a> {
        Figure {
            title,
            subtitle: String::new(),
            end: self.end,
            compare_from: self.compare_from,
            estimate_label: None,
            estimate_colors: Vec::new(),
            columns,
        }
    }

    /// Fig. 5.
    fn linkage(&self) -> Figure<'_> {
        let column = |axis: usize, y_label: &'static str| {
            let panels = PINS.iter().enumerate().map(|(k, (_, title))| Panel {
                title: (*title).to_owned(),
                note: self
                    .shown
                    .as_ref()
                    .and_then(|s| s.pin_errors[k][axis].value())
                    .map_or(String::new(), pin_note),
                y_label,
                least_span: 2.0,
                truth: &self.pins[k][axis],
                estimate: self.shown.as_ref().map(|s| &s.pins[k][axis]),
                color: LINKAGE,
            });
            Column {
                panels: panels.collect(),
                one_scale: false,
            }
        };
        Figure {
            subtitle: "in world axes, measured from pin Q".to_owned(),
            estimate_label: self.shown_name().map(str::to_owned),
            estimate_colors: vec![LINKAGE],
            ..self.figure(
                "Position of the linkage's pins (the paper's Fig. 5)".to_owned(),
                vec![column(0, "x from Q (mm)"), column(1, "y from Q (mm)")],
            )
        }
    }

    /// Fig. 6.
    fn forces(&self) -> Figure<'_> {
        let estimator = self.shown.as_ref().map(|s| &self.estimators[s.index]);
        let summary = estimator.map(|e| e.accuracy.summary());
        let errors = summary
            .as_ref()
            .and_then(|s| s.normal_force.zip(s.traction));
        let note = |rmse: Option<f64>| rmse.map_or(String::new(), |r| format!("RMSE {r:.2} N"));
        let normal = (0..3).map(|i| Panel {
            title: WHEEL_TITLES[i].to_owned(),
            note: note(errors.map(|(n, _)| n.rmse[i])),
            y_label: "normal force N (N)",
            least_span: 2.0,
            truth: &self.normal_force[i],
            estimate: estimator.map(|e| &e.normal_force[i]),
            color: WHEELS[i],
        });
        let traction = (0..3).map(|i| Panel {
            title: WHEEL_TITLES[i].to_owned(),
            note: note(errors.map(|(_, t)| t.rmse[i])),
            y_label: "traction T (N)",
            least_span: 2.0,
            truth: &self.traction[i],
            estimate: self.shown.as_ref().map(|s| &s.traction[i]),
            color: WHEELS[i],
        });
        Figure {
            estimate_label: self.shown_name().map(str::to_owned),
            estimate_colors: WHEELS.to_vec(),
            ..self.figure(
                "Force distribution over the wheels (the paper's Fig. 6)".to_owned(),
                vec![Column::of_one_scale(normal), Column::of_one_scale(traction)],
            )
        }
    }

    /// Figs. 7 and 8, and their like.
    fn normal_forces<'a>(&'a self, estimator: &'a EstimatorTraces, title: String) -> Figure<'a> {
        let summary = estimator.accuracy.summary();
        let panels = (0..3).map(|i| Panel {
            title: WHEEL_TITLES[i].to_owned(),
            note: summary
                .normal_force
                .map_or(String::new(), |e| format!("RMSE {:.2} N", e.rmse[i])),
            y_label: "normal force N (N)",
            least_span: 2.0,
            truth: &self.normal_force[i],
            estimate: Some(&estimator.normal_force[i]),
            color: WHEELS[i],
        });
        Figure {
            subtitle: overall(&summary),
            estimate_label: Some(estimator.name.clone()),
            estimate_colors: WHEELS.to_vec(),
            ..self.figure(title, vec![Column::of_one_scale(panels)])
        }
    }

    fn shown_name(&self) -> Option<&str> {
        let shown = self.shown.as_ref()?;
        Some(&self.estimators[shown.index].name)
    }
}

impl Shown {
    fn add(&mut self, frame: &Frame<'_>, compared: bool) {
        let (truth, time) = (frame.truth, frame.truth.time);
        let estimate = frame
            .estimates
            .get(self.index)
            .and_then(|e| e.as_ref().ok());
        for (i, trace) in self.traction.iter_mut().enumerate() {
            trace.add(time, estimate.map(|e| e.traction[i]));
        }
        for (k, (pin, _)) in PINS.into_iter().enumerate() {
            let from_q = estimate.map(|e| e.pin_from_q[index_of(pin)] * MM);
            self.pins[k][0].add(time, from_q.map(|v| v.x));
            self.pins[k][1].add(time, from_q.map(|v| v.y));
            if let Some(from_q) = from_q.filter(|_| compared) {
                let error = from_q - true_from_q(truth, pin);
                self.pin_errors[k][0].add(error.x);
                self.pin_errors[k][1].add(error.y);
            }
        }
    }
}

/// The error of a pin's position in words; `rms` in mm.
fn pin_note(rms: f64) -> String {
    if rms < 0.01 {
        "RMSE below 0.01 mm".to_owned()
    } else {
        format!("RMSE {rms:.2} mm")
    }
}

/// Where a pin truly is from Q, mm.
fn true_from_q(truth: &Truth, pin: Pin) -> Vec2 {
    (truth.pin(pin).position - truth.pin(Pin::Q).position) * MM
}

/// Where a pin stands in the arrays of an estimate, which are in the order of [`Pin::ALL`].
fn index_of(pin: Pin) -> usize {
    match pin {
        Pin::P => 0,
        Pin::Q => 1,
        Pin::R => 2,
        Pin::S => 3,
    }
}

/// The error over all wheels in words.
fn overall(summary: &EstimatorSummary) -> String {
    let Some(errors) = summary.normal_force else {
        return "nothing to compare".to_owned();
    };
    let rmse = format!("RMSE over the three wheels {:.2} N", errors.rmse_all);
    match errors.nrmse {
        Some(nrmse) => format!("{rmse} = {:.1} % of the mean normal force", 100.0 * nrmse),
        None => rmse,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{records, scene};
    use std::collections::BTreeMap;

    /// Draws the records of the test scene; file names and texts.
    fn draw(records: usize) -> BTreeMap<String, String> {
        let folder = tempfile::tempdir().expect("a folder");
        let mut sink = FigureSink::new(&folder.path().join("figures"));
        sink.begin(&scene()).expect("begins");
        for record in crate::testing::records().iter().take(records) {
            sink.frame(&record.frame()).expect("a record");
        }
        sink.end(None).expect("ends");
        std::fs::read_dir(folder.path().join("figures"))
            .expect("files")
            .map(|entry| {
                let path = entry.expect("a file").path();
                let name = path.file_name().expect("a name").to_string_lossy();
                (
                    name.into_owned(),
                    std::fs::read_to_string(&path).expect("text"),
                )
            })
            .collect()
    }

    #[test]
    fn every_estimator_has_its_figure() {
        let names: Vec<_> = draw(usize::MAX).into_keys().collect();
        assert_eq!(
            names,
            [
                "fig5_linkage.svg",
                "fig6_forces.svg",
                "fig7_paper-body.svg",
                "normal_force_mine.svg",
                "normal_force_true-mass.svg",
            ]
        );
        assert_eq!(titles("paper-wheels").0, "fig8_paper-wheels.svg");
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

    /// What a reader needs: axes with units, a legend, the error.
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
                    "RMSE below 0.01 mm",
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
                    "Normal forces, linkage mass lumped to the body (the paper&apos;s Fig. 7)",
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

    /// True and estimated can be told apart on a grey print: one is solid and thick, the other dashed and thin.
    #[test]
    fn lines_are_told_apart_without_colour() {
        for (name, svg) in draw(usize::MAX) {
            let lines: Vec<_> = svg.lines().filter(|l| l.starts_with("<polyline")).collect();
            let width = |line: &str| -> u32 {
                let (_, rest) = line.split_once("stroke-width=\"").expect("a width");
                rest.split('"')
                    .next()
                    .expect("a number")
                    .parse()
                    .expect("a number")
            };
            let (dashed, solid): (Vec<&str>, Vec<&str>) = lines
                .into_iter()
                .partition(|l| l.contains("stroke-dasharray"));
            assert!(dashed.len() >= 4, "{name}");
            let truth = solid.into_iter().filter(|l| l.contains(style::TRUTH_HEX));
            let thinnest_truth = truth.map(width).min().expect("true lines");
            let thickest_estimate = dashed.into_iter().map(width).max().expect("dashed lines");
            assert!(thinnest_truth > thickest_estimate, "{name}");
        }
    }

    /// Where there was no estimate the dashed line has a gap: two pieces a panel and not one.
    #[test]
    fn a_gap_in_the_estimates_stays_a_gap() {
        assert!(records().iter().any(|r| r.estimates[0].is_err()));
        let svg = &draw(usize::MAX)["fig7_paper-body.svg"];
        let pieces = |svg: &str| {
            svg.lines()
                .filter(|l| l.starts_with("<polyline") && l.contains("stroke-dasharray"))
                .filter(|l| l.split_whitespace().count() > 15)
                .count()
        };
        assert_eq!(pieces(svg), 6);
    }

    /// A run that broke off is drawn as far as it went; one that never began leaves no figures.
    #[test]
    fn a_broken_run_is_drawn_as_far_as_it_went() {
        let figures = draw(30);
        assert_eq!(figures.len(), 5);
        assert!(figures["fig7_paper-body.svg"].contains("nothing to compare"));
        for (name, svg) in &figures {
            assert_well_formed(name, svg);
        }
        assert!(draw(0).is_empty());
    }

    #[test]
    fn the_same_records_leave_the_same_figures() {
        assert_eq!(draw(usize::MAX), draw(usize::MAX));
    }
}
