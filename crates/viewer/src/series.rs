//! Time series: forces, errors with bands of two standard deviations, contact angles, friction,
//! residuals.

use crate::colours::{WHEELS, by_index, dark, light};
use crate::draw::contact_point;
use crate::error::Result;
use crate::writer::Writer;
use re_sdk_types::archetypes::{Scalars, SeriesLines};
use re_sdk_types::components::Color;
use robhaz_estimator::Estimate;
use robhaz_model::WheelCommand;
use robhaz_run::{EstimatorDescription, Frame, RunDescription};
use robhaz_score::{Compared, estimated_needed_friction, needed_friction, rms_over_wheels};
use robhaz_sim::{EquivalentContact, Truth};

/// Names of the wheels, front to rear.
pub(crate) const WHEEL_NAMES: [&str; 3] = ["front", "middle", "rear"];
/// Width of a true line, points.
pub(crate) const WIDE: f32 = 5.0;
/// Width of an estimated line, points.
pub(crate) const NARROW: f32 = 1.5;
/// Width of the edge of a band, points.
pub(crate) const EDGE: f32 = 0.75;

/// The values of the lines of a plot in a record, NaN for a gap; `None` where the record has no
/// row.
type Values = Box<dyn Fn(&Frame<'_>) -> Option<Vec<f64>> + Send>;

/// A line of a plot.
#[derive(Clone)]
pub(crate) struct Line {
    /// Name with unit.
    name: String,
    colour: Color,
    /// Width, points.
    width: f32,
}

/// Several lines over time in one entity, with one value of each at each time. Scalars need the
/// least memory and time in this form.
struct Plot {
    entity: String,
    lines: Vec<Line>,
    get: Values,
    /// Times that are not logged yet, s.
    times: Vec<f64>,
    /// Values at those times, line by line at each.
    values: Vec<f64>,
    /// The style of the lines is logged.
    declared: bool,
}

impl Plot {
    /// Adds the values of one record.
    fn push(&mut self, frame: &Frame<'_>) {
        if let Some(values) = (self.get)(frame) {
            self.times.push(frame.time);
            self.values.extend(values);
            debug_assert_eq!(self.values.len(), self.times.len() * self.lines.len());
        }
    }

    /// Logs the values that were added since the last call. The style of the lines is logged before
    /// the first values, so that a plot without values is not in the recording.
    fn flush(&mut self, out: &mut Writer) -> Result {
        let (entity, lines) = (self.entity.as_str(), &self.lines);
        let times = std::mem::take(&mut self.times);
        if !times.is_empty() && !std::mem::replace(&mut self.declared, true) {
            let style = SeriesLines::new()
                .with_names(lines.iter().map(|l| l.name.as_str()))
                .with_colors(lines.iter().map(|l| l.colour))
                .with_widths(lines.iter().map(|l| l.width));
            out.constant(entity, &style)?;
        }
        let rows = std::iter::repeat_n(lines.len(), times.len());
        let values = Scalars::new(self.values.drain(..));
        out.columns(entity, &times, values.columns(rows))
    }
}

/// All time series of a run.
#[derive(Default)]
pub(crate) struct Series(Vec<Plot>);

impl Series {
    /// The series of a run. Without truth there are no true lines. `chosen` is the index of the
    /// estimator whose friction and residual are shown.
    pub(crate) fn new(run: &RunDescription, chosen: Option<usize>) -> Self {
        let mut series = Self::default();
        (0..3).for_each(|i| series.add_forces(run, i));
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
        self.0.iter_mut().for_each(|plot| plot.push(frame));
    }

    /// Logs the records that were added since the last call.
    pub(crate) fn flush(&mut self, out: &mut Writer) -> Result {
        self.0.iter_mut().try_for_each(|plot| plot.flush(out))
    }

    /// Adds a plot, unless it has no lines.
    pub(crate) fn add(
        &mut self,
        entity: impl std::fmt::Display,
        lines: Vec<Line>,
        get: impl Fn(&Frame<'_>) -> Option<Vec<f64>> + Send + 'static,
    ) {
        if !lines.is_empty() {
            self.0.push(Plot {
                entity: format!("series/{entity}"),
                lines,
                get: Box::new(get),
                times: Vec::new(),
                values: Vec::new(),
                declared: false,
            });
        }
    }

    /// N, T and the error of N of a wheel, and two standard deviations: around no error, without
    /// truth around N and T.
    fn add_forces(&mut self, run: &RunDescription, i: usize) {
        let wheel = format!("wheel{}", i + 1);
        let truth = run.has_truth.then(|| line("true [N]", WHEELS[i], WIDE));
        let truth = Vec::from_iter(truth);
        let true_normal = move |t: &Truth| {
            let contact = t.wheels[i].equivalent_contact();
            contact.map_or(f64::NAN, |c| c.normal_force)
        };
        // The viewer draws entities in the order of their names: "estimated" comes after "actual",
        // on top of it.
        let normal = format!("normal_force/{wheel}");
        self.add(format!("{normal}/actual"), truth.clone(), move |f| {
            Some(vec![true_normal(f.truth?)])
        });
        self.add(format!("{normal}/estimated"), estimates(run), move |f| {
            Some(of_estimates(f, |e| Some(e.normal_force[i])))
        });
        let has_truth = run.has_truth;
        let traction = format!("traction/{wheel}");
        let lines = [truth, estimates(run)].concat();
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
                    Some(around(0.0, f.estimate(k)?.sigma_normal(i)?))
                });
            } else {
                self.add(format!("{normal}/band/{name}"), lines.clone(), move |f| {
                    let e = f.estimate(k)?;
                    Some(around(e.normal_force[i], e.sigma_normal(i)?))
                });
                self.add(format!("{traction}/band/{name}"), lines, move |f| {
                    let e = f.estimate(k)?;
                    Some(around(e.traction[i], e.sigma_traction(i)?))
                });
            }
        }
    }

    /// Contact angles: true, as the estimators get them, and as the chosen one finds them, with two
    /// standard deviations.
    fn add_angles(&mut self, run: &RunDescription, chosen: Option<usize>) {
        let truth = run.has_truth;
        let given = of_each_wheel("given [deg]", dark, NARROW);
        let lines = of_all_wheels(truth.then_some("true"), None, "deg");
        self.add("contact_angle", [lines, given].concat(), move |f| {
            let given = f.sensors.contact_angle.map(|a| a.unwrap_or(f64::NAN));
            let truth = true_lines(truth, f, |c| Some(c.angle)).into_iter();
            Some(truth.chain(given).map(f64::to_degrees).collect())
        });
        let Some(k) = chosen else {
            return;
        };
        let name = &run.estimators[k].label;
        let lines = of_all_wheels(None, Some(name), "deg");
        self.add("contact_angle/estimated", lines, move |f| {
            let angles = f.estimate(k).map_or([f64::NAN; 3], |e| e.contact_angle);
            Some(angles.map(f64::to_degrees).into())
        });
        let edges = ["+", "-"].map(|sign| {
            let name = format!("{name} {sign} 2 sigma [deg]");
            of_each_wheel(&name, light, EDGE)
        });
        self.add("contact_angle/estimated/band", edges.concat(), move |f| {
            let estimate = f.estimate(k)?;
            let sigmas = estimate.kalman.as_ref()?.contact_angle_sigma;
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
                let estimate = f.estimate(k);
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
        let forces = ["horizontal", "vertical"].map(|axis| format!("{axis} force [N]"));
        let moments = [1, 2].map(|link| format!("moment of link {link} about Q [N m]"));
        for (entity, first, names) in [("force", 0, forces), ("moment", 2, moments)] {
            let of = |k: usize| [0, 1].map(|j| line(&*names[j], by_index(k + j), NARROW));
            let lines = chosen.into_iter().flat_map(of);
            self.add(format!("residual/{entity}"), lines.collect(), move |f| {
                let estimate = f.estimate(chosen?);
                let residual = |row: usize| estimate.map_or(f64::NAN, |e| e.residual[row]);
                Some(vec![residual(first), residual(first + 1)])
            });
        }
        for (k, estimator) in run.estimators.iter().enumerate() {
            let name = &estimator.label;
            let value = line(format!("{name} [N]"), by_index(k), NARROW);
            let lines = [vec![value], edges(name, k)].concat();
            self.add(format!("parity/{name}"), lines, move |f| {
                // Without a covariance the residual has no standard deviation. The residual of eq.
                // (8) shows its value.
                let parity = f.estimate(k).filter(|e| e.kalman.is_some())?.parity?;
                Some([vec![parity.value], around(0.0, parity.sigma)].concat())
            });
        }
    }
}

/// Lines of N or T of all estimators.
fn estimates(run: &RunDescription) -> Vec<Line> {
    let of = |(k, e): (usize, &EstimatorDescription)| {
        line(format!("{} [N]", e.label), by_index(k), NARROW)
    };
    run.estimators.iter().enumerate().map(of).collect()
}

/// A value of every estimate. NaN, a gap in the line, without an estimate.
fn of_estimates(frame: &Frame<'_>, value: impl Fn(&Estimate) -> Option<f64>) -> Vec<f64> {
    let of = |e: &Result<Estimate, _>| e.as_ref().ok().and_then(&value).unwrap_or(f64::NAN);
    frame.estimates.iter().map(of).collect()
}

/// The lines of two standard deviations of the estimator with an index.
fn edges(name: &str, index: usize) -> Vec<Line> {
    let edge = |sign| line(format!("{name} {sign} 2 sigma [N]"), by_index(index), EDGE);
    ["+", "-"].map(edge).into()
}

/// Two standard deviations above and below a value.
pub(crate) fn around(value: f64, sigma: f64) -> Vec<f64> {
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

pub(crate) fn line(name: impl Into<String>, colour: Color, width: f32) -> Line {
    Line {
        name: name.into(),
        colour,
        width,
    }
}

/// A line of each wheel in a shade of its colour; `name` follows that of the wheel.
fn of_each_wheel(name: &str, shade: fn(Color) -> Color, width: f32) -> Vec<Line> {
    let wheels = WHEEL_NAMES.iter().zip(WHEELS);
    let of = |(wheel, colour)| line(format!("{wheel} {name}"), shade(colour), width);
    wheels.map(of).collect()
}

/// Wide lines of all wheels from a first source, and narrow lines from a second source. `None`: no
/// such lines.
fn of_all_wheels(first: Option<&str>, second: Option<&str>, unit: &str) -> Vec<Line> {
    let wide = first.map(|f| of_each_wheel(&format!("{f} [{unit}]"), |colour| colour, WIDE));
    let narrow = second.map(|s| of_each_wheel(&format!("{s} [{unit}]"), light, NARROW));
    wide.into_iter().chain(narrow).flatten().collect()
}
