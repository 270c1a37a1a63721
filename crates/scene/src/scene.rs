//! A scene with every choice made: the result of reading a scene file.

use crate::estimators::{self, EstimatorChoice};
use crate::model_error::{ModelError, Result};
use crate::robot::RobotChoice;
use crate::terrain::TerrainChoice;
use robhaz_control::shared::{largest_integral_ratio, largest_proportional_gain};
use robhaz_control::{ControlKind, ControlSettings, FrictionTestPlan};
use robhaz_estimator::statics::LoadCovariance;
use robhaz_estimator::{EstimatorSettings, NoiseBudget};
use robhaz_model::Robot;
use robhaz_sim::contact::ContactLaw;
use robhaz_sim::drive::{Drive, SpeedScaling};
use robhaz_sim::friction::FrictionLaw;
use robhaz_sim::sensors::{Grade, ImuPlace, SensorSpec, Sensors};
use robhaz_sim::{EngineChoice, PlantSetup};
use robhaz_terrain::Profile;

/// Everything that a run depends on. SI throughout.
#[derive(Clone, Debug, PartialEq)]
pub struct Scene {
    /// `name` of the file, else the file's stem: the name of the default output folder. Lower-case
    /// letters, digits, `-`, `_`.
    pub name: String,
    /// Seed of everything random in the run.
    pub seed: u64,
    /// `[robot]`
    pub robot: RobotChoice,
    /// `[terrain]`
    pub terrain: TerrainChoice,
    /// `[contact]`, eq. (10)
    pub contact: ContactLaw,
    /// `[contact]`, eq. (11) and rolling resistance
    pub friction: FrictionLaw,
    /// `[drive]`, eq. (2)
    pub drive: Drive,
    /// `[drive]`: control of the wheels
    pub control: ControlChoice,
    /// `[sensors]`
    pub sensors: SensorChoice,
    /// `[model_error]`: differences between the nominal robot and the simulated one.
    pub model_error: ModelError,
    /// `[[estimator]]`, in the file's order; names are unique. May be empty.
    pub estimators: Vec<EstimatorChoice>,
    /// `[engine]`
    pub engine: EngineChoice,
    /// `[record]`
    pub record: RecordChoice,
}

/// The sensors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SensorChoice {
    /// The preset of their errors.
    pub grade: Grade,
    /// Their errors: those of the grade, with single values overridden.
    pub spec: SensorSpec,
    /// Samples a second, Hz; a whole multiple of the record's rate.
    pub rate: f64,
}

/// The control of the wheels.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ControlChoice {
    /// Kind of control.
    pub kind: ControlKind,
    /// Name of the estimator that the control gets, among [`Scene::estimators`]. Always there for a
    /// closed loop.
    pub estimator: Option<String>,
    /// What the kind `friction-test` does.
    pub friction_test: FrictionTestPlan,
}

/// Duration and rate of the records.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RecordChoice {
    /// Simulated time, s.
    pub duration: f64,
    /// Records a second, Hz.
    pub rate: f64,
    /// Errors are computed from this time on, after rest and start, s.
    pub compare_from: f64,
}

/// Largest overshoot of a curve beyond the heights of two neighbouring points without a warning, as
/// a share of the ground's height range: a spline through a well-sampled summit overshoots, too.
const OVERSHOOT: f64 = 0.05;

impl SensorChoice {
    /// The sensors of a grade, at 1 kHz.
    pub fn of(grade: Grade) -> Self {
        Self {
            grade,
            spec: grade.sensors(),
            rate: 1000.0,
        }
    }
}

impl Default for SensorChoice {
    /// Ideal sensors at 1 kHz.
    fn default() -> Self {
        Self::of(Grade::Ideal)
    }
}

impl RecordChoice {
    /// Number of records: one at time 0, one at the end, one a period between.
    pub fn count(&self) -> u64 {
        // Checked when read: positive and bounded.
        let periods = (self.duration * self.rate).round() as u64;
        periods + 1
    }
}

impl Default for RecordChoice {
    /// 20 s at 1 kHz, errors from 2 s on.
    fn default() -> Self {
        Self {
            duration: 20.0,
            rate: 1000.0,
            compare_from: 2.0,
        }
    }
}

impl Default for Scene {
    /// The scene of an empty file: robot A on the smooth course under the PI drive, all presets of
    /// the estimator.
    fn default() -> Self {
        Self {
            name: "scene".to_owned(),
            seed: 0,
            robot: RobotChoice::default(),
            terrain: TerrainChoice::default(),
            contact: ContactLaw::default(),
            friction: FrictionLaw::default(),
            drive: Drive::default(),
            control: ControlChoice::default(),
            sensors: SensorChoice::default(),
            model_error: ModelError::default(),
            estimators: estimators::defaults(),
            engine: EngineChoice::default(),
            record: RecordChoice::default(),
        }
    }
}

impl Scene {
    /// The plant of this scene; one period is one sample of the sensors.
    pub fn plant_setup(&self) -> PlantSetup {
        PlantSetup {
            robot: self.robot.robot.clone(),
            terrain: self.terrain.build(&self.robot.robot),
            contact: self.contact,
            friction: self.friction,
            stretches: self.terrain.stretches.clone(),
            drive: self.drive.clone(),
            engine: self.engine,
            period: 1.0 / self.sensors.rate,
            balance: false,
        }
    }

    /// Warnings about allowed values that may be mistakes, one line each.
    pub fn warnings(&self) -> Vec<String> {
        let parts: Vec<(String, &Profile)> = match &self.terrain.profile {
            Profile::Course(course) => {
                let parts = course.profiles().enumerate();
                parts
                    .map(|(i, p)| (format!("terrain.part[{i}]"), p))
                    .collect()
            }
            one => vec![("terrain".to_owned(), one)],
        };
        let overshoot = |(path, profile): &(String, &Profile)| {
            let Profile::Heights(heights) = profile else {
                return None;
            };
            let found = heights.overshoot().filter(|o| o.share > OVERSHOOT)?;
            Some(format!(
                "{path}: near x = {:.3} m the spline leaves the heights of its points by {:.3} m, {:.0} % of the height from the \
                 lowest to the highest; interpolation = \"monotone\" stays between them",
                found.x,
                found.beyond,
                100.0 * found.share
            ))
        };
        let mut warnings: Vec<String> = parts.iter().filter_map(overshoot).collect();
        let scalings = self.drive.scalings.iter().enumerate();
        warnings.extend(scalings.filter_map(|(i, s)| self.warning_of_scaling(i, s)));
        let planned = self.control.friction_test != FrictionTestPlan::default();
        if planned && self.control.kind != ControlKind::FrictionTest {
            let kind = ControlKind::FrictionTest.name();
            warnings.push(format!(
                "drive.friction_test has no effect without drive.kind = \"{kind}\""
            ));
        }
        warnings
    }

    /// A scaling without its full effect.
    fn warning_of_scaling(&self, index: usize, scaling: &SpeedScaling) -> Option<String> {
        let path = format!("drive.scaling[{index}]");
        let (end, ramp) = (self.record.duration, self.drive.ramp_time);
        if scaling.from >= end {
            let from = scaling.from;
            return Some(format!(
                "{path} begins at {from} s, when the run has ended ({end} s)"
            ));
        }
        let length = scaling.to - scaling.from;
        (length < ramp).then(|| {
            format!(
                "{path} lasts {length:.3} s, shorter than drive.ramp_time = {ramp} s: its factor is not reached"
            )
        })
    }

    /// The sensors of this scene, with the errors that its seed draws.
    pub fn sensors(&self) -> Sensors {
        Sensors::new(&self.sensors.spec, self.seed, &self.robot.robot)
    }

    /// The nominal robot, which the estimators are given.
    ///
    /// # Errors
    /// [`ModelErrorTooLarge`](crate::ModelErrorTooLarge) when `[model_error]` draws an invalid robot. Scenes that were
    /// read from files are checked.
    pub fn nominal_robot(&self) -> Result<Robot> {
        Ok(self.nominal()?.0)
    }

    fn nominal(&self) -> Result<(Robot, Option<LoadCovariance>)> {
        self.model_error.nominal(&self.robot.robot, self.seed)
    }

    /// The estimator that the control gets, as an index of [`Scene::estimators`]. `None` for a
    /// control without readings.
    pub fn control_estimator(&self) -> Option<usize> {
        let name = self.control.estimator.as_deref()?;
        let closed = self.control.kind.is_closed_loop();
        let place = self.estimators.iter().position(|e| e.name == name);
        place.filter(|_| closed)
    }

    /// Kp (N m s) and Ki (N m) of the control: those of the drives, which are continuous; of one speed
    /// control at most what a wheel in the air bears at the rate of the readings.
    fn gains(&self) -> [f64; 2] {
        let (drive, rate) = (&self.drive, self.sensors.rate);
        if self.control.kind != ControlKind::Shared {
            return [drive.kp, drive.ki];
        }
        let kp = (drive.kp).min(largest_proportional_gain(&self.robot.robot, rate));
        [kp, drive.ki.min(largest_integral_ratio(rate) * kp)]
    }

    /// What the control is designed for: the nominal robot and the gains of the drives.
    ///
    /// # Errors
    /// As [`Scene::nominal_robot`].
    pub fn control_settings(&self) -> Result<ControlSettings> {
        let drive = &self.drive;
        let [kp, ki] = self.gains();
        Ok(ControlSettings {
            kind: self.control.kind,
            robot: self.nominal_robot()?,
            viscous_damping: self.model_error.nominal_damping(drive.viscous_damping),
            kp,
            ki,
            torque_limit: drive.torque_limit,
            tracking_time: drive.tracking_time,
            friction_test: self.control.friction_test,
        })
    }

    /// The settings of an estimator with the nominal damping and the noise budget.
    ///
    /// # Errors
    /// As [`Scene::nominal_robot`].
    pub fn nominal_settings(&self, estimator: &EstimatorChoice) -> Result<EstimatorSettings> {
        let settings = estimator.settings;
        let damping = estimator.damping.unwrap_or(self.drive.viscous_damping);
        Ok(EstimatorSettings {
            viscous_damping: self.model_error.nominal_damping(damping),
            compression: self.contact.mean_penetration(&self.robot.robot),
            budget: self.noise_budget()?,
            ..settings
        })
    }

    /// The noise budget from the sensors' data sheets and the tolerances of the nominal values. No
    /// data sheet states the gear friction: that of [`NoiseBudget::typical_for`]. A
    /// weighing replaces the tolerances of the nominal values.
    ///
    /// # Errors
    /// As [`Scene::nominal_robot`].
    pub fn noise_budget(&self) -> Result<NoiseBudget> {
        let (spec, model) = (&self.sensors.spec, &self.model_error);
        let (body_cg, link_mass, load_covariance) = match model.scales > 0.0 {
            true => (0.0, 0.0, self.nominal()?.1),
            false => (model.body_cg, model.link_masses, None),
        };
        let budget = NoiseBudget {
            encoder_counts: spec.encoder_counts,
            jitter: spec.jitter,
            torque_noise: spec.torque_noise,
            torque_offset: spec.torque_offset,
            torque_gain: spec.torque_gain,
            inclination_noise: spec.inclination_noise,
            inclination_bias: spec.inclination_bias,
            specific_force: spec.specific_force,
            inclination_lag: spec.inclination_lag,
            rate_noise: spec.rate_noise,
            rate_bias: spec.rate_bias,
            rate_walk: spec.rate_walk,
            contact_angle: spec.contact_angle_error,
            contact_angle_time: spec.contact_angle_time,
            body_cg,
            link_mass,
            load_covariance,
            ..NoiseBudget::typical_for(&self.robot.robot)
        };
        Ok(match spec.imu {
            ImuPlace::Links => budget,
            ImuPlace::Body => {
                budget.of_body_sensors(&self.robot.robot, [spec.pin_noise, spec.pin_bias])
            }
        })
    }

    /// Sensor samples between two records.
    pub fn samples_per_record(&self) -> u64 {
        // Checked when read: a small whole number.
        let samples = (self.sensors.rate / self.record.rate).round() as u64;
        samples.max(1)
    }
}
