//! A run of a scene, kept in memory.

use crate::{DrivenPlant, MOST_KEPT, Result, RunError, Stop};
use robhaz_scene::Scene;
use robhaz_sim::{Balance, PlantError, Truth};

/// Truth and balance of a run at each record, up to its end or until it stopped.
#[derive(Clone, Debug, PartialEq)]
pub struct Run {
    /// The truth at each record.
    pub truth: Vec<Truth>,
    /// Impulse and work up to each record.
    pub balance: Vec<Balance>,
    /// Reason why the run stopped before its end.
    pub stopped: Option<PlantError>,
}

impl Run {
    /// Runs a whole scene, with one record per period.
    ///
    /// # Errors
    /// [`RunError::TooLong`], and as [`DrivenPlant::new`].
    pub fn of(scene: &Scene) -> Result<Self> {
        Self::until(scene, &|| None)
    }

    /// The same; [`RunError::Stopped`] where `stop` names a cause.
    pub(super) fn until(scene: &Scene, stop: Stop<'_>) -> Result<Self> {
        let found = scene.record.count();
        if found > MOST_KEPT {
            let (of, who) = ("records", "verify");
            return Err(RunError::TooLong { found, of, who });
        }
        let mut run = Self {
            truth: Vec::new(),
            balance: Vec::new(),
            stopped: None,
        };
        let mut plant = match Records::of(scene) {
            Err(RunError::Start(why)) => {
                run.stopped = Some(why.cause);
                return Ok(run);
            }
            made => made?,
        };
        for _ in 0..found {
            go_on(stop)?;
            match plant.next_truth() {
                Ok(truth) => {
                    run.truth.push(truth);
                    run.balance.extend(plant.plant.balance());
                }
                Err(why) => {
                    run.stopped = Some(why);
                    break;
                }
            }
        }
        Ok(run)
    }

    /// Runs the scene again, and compares it with this run: the same bits at each record, and the
    /// same end.
    ///
    /// # Errors
    /// As [`DrivenPlant::new`]; [`RunError::Stopped`].
    pub(super) fn repeats(&self, scene: &Scene, stop: Stop<'_>) -> Result<bool> {
        let mut plant = Records::of(scene)?;
        for (truth, balance) in self.truth.iter().zip(&self.balance) {
            go_on(stop)?;
            if plant.next_truth() != Ok(*truth) || plant.plant.balance() != Some(balance) {
                return Ok(false);
            }
        }
        let stopped = self.stopped;
        Ok(stopped.is_none_or(|why| plant.next_truth() == Err(why)))
    }
}

fn go_on(stop: Stop<'_>) -> Result {
    stop().map_or(Ok(()), |cause| Err(RunError::Stopped { cause }))
}

/// The records of a scene, with impulse and work.
struct Records {
    plant: DrivenPlant,
    samples_per_record: u64,
    started: bool,
}

impl Records {
    /// Before the first record. A control that takes readings needs every sample; else a period is
    /// a record.
    fn of(scene: &Scene) -> Result<Self> {
        let mut setup = scene.plant_setup();
        setup.balance = true;
        let mut samples_per_record = scene.samples_per_record();
        if !scene.control.kind.is_closed_loop() {
            setup.period = 1.0 / scene.record.rate;
            samples_per_record = 1;
        }
        Ok(Self {
            plant: DrivenPlant::new(scene, &setup)?,
            samples_per_record,
            started: false,
        })
    }

    /// The truth at the next record.
    fn next_truth(&mut self) -> Result<Truth, PlantError> {
        if std::mem::replace(&mut self.started, true) {
            for _ in 1..self.samples_per_record {
                self.plant.next_truth()?;
            }
        }
        self.plant.next_truth()
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test may stop at the first surprise")]
mod tests {
    use super::*;

    /// Equivalence and sensitivity: a run repeats to the bit; a record that differs by one bit is
    /// found.
    #[test]
    fn a_run_repeats_to_the_bit() {
        let mut scene = Scene::default();
        scene.record.duration = 0.05;
        let mut run = Run::of(&scene).unwrap();
        assert!(run.repeats(&scene, &|| None).unwrap());
        let force = &mut run.truth.last_mut().unwrap().wheels[0].normal_force;
        *force = f64::from_bits(force.to_bits() + 1);
        assert!(!run.repeats(&scene, &|| None).unwrap());
    }
}
