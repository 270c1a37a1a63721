//! A run that tests and the example share.

use robhaz_scene::{RecordChoice, Scene};

/// The default robot on the profile `smooth` with the paper's three estimators, recorded at 1 kHz for `duration` s.
pub fn smooth(duration: f64) -> Scene {
    let mut scene = with_best(duration);
    scene.estimators.retain(|e| e.name != "best");
    scene
}

/// The same with all estimators.
pub fn with_best(duration: f64) -> Scene {
    Scene {
        name: "smooth".to_owned(),
        record: RecordChoice {
            duration,
            compare_from: 2.0_f64.min(duration),
            ..RecordChoice::default()
        },
        ..Scene::default()
    }
}
