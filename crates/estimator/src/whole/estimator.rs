//! The estimator of a whole rover: readings of both sides in, forces of six wheels out.
//!
//! Each side has the filters of `kalman` for its links, wheels, motion and contact angles. What they
//! find is the input of the nine rows, and the forces of the rows are those of both sides.

mod across;
mod hung;
mod intake;
mod joint;
mod misfit;
mod scale;
mod sliding;
mod yaw;

use self::hung::Hung;
use self::misfit::MeanMisfit;
use self::sliding::Sliding;
use self::yaw::Yaw;
use super::estimate::{TipLine, WholeEstimate};
use super::inputs::{SideInputs, UNREAD, consider, level_loads};
use super::readings::{SideReadings, WholeFrame};
use super::{WholeEquilibrium, WholeError, WholeForces, WholeMotion, WholePosture, input};
use crate::common::OBSTACLES;
use crate::door;
use crate::estimate::EstimateError;
use crate::estimator::Estimator;
use crate::filters::LinkAngleKalman;
use crate::flags::Flags;
use crate::frame::{BodyInputs, Gate, LinkReading, Repeats};
use crate::methods::{Across, SideState};
use crate::nominal::{at_stop, stop_torque};
use crate::settings::{ContactAngles, EstimatorSettings, KalmanMethod, Method, NoiseBudget, Sides};
use crate::start::{Carried, Start};
use crate::state::COUNT;
use crate::statics::{DIRECT, Forces};
use crate::torque_scale::ScaleFilter;
use robhaz_model::{Coupling, Units, Vec2, WholeRover, WholeRoverError};

/// An estimator for one rover with both sides. It takes one frame of readings after the other.
///
/// ```
/// use robhaz_estimator::EstimatorSettings;
/// use robhaz_estimator::whole::{WholeEstimator, WholeFrame};
/// use robhaz_model::{Carrier, Coupling, Robot, Vec2, WholeRover};
///
/// let mut side = Robot::default_a();
/// side.geometry.make_bogie(Carrier::Link2);
/// let rover = WholeRover {
///     pivot: Vec2::new(0.0, 0.3),
///     half_tracks: [0.3; 3],
///     link_places: [0.3; 2],
///     coupling: Coupling::Differential,
///     body_place: 0.0,
///     coupling_stop: WholeRover::NO_STOP,
///     body_inertia: [0.0; 2],
///     link_inertias: [[0.0; 2]; 2],
///     wheel_inertia: 0.0,
///     side,
/// };
/// // Joints that are read with a noise and an error of 0.1 deg each.
/// let joint = [0.1_f64.to_radians(); 2];
/// let mut estimator = WholeEstimator::new(&rover, EstimatorSettings::kalman(), joint)?;
/// // At rest on a slope of 0.1 rad across, left side up.
/// let estimate = estimator.update(&WholeFrame {
///     time: 0.0,
///     wheel_angle: [Some(0.0); 6],
///     motor_torque: [Some(0.0); 6],
///     steering: [None; 6],
///     pins: [Some(0.0); 2],
///     coupling: Some(0.0),
///     inclination: Some(0.0),
///     roll: Some(0.1),
///     rates: [Some(0.0); 3],
/// })?;
/// // The lower side carries more.
/// assert!(estimate.normal_force[4] > estimate.normal_force[1]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct WholeEstimator {
    rover: WholeRover,
    settings: EstimatorSettings,
    units: Units,
    sides: [Estimator; 2],
    /// Whether the body ties the velocities of both sides.
    tied: bool,
    readings: SideReadings,
    /// In the units of the filters.
    body: BodyInputs,
    repeats: Repeats<5>,
    hung: [Hung; 3],
    roll: LinkAngleKalman,
    yaw: Yaw,
    /// The last readings, rad.
    steering: [f64; 6],
    /// Whether the steering of each wheel has been read.
    steered: [bool; 6],
    /// Which of [`READINGS`] there have been.
    known: [bool; READINGS.len()],
    /// Velocities of both sides' Q, m/s, as of the last frame.
    velocity: [Vec2; 2],
    sliding: Sliding,
    misfit: MeanMisfit,
    /// Mean square of the contact angles' differences from their mean, rad^2.
    roughness: f64,
    /// Normal forces at rest on level ground, N.
    level: [f64; 6],
    /// Normal forces about which the rows are linearised, not below 0, N.
    about: [f64; 6],
    /// The torques against the weight, by the mean of both sides, in the units of the filters.
    scale: ScaleFilter,
    start: Start,
    /// By the roll: a side sees the inclination.
    carried: Carried,
    time: Option<f64>,
}

/// Readings that no frame may lack for ever, as [`EstimateError::Missing`] names them.
const READINGS: [&str; 19] = [
    "pins (left)",
    "pins (right)",
    "coupling",
    "inclination",
    "roll",
    "rates (roll)",
    "rates (yaw)",
    "wheel_angle[0]",
    "wheel_angle[1]",
    "wheel_angle[2]",
    "wheel_angle[3]",
    "wheel_angle[4]",
    "wheel_angle[5]",
    "motor_torque[0]",
    "motor_torque[1]",
    "motor_torque[2]",
    "motor_torque[3]",
    "motor_torque[4]",
    "motor_torque[5]",
];

impl WholeEstimator {
    /// An estimator for a rover at rest, from its nominal geometry and masses. Of the `settings`
    /// method and sides do not count: it is `kalman` without contact angles; inclination and
    /// rate of the noise budget are those of the body's sensor. `joint` has white noise (rad a
    /// sample) and constant error (rad) of the angles of pins and coupling.
    ///
    /// # Errors
    /// [`WholeRoverError`].
    pub fn new(
        rover: &WholeRover,
        settings: EstimatorSettings,
        joint: [f64; 2],
    ) -> Result<Self, WholeRoverError> {
        rover.check()?;
        let method = match settings.method {
            Method::Kalman(method) => method,
            Method::Paper(_) => KalmanMethod::DEFAULT,
        };
        let [joint_noise, _] = joint;
        let settings = EstimatorSettings {
            method: Method::Kalman(KalmanMethod {
                contact_angles: ContactAngles::Unknown,
                // It is the rover's, not a side's.
                parity: false,
                ..method
            }),
            sides: Sides::OneOfTwo,
            budget: settings.budget.of_body_sensors(&rover.side, joint),
            ..settings
        };
        let side = &rover.side;
        let units = Units::of(side);
        let level = level_loads(rover).map_err(|_| WholeRoverError::FourBar)?;
        let mut of_side = settings;
        of_side.budget.payload *= 0.5;
        let side_estimator = || {
            let mut estimator = Estimator::new(side, of_side);
            if let Some(motion) = estimator.motion() {
                motion.couple();
            }
            estimator
        };
        let sides = [side_estimator(), side_estimator()];
        Ok(Self {
            scale: sides[0].scale_filter(scale::trailing(rover).unwrap_or(Across::NONE.trailing)),
            units,
            sides,
            tied: true,
            readings: SideReadings::new(rover, joint_noise),
            body: BodyInputs::default(),
            repeats: Repeats::default(),
            hung: Default::default(),
            roll: LinkAngleKalman::new(&door::budget_in(&units, &settings.budget)),
            yaw: Yaw::new(&settings.budget),
            steering: [0.0; 6],
            steered: [false; 6],
            known: [false; READINGS.len()],
            velocity: [Vec2::zeros(); 2],
            sliding: Sliding::default(),
            misfit: MeanMisfit::default(),
            roughness: 0.0,
            level,
            about: level,
            start: Start::new(settings.budget.inclination_noise),
            carried: Carried::default(),
            time: None,
            rover: rover.clone(),
            settings,
        })
    }

    /// The same, but the body does not tie the velocities of both sides: for a test that compares the roll
    /// with the ground, which would else follow a roll of the wrong sign.
    #[must_use]
    pub fn untied(self) -> Self {
        Self {
            tied: false,
            ..self
        }
    }

    /// Takes the readings of one instant and estimates the forces of that instant. A reading that is
    /// missing is held, with a flag, as [`Estimator::update`] does. Filters that false readings have carried to
    /// where the equations have no solution start anew with the next frame.
    ///
    /// # Errors
    /// [`EstimateError`].
    pub fn update(&mut self, frame: &WholeFrame) -> Result<WholeEstimate, EstimateError> {
        let found = self.estimate(frame);
        if matches!(found, Err(EstimateError::Singular)) {
            self.start_anew();
        }
        found
    }

    fn estimate(&mut self, frame: &WholeFrame) -> Result<WholeEstimate, EstimateError> {
        let (dt, interrupted) = self.advance_clock(frame.time)?;
        let frame = &self.read_body(*frame, dt);
        let found = self.begin(frame, interrupted);
        self.take(frame);
        let frames = self.readings.frames(frame);
        let in_units = self.budget_in_units();
        let (roll, body_flags) = self.update_roll(frame, &in_units, dt);
        let body_flags = body_flags | found;
        let across = self.across();
        let [left, right] = &mut self.sides;
        // Both take the frame, also where one has no estimate.
        let of_left = left.advance(&frames[0], &across[0]);
        hand_over(left, right);
        let of_right = right.advance(&frames[1], &across[1]);
        hand_over(right, left);
        if let Some((field, _)) = READINGS.iter().zip(self.known).find(|(_, known)| !known) {
            return Err(EstimateError::Missing { field });
        }
        let mut steps = [of_left?, of_right?];

        if steps[0].dt > 0.0 {
            if self.tied {
                self.impose_body(&mut steps, &in_units);
            }
            self.impose_parities(&mut steps, roll, across[0].settled)
                .map_err(|_| EstimateError::Singular)?;
        }
        let states = steps.each_ref().map(|step| &step.state);
        self.velocity = states.map(|state| state.velocity);
        let radius = self.rover.side.geometry.wheel_radius;
        let spins: [f64; 6] = core::array::from_fn(|i| states[i / 3].spin[i % 3][0]);
        let rims = spins.map(|spin| radius * spin);
        self.sliding.follow(
            &self.rover,
            &self.units,
            &rims,
            &self.yaw,
            &self.steering,
            dt,
        );
        let turned = self.with_roll_of_inclinometer(states, roll);
        let found = turned.and_then(|turned| self.solve(states, roll, turned, dt));
        let (mut forces, inclination, lateral_force) =
            found.map_err(|_| EstimateError::Singular)?;
        let [forces0, forces1] = [0, 1].map(|side| side_forces(side, states, &forces));
        let [step0, step1] = steps;
        let [left, right] = &mut self.sides;
        let left = left.conclude(step0, forces0);
        let right = right.conclude(step1, forces1);
        self.part_discarded();
        let (Some(left), Some(right)) = (left, right) else {
            return Err(EstimateError::Singular);
        };
        let mut sides = [left, right];
        for side in &mut sides {
            side.flags |= self.coupling_at_stop() | self.readings.flags();
        }
        let dragged = self.sliding.dragged().is_some();
        // Where wheels are dragged or readings are old, the equations do not hold.
        let holds = !dragged
            && !sides
                .iter()
                .any(|side| side.flags.contains(Flags::SENSOR_STALE));
        let turn = if holds {
            dt * libm::fabs(spins.iter().sum::<f64>()) / 6.0
        } else {
            0.0
        };
        let contradicts = self.misfit.take(forces.misfit, turn);
        let contradicts = contradicts || self.roll.contradicts();
        let body_flags = body_flags | Flags::CONTRADICTION.when(contradicts);
        let torque_scale = self.find_scale(&mut sides, &mut forces, across[0].settled, dt);
        let [left, right] = sides;
        let (tip_margin, tip_line) = self.tip_over(&forces.normal);
        Ok(WholeEstimate {
            time: frame.time,
            normal_force: both(left.normal_force, right.normal_force),
            covariance: forces.covariance.into(),
            of_inclination: forces.of_inclination,
            traction: both(left.traction, right.traction),
            attitude: [inclination, roll[0]],
            lateral_force,
            axial_share: forces.axial,
            tip_margin,
            tip_line,
            dragged,
            misfit: forces.misfit,
            torque_scale,
            body_flags,
            sides: [left, right],
        })
    }

    /// What was discarded on one side has no covariance with the other one any more.
    fn part_discarded(&mut self) {
        let [left, right] = &mut self.sides;
        if let (Some(left), Some(right)) = (left.motion(), right.motion())
            && !(left.is_coupled() && right.is_coupled())
        {
            let apart = [[0.0; COUNT]; COUNT];
            left.set_guests(apart);
            right.set_guests(apart);
        }
    }

    /// Flag of the coupling near an end stop.
    fn coupling_at_stop(&self) -> Flags {
        let (angle, _) = self.readings.coupled();
        at_stop(angle, self.rover.coupling_stop)
    }

    /// The noise budget in the units of the filters.
    fn budget_in_units(&self) -> NoiseBudget {
        door::budget_in(&self.units, &self.settings.budget)
    }

    /// Advances roll and yaw; `in_units` is the noise budget in those of the filters. Returns angle (rad), rate
    /// (rad/s) and acceleration (rad/s^2) of the roll, and the flags of the readings.
    fn update_roll(
        &mut self,
        frame: &WholeFrame,
        in_units: &NoiseBudget,
        dt: f64,
    ) -> ([f64; 3], Flags) {
        let (budget, time) = (&self.settings.budget, self.units.time);
        let [roll_rate, _, yaw_rate] = frame.rates;
        let rates = [roll_rate, yaw_rate].map(|rate| rate.map(|rate| rate * time));
        let gate = Gate::new(budget, &self.rover.side);
        let flags = self.body.take(frame.roll, rates, dt / time, &gate);
        let [roll_rate, yaw_rate] = &self.body.rates;
        let reading = yaw_rate.recent().map(|rate| rate / time);
        let stands = self.sliding.stands();
        self.yaw.take(budget, reading, stands, [dt, time]);
        let readings = LinkReading {
            inclination: self.body.roll.now(),
            rate: roll_rate.now(),
            ..LinkReading::default()
        };
        let roll = &mut self.roll;
        if roll.started {
            let [left, right] = self.velocity;
            let sideways = self.yaw.acceleration * self.rover.ahead_of_middle();
            let across = 0.5 * (left.x + right.x) * self.yaw.rate + sideways;
            let across = across / self.rover.side.gravity;
            roll.jump(in_units, roll_rate.late, roll_rate.left_out(), dt / time);
            roll.update(in_units, dt / time, &readings, across);
        } else if self.body.roll.known {
            let held = &self.body.roll;
            roll.start(held.value, held.age, readings.rate.unwrap_or(0.0));
        }
        let turning = roll.acceleration / (time * time);
        ([roll.angle(), roll.smooth_rate / time, turning], flags)
    }

    /// The inputs of the rows, the motion and the rows.
    fn equations<'a>(
        &self,
        states: [&'a SideState; 2],
        roll: [f64; 3],
    ) -> Result<
        (
            SideInputs<'a>,
            (WholePosture, WholeMotion),
            WholeEquilibrium,
        ),
        WholeError,
    > {
        let rover = &self.rover;
        let coupled = self.readings.coupled();
        let mut inputs = SideInputs::new(rover, states, coupled, self.steering, roll[0])?;
        inputs.steered = self.steered;
        let posture = WholePosture::new(rover, &inputs.joints)?;
        let yaw = [self.yaw.rate, self.yaw.acceleration];
        let motion = inputs.motion(rover, &posture, roll, yaw);
        let mut equations =
            WholeEquilibrium::new(rover, &posture, &motion, &inputs.contact_angles())?;
        let rate_error = match self.readings.is_stale() {
            false => self.readings.rear_rate_error(),
            // By that angle within a wheel's radius.
            true => UNREAD * libm::fabs(inputs.speed()) / rover.side.geometry.wheel_radius,
        };
        equations.slide(&motion, inputs.speed(), &inputs.creep(), rate_error);
        equations.toe = self.settings.budget.toe;
        equations.pin_moment = self.settings.budget.pin_moment;
        let at_stop = self.coupling_at_stop();
        let of_coupling = stop_torque(at_stop) * self.units.torque();
        let [left, right] = states.map(|state| state.stop_torque);
        equations.stop_torque = [of_coupling, left, right];
        equations.dragged = self.sliding.dragged().is_some();
        // The ground is inclined across the wheels as much as along them.
        equations.inclination_across = self.roughness;
        equations.roll(&inputs.rolling_resistance(), &inputs.friction_share());
        Ok((inputs, (posture, motion), equations))
    }

    /// N with the roll that the inclinometer shows, N, where its gyroscope contradicts it. Beside [`Self::solve`], whose
    /// stack is as large, not within it.
    #[inline(never)]
    fn with_roll_of_inclinometer(
        &self,
        states: [&SideState; 2],
        [angle, rate, acceleration]: [f64; 3],
    ) -> Result<Option<[f64; 6]>, WholeError> {
        if !self.roll.contradicts() {
            return Ok(None);
        }
        let roll = [angle + self.roll.apart(), rate, acceleration];
        let (inputs, _, equations) = self.equations(states, roll)?;
        let roll_sigma = self.roll.angle_sigma(&self.settings.budget);
        let covariance = inputs.covariance(&self.rover, roll_sigma);
        let forces = equations.solve_about(&inputs.traction(), &covariance, &self.about)?;
        Ok(Some(forces.normal))
    }

    /// Forces of the nine rows, the inclination of the body (rad), and the ground's force across
    /// the body, N.
    fn solve(
        &mut self,
        states: [&SideState; 2],
        roll: [f64; 3],
        turned: Option<[f64; 6]>,
        dt: f64,
    ) -> Result<(WholeForces, f64, f64), WholeError> {
        let rover = &self.rover;
        let (inputs, (posture, motion), equations) = self.equations(states, roll)?;
        let roll_sigma = self.roll.angle_sigma(&self.settings.budget);
        let covariance = inputs.covariance(rover, roll_sigma);
        let mut forces = equations.solve_about(&inputs.traction(), &covariance, &self.about)?;
        let normal = forces.normal.map(|n| n.max(0.0));
        // Wheels may jump, or readings be false.
        let bears = normal.iter().sum::<f64>() > LEAST_BORNE * self.level.iter().sum::<f64>();
        self.about = if bears { normal } else { self.level };
        consider(
            rover,
            &posture,
            &inputs,
            &self.settings.budget,
            motion.specific_force,
            &equations,
            &mut forces,
        );
        if let Some(turned) = turned {
            // The force across that a wrong roll asks for passes for axial forces.
            forces.consider_difference(&turned);
        }
        if rover.coupling == Coupling::RearBogie && self.readings.is_stale() {
            let turned = equations.of_rear_turn(UNREAD, &forces.normal, &inputs.traction());
            forces.consider(&turned);
        }
        let weight = dt.clamp(0.0, OBSTACLES) / OBSTACLES;
        self.roughness += weight * (inputs.roughness() - self.roughness);
        let of_axial = equations.axial_variance(&inputs.traction(), &forces.normal);
        /// Share of the axial forces' variance that is there while the ground is inclined: the drives push the
        /// wheels along it, none across.
        /// Chosen.
        const INCLINED: f64 = 0.5;
        for i in 0..6 {
            let (n, across) = (forces.normal[i], forces.axial * forces.normal[i]);
            let of_inclination = equations.inclination_across
                * (across * across
                    + INCLINED * of_axial
                    + 0.75 * equations.inclination_across * n * n);
            forces.covariance[(i, i)] += of_inclination;
            forces.of_inclination[i] = of_inclination;
        }
        Ok((forces, inputs.inclination, equations.f[FORCE_Y]))
    }

    /// Least margin and its line.
    fn tip_over(&self, normal: &[f64; 6]) -> (f64, TipLine) {
        let mut least = (f64::INFINITY, TipLine::Left);
        for line in TipLine::ALL {
            let (mut now, mut level) = (0.0, 0.0);
            for (i, (n, at_rest)) in normal.iter().zip(&self.level).enumerate() {
                if line.is_off(i) {
                    now += n;
                    level += at_rest;
                }
            }
            if now / level < least.0 {
                least = (now / level, line);
            }
        }
        least
    }
}

/// Gives a side the covariance of both sides' states as the other one has it.
fn hand_over(from: &mut Estimator, to: &mut Estimator) {
    if let (Some(from), Some(to)) = (from.motion(), to.motion()) {
        to.set_guests(from.guests_of_other());
    }
}

/// Of the left wheels, then of the right ones.
fn both([a, b, c]: [f64; 3], [d, e, f]: [f64; 3]) -> [f64; 6] {
    [a, b, c, d, e, f]
}

/// Least sum of the normal forces, over the weight, about which the rows are linearised.
/// Guard.
const LEAST_BORNE: f64 = 0.1;

/// Row of the sum of forces across.
const FORCE_Y: usize = 1;

/// The forces of one side, with their covariance.
fn side_forces(side: usize, states: [&SideState; 2], forces: &WholeForces) -> Forces {
    let state = states[side];
    let mut covariance = [[0.0; 6]; 6];
    for i in 0..3 {
        for j in 0..3 {
            let (a, b) = (3 * side + i, 3 * side + j);
            covariance[2 * i][2 * j] = state.covariance[DIRECT + i][DIRECT + j];
            covariance[2 * i + 1][2 * j + 1] = forces.covariance[(a, b)];
            let with = forces.with_inputs[(a, input::TRACTION + b)];
            covariance[2 * i + 1][2 * j] = with;
            covariance[2 * j][2 * i + 1] = with;
        }
    }
    Forces {
        normal: [0, 1, 2].map(|i| forces.normal[3 * side + i]),
        traction: state.traction,
        covariance,
    }
}
