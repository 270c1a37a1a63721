//! The sink that sums up a run.

use super::clearance::ClearanceSummary;
use super::file::Summary;
use super::log::{ForceSums, LogSummary};
use super::parts::{
    BrokenOff, ControlSummary, EstimatorSummary, FrictionSummary, FrictionTestSummary,
    NominalRobot, SensorErrors, TorqueScaleSummary,
};
use super::suspects::{Suspects, add_suspects};
use crate::error::RecordError;
use crate::felt_ground::FeltGrounds;
use robhaz_estimator::TorqueScale;
use robhaz_run::{ClearanceNeed, Frame, RunDescription, RunEnd, Sink, SinkError};
use robhaz_score::contact::ContactScore;
use robhaz_score::events::{EventCounts, EventDetector};
use robhaz_score::{ProgressMeter, Rule, Score};
use robhaz_sim::Truth;

/// Sums up a run. It keeps sums and the points of the ground, no records.
#[derive(Debug, Default)]
pub struct SummarySink {
    run: Option<RunDescription>,
    /// Scores of the estimators, in the order of the run; those of contact states where an estimator states them.
    scores: Vec<(Score, Option<ContactScore>)>,
    /// Progress and events of a simulation.
    progress: Option<ProgressMeter>,
    events: Option<(EventDetector, EventCounts)>,
    /// Clearance so far.
    clearance: Option<ClearanceSummary>,
    grounds: FeltGrounds,
    /// Sums over the estimates of a recorded log; empty for a simulation.
    sums: Vec<ForceSums>,
    /// The torques' scale of each estimator at its last estimate.
    scales: Vec<Option<TorqueScale>>,
    /// Suspect channels of each estimator.
    suspects: Vec<Suspects>,
    rule: Option<Rule>,
    /// Whether a record had a truth.
    compared: bool,
    end: Option<RunEnd>,
}

impl SummarySink {
    /// A sink for one run.
    pub fn new() -> Self {
        Self::default()
    }

    /// The summary of the run, marked when it broke off.
    ///
    /// # Errors
    /// [`RecordError::Unfinished`] when the run goes on, or has no record.
    pub fn summary(&self) -> Result<Summary, RecordError> {
        let (Some(run), Some(end)) = (&self.run, &self.end) else {
            return Err(RecordError::Unfinished);
        };
        let world = run.world.as_ref();
        let terrain = world.map(|w| w.terrain.build(&run.robot.robot));
        let estimators = run.estimators.iter().zip(&self.scores).enumerate();
        Ok(Summary {
            scene: run.name.clone(),
            engine: world.map(|w| w.engine.name().to_owned()),
            seed: world.map(|w| w.seed),
            duration_s: end.duration,
            wall_s: end.wall,
            real_time_factor: end.real_time_factor(),
            step_s: end.step,
            record_rate_hz: run.record.rate,
            compare_from_s: run.record.compare_from,
            version: env!("CARGO_PKG_VERSION").to_owned(),
            broken_off: end.broken_off.clone().map(|reason| BrokenOff {
                reason,
                time_s: end.duration,
            }),
            progress: self.progress.as_ref().map(|meter| meter.progress().into()),
            events: self.events.as_ref().map(|(_, counts)| *counts),
            clearance: self.clearance.clone(),
            friction: world.map(FrictionSummary::of),
            control: ControlSummary::of(run),
            friction_tests: end
                .friction_tests
                .iter()
                .map(FrictionTestSummary::of)
                .collect(),
            sensors: world.map(SensorErrors::of),
            log: end.log.as_ref().map(LogSummary::from),
            nominal: NominalRobot::of(run),
            estimators: estimators
                .map(|(k, (e, (score, contacts)))| {
                    let estimator = EstimatorSummary {
                        ground: self.grounds.errors(k, terrain.as_ref()),
                        suspects: self.suspects.get(k).cloned().unwrap_or_default(),
                        ..EstimatorSummary::new(
                            &e.label,
                            score,
                            contacts.as_ref().and_then(ContactScore::scores),
                        )
                    };
                    match self.sums.get(k) {
                        Some(sums) => EstimatorSummary {
                            torque_scale: self.scale(k, run.nominal_robot.mass.total()),
                            ..estimator.with_means(sums, self.compared)
                        },
                        None => estimator,
                    }
                })
                .collect(),
        })
    }
}

impl SummarySink {
    /// The torques' scale of an estimator, for a described mass of one side, kg.
    fn scale(&self, index: usize, described: f64) -> Option<TorqueScaleSummary> {
        let scale = self.scales.get(index)?.as_ref()?;
        Some(TorqueScaleSummary::of(scale, described))
    }

    /// Adds a record with its truth.
    fn compare(&mut self, truth: &Truth, frame: &Frame<'_>) {
        let judged = self.rule.map(|rule| rule.judge(truth));
        for (i, (score, contacts)) in self.scores.iter_mut().enumerate() {
            let estimate = frame.estimates.get(i).and_then(|e| e.as_ref().ok());
            if let Some(judged) = &judged {
                score.add_judged(truth.time, judged, estimate);
            }
            if let Some(contacts) = contacts {
                contacts.add(truth, estimate);
            }
        }
        if let Some(progress) = &mut self.progress {
            progress.add(truth);
        }
        if let Some(clearances) = &frame.clearances {
            ClearanceSummary::add(&mut self.clearance, frame.time, clearances);
        }
        if let Some((detector, counts)) = &mut self.events {
            if self.clearance.is_some() {
                counts.touches.get_or_insert(0);
            }
            detector.sample(truth, frame.clearances.as_ref(), &mut |event| {
                counts.add(&event);
                if let Some(clearance) = &mut self.clearance {
                    clearance.add_event(&event);
                }
            });
        }
    }
}

impl Sink for SummarySink {
    fn clearance_need(&self) -> ClearanceNeed {
        ClearanceNeed::AtChanges
    }

    fn begin(&mut self, run: &RunDescription) -> Result<(), SinkError> {
        let rule = Rule {
            compare_from: run.record.compare_from,
        };
        let geometry = &run.robot.robot.geometry;
        let world = run.world.as_ref();
        *self = Self {
            run: Some(run.clone()),
            scores: run
                .estimators
                .iter()
                .map(|e| {
                    let contacts = e.settings.states_contacts();
                    (Score::new(rule), contacts.then(|| ContactScore::new(rule)))
                })
                .collect(),
            progress: world.map(|w| ProgressMeter::new(&w.drive, geometry.wheel_radius)),
            events: world.map(|_| (EventDetector::new(geometry.stop), EventCounts::default())),
            clearance: None,
            grounds: FeltGrounds::new(run),
            sums: match world {
                Some(_) => Vec::new(),
                None => vec![ForceSums::default(); run.estimators.len()],
            },
            scales: vec![None; run.estimators.len()],
            suspects: vec![Suspects::new(); run.estimators.len()],
            rule: Some(rule),
            compared: false,
            end: None,
        };
        Ok(())
    }

    fn frame(&mut self, frame: &Frame<'_>) -> Result<(), SinkError> {
        if let Some(truth) = frame.truth {
            self.compared = true;
            self.compare(truth, frame);
        }
        self.grounds.add(frame);
        for (suspects, estimate) in self.suspects.iter_mut().zip(frame.estimates) {
            if let Ok(estimate) = estimate {
                add_suspects(suspects, frame.time, estimate);
            }
        }
        for (scale, estimate) in self.scales.iter_mut().zip(frame.estimates) {
            if let Ok(estimate) = estimate {
                *scale = estimate.torque_scale.or(*scale);
            }
        }
        if self.rule.is_some_and(|rule| rule.compares(frame.time)) {
            for (sums, estimate) in self.sums.iter_mut().zip(frame.estimates) {
                sums.add(estimate.as_ref().ok());
            }
        }
        Ok(())
    }

    fn end(&mut self, end: Option<&RunEnd>) -> Result<(), SinkError> {
        self.grounds.finish(end);
        self.end = end.cloned();
        Ok(())
    }
}
