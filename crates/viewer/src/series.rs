//! Time series: forces, errors with bands of two standard deviations, contact angles, friction,
//! residuals.

use crate::ViewerError;
use crate::colours::{Colour, WHEELS, by_index};
use crate::contact::contact_point;
use crate::plot::{Line, Plot};
use crate::writer::Writer;
use robhaz_estimator::Estimate;
use robhaz_model::WheelCommand;
use robhaz_run::{EstimatorDescription, Frame, RunDescription};
use robhaz_score::{Compared, estimated_needed_friction, needed_friction, rms_over_wheels};
use robhaz_sim::{EquivalentContact, Truth};

/// Names of the wheels, front to rear.
pub(crate) const WHEEL_NAMES: [&str; 3] = ["front", "middle", "rear"];

/// The values of the lines of a plot in a record, NaN for a gap; `None` where the record has no
/// row.
type Values = Box<dyn Fn(&Frame<'_>) -> Option<Vec<f64>> + Send>;

/// All time series of a run.
pub(crate) struct Series(Vec<(Plot, Values)>);

impl Series {
    /// The series of a run. Without truth there are no true lines. `chosen` is the index of the
    /// estimator whose friction and residual are shown.
    pub(crate) fn new(run: &RunDescription, chosen: Option<usize>) -> Self {
        let mut series = Self(Vec::new());
        for i in 0..3 {
            series.add_forces(run, i);
        }
        if run.has_truth {
            let rms = |f: &Frame<'_>| {
                let compared = Compared::of(f.truth?);
                let error = move |e: &Estimate| compared.map(|c| rms_over_wheels(e, &c));
                Some(of_estimates(f, error))
            };
            series.add("error_of_normal_force/rms", estimates(run), rms);
        }
        series.add_angles(run, chosen);
        series.add_friction(run, chosen);
        if run.takes_commands() {
            let lines = of_all_wheels(Some("commanded"), None, "N m");
            series.add("commanded_torque", lines, |f| {
                let torque = |command| match command {
                    WheelCommand::Torque(torque) => torque,
                    // A gap: the drive sets the torque.
                    WheelCommand::Planned | WheelCommand::Speed(_) => f64::NAN,
                };
                Some(f.commands.unwrap_or_default().map(torque).into())
            });
        }
        series.add_residuals(run, chosen);
        series
    }

    /// Adds one record.
    pub(crate) fn push(&mut self, frame: &Frame<'_>) {
        for (plot, values) in &mut self.0 {
            if let Some(values) = values(frame) {
                plot.push(frame.time, values);
            }
        }
    }

    /// Logs the records that were added since the last call.
    pub(crate) fn flush(&mut self, out: &mut Writer) -> Result<(), ViewerError> {
        self.0.iter_mut().try_for_each(|(plot, _)| plot.flush(out))
    }

    fn add(
        &mut self,
        entity: impl std::fmt::Display,
        lines: Vec<Line>,
        values: impl Fn(&Frame<'_>) -> Option<Vec<f64>> + Send + 'static,
    ) {
        if !lines.is_empty() {
            let plot = Plot::new(format!("series/{entity}"), lines);
            self.0.push((plot, Box::new(values)));
        }
    }

    /// N, T and the error of N of a wheel, and two standard deviations: around no error, without
    /// truth around N and T.
    fn add_forces(&mut self, run: &RunDescription, i: usize) {
        let wheel = format!("wheel{}", i + 1);
        let truth = run.has_truth.then(|| Line::truth("true [N]", WHEELS[i]));
        let true_normal = move |t: &Truth| {
            let contact = t.wheels[i].equivalent_contact();
            contact.map_or(f64::NAN, |c| c.normal_force)
        };
        // The viewer draws entities in the order of their names: "estimated" comes after "actual",
        // on top of it.
        let normal = format!("normal_force/{wheel}");
        self.add(
            format!("{normal}/actual"),
            truth.clone().into_iter().collect(),
            move |f| Some(vec![true_normal(f.truth?)]),
        );
        self.add(format!("{normal}/estimated"), estimates(run), move |f| {
            Some(of_estimates(f, |e| Some(e.normal_force[i])))
        });
        let has_truth = run.has_truth;
        let traction = format!("traction/{wheel}");
        let lines = truth.into_iter().chain(estimates(run)).collect();
        self.add(&traction, lines, move |f| {
            let truth = f.truth.map_or(f64::NAN, |t| t.wheels[i].traction);
            let estimates = of_estimates(f, |e| Some(e.traction[i]));
            let truth = has_truth.then_some(truth).into_iter();
            Some(truth.chain(estimates).collect())
        });
        let error = format!("error_of_normal_force/{wheel}");
        if has_truth {
            self.add(format!("{error}/error"), estimates(run), move |f| {
                let truth = true_normal(f.truth?);
                Some(of_estimates(f, |e| Some(e.normal_force[i] - truth)))
            });
        }
        for (k, estimator) in run.estimators.iter().enumerate() {
            let (name, lines) = (&estimator.label, edges(&estimator.label, k));
            if has_truth {
                self.add(format!("{error}/band/{name}"), lines, move |f| {
                    f.truth?;
                    Some(around(0.0, estimate(f, k)?.sigma_normal(i)?))
                });
            } else {
                self.add(format!("{normal}/band/{name}"), lines.clone(), move |f| {
                    let e = estimate(f, k)?;
                    Some(around(e.normal_force[i], e.sigma_normal(i)?))
                });
                self.add(format!("{traction}/band/{name}"), lines, move |f| {
                    let e = estimate(f, k)?;
                    Some(around(e.traction[i], e.sigma_traction(i)?))
                });
            }
        }
    }

    /// Contact angles: true, as the estimators get them, and as the chosen one finds them, with two
    /// standard deviations.
    fn add_angles(&mut self, run: &RunDescription, chosen: Option<usize>) {
        let truth = run.has_truth;
        let given = of_each_wheel("given [deg]", |n, colour| Line::estimate(n, colour.dark()));
        let lines = of_all_wheels(truth.then_some("true"), None, "deg");
        self.add(
            "contact_angle",
            lines.into_iter().chain(given).collect(),
            move |f| {
                let given = f
                    .sensors
                    .contact_angle
                    .map(|angle| angle.unwrap_or(f64::NAN));
                let all = true_lines(truth, f, |c| Some(c.angle))
                    .into_iter()
                    .chain(given);
                Some(all.map(f64::to_degrees).collect())
            },
        );
        let Some(k) = chosen else {
            return;
        };
        let name = &run.estimators[k].label;
        let lines = of_all_wheels(None, Some(name), "deg");
        self.add("contact_angle/estimated", lines, move |f| {
            let angles = estimate(f, k).map_or([f64::NAN; 3], |e| e.contact_angle);
            Some(angles.map(f64::to_degrees).into())
        });
        let edges = ["+", "-"].map(|sign| {
            let name = format!("{name} {sign} 2 sigma [deg]");
            of_each_wheel(&name, |name, colour| Line::edge(name, colour.light()))
        });
        self.add("contact_angle/estimated/band", edges.concat(), move |f| {
            let estimate = estimate(f, k)?;
            let sigmas = estimate.contact_angle_sigma?;
            let edge = |sign: f64| {
                let edges = estimate.contact_angle.iter().zip(sigmas);
                edges.map(move |(angle, sigma)| (angle + sign * 2.0 * sigma).to_degrees())
            };
            Some(edge(1.0).chain(edge(-1.0)).collect())
        });
    }

    /// Needed friction and slip margin: true, and by the chosen estimator.
    fn add_friction(&mut self, run: &RunDescription, chosen: Option<usize>) {
        let truth = run.has_truth;
        let needed = move |f: &Frame<'_>| -> Vec<f64> {
            let ratio = |c: EquivalentContact| needed_friction(c.traction, c.normal_force);
            let of = |e: &Estimate, i| estimated_needed_friction(e, i).map(|needed| needed.0);
            let estimated = chosen.map(|k| {
                let estimate = estimate(f, k);
                [0, 1, 2].map(|i| estimate.and_then(|e| of(e, i)).unwrap_or(f64::NAN))
            });
            let truth = true_lines(truth, f, ratio).into_iter();
            truth.chain(estimated.into_iter().flatten()).collect()
        };
        let name = chosen.map(|k| run.estimators[k].label.as_str());
        let lines = of_all_wheels(truth.then_some("true"), name, "-");
        self.add("friction", lines.clone(), move |f| Some(needed(f)));
        let Some(world) = &run.world else {
            return;
        };
        let (law, stretches) = (world.friction, world.terrain.stretches.clone());
        let radius = run.robot.robot.geometry.wheel_radius;
        self.add("slip_margin", lines, move |f| {
            let largest = f.truth?.wheels.each_ref().map(|wheel| {
                let x = contact_point(wheel, radius).x;
                law.at(&stretches, x).mu_s
            });
            let needed = needed(f).into_iter().enumerate();
            Some(needed.map(|(i, n)| largest[i % 3] - n.abs()).collect())
        });
    }

    /// Residual of eq. (8) of the chosen estimator, and the parity residual of every estimator with
    /// a covariance.
    fn add_residuals(&mut self, run: &RunDescription, chosen: Option<usize>) {
        for (entity, first, unit, rows) in [
            ("force", 0, "N", ["horizontal force", "vertical force"]),
            (
                "moment",
                2,
                "N m",
                ["moment of link 1 about Q", "moment of link 2 about Q"],
            ),
        ] {
            let lines = chosen.into_iter().flat_map(|k| {
                let line =
                    |j: usize| Line::estimate(format!("{} [{unit}]", rows[j]), by_index(k + j));
                [line(0), line(1)]
            });
            self.add(format!("residual/{entity}"), lines.collect(), move |f| {
                let estimate = estimate(f, chosen?);
                let residual = |row: usize| estimate.map_or(f64::NAN, |e| e.residual[row]);
                Some(vec![residual(first), residual(first + 1)])
            });
        }
        for (k, estimator) in run.estimators.iter().enumerate() {
            let name = &estimator.label;
            let value = Line::estimate(format!("{name} [N]"), by_index(k));
            let lines = [vec![value], edges(name, k)].concat();
            self.add(format!("parity/{name}"), lines, move |f| {
                // Without a covariance the residual has no standard deviation. The residual of eq.
                // (8) shows its value.
                let parity = estimate(f, k).filter(|e| e.covariance.is_some())?.parity?;
                Some([vec![parity.value], around(0.0, parity.sigma)].concat())
            });
        }
    }
}

/// The estimate of the estimator with an index, if it has one.
fn estimate<'a>(frame: &Frame<'a>, index: usize) -> Option<&'a Estimate> {
    frame.estimates.get(index)?.as_ref().ok()
}

/// Lines of N or T of all estimators.
fn estimates(run: &RunDescription) -> Vec<Line> {
    let lines = run.estimators.iter().enumerate();
    let line = |(k, e): (usize, &EstimatorDescription)| {
        Line::estimate(format!("{} [N]", e.label), by_index(k))
    };
    lines.map(line).collect()
}

/// A value of every estimate. NaN, a gap in the line, without an estimate.
fn of_estimates(frame: &Frame<'_>, value: impl Fn(&Estimate) -> Option<f64>) -> Vec<f64> {
    let of = |e: &Result<Estimate, _>| e.as_ref().ok().and_then(&value).unwrap_or(f64::NAN);
    frame.estimates.iter().map(of).collect()
}

/// The lines of two standard deviations of the estimator with an index.
fn edges(name: &str, index: usize) -> Vec<Line> {
    let edge = |sign| Line::edge(format!("{name} {sign} 2 sigma [N]"), by_index(index));
    ["+", "-"].map(edge).into()
}

/// Two standard deviations above and below a value.
fn around(value: f64, sigma: f64) -> Vec<f64> {
    vec![value + 2.0 * sigma, value - 2.0 * sigma]
}

/// Values of the true lines of all wheels, of their equivalent contacts: gaps where there is none.
/// No values where the plots have no such lines.
fn true_lines(
    has_truth: bool,
    frame: &Frame<'_>,
    value: impl Fn(EquivalentContact) -> Option<f64>,
) -> Vec<f64> {
    let of = |i: usize| value(frame.truth?.wheels[i].equivalent_contact()?);
    let all = (0..3).map(|i| of(i).unwrap_or(f64::NAN));
    all.filter(|_| has_truth).collect()
}

/// A line of each wheel, whose name follows that of the wheel.
fn of_each_wheel(name: &str, line: impl Fn(String, Colour) -> Line) -> [Line; 3] {
    [0, 1, 2].map(|i| line(format!("{} {name}", WHEEL_NAMES[i]), WHEELS[i]))
}

/// Wide lines of all wheels from a first source, and narrow lines from a second source. `None`: no
/// such lines.
fn of_all_wheels(first: Option<&str>, second: Option<&str>, unit: &str) -> Vec<Line> {
    let name = &|i: usize, source: &str| format!("{} {source} [{unit}]", WHEEL_NAMES[i]);
    let wide = first
        .into_iter()
        .flat_map(|source| (0..3).map(move |i| Line::truth(name(i, source), WHEELS[i])));
    let narrow = second
        .into_iter()
        .flat_map(|source| (0..3).map(move |i| Line::estimate(name(i, source), WHEELS[i].light())));
    wide.chain(narrow).collect()
}
