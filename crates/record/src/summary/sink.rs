//! The sink that sums up a run.

use super::Summary;
use super::both::BothSums;
use super::means::ForceSums;
use super::parts::{
    BrokenOff, ClearanceSummary, ControlSummary, EstimatorSummary, Faulty, FaultyChannels,
    FrictionSummary, FrictionTestSummary, NominalRobot, SensorErrors, TorqueScaleSummary,
};
use crate::error::{RecordError, Result};
use crate::estimated_terrain::compared;
use robhaz_estimator::{Channels, Estimate, TorqueScale};
use robhaz_run::{EstimatorDescription, Frame, RunDescription, RunEnd, Sink, SinkError};
use robhaz_score::contact::ContactScore;
use robhaz_score::events::{EventCounts, EventDetector};
use robhaz_score::{Agreement, Excuse, GroundErrors, Inclusion, ProgressMeter, Rule, Score};
use robhaz_sim::Truth;

/// Sums up a run. It keeps sums and the points of the ground, no records.
#[derive(Debug, Default)]
pub struct SummarySink {
    run: Option<RunDescription>,
    estimators: Vec<EstimatorSums>,
    /// Progress and events of a simulation.
    progress: Option<ProgressMeter>,
    events: Option<(EventDetector, EventCounts)>,
    /// Clearance so far.
    clearance: Option<ClearanceSummary>,
    /// Of a log of both sides.
    both: BothSums,
    rule: Option<Rule>,
    /// Whether a record had a truth.
    compared: bool,
    end: Option<RunEnd>,
}

/// Sums over the records of one estimator.
#[derive(Debug)]
struct EstimatorSums {
    score: Score,
    /// Where it states contact states.
    contacts: Option<ContactScore>,
    /// Of a recorded log.
    forces: Option<ForceSums>,
    /// The torques' scale at the last estimate that has one.
    scale: Option<TorqueScale>,
    faulty_channels: FaultyChannels,
    agreement: Agreement,
}

impl EstimatorSums {
    /// Adds a record; its truth with whether it counts, if there is one.
    fn add(
        &mut self,
        time: f64,
        judged: Option<&(&Truth, Inclusion)>,
        estimate: Option<&Estimate>,
        counts: bool,
    ) {
        if let Some((truth, judged)) = judged {
            self.score.add_judged(truth.time, judged, estimate);
            if let Some(contacts) = &mut self.contacts {
                contacts.add(truth, estimate);
            }
        }
        if let Some(estimate) = estimate {
            self.agreement.add(time, estimate);
        }
        if let Some(kalman) = estimate.and_then(|e| e.kalman.as_ref()) {
            for name in kalman.health.faulty.names() {
                let (first_s, records) = (time, 0);
                let faulty = self.faulty_channels.entry(name.to_owned());
                faulty.or_insert(Faulty { first_s, records }).records += 1;
            }
            self.scale = kalman.torque_scale.or(self.scale);
        }
        if let Some(forces) = self.forces.as_mut().filter(|_| counts) {
            forces.add(estimate);
        }
    }

    /// Why readings that contradict each other may look so; none of torques against the weight, nor of an edge in a
    /// run of both sides.
    fn excuse(&self, run: &RunDescription) -> Option<Excuse> {
        let mut of_scale = Channels::TORQUE_SCALE.names();
        let has_other = of_scale.any(|name| self.faulty_channels.contains_key(name));
        let found = self.agreement.contradiction(run.certain);
        let excuse = found.filter(|_| !has_other)?.excuse;
        excuse.filter(|excuse| run.both.is_none() || *excuse == Excuse::FarApart)
    }

    /// The summary of the estimator of a run, whose records had a truth if `compared`.
    fn summary(&self, run: &RunDescription, compared: bool) -> EstimatorSummary {
        let score = &self.score;
        let forces = self.forces.as_ref();
        let described = run.nominal_robot.mass.total();
        let scale = self.scale.as_ref().filter(|_| forces.is_some());
        let of_forces = forces.filter(|_| !compared);
        let (samples, missing) = of_forces.map_or_else(
            || (score.samples(), score.missing),
            |forces| (forces.samples, forces.missing),
        );
        EstimatorSummary {
            normal_force: score.normal_force(),
            traction: score.traction(),
            mean_normal_force: score.mean_normal_force(),
            stated: score.stated(),
            coverage: score.coverage(),
            nees: score.nees(),
            error_over_stated: score.normalised(),
            nis: score.nis(),
            lag_s: score.lag(),
            ground: None,
            samples,
            missing,
            two_contacts: score.two_contacts(),
            no_equivalent: score.no_equivalent,
            normal_force_at_one_contact: score.at_one_contact().normal_force(),
            contacts: self.contacts.as_ref().and_then(ContactScore::scores),
            faulty_channels: self.faulty_channels.clone(),
            excuse: self.excuse(run),
            excuse_of_forces: self.agreement.wrong(run.certain).flatten(),
            torque_scale: scale.map(|scale| TorqueScaleSummary::of(scale, described)),
            means: forces.and_then(ForceSums::means),
        }
    }
}

impl SummarySink {
    /// A sink for one run.
    pub fn new() -> Self {
        Self::default()
    }

    /// The summary of the run, marked when it broke off.
    ///
    /// # Errors
    /// [`RecordError::Refused`] when the run goes on, or has no record.
    pub fn summary(&self) -> Result<Summary> {
        let (Some(run), Some(end)) = (&self.run, &self.end) else {
            let why = "the run has no summary: it goes on, or it has no record";
            return Err(RecordError::Refused(why.to_owned()));
        };
        let world = run.world.as_deref();
        let terrain = world.map(|w| w.terrain.build(&run.robot.robot));
        let friction_tests = end.friction_tests.iter().map(FrictionTestSummary::of);
        let estimators = run.estimators.iter().zip(&self.estimators).enumerate();
        let estimators = estimators.map(|(k, (e, sums))| {
            let points = compared(run, end, k, terrain.as_ref());
            // Points behind the origin count, too.
            let points = points.into_iter().filter_map(|(p, t)| Some((p, t?)));
            let mut found = sums.summary(run, self.compared);
            found.ground = GroundErrors::of(points);
            (e.label.clone(), found)
        });
        Ok(Summary {
            scene: run.name.clone(),
            engine: world.map(|w| w.engine.kind.name().to_owned()),
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
            progress: self.progress.as_ref().map(|meter| meter.progress()),
            events: self.events.as_ref().map(|(_, counts)| *counts),
            clearance: self.clearance.clone(),
            friction: world.map(FrictionSummary::of),
            control: ControlSummary::of(run),
            friction_tests: friction_tests.collect(),
            sensors: world.map(SensorErrors::of),
            log: end.log.clone(),
            both: run
                .both
                .as_ref()
                .and_then(|both| self.both.summary(both, run.nominal_robot.mass.total())),
            nominal: NominalRobot::of(run),
            estimators: estimators.collect(),
        })
    }

    /// Adds the course of a simulation at a record.
    fn add_truth(&mut self, truth: &Truth, frame: &Frame<'_>) {
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
    fn begin(&mut self, run: &RunDescription) -> Result<(), SinkError> {
        let compare_from = run.record.compare_from;
        let rule = Rule { compare_from };
        let geometry = &run.robot.robot.geometry;
        let world = run.world.as_ref();
        let sums = |e: &EstimatorDescription| EstimatorSums {
            score: Score::new(rule),
            contacts: (e.settings.states_covariance()).then(|| ContactScore::new(rule)),
            forces: world.is_none().then(ForceSums::default),
            scale: None,
            faulty_channels: FaultyChannels::new(),
            agreement: Agreement::new(compare_from),
        };
        *self = Self {
            run: Some(run.clone()),
            estimators: run.estimators.iter().map(sums).collect(),
            progress: world.map(|w| ProgressMeter::new(&w.drive, geometry.wheel_radius)),
            events: world.map(|_| (EventDetector::new(geometry.stop), EventCounts::default())),

            rule: Some(rule),
            ..Self::default()
        };
        Ok(())
    }

    fn frame(&mut self, frame: &Frame<'_>) -> Result<(), SinkError> {
        let Some(rule) = self.rule else {
            return Ok(());
        };
        let truths = frame.truths().iter();
        let judged: Vec<_> = truths.map(|truth| (truth, rule.judge(truth))).collect();
        self.compared |= !judged.is_empty();
        if let Some(truth) = frame.truth {
            self.add_truth(truth, frame);
        }

        let counts = rule.compares(frame.time);
        if let Some(both) = &frame.both {
            self.both.add_scale(both);
            if counts {
                self.both.add(frame.time, both);
            }
        }
        for (k, sums) in self.estimators.iter_mut().enumerate() {
            let judged = judged.get(k).or(judged.last());
            sums.add(frame.time, judged, frame.estimate(k), counts);
        }
        Ok(())
    }

    fn end(&mut self, end: Option<&RunEnd>) -> Result<(), SinkError> {
        self.end = end.cloned();
        Ok(())
    }
}
