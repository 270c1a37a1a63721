//! Scenes of the tests.

use robhaz_scene::{RecordChoice, Scene};

/// The default robot on the terrain `smooth` with all presets but `kalman`. Records at 1 kHz for
/// `duration` (s).
pub fn smooth(duration: f64) -> Scene {
    let mut scene = with_kalman(duration);
    scene.estimators.retain(|e| !e.settings.states_covariance());
    scene
}

/// As [`smooth`], with `kalman` as the fourth estimator.
pub fn with_kalman(duration: f64) -> Scene {
    let mut scene = Scene {
        name: "smooth".to_owned(),
        record: RecordChoice {
            duration,
            compare_from: 2.0_f64.min(duration),
            ..RecordChoice::default()
        },
        ..Scene::default()
    };
    scene.estimators.truncate(4);
    scene
}
