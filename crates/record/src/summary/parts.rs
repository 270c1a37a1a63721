//! The parts of a summary, with their units.

use super::means::MeanForces;
use indexmap::IndexMap;
use robhaz_control::{FrictionTestEnd, FrictionTestResult};
use robhaz_estimator::TorqueScale;
use robhaz_model::Pin;
use robhaz_run::RunDescription;
use robhaz_scene::Scene;
use robhaz_score::contact::FlagScores;
use robhaz_score::events::{Event, EventKind};
use robhaz_score::{Excuse, ForceErrors, GroundErrors};
use robhaz_sim::clearance::Clearances;
use robhaz_sim::friction::{FrictionKind, FrictionLaw, Parameter};
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

/// The result of a friction test.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FrictionTestSummary {
    /// The tested wheel: 1 front, 2 middle, 3 rear.
    pub wheel: usize,
    /// How the test ended: `slipped`, or `slipped, or another wheel`, if mu_max was found, else why
    /// not. Then it is at least `mu_max`.
    pub end: String,
    /// Time of the largest T/N, s.
    pub time: f64,
    /// Place of the contact at that time along the path, m; `None` before the robot has moved, and
    /// without slip.
    pub x: Option<f64>,
    /// mu_max, -; without slip the largest T/N.
    pub mu_max: f64,
    /// Its standard deviation by the budget of the readings, -. A common scale of all torques
    /// multiplies mu_max, and is not in it.
    pub sigma: f64,
    /// Number of ramps that ended in slip.
    pub ramps: u32,
    /// Distance that the rim slid, m.
    pub slipped_distance: f64,
    /// Noise and rate of the readings over what an onset of slip needs to show, -, of a test that
    /// they ended; `None` for others, and where they show no speed of the wheel at all.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub slip_noise: Option<f64>,
    /// Duration of the test, s.
    pub duration: f64,
}

impl FrictionTestSummary {
    pub(crate) fn of(result: &FrictionTestResult) -> Self {
        Self {
            wheel: result.wheel + 1,
            end: result.end.name().to_owned(),
            time: result.time,
            x: result.place,
            mu_max: result.mu,
            sigma: result.sigma,
            ramps: result.ramps,
            slipped_distance: result.slipped_distance,
            slip_noise: (result.end == FrictionTestEnd::Noise)
                .then_some(result.slip_noise)
                .filter(|noise| noise.is_finite()),
            duration: result.duration,
        }
    }

    /// The result in one line.
    pub fn in_words(&self) -> String {
        let wheel = self.wheel;
        let (mu, margin) = (self.mu_max, 2.0 * self.sigma);
        let (slid, seconds) = (1e3 * self.slipped_distance, self.duration);
        let (end, least) = (&self.end, (mu - margin).max(0.0));
        if self.end == FrictionTestEnd::Noise.name() {
            let up = |factor: f64| (10.0 * factor).ceil() / 10.0;
            let remedy = match self.slip_noise {
                Some(noise) => format!(
                    "encoders and gyroscopes {:.1} times as fine would do, or {:.1} times the rate",
                    up(noise.sqrt()),
                    up(noise)
                ),
                None => "rate and encoders are too coarse for a speed of the wheel".to_owned(),
            };
            return format!(
                "Friction test, wheel {wheel}: refused, the readings would not show the slip in time; {remedy}; mu_max \
                 is at least {least:.3}"
            );
        }
        let found = match self.ramps {
            0 => format!("ended without slip ({end}), mu_max is at least {least:.3}"),
            _ => format!("mu_max = {mu:.3} +- {margin:.3} (2 sigma, torques as read)"),
        };
        format!("Friction test, wheel {wheel}: {found}, slid {slid:.0} mm, took {seconds:.1} s")
    }
}

/// The control of the wheels.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ControlSummary {
    /// Name of the kind.
    pub kind: String,
    /// Name of the estimator that it got; `None` for a control without readings.
    pub estimator: Option<String>,
    /// Kp (N m s) and Ki (N m) of one speed control, where the rate of the readings bears less than
    /// those of the drives; `None` for others.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reduced_gains: Option<[f64; 2]>,
}

impl ControlSummary {
    /// `None` for recorded readings.
    pub(super) fn of(run: &RunDescription) -> Option<Self> {
        let scene = run.world.as_ref()?;
        let estimator = scene.control_estimator();
        let estimator = estimator.and_then(|k| run.estimators.get(k));
        Some(Self {
            kind: scene.control.kind.name().to_owned(),
            estimator: estimator.map(|e| e.label.clone()),
            reduced_gains: scene.control_settings().ok().and_then(|settings| {
                let gains = [settings.kp, settings.ki];
                let drive = [scene.drive.kp, scene.drive.ki];
                let reduced = gains.iter().zip(&drive).any(|(gain, drive)| gain < drive);
                reduced.then_some(gains)
            }),
        })
    }

    /// What is to be said of it, in one line.
    pub fn in_words(&self) -> Option<String> {
        let [kp, ki] = self.reduced_gains?;
        Some(format!(
            "Speed control with Kp = {kp:.3} N m s and Ki = {ki:.3} N m, what a wheel in the air bears at this rate; \
             drive.kp and drive.ki are those of the motor drives"
        ))
    }
}

/// The friction of the ground outside of its stretches, and the rolling resistance.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FrictionSummary {
    /// Name of the law.
    pub law: String,
    /// Static coefficient, -.
    pub mu_s: f64,
    /// Dynamic coefficient, -.
    pub mu_d: f64,
    /// Slip speed up to which the static coefficient holds, m/s.
    pub v_s: f64,
    /// Slip speed from which the dynamic coefficient holds, m/s.
    pub v_d: f64,
    /// Parameters that only some laws have, by their names, SI; `None` if this law has not.
    #[serde(flatten)]
    pub parameters: IndexMap<String, Option<f64>>,
    /// Coefficient f_r of the rolling resistance, -.
    pub rolling_resistance: f64,
}

impl FrictionSummary {
    pub(crate) fn of(world: &Scene) -> Self {
        // All fields, so that none is left out; those that not every law has are its parameters.
        let FrictionLaw {
            kind,
            mu_s,
            mu_d,
            v_s,
            v_d,
            slip_stiffness: _,
            rolling,
        } = world.friction;
        let own = |kind: FrictionKind| kind.parameters().iter().filter(|p| !p.is_shared);
        let parameter = |of: FrictionKind, p: &Parameter| {
            let value = (of == kind).then(|| p.of(&world.friction));
            (p.name.to_owned(), value)
        };
        let of = |of| own(of).map(move |p| parameter(of, p));
        Self {
            law: kind.name().to_owned(),
            mu_s,
            mu_d,
            v_s,
            v_d,
            parameters: FrictionKind::ALL.into_iter().flat_map(of).collect(),
            rolling_resistance: rolling,
        }
    }

    /// The law in a few words; `None` for the default law without rolling resistance.
    pub(crate) fn in_words(&self) -> Option<String> {
        let stated = FrictionKind::all_parameters().filter_map(|parameter| {
            let value = (*self.parameters.get(parameter.name)?)?;
            Some(format!("{} = {value}", parameter.symbol))
        });
        let parameters = match stated.collect::<Vec<_>>() {
            stated if stated.is_empty() => String::new(),
            stated => format!(" with {}", stated.join(", ")),
        };
        let rolling = match self.rolling_resistance {
            0.0 => String::new(),
            f_r => format!(", rolling resistance {f_r}"),
        };
        let is_default = self.law == FrictionKind::default().name() && rolling.is_empty();
        (!is_default).then(|| format!("friction {}{parameters}{rolling}", self.law))
    }
}

/// The grade of the run's sensors and the errors that were drawn once for the run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SensorErrors {
    /// Name of the grade; single errors may have been changed.
    pub grade: String,
    /// The errors.
    #[serde(flatten)]
    pub drawn: DrawnErrors,
}

/// The nominal robot, which the estimators are given, as far as it can differ from the simulated
/// one.
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

/// The torques against the weight: [`TorqueScale`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TorqueScaleSummary {
    /// Torques over those that the described robot needs, -.
    pub ratio: f64,
    /// Its standard deviation, -.
    pub sigma: f64,
    /// What follows from it: `unconfirmed`, `confirmed`, `contradicts` ([`robhaz_estimator::Confirmation`]).
    pub confirmation: String,
    /// In words.
    pub words: String,
}

impl TorqueScaleSummary {
    /// For a robot of which one side has the mass `described`, kg.
    pub(super) fn of(scale: &TorqueScale, described: f64) -> Self {
        Self {
            ratio: scale.ratio,
            sigma: scale.sigma,
            confirmation: scale.confirmation.name().to_owned(),
            words: scale.in_words(described).to_string(),
        }
    }
}

/// When a channel was faulty.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Faulty {
    /// Time of the first record at which it was, s.
    pub first_s: f64,
    /// Number of such records.
    pub records: u64,
}

/// Faulty channels by name, in the order of their first record:
/// [`robhaz_estimator::Health::faulty`].
pub type FaultyChannels = IndexMap<String, Faulty>;

/// Errors of one estimator.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct EstimatorSummary {
    /// Errors of the normal forces; `None` when nothing could be compared.
    pub normal_force: Option<ForceErrors>,
    /// Errors of the tractions; `None` when nothing could be compared.
    pub traction: Option<ForceErrors>,
    /// Mean of the true normal force of each wheel over the samples compared, N.
    pub mean_normal_force: Option<[f64; 3]>,
    /// Stated standard deviation of N over the mean of N, -: [`robhaz_score::Statistics::stated`].
    /// `None` if the estimator states none.
    pub stated: Option<f64>,
    /// Share of errors of N within two stated standard deviations, -. `None` if the estimator
    /// states none.
    pub coverage: Option<f64>,
    /// Mean NEES of the three N: 3 if the stated covariance is right. `None` if the estimator
    /// states none.
    pub nees: Option<f64>,
    /// RMS of the errors of N, each over its stated standard deviation: 1 if these are right.
    /// `None` if the estimator states none.
    pub error_over_stated: Option<f64>,
    /// Mean NIS of the parity residual: 1 if its expected variance is right. `None` if the
    /// estimator expects none.
    pub nis: Option<f64>,
    /// Time by which the estimated N follow the true ones, s: [`robhaz_score::Statistics::lag`].
    /// `None` where the truth hardly changes.
    pub lag_s: Option<f64>,
    /// Errors of the ground that the estimator has found. `None` if it finds none, and for
    /// recorded readings.
    pub ground: Option<GroundErrors>,
    /// Number of records compared; without truth, of records with an estimate.
    pub samples: u64,
    /// Number of records that count but have no estimate.
    pub missing: u64,
    /// How many of the records compared have a wheel with two contacts. Its true N and T are those
    /// of the equivalent contact.
    pub two_contacts: u64,
    /// Number of records left out because no single contact is equivalent to the contacts of a
    /// wheel.
    pub no_equivalent: u64,
    /// Errors of the normal forces over the records at which no wheel has two contacts; `None` when
    /// there are none.
    pub normal_force_at_one_contact: Option<ForceErrors>,
    /// How well contact states were found: in the air, two contacts, sliding. `None` if the
    /// estimator states none.
    pub contacts: Option<FlagScores>,
    /// Channels whose readings contradicted others, over all records.
    #[serde(default, skip_serializing_if = "FaultyChannels::is_empty")]
    pub faulty_channels: FaultyChannels,
    /// Why they may look so though no reading is wrong.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub excuse: Option<Excuse>,
    /// Why so many forces are out of range though no reading is wrong.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub excuse_of_forces: Option<Excuse>,
    /// The torques against the weight at the end; of a recorded log alone.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub torque_scale: Option<TorqueScaleSummary>,
    /// Means over the records that count; of a recorded log alone.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub means: Option<MeanForces>,
}

impl SensorErrors {
    pub(crate) fn of(world: &Scene) -> Self {
        Self {
            grade: world.sensors.grade.name().to_owned(),
            drawn: *world.sensors().drawn(),
        }
    }
}

impl NominalRobot {
    pub(crate) fn of(run: &RunDescription) -> Self {
        let (geometry, mass) = (&run.nominal_robot.geometry, &run.nominal_robot.mass);
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
}

/// Clearance of body and links to the ground over a run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ClearanceSummary {
    /// The least of all records, m; at 0 or below a bar touched the ground.
    pub least_m: f64,
    /// The bar that it belongs to: `body`, `link1` ...
    pub bar: String,
    /// Its time, s.
    pub time_s: f64,
    /// How often a bar began to touch the ground.
    pub touches: u64,
    /// Time of the first touch, s, and its bar. From then on forces are wrong: that of the touch is
    /// not modelled.
    pub first_touch: Option<(f64, String)>,
}

impl ClearanceSummary {
    /// Adds a record to the summary so far.
    pub(super) fn add(so_far: &mut Option<Self>, time: f64, clearances: &Clearances) {
        let (bar, least) = clearances.least;
        // A clearance that is not a number is that of no bar.
        if !least.is_finite() {
            return;
        }
        let found = so_far.get_or_insert_with(|| Self {
            least_m: f64::INFINITY,
            bar: String::new(),
            time_s: time,
            touches: 0,
            first_touch: None,
        });
        if least < found.least_m {
            (found.least_m, found.time_s) = (least, time);
            bar.name().clone_into(&mut found.bar);
        }
    }

    /// Adds an event after its record.
    pub(super) fn add_event(&mut self, event: &Event) {
        if let EventKind::BarTouches(bar) = event.kind {
            self.touches += 1;
            let first = || (event.time, bar.name().to_owned());
            self.first_touch.get_or_insert_with(first);
        }
    }
}
