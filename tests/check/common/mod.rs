//! Honest readings of shipped scenes, and faults made of them.

pub mod faults;

use robhaz_estimator::{Estimate, Estimator, EstimatorSettings, KalmanReport, SensorFrame};
use robhaz_log::check::{BodyNoise, Report, Stated, check};
use robhaz_scene::Scene;
use robhaz_sim::Truth;
use robhaz_study::TruthRun;
use std::error::Error;
use std::path::Path;

pub type Failure = Box<dyn Error + Send + Sync>;

/// The low-gain drive.
pub const SOFT: [&str; 2] = ["drive.kp=2", "drive.ki=0"];

/// A shipped scene with overrides.
pub fn scene(name: &str, overrides: &[&str]) -> Result<Scene, Failure> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes");
    let fixed = [
        "engine.kind=direct",
        "estimator=[{name='kalman'},{name='kalman',label='kalman-no-angles',contact_angles='none'}]",
    ];
    let overrides = fixed.iter().chain(overrides);
    let overrides: Vec<String> = overrides.map(|s| (*s).to_owned()).collect();
    Ok(Scene::load(&path.join(format!("{name}.toml")), &overrides)?)
}

/// The readings of a scene whose truth is known, with the sensor errors of a seed.
pub fn readings(scene: &Scene, truth: &TruthRun, seed: u64) -> Vec<SensorFrame> {
    readings_of(scene, truth.samples(), seed)
}

/// The readings of samples of the truth, with the sensor errors of a seed.
pub fn readings_of<'a>(
    scene: &Scene,
    samples: impl Iterator<Item = &'a Truth>,
    seed: u64,
) -> Vec<SensorFrame> {
    let mut scene = scene.clone();
    scene.seed = seed;
    let mut sensors = scene.sensors();
    samples.map(|t| sensors.read(t)).collect()
}

/// A scene with typical sensors and further keys, and its readings at 100 Hz with the sensor errors of a seed.
pub fn drive(name: &str, keys: &[&str], seed: u64) -> Result<(Scene, Vec<SensorFrame>), Failure> {
    let scene = scene(name, &[keys, &["sensors.grade=typical"]].concat())?;
    let truth = TruthRun::of(&scene)?;
    let frames = readings_of(&scene, truth.samples().step_by(10), seed);
    Ok((scene, frames))
}

/// By how much the forces of a wheel err, and what is stated of it, N.
pub struct Errors {
    /// Of N and T.
    pub errors: [f64; 2],
    pub sigmas: [f64; 2],
    /// True N.
    pub load: f64,
}

impl Errors {
    /// Of the wheels that have an equivalent contact, with their numbers.
    pub fn of(estimate: &Estimate, truth: &Truth) -> Result<Vec<(usize, Self)>, Failure> {
        let mut all = Vec::new();
        for (i, wheel) in truth.wheels.iter().enumerate() {
            let Some(contact) = wheel.equivalent_contact() else {
                continue;
            };
            let sigmas = estimate.sigma_normal(i).zip(estimate.sigma_traction(i));
            let errors = Self {
                errors: [
                    estimate.normal_force[i] - contact.normal_force,
                    estimate.traction[i] - contact.traction,
                ],
                sigmas: sigmas.ok_or("kalman states its deviations")?.into(),
                load: contact.normal_force,
            };
            all.push((i, errors));
        }
        Ok(all)
    }

    /// The same in deviations. Forces that are held at zero have none: at least `least`, N.
    pub fn in_deviations(&self, least: f64) -> [f64; 2] {
        [0, 1].map(|k| self.errors[k].abs() / self.sigmas[k].max(least))
    }
}

/// RMS error of N over the mean N from 2 s on and the mean of its stated deviation over the same, of the frames of
/// samples of the truth; and the last report.
pub fn error_of(
    scene: &Scene,
    samples: &[&Truth],
    frames: &[SensorFrame],
    settings: EstimatorSettings,
) -> Result<([f64; 2], KalmanReport), Failure> {
    let mut estimator = Estimator::new(&scene.nominal_robot()?, settings);
    let (mut squares, mut stated, mut sum, mut count, mut last) = (0.0, 0.0, 0.0, 0.0, None);
    for (sample, frame) in samples.iter().zip(frames) {
        let Ok(estimate) = estimator.update(frame) else {
            continue;
        };
        last = estimate.kalman;
        let errors = Errors::of(&estimate, sample)?;
        for (_, wheel) in errors.iter().filter(|_| frame.time > 2.0) {
            squares += wheel.errors[0] * wheel.errors[0];
            stated += wheel.sigmas[0];
            sum += wheel.load;
            count += 1.0;
        }
    }
    let relative = [f64::sqrt(squares * count) / sum, stated / sum];
    Ok((relative, last.ok_or("no estimate")?))
}

/// Number of seeds of a study: this one, or that of the environment variable SEEDS.
pub fn seeds(usual: u64) -> u64 {
    let stated = std::env::var("SEEDS").ok();
    stated.and_then(|n| n.parse().ok()).unwrap_or(usual)
}

/// What `check` says of frames with what a scene states, without contact angles: no robot knows
/// them.
pub fn report(scene: &Scene, frames: &[SensorFrame]) -> Result<Report, Failure> {
    let mut frames = frames.to_vec();
    frames.iter_mut().for_each(|f| f.contact_angle = [None; 3]);
    checked(scene, false, &frames)
}

/// The same of frames as they are, whose links' readings may be made of sensors of the body.
pub fn checked(scene: &Scene, of_body: bool, frames: &[SensorFrame]) -> Result<Report, Failure> {
    let best = scene.estimators.last().ok_or("no estimator")?;
    let settings = scene.nominal_settings(best)?;
    let spec = &scene.sensors.spec;
    let stated = Stated {
        robot: &scene.nominal_robot()?,
        settings,
        body: of_body.then_some(BodyNoise {
            inclination: spec.inclination_noise,
            rate: spec.rate_noise,
            pin: spec.pin_noise,
        }),
        compare_from: scene.record.compare_from,
    };
    Ok(check(frames, &stated))
}
