//! A run that tests and the example share.

use robhaz_estimator::EstimatorSettings;
use robhaz_model::Robot;
use robhaz_scene::{
    EngineChoice, EstimatorChoice, Grade, RecordChoice, RobotChoice, Scene, SensorChoice,
    TerrainChoice,
};
use robhaz_sim::contact::ContactLaw;
use robhaz_sim::drive::Drive;
use robhaz_sim::friction::FrictionLaw;
use robhaz_terrain::Profile;

/// The default robot on the profile `smooth` with the paper's estimators, recorded at 1 kHz for `duration` s.
pub fn smooth(duration: f64) -> Scene {
    let estimator = |name: &str, settings| EstimatorChoice {
        name: name.to_owned(),
        settings,
    };
    Scene {
        name: "smooth".to_owned(),
        seed: 1,
        robot: RobotChoice {
            geometry_name: "A".to_owned(),
            mass_name: "caption".to_owned(),
            robot: Robot::default_a(),
        },
        terrain: TerrainChoice {
            kind: "smooth",
            profile: Profile::smooth(),
            stretches: Vec::new(),
        },
        contact: ContactLaw::default(),
        friction: FrictionLaw::default(),
        drive: Drive::default(),
        sensors: SensorChoice {
            grade: Grade::Ideal,
            rate: 1000.0,
        },
        estimators: vec![
            estimator("paper-body", EstimatorSettings::paper_body()),
            estimator("paper-wheels", EstimatorSettings::paper_wheels()),
            estimator("true-mass", EstimatorSettings::true_mass()),
        ],
        engine: EngineChoice::default(),
        record: RecordChoice {
            duration,
            rate: 1000.0,
            compare_from: 2.0_f64.min(duration),
        },
    }
}
