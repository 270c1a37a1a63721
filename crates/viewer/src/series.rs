//! Time series: forces, errors with bands of two standard deviations, contact angles, friction, residuals.

use crate::ViewerError;
use crate::colours::{Colour, WHEELS, by_index};
use crate::contact::contact_point;
use crate::plot::{Line, Plot};
use crate::writer::Writer;
use robhaz_estimator::{Estimate, EstimateError};
use robhaz_model::WheelCommand;
use robhaz_run::{Frame, RunDescription};
use robhaz_score::{Compared, estimated_needed_friction, needed_friction, rms_over_wheels};
use robhaz_sim::friction::{FrictionLaw, Stretch};
use robhaz_sim::{EquivalentContact, Truth, WheelTruth};

/// Names of the wheels, front to rear.
pub(crate) const WHEEL_NAMES: [&str; 3] = ["front", "middle", "rear"];

/// All time series of a run.
pub(crate) struct Series {
    /// Index of the estimator whose friction and residual are shown.
    chosen: Option<usize>,
    /// Wheel radius, m.
    radius: f64,
    /// Whether the plots have true lines.
    has_truth: bool,
    /// Friction of the ground. `None` for recorded readings.
    friction_law: Option<(FrictionLaw, Vec<Stretch>)>,
    true_normal: [Plot; 3],
    normal: [Plot; 3],
    traction: [Plot; 3],
    error: [Plot; 3],
    /// Two standard deviations of N around zero error: by estimator, then by wheel.
    bands: Vec<[Plot; 3]>,
    /// Of runs without truth: N and T with two standard deviations added and subtracted, by
    /// estimator, then by wheel.
    force_bands: Vec<[[Plot; 3]; 2]>,
    rms_error: Plot,
    /// True and given.
    contact_angle: Plot,
    /// By the chosen estimator, and with two standard deviations added and subtracted.
    estimated_angle: Plot,
    angle_band: Plot,
    friction: Plot,
    margin: Plot,
    /// Commanded torques. `None` without a control that takes readings.
    commanded: Option<Plot>,
    residual_force: Plot,
    residual_moment: Plot,
    /// By estimator.
    parity: Vec<Plot>,
}

impl Series {
    /// The series of a run. Recorded readings without a table of the truth have no true lines. `chosen` is the index of the estimator whose friction
    /// and residual are shown.
    pub(crate) fn new(run: &RunDescription, chosen: Option<usize>) -> Self {
        let names: Vec<&str> = run.estimators.iter().map(|e| e.label.as_str()).collect();
        let has_truth = run.has_truth;
        let truth_name = has_truth.then_some("true");
        let estimates = |unit: &str| -> Vec<Line> {
            let lines = names.iter().enumerate();
            lines
                .map(|(k, name)| Line::estimate(format!("{name} [{unit}]"), by_index(k)))
                .collect()
        };
        let per_wheel = |quantity: &str, source: &str, lines: &dyn Fn(usize) -> Vec<Line>| {
            [0, 1, 2].map(|i| {
                Plot::new(
                    format!("series/{quantity}/wheel{}{source}", i + 1),
                    lines(i),
                )
            })
        };
        let truth = |i: usize| Line::truth("true [N]", WHEELS[i]);
        let bands = |(k, name): (usize, &&str)| {
            per_wheel("error_of_normal_force", &format!("/band/{name}"), &|_| {
                let edge = |sign| Line::edge(format!("{name} {sign} 2 sigma [N]"), by_index(k));
                vec![edge("+"), edge("-")]
            })
        };
        let force_bands = |(k, name): (usize, &&str)| {
            ["normal_force", "traction"].map(|force| {
                per_wheel(force, &format!("/band/{name}"), &|_| {
                    let edge = |sign| Line::edge(format!("{name} {sign} 2 sigma [N]"), by_index(k));
                    vec![edge("+"), edge("-")]
                })
            })
        };
        let parity = |(k, name): (usize, &&str)| {
            let edge = |sign| Line::edge(format!("{name} {sign} 2 sigma [N]"), by_index(k));
            let value = Line::estimate(format!("{name} [N]"), by_index(k));
            Plot::new(
                format!("series/parity/{name}"),
                vec![value, edge("+"), edge("-")],
            )
        };
        let of_chosen = |entity: &str, rows: [&str; 2], unit: &str| {
            let lines = chosen.into_iter().flat_map(|k| {
                let (first, second) = (by_index(k), by_index(k + 1));
                [
                    Line::estimate(format!("{} [{unit}]", rows[0]), first),
                    Line::estimate(format!("{} [{unit}]", rows[1]), second),
                ]
            });
            Plot::new(entity, lines.collect())
        };
        let chosen_name = chosen.map(|k| names[k]);
        Self {
            chosen,
            radius: run.robot.robot.geometry.wheel_radius,
            has_truth,
            friction_law: run
                .world
                .as_ref()
                .map(|world| (world.friction, world.terrain.stretches.clone())),
            // The viewer draws entities in the order of their names: "estimated" comes after "actual", on top of it.
            true_normal: per_wheel("normal_force", "/actual", &|i| vec![truth(i)]),
            normal: per_wheel("normal_force", "/estimated", &|_| estimates("N")),
            traction: per_wheel("traction", "", &|i| {
                let truth = has_truth.then(|| truth(i));
                truth.into_iter().chain(estimates("N")).collect()
            }),
            error: per_wheel("error_of_normal_force", "/error", &|_| estimates("N")),
            bands: names.iter().enumerate().map(bands).collect(),
            // With truth the plots of errors have the bands.
            force_bands: match has_truth {
                true => Vec::new(),
                false => names.iter().enumerate().map(force_bands).collect(),
            },
            rms_error: Plot::new("series/error_of_normal_force/rms", estimates("N")),
            contact_angle: Plot::new("series/contact_angle", {
                let given = of_each_wheel("given [deg]", |name, colour| {
                    Line::estimate(name, colour.dark())
                });
                let truth = of_all_wheels(truth_name, None, "deg").into_iter();
                truth.chain(given).collect()
            }),
            estimated_angle: Plot::new(
                "series/contact_angle/estimated",
                of_all_wheels(None, chosen_name, "deg"),
            ),
            angle_band: Plot::new("series/contact_angle/estimated/band", {
                let edges = chosen_name.into_iter().flat_map(|name| {
                    ["+", "-"].map(|sign| {
                        of_each_wheel(&format!("{name} {sign} 2 sigma [deg]"), |name, colour| {
                            Line::edge(name, colour.light())
                        })
                    })
                });
                edges.flatten().collect()
            }),
            friction: Plot::new(
                "series/friction",
                of_all_wheels(truth_name, chosen_name, "-"),
            ),
            margin: Plot::new(
                "series/slip_margin",
                of_all_wheels(truth_name, chosen_name, "-"),
            ),
            commanded: run.takes_commands().then(|| {
                let lines = of_all_wheels(Some("commanded"), None, "N m");
                Plot::new("series/commanded_torque", lines)
            }),
            residual_force: of_chosen(
                "series/residual/force",
                ["horizontal force", "vertical force"],
                "N",
            ),
            residual_moment: of_chosen(
                "series/residual/moment",
                ["moment of link 1 about Q", "moment of link 2 about Q"],
                "N m",
            ),
            parity: names.iter().enumerate().map(parity).collect(),
        }
    }

    /// Adds one record.
    pub(crate) fn push(&mut self, frame: &Frame<'_>) {
        let truth = frame.truth.filter(|_| self.has_truth);
        let time = frame.time;
        for i in 0..3 {
            self.push_forces(frame, truth, i);
        }
        if let Some(truth) = truth {
            let compared = Compared::of(truth);
            let error = |e: &Estimate| compared.map_or(f64::NAN, |c| rms_over_wheels(e, &c));
            let errors = frame.estimates.iter().map(|e| or_gap(e, error));
            self.rms_error.push(time, errors);
        }
        let angles = self.true_lines(truth, |w| or_gap_of(w, |c| c.angle));
        let given = frame.sensors.contact_angle;
        let given = given.map(|g| g.unwrap_or(f64::NAN));
        let angles = angles.into_iter().flatten().chain(given);
        self.contact_angle.push(time, angles.map(f64::to_degrees));
        self.push_estimated_angles(frame);
        self.push_friction(frame, truth);
        if let Some(commanded) = &mut self.commanded {
            let torque = |command| match command {
                WheelCommand::Torque(torque) => torque,
                // A gap: the drive sets the torque.
                WheelCommand::Planned | WheelCommand::Speed(_) => f64::NAN,
            };
            commanded.push(time, frame.commands.unwrap_or_default().map(torque));
        }
        self.push_residuals(frame);
    }

    /// Logs the records that were added since the last call.
    pub(crate) fn flush(&mut self, out: &mut Writer) -> Result<(), ViewerError> {
        let whole = [
            &mut self.rms_error,
            &mut self.contact_angle,
            &mut self.estimated_angle,
            &mut self.angle_band,
            &mut self.friction,
            &mut self.margin,
            &mut self.residual_force,
            &mut self.residual_moment,
        ];
        self.true_normal
            .iter_mut()
            .chain(&mut self.normal)
            .chain(&mut self.traction)
            .chain(&mut self.error)
            .chain(self.bands.iter_mut().flatten())
            .chain(self.force_bands.iter_mut().flatten().flatten())
            .chain(whole)
            .chain(&mut self.commanded)
            .chain(&mut self.parity)
            .try_for_each(|plot| plot.flush(out))
    }

    fn push_forces(&mut self, frame: &Frame<'_>, truth: Option<&Truth>, i: usize) {
        let (time, wheel) = (frame.time, truth.map(|t| &t.wheels[i]));
        let normal = |e: &_| or_gap(e, |e: &Estimate| e.normal_force[i]);
        let traction = |e: &_| or_gap(e, |e: &Estimate| e.traction[i]);
        let estimates = frame.estimates;
        self.normal[i].push(time, estimates.iter().map(normal));
        let true_traction = wheel.map_or(f64::NAN, |w| w.traction);
        let tractions = self.has_truth.then_some(true_traction).into_iter();
        self.traction[i].push(time, tractions.chain(estimates.iter().map(traction)));
        for ([normal, traction], estimate) in self.force_bands.iter_mut().zip(estimates) {
            let Ok(estimate) = estimate else {
                continue;
            };
            let forces = [
                (normal, estimate.normal_force[i], estimate.sigma_normal(i)),
                (traction, estimate.traction[i], estimate.sigma_traction(i)),
            ];
            for (plots, force, sigma) in forces {
                if let Some(half) = sigma.map(|sigma| 2.0 * sigma) {
                    plots[i].push(time, [force + half, force - half]);
                }
            }
        }
        let Some(wheel) = wheel else {
            return;
        };
        let true_normal = or_gap_of(wheel, |c| c.normal_force);
        self.true_normal[i].push(time, [true_normal]);
        let errors = estimates.iter().map(|e| normal(e) - true_normal);
        self.error[i].push(time, errors);
        for (band, estimate) in self.bands.iter_mut().zip(estimates) {
            let sigma = estimate.as_ref().ok().and_then(|e| e.sigma_normal(i));
            if let Some(sigma) = sigma {
                band[i].push(time, [2.0 * sigma, -2.0 * sigma]);
            }
        }
    }

    /// Values of the true lines of all wheels: gaps in a record without truth. `None`: the plots have no such lines.
    fn true_lines(
        &self,
        truth: Option<&Truth>,
        value: impl Fn(&WheelTruth) -> f64,
    ) -> Option<[f64; 3]> {
        let values = truth.map_or([f64::NAN; 3], |t| t.wheels.each_ref().map(value));
        self.has_truth.then_some(values)
    }

    fn push_estimated_angles(&mut self, frame: &Frame<'_>) {
        let Some(k) = self.chosen else {
            return;
        };
        let estimate = frame.estimates.get(k).and_then(|e| e.as_ref().ok());
        let angles = estimate.map_or([f64::NAN; 3], |e| e.contact_angle);
        let in_degrees = angles.map(f64::to_degrees);
        self.estimated_angle.push(frame.time, in_degrees);
        if let Some(sigmas) = estimate.and_then(|e| e.contact_angle_sigma) {
            let edge = |sign: f64| {
                let edges = angles.iter().zip(sigmas);
                edges.map(move |(angle, sigma)| (angle + sign * 2.0 * sigma).to_degrees())
            };
            self.angle_band
                .push(frame.time, edge(1.0).chain(edge(-1.0)));
        }
    }

    fn push_friction(&mut self, frame: &Frame<'_>, truth: Option<&Truth>) {
        let ratio =
            |c: EquivalentContact| needed_friction(c.traction, c.normal_force).unwrap_or(f64::NAN);
        let needed = self.true_lines(truth, |w| or_gap_of(w, ratio));
        let estimated = self.chosen.map(|k| {
            [0, 1, 2].map(|i| {
                or_gap(&frame.estimates[k], |e| {
                    estimated_needed_friction(e, i).map_or(f64::NAN, |(needed, _)| needed)
                })
            })
        });
        let all = || needed.into_iter().chain(estimated).flatten();
        self.friction.push(frame.time, all());
        let (Some(truth), Some((law, stretches))) = (truth, &self.friction_law) else {
            return;
        };
        let largest = truth.wheels.map(|w| {
            let x = contact_point(&w, self.radius).x;
            law.at(stretches, x).mu_s
        });
        let margin = |i: usize, needed: f64| largest[i % 3] - needed.abs();
        self.margin
            .push(frame.time, all().enumerate().map(|(i, n)| margin(i, n)));
    }

    fn push_residuals(&mut self, frame: &Frame<'_>) {
        let time = frame.time;
        if let Some(k) = self.chosen {
            let residual = |row: usize| or_gap(&frame.estimates[k], |e| e.residual[row]);
            self.residual_force.push(time, [residual(0), residual(1)]);
            self.residual_moment.push(time, [residual(2), residual(3)]);
        }
        for (plot, estimate) in self.parity.iter_mut().zip(frame.estimates) {
            // Without a covariance the residual has no standard deviation. The residual of eq. (8) shows its value.
            let known = estimate.as_ref().ok().filter(|e| e.covariance.is_some());
            if let Some(parity) = known.and_then(|e| e.parity) {
                let band = 2.0 * parity.sigma;
                plot.push(time, [parity.value, band, -band]);
            }
        }
    }
}

/// A line of each wheel, whose name follows that of the wheel.
fn of_each_wheel(name: &str, line: impl Fn(String, Colour) -> Line) -> [Line; 3] {
    [0, 1, 2].map(|i| line(format!("{} {name}", WHEEL_NAMES[i]), WHEELS[i]))
}

/// Wide lines of all wheels from a first source, and narrow lines from a second source. `None`: no such lines.
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

/// A value of an estimate. NaN, a gap in the line, without an estimate.
fn or_gap(estimate: &Result<Estimate, EstimateError>, value: impl Fn(&Estimate) -> f64) -> f64 {
    estimate.as_ref().map_or(f64::NAN, value)
}

/// A value of the equivalent contact of a wheel. NaN, a gap in the line, where there is none.
fn or_gap_of(wheel: &WheelTruth, value: impl Fn(EquivalentContact) -> f64) -> f64 {
    wheel.equivalent_contact().map_or(f64::NAN, value)
}
