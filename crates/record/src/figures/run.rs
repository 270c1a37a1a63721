//! The traces of a run for its figures.

use super::trace::{Estimated, Trace};
use robhaz_estimator::{Estimate, EstimatorSettings};
use robhaz_model::{Geometry, Pin, Vec2};
use robhaz_run::{EstimatorDescription, Frame, RunDescription};
use robhaz_score::{Compared, Rms, Rule, Score};
use robhaz_sim::Truth;
use robhaz_terrain::Terrain;
use std::array::from_fn;

/// The pins of Fig. 5, and their titles.
pub const PINS: [(Pin, &str); 3] = [(Pin::P, "Pin P"), (Pin::R, "Pin R"), (Pin::S, "Pin S")];
const MM: f64 = 1e3;
/// Number of poses of the robot that are kept.
const POSES: u64 = 600;

/// The traces of a run.
pub struct RunTraces {
    /// Which records count in the errors.
    pub rule: Rule,
    /// Time of the last record, s.
    pub end: f64,
    /// True forces: one for all estimators, or, of a log of both sides, one a side.
    truths: Vec<TrueForces>,
    /// True N (N) of each wheel over the position of its centre (m).
    pub normal_force_at: [Trace; 3],
    /// True x and y of each of [`PINS`] from Q, mm.
    pub pins: [[Trace; 2]; 3],
    pub estimators: Vec<EstimatorTraces>,
    /// Whether there is a truth to draw.
    pub has_truth: bool,
    /// The robot at equal distances of time, and at the end.
    pub poses: Vec<Truth>,
    records_per_pose: u64,
    records: u64,
    last: Option<Truth>,
    /// The ground; `None` for recorded readings.
    pub ground: Option<Terrain>,
    pub geometry: Geometry,
    /// Mean static load of a wheel, N.
    pub mean_load: f64,
}

/// True N and T of each wheel's equivalent contact, N. A gap in N where there is none.
pub struct TrueForces {
    pub normal_force: [Trace; 3],
    pub traction: [Trace; 3],
}

/// The traces of an estimator.
pub struct EstimatorTraces {
    /// Its number.
    index: usize,
    pub name: String,
    /// Stem of the file and title of its figure of N.
    pub figure: (String, String),
    /// Estimate and error of N, N.
    pub normal_force: [Estimated; 3],
    pub error: [Estimated; 3],
    pub score: Score,
    /// Whether Figs. 5 and 6 show it: one, or, of a log of both sides, one a side. Only these have
    /// the traces below.
    pub is_shown: bool,
    pub traction: [Estimated; 3],
    pub pins: [[Estimated; 2]; 3],
    /// Errors of x and y of each of [`PINS`], mm.
    pub pin_errors: [[Rms; 2]; 3],
}

impl RunTraces {
    /// The traces of a run before its first record.
    pub fn new(run: &RunDescription) -> Self {
        let records = run.record.count();
        let estimators = &run.estimators;
        let true_mass = |e: &_| is_preset(e, EstimatorSettings::true_mass());
        let shown = estimators.iter().position(true_mass);
        let shown = shown.or_else(|| estimators.len().checked_sub(1));
        let traces = || from_fn(|_| Trace::new(records));
        let estimated = || from_fn(|_| Estimated::new(records));
        let true_forces = || TrueForces {
            normal_force: traces(),
            traction: traces(),
        };
        let robot = &run.robot.robot;
        let compare_from = run.record.compare_from;
        let rule = Rule { compare_from };
        let of_estimator = |(index, e): (usize, &EstimatorDescription)| EstimatorTraces {
            index,
            name: e.label.clone(),
            figure: figure_of(e),
            normal_force: estimated(),
            error: estimated(),
            score: Score::new(rule),
            is_shown: run.both.is_some() || shown == Some(index),
            traction: estimated(),
            pins: from_fn(|_| from_fn(|_| Estimated::new(records))),
            pin_errors: Default::default(),
        };
        Self {
            rule,
            end: 0.0,
            truths: match run.both {
                Some(_) => vec![true_forces(), true_forces()],
                None => vec![true_forces()],
            },
            has_truth: run.has_truth,
            normal_force_at: traces(),
            pins: from_fn(|_| from_fn(|_| Trace::new(records))),
            estimators: estimators.iter().enumerate().map(of_estimator).collect(),
            poses: Vec::new(),
            records_per_pose: records.div_ceil(POSES).max(1),
            records: 0,
            last: None,
            ground: run.world.as_ref().map(|w| w.terrain.build(robot)),
            geometry: robot.geometry.clone(),
            mean_load: robot.mean_wheel_load(),
        }
    }

    /// What an estimator is compared with; without one what all are.
    pub fn truth_of(&self, estimator: Option<&EstimatorTraces>) -> &TrueForces {
        let index = estimator.map_or(0, |e| e.index);
        &self.truths[index.min(self.truths.len() - 1)]
    }

    /// Adds one record.
    pub fn add(&mut self, frame: &Frame<'_>) {
        self.end = frame.time;
        let truths = frame.truths();
        for (traces, truth) in self.truths.iter_mut().zip(truths) {
            traces.add(frame.time, truth);
        }
        if let Some(truth) = frame.truth {
            self.add_truth(frame.time, truth);
        }
        let judge = |truth: &Truth| (truth.time, self.rule.judge(truth), Compared::of(truth));
        let judged: Vec<_> = truths.iter().map(judge).collect();
        for estimator in &mut self.estimators {
            let index = estimator.index;
            let estimate = frame.estimate(index);
            let judged = judged.get(index.min(self.truths.len() - 1));
            if let Some((time, judged, _)) = judged {
                estimator.score.add_judged(*time, judged, estimate);
            }
            let compared = judged.and_then(|(.., compared)| compared.as_ref());
            estimator.add(frame.time, compared, estimate);
            if estimator.is_shown {
                estimator.add_shown(frame, estimate, self.rule.compares(frame.time));
            }
        }
        self.records += 1;
    }

    fn add_truth(&mut self, time: f64, truth: &Truth) {
        for (i, wheel) in truth.wheels.iter().enumerate() {
            let contact = wheel.equivalent_contact();
            let normal_force = contact.map(|c| c.normal_force);
            self.normal_force_at[i].add(wheel.position.x, normal_force);
        }
        for (traces, (pin, _)) in self.pins.iter_mut().zip(PINS) {
            let from_q = true_from_q(truth, pin);
            traces[0].add(time, Some(from_q.x));
            traces[1].add(time, Some(from_q.y));
        }
        if self.records.is_multiple_of(self.records_per_pose) {
            self.poses.push(*truth);
        }
        self.last = Some(*truth);
    }

    /// The run has ended: the last pose is kept, too.
    pub fn finish(&mut self) {
        self.poses.extend(self.last.take());
    }
}

impl TrueForces {
    fn add(&mut self, time: f64, truth: &Truth) {
        for (i, wheel) in truth.wheels.iter().enumerate() {
            let contact = wheel.equivalent_contact();
            self.normal_force[i].add(time, contact.map(|c| c.normal_force));
            self.traction[i].add(time, Some(wheel.traction));
        }
    }
}

impl EstimatorTraces {
    fn add(&mut self, time: f64, compared: Option<&Compared>, estimate: Option<&Estimate>) {
        for i in 0..3 {
            let normal = estimate.map(|e| e.normal_force[i]);
            let error = normal
                .zip(compared)
                .map(|(n, c)| n - c.wheels[i].normal_force);
            let sigma = estimate.and_then(|e| e.sigma_normal(i));
            self.normal_force[i].add(time, normal, sigma);
            self.error[i].add_around(time, error, Some(0.0), sigma);
        }
    }

    fn add_shown(&mut self, frame: &Frame<'_>, estimate: Option<&Estimate>, compared: bool) {
        let time = frame.time;
        for i in 0..3 {
            let traction = estimate.map(|e| e.traction[i]);
            let sigma = estimate.and_then(|e| e.sigma_traction(i));
            self.traction[i].add(time, traction, sigma);
        }
        for (k, (pin, _)) in PINS.into_iter().enumerate() {
            let from_q = estimate.map(|e| e.pin_from_q[pin as usize] * MM);
            self.pins[k][0].add(time, from_q.map(|v| v.x), None);
            self.pins[k][1].add(time, from_q.map(|v| v.y), None);
            if let (Some(from_q), Some(truth), true) = (from_q, frame.truth, compared) {
                let error = from_q - true_from_q(truth, pin);
                // A truth of a log may have forces alone.
                if error.x.is_finite() && error.y.is_finite() {
                    self.pin_errors[k][0].add(error.x);
                    self.pin_errors[k][1].add(error.y);
                }
            }
        }
    }
}

/// Whether an estimator has the settings of a preset. Its label shows nothing. The noise budget
/// does not count: it belongs to the scene, and the paper's method does not use it.
fn is_preset(estimator: &EstimatorDescription, preset: EstimatorSettings) -> bool {
    let budget = estimator.listed.budget;
    estimator.listed == EstimatorSettings { budget, ..preset }
}

/// Stem of the file and title of the figure of N.
fn figure_of(estimator: &EstimatorDescription) -> (String, String) {
    let label = &estimator.label;
    let lumped = |figure: u32, to: &str| {
        let title = "Normal forces, linkage mass lumped to the";
        let title = format!("{title} {to} (as the paper's Fig. {figure})");
        (format!("fig{figure}_{label}"), title)
    };
    if is_preset(estimator, EstimatorSettings::paper_body()) {
        lumped(7, "body")
    } else if is_preset(estimator, EstimatorSettings::paper_wheels()) {
        lumped(8, "wheels")
    } else {
        let title = format!("Normal forces, estimator {label}");
        (format!("normal_force_{label}"), title)
    }
}

/// True position of a pin from Q, mm.
fn true_from_q(truth: &Truth, pin: Pin) -> Vec2 {
    (truth.pin(pin).position - truth.pin(Pin::Q).position) * MM
}
