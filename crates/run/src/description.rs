//! What is known of a run before its first record.

use fnv::FnvHasher;
use robhaz_estimator::EstimatorSettings;
use robhaz_model::{Coupling, Robot};
use robhaz_scene::{
    EstimatorChoice, LogChoice, ModelErrorTooLarge, RecordChoice, RobotChoice, Scene,
};
use std::hash::Hasher as _;

/// What is known of a run before its first record, simulated or recorded.
#[derive(Clone, Debug, PartialEq)]
pub struct RunDescription {
    /// Name of the scene or log.
    pub name: String,
    /// Distinguishes runs of one name: it is equal for equal scenes. A log takes a hash of its
    /// content.
    pub fingerprint: u64,
    /// Rate of the records, planned duration, and the time from which errors count. Time starts at
    /// 0.
    pub record: RecordChoice,
    /// The estimators, in the order of [`crate::Frame::estimates`]. Their labels are unique.
    pub estimators: Vec<EstimatorDescription>,
    /// The robot that is simulated; of a log the nominal one.
    pub robot: RobotChoice,
    /// The nominal robot, which the estimators are given.
    pub nominal_robot: Robot,
    /// Nominal viscous damping B, N m s.
    pub nominal_damping: f64,
    /// Whether its records have the truth: those of a simulation, and of a log with a table of true
    /// forces.
    pub has_truth: bool,
    /// The scene of a simulation. `None` for a log.
    pub world: Option<Box<Scene>>,
    /// Of a log of both sides; `None` for other runs.
    pub both: Option<BothDescription>,
    /// Mean NIS from which on a contradiction between readings is one: 0 where they follow each other
    /// closely enough for the filters.
    pub certain: f64,
}

/// What is known of a run of both sides. Its estimators are the sides, left and right.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BothDescription {
    /// Name of the estimator of both.
    pub label: String,
    /// What joins the sides.
    pub coupling: Coupling,
    /// Why the readings of left and right contradict each other, before any estimate; `None` where
    /// they do not.
    pub contradiction: Option<String>,
    /// What the readings do not confirm, though the forces depend on it.
    pub unconfirmed: Vec<String>,
}

/// An estimator of a run.
#[derive(Clone, Debug, PartialEq)]
pub struct EstimatorDescription {
    /// Its name in tables, figures and file names.
    pub label: String,
    /// The settings as listed. They show which preset the estimator is.
    pub listed: EstimatorSettings,
    /// The settings that the estimator runs with: as listed, with the nominal damping and the noise
    /// budget.
    pub settings: EstimatorSettings,
}

impl RunDescription {
    /// The description of the simulation of a scene.
    ///
    /// # Errors
    /// [`ModelErrorTooLarge`] when the nominal robot is not a valid robot.
    pub fn of(scene: &Scene) -> Result<Self, ModelErrorTooLarge> {
        // Every choice as it is written in a resolved scene, with the hashes of its tracks.
        let mut hash = FnvHasher::default();
        hash.write(scene.to_toml("").as_bytes());
        let nominal = LogChoice::of_scene(scene)?;
        Ok(Self {
            robot: scene.robot.clone(),
            has_truth: true,
            world: Some(Box::new(scene.clone())),
            ..Self::of_log(&scene.name, hash.finish(), scene.record, &nominal)
        })
    }

    /// Whether a control that takes readings gives the records commands: see
    /// [`crate::Frame::commands`].
    pub fn takes_commands(&self) -> bool {
        let world = self.world.as_ref();
        world.is_some_and(|world| world.control.kind.is_closed_loop())
    }

    /// The description of a recorded log.
    pub fn of_log(name: &str, fingerprint: u64, record: RecordChoice, choice: &LogChoice) -> Self {
        let estimator = |e: &EstimatorChoice| EstimatorDescription {
            label: e.name.clone(),
            listed: e.settings,
            settings: choice.settings(e),
        };
        Self {
            name: name.to_owned(),
            fingerprint,
            record,
            estimators: choice.estimators.iter().map(estimator).collect(),
            robot: choice.robot.clone(),
            nominal_robot: choice.robot.robot.clone(),
            nominal_damping: choice.viscous_damping,
            has_truth: false,
            world: None,
            both: None,
            certain: 0.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Property: the estimators get the nominal damping and the noise budget; the listed settings
    /// stay as listed.
    #[test]
    fn estimators_run_with_the_nominal_damping() -> Result<(), ModelErrorTooLarge> {
        let mut scene = Scene::default();
        scene.model_error.viscous_damping = 0.1;
        let description = RunDescription::of(&scene)?;
        assert!((description.nominal_damping - 1.1 * scene.drive.viscous_damping).abs() < 1e-15);
        for (found, choice) in description.estimators.iter().zip(&scene.estimators) {
            assert_eq!(found.listed, choice.settings);
            assert_eq!(found.settings, scene.nominal_settings(choice)?);
            assert_ne!(found.settings, found.listed);
        }
        Ok(())
    }

    /// Property: any difference between two scenes changes the fingerprint.
    #[test]
    fn scenes_have_fingerprints() -> Result<(), ModelErrorTooLarge> {
        let scene = Scene::default();
        let other = Scene {
            seed: 1,
            ..scene.clone()
        };
        let print = |scene: &Scene| RunDescription::of(scene).map(|d| d.fingerprint);
        assert_eq!(print(&scene)?, print(&scene.clone())?);
        assert_ne!(print(&scene)?, print(&other)?);
        Ok(())
    }
}
