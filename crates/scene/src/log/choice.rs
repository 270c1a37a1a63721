//! A log description with every choice made.

use super::mapping::{Mapping, StatedAt};
use crate::estimators::{self, EstimatorChoice, PRESETS};
use crate::model_error::ModelErrorTooLarge;
use crate::robot::RobotChoice;
use crate::scene::Scene;
use robhaz_estimator::{ContactAngles, EstimatorSettings, Method, NoiseBudget, Sides};
use robhaz_keys::reader::nearest;
use robhaz_model::named;
use robhaz_sim::sensors::ImuPlace;
use std::collections::BTreeSet;

named! {
    /// What the readings of a log are of.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    pub enum LogSides {
        /// One side of a robot with two.
        OneOfTwo = "one of two",
        /// A robot in the plane, such as a simulated one, or a test rig of one side.
        Plane = "plane",
        /// Both sides of a robot.
        Both = "both",
    }
}

impl LogSides {
    /// What an estimator of one side is of.
    pub fn of_side(self) -> Sides {
        match self {
            Self::Plane => Sides::Plane,
            Self::OneOfTwo | Self::Both => Sides::OneOfTwo,
        }
    }
}

/// Keys of which it counts whether they are stated: `sides`, else a log with readings of both sides is of both; the
/// robot and its errors; and those that else follow from the robot or the log.
pub(super) const STATED: &str = "sides robot budget.body_cg budget.link_masses budget.load_covariance \
    budget.wheel_radius budget.gear_friction budget.torque_offset budget.torque_noise drive.viscous_damping";

/// What is known of a log beside its readings. SI throughout.
#[derive(Clone, Debug, PartialEq)]
pub struct LogChoice {
    /// `name` of the description: the name of the default output folder. `None` for the name of the
    /// log.
    pub name: Option<String>,
    /// `sides`: whether the log is of one side of a robot with two, of a robot in the plane, or of
    /// both sides.
    pub sides: LogSides,
    /// Where that is stated.
    pub sides_at: StatedAt,
    /// The keys that are stated, of those of which that counts: `sides`, `robot`, the errors of a robot, and what else
    /// follows from the robot or the log.
    pub stated: BTreeSet<&'static str>,
    /// `[robot]`: the nominal robot.
    pub robot: RobotChoice,
    /// White noise of inclination (rad a sample) and rate (rad/s a sample) of the inertial sensor in
    /// the body of which the readings of the links are made, with the angle of pin Q; `None` of
    /// sensors on the links.
    pub body: Option<[f64; 2]>,
    /// White noise (rad a sample) and constant error (rad) of the angle of pin Q.
    pub pin: [f64; 2],
    /// `[drive]`: nominal viscous damping B of estimators without a value of their own, N m s.
    pub viscous_damping: f64,
    /// `[drive]`: efficiency of the gears of torques that are read before them, -.
    pub gear_efficiency: f64,
    /// `[contact]`: nominal compression of wheel and ground at the mean wheel load, m.
    pub compression: f64,
    /// `[budget]`: standard deviations of all sensor errors.
    pub budget: NoiseBudget,
    /// `[record]`: errors and means count from this time on, s.
    pub compare_from: f64,
    /// `[[estimator]]`, in order; names are unique.
    pub estimators: Vec<EstimatorChoice>,
    /// Which column is which reading. `None` for the names that a run writes. Not written into a
    /// resolved description: the table beside it has those names.
    pub mapping: Option<Mapping>,
}

/// Why estimators cannot run on a log.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct EstimatorError(String);

impl Default for LogChoice {
    /// One side of robot A, sensors of the budget [`NoiseBudget::typical`], all presets.
    fn default() -> Self {
        let scene = Scene::default();
        Self {
            name: None,
            sides: LogSides::OneOfTwo,
            sides_at: StatedAt::default(),
            stated: BTreeSet::new(),
            robot: scene.robot,
            body: None,
            pin: [0.1_f64.to_radians(); 2],
            viscous_damping: scene.drive.viscous_damping,
            gear_efficiency: 1.0,
            compression: EstimatorSettings::kalman().compression,
            budget: NoiseBudget::typical(),
            compare_from: scene.record.compare_from,
            estimators: estimators::defaults(),
            mapping: None,
        }
    }
}

impl LogChoice {
    /// The description of the readings of a scene: its nominal robot and damping, its noise budget
    /// and estimators.
    ///
    /// # Errors
    /// [`ModelErrorTooLarge`] when the nominal robot is not a valid robot.
    pub fn of_scene(scene: &Scene) -> Result<Self, ModelErrorTooLarge> {
        let robot = scene.nominal_robot()?;
        let name = |name: &str, same: bool| match same {
            true => name.to_owned(),
            false => format!("{name}, nominal"),
        };
        let (simulated, spec) = (&scene.robot, &scene.sensors.spec);
        let is_same = robot.geometry == simulated.robot.geometry;
        let geometry = name(&simulated.geometry_name, is_same);
        let mass = name(&simulated.mass_name, robot.mass == simulated.robot.mass);
        let nominal = |damping: f64| scene.model_error.nominal_damping(damping);
        let common = nominal(scene.drive.viscous_damping);
        let estimator = |choice: &EstimatorChoice| {
            let own = choice.damping.map_or(common, nominal);
            EstimatorChoice {
                damping: (own.to_bits() != common.to_bits()).then_some(own),
                ..choice.clone()
            }
        };
        Ok(Self {
            name: Some(scene.name.clone()),
            // The simulated robot.
            sides: LogSides::Plane,
            sides_at: StatedAt::default(),
            stated: STATED.split(' ').filter(|key| *key != "sides").collect(),
            robot: RobotChoice::new(geometry, mass, robot),
            body: (spec.imu == ImuPlace::Body).then_some([spec.inclination_noise, spec.rate_noise]),
            pin: [spec.pin_noise, spec.pin_bias],
            viscous_damping: common,
            gear_efficiency: 1.0,
            compression: scene.contact.mean_penetration(&simulated.robot),
            budget: scene.noise_budget()?,
            compare_from: scene.record.compare_from,
            estimators: scene.estimators.iter().map(estimator).collect(),
            mapping: None,
        })
    }

    /// Whether a key of [`Self::stated`] is stated, here or, of the robot, in a file of its own.
    pub fn states(&self, key: &str) -> bool {
        self.stated.contains(key)
    }

    /// Settings of an estimator with the drive, the noise budget and the sides that are stated of the log.
    pub fn stated(&self, settings: EstimatorSettings) -> EstimatorSettings {
        let rover = self.robot.whole_rover();
        let shift = rover.map(|rover| rover.load_shift());
        EstimatorSettings {
            load_shift: shift.unwrap_or(settings.load_shift),
            viscous_damping: self.viscous_damping,
            gear_efficiency: self.gear_efficiency,
            compression: self.compression,
            budget: self.budget,
            sides: self.sides.of_side(),
            ..settings
        }
    }

    /// The settings with which an estimator runs: as listed, with its nominal damping and what is stated.
    pub fn settings(&self, estimator: &EstimatorChoice) -> EstimatorSettings {
        let settings = self.stated(estimator.settings);
        EstimatorSettings {
            viscous_damping: estimator.damping.unwrap_or(settings.viscous_damping),
            ..settings
        }
    }

    /// Keeps the one estimator that a log of both sides can have: `kalman` without contact angles.
    /// With `named` estimators all of them must be able to.
    ///
    /// # Errors
    /// [`EstimatorError`]: none of them can.
    pub fn keep_one_of_both(&mut self, named: bool) -> Result<(), EstimatorError> {
        let refused = self.estimators.iter().find(|e| named && !e.rolls());
        let found = self.estimators.iter().find(|e| e.rolls());
        let (None, Some(found)) = (refused, found.cloned()) else {
            let name = refused.map_or("none of the description", |e| &e.name);
            let such = self.such_as_kalman();
            return Err(EstimatorError(format!(
                "estimator: found {name}, allowed for a log of both sides: one with filters = \"kalman\" and rolling = \"on\"{such}"
            )));
        };
        self.estimators = vec![found];
        self.without_contact_angles(true).map(|_| ())
    }

    /// Keeps the estimators of these names, in this order: those of the description, else presets.
    ///
    /// # Errors
    /// [`EstimatorError`]: a name that neither the description lists nor a preset has.
    pub fn select(&mut self, names: &[String]) -> Result<(), EstimatorError> {
        let mut selected: Vec<EstimatorChoice> = Vec::new();
        for name in names {
            let found = self.named(name)?;
            // Named twice, it runs once.
            if selected.iter().all(|e| e.name != *name) {
                selected.push(found);
            }
        }
        self.estimators = selected;
        Ok(())
    }

    /// Estimates without contact angles. Estimators that need them are left out, or, if `convert`,
    /// get the key `contact_angles = "none"`. Returns those that were left out.
    ///
    /// # Errors
    /// [`EstimatorError`] where an estimator cannot be converted, or none is left.
    pub fn without_contact_angles(
        &mut self,
        convert: bool,
    ) -> Result<Vec<EstimatorChoice>, EstimatorError> {
        let such = self.such_as_kalman();
        for estimator in self.estimators.iter_mut().filter(|_| convert) {
            if let Method::Kalman(method) = &mut estimator.settings.method
                && method.rolling
            {
                method.contact_angles = ContactAngles::Unknown;
            }
        }
        let needing = self.needing_contact_angles();
        let refused = match needing[..] {
            [first, ..] if convert => Some(needs_contact_angles(first, such)),
            _ if needing.is_empty() || needing.len() < self.estimators.len() => None,
            _ => Some(needs_contact_angles(&needing.join(", "), such)),
        };
        let needs = |e: &mut EstimatorChoice| e.settings.needs_contact_angles();
        let left_out = self.estimators.extract_if(.., needs).collect();
        refused.map_or(Ok(left_out), Err)
    }

    /// Names of the estimators that need contact angles.
    pub fn needing_contact_angles(&self) -> Vec<&str> {
        let needs = |e: &&EstimatorChoice| e.settings.needs_contact_angles();
        let names = self.estimators.iter().filter(needs);
        names.map(|e| e.name.as_str()).collect()
    }

    /// The mapping, for its keys.
    pub(super) fn mapped(&mut self) -> &mut Mapping {
        self.mapping.get_or_insert_default()
    }

    /// The end of a remedy: the preset, unless an estimator of the description hides it.
    fn such_as_kalman(&self) -> &'static str {
        match self.named("kalman") {
            Ok(found) if found.rolls() => ", such as --estimator kalman",
            _ => {
                ": turn it on in the description's own kalman, or rename that and take the preset with --estimator kalman"
            }
        }
    }

    fn named(&self, name: &str) -> Result<EstimatorChoice, EstimatorError> {
        if let Some(listed) = self.estimators.iter().find(|e| e.name == name) {
            return Ok(listed.clone());
        }
        let mut presets = estimators::defaults().into_iter();
        if let Some(choice) = presets.find(|preset| preset.name == name) {
            return Ok(choice);
        }
        let listed = || self.estimators.iter().map(|e| e.name.as_str());
        let presets = PRESETS.iter().map(|preset| preset.0);
        let presets = presets.filter(|p| listed().all(|e| e != *p));
        let allowed: Vec<&str> = listed().chain(presets).collect();
        let near = nearest(name, &allowed);
        let hint = near.map_or(String::new(), |near| format!("; did you mean {near}?"));
        Err(EstimatorError(format!(
            "estimator: found {name:?}, allowed: {}{hint}",
            allowed.join(", ")
        )))
    }
}

impl EstimatorChoice {
    /// Whether it runs without contact angles, if need be with another key.
    pub fn rolls(&self) -> bool {
        matches!(self.settings.method, Method::Kalman(method) if method.rolling)
    }
}

fn needs_contact_angles(names: &str, such: &str) -> EstimatorError {
    EstimatorError(format!(
        "{names} cannot estimate without contact angles; allowed: estimators with filters = \"kalman\" and rolling = \"on\"{such}"
    ))
}
