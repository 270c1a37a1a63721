//! The parts of a summary, with their units.

use robhaz_model::{Pin, Robot};
use robhaz_run::{RunDescription, World};
use robhaz_score::{ForceErrors, GroundErrors, Progress, Score};
use robhaz_sim::sensors::DrawnErrors;
use serde::{Deserialize, Serialize};

/// The end of a run that broke off.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct BrokenOff {
    /// The cause, in words.
    pub reason: String,
    /// Simulated time of the last record, s.
    pub time_s: f64,
}

/// Travel of the robot, and whether it was stuck at the end: [`Progress`] with its units.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ProgressSummary {
    /// Travel of the body along x, m, positive in the direction of the set speed.
    pub distance_m: f64,
    /// Integral of the set speed, m.
    pub asked_m: f64,
    /// Time since which the robot has not advanced, s; `None` where it advanced to the end.
    pub stuck_since_s: Option<f64>,
    /// Time for which each wheel spun, s.
    pub spinning_s: [f64; 3],
}

impl From<Progress> for ProgressSummary {
    fn from(progress: Progress) -> Self {
        Self {
            distance_m: progress.distance,
            asked_m: progress.asked,
            stuck_since_s: progress.stuck_since,
            spinning_s: progress.spinning,
        }
    }
}

impl ProgressSummary {
    pub(super) fn is_finite(&self) -> bool {
        let numbers = [self.distance_m, self.asked_m];
        let since = self.stuck_since_s;
        numbers
            .iter()
            .chain(&since)
            .chain(&self.spinning_s)
            .all(|v| v.is_finite())
    }
}

/// The grade of the run's sensors and the errors that were drawn once for the run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SensorErrors {
    /// Name of the grade; single errors may have been changed.
    pub grade: String,
    /// Relative error of each torque's scale.
    pub torque_gain: [f64; 3],
    /// Offset of each torque, N m.
    pub torque_offset: [f64; 3],
    /// Bias of the inclinometers on links 1 and 2, rad.
    pub inclination_bias: [f64; 2],
    /// Bias of the gyros on links 1 and 2 at the start, rad/s.
    pub rate_bias: [f64; 2],
    /// Relative error of the gyros' scale.
    pub rate_scale: [f64; 2],
}

/// The nominal robot, which the estimators are given, as far as it can differ from the simulated one.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct NominalRobot {
    /// The body's centre of mass, m.
    pub body_cg: [f64; 2],
    /// P, Q, R and S, m.
    pub pins: [[f64; 2]; 4],
    /// Masses of links 1 to 3, kg.
    pub link_masses: [f64; 3],
    /// Viscous damping B, N m s.
    pub viscous_damping: f64,
    /// J_wheel, kg m^2.
    pub wheel_inertia: f64,
    /// J_rotor, kg m^2.
    pub rotor_inertia: f64,
    /// Radius of the wheels, m.
    pub wheel_radius: f64,
}

/// Errors of one estimator.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct EstimatorSummary {
    /// Its label.
    #[serde(skip)]
    pub name: String,
    /// Errors of the normal forces; `None` when nothing could be compared.
    pub normal_force: Option<ForceErrors>,
    /// Errors of the tractions; `None` when nothing could be compared.
    pub traction: Option<ForceErrors>,
    /// Mean of the true normal force of each wheel over the samples compared, N.
    pub mean_normal_force: Option<[f64; 3]>,
    /// Stated standard deviation of N over the mean of N, -: [`Score::stated`]. `None` if the estimator states none.
    #[serde(default)]
    pub stated: Option<f64>,
    /// Share of errors of N within two stated standard deviations, -. `None` if the estimator states none.
    #[serde(default)]
    pub coverage: Option<f64>,
    /// Mean NEES of the three N: 3 if the stated covariance is right. `None` if the estimator states none.
    #[serde(default)]
    pub nees: Option<f64>,
    /// Errors of the ground that the estimator has found. `None` if it finds none, for recorded readings, and in the summaries of
    /// earlier versions.
    #[serde(default)]
    pub ground: Option<GroundErrors>,
    /// Number of records compared.
    pub samples: u64,
    /// Number of records that should have been compared, but had no estimate.
    pub missing: u64,
    /// Number of records left out because a wheel has two contacts.
    #[serde(default)]
    pub two_contacts: u64,
}

impl SensorErrors {
    pub(crate) fn of(world: &World) -> Self {
        let DrawnErrors {
            torque_gain,
            torque_offset,
            inclination_bias,
            rate_bias,
            rate_scale,
        } = world.drawn;
        Self {
            grade: world.grade.name().to_owned(),
            torque_gain,
            torque_offset,
            inclination_bias,
            rate_bias,
            rate_scale,
        }
    }

    pub(super) fn is_finite(&self) -> bool {
        let of_torques = self.torque_gain.iter().chain(&self.torque_offset);
        let of_links = [&self.inclination_bias, &self.rate_bias, &self.rate_scale];
        of_torques
            .chain(of_links.into_iter().flatten())
            .all(|v| v.is_finite())
    }
}

impl NominalRobot {
    pub(crate) fn of(run: &RunDescription) -> Self {
        let Robot { geometry, mass } = &run.nominal_robot;
        Self {
            body_cg: geometry.body_cg.into(),
            pins: Pin::ALL.map(|pin| geometry.pins.get(pin).into()),
            link_masses: mass.links,
            viscous_damping: run.nominal_damping,
            wheel_inertia: mass.wheel_inertia,
            rotor_inertia: mass.rotor_inertia,
            wheel_radius: geometry.wheel_radius,
        }
    }

    pub(super) fn is_finite(&self) -> bool {
        let points = self.pins.iter().chain([&self.body_cg]).flatten();
        let numbers = [
            self.viscous_damping,
            self.wheel_inertia,
            self.rotor_inertia,
            self.wheel_radius,
        ];
        points
            .chain(&self.link_masses)
            .chain(&numbers)
            .all(|v| v.is_finite())
    }
}

impl EstimatorSummary {
    pub(crate) fn new(name: &str, score: &Score) -> Self {
        Self {
            name: name.to_owned(),
            normal_force: score.normal_force(),
            traction: score.traction(),
            mean_normal_force: score.mean_normal_force(),
            stated: score.stated(),
            coverage: score.coverage(),
            nees: score.nees(),
            ground: None,
            samples: score.samples(),
            missing: score.missing(),
            two_contacts: score.two_contacts(),
        }
    }

    /// The first key whose number JSON cannot hold.
    pub(super) fn not_finite(&self) -> Option<String> {
        let name = &self.name;
        let forces = [
            ("normal_force", &self.normal_force),
            ("traction", &self.traction),
        ];
        let of_forces = forces
            .iter()
            .find(|(_, errors)| errors.is_some_and(|e| !e.is_finite()));
        let load = self.mean_normal_force.iter().flatten();
        let stated = [
            ("stated", self.stated),
            ("coverage", self.coverage),
            ("nees", self.nees),
        ];
        let of_stated = stated
            .iter()
            .find(|(_, value)| value.is_some_and(|v| !v.is_finite()));
        let of_ground = self.ground.is_some_and(|errors| !errors.is_finite());
        of_forces
            .map(|(force, _)| *force)
            .or(of_ground.then_some("ground"))
            .or(of_stated.map(|(key, _)| *key))
            .map(|key| format!("estimators.{name}.{key}"))
            .or_else(|| {
                load.copied()
                    .find(|value| !value.is_finite())
                    .map(|_| format!("estimators.{name}.mean_normal_force"))
            })
    }
}
