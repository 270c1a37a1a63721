//! The engine `rapier`: four bars as rigid bodies of rapier2d, each with the masses of its wheels,
//! and four pins as impulse joints.
//!
//! Rapier has no colliders here. Before each step, terrain contacts, contact force, friction, drive
//! and stops are evaluated with our own laws at the state at the start of the step. They are kept
//! constant over the step, the normal forces with the change that is expected in it (module
//! `damping`). The wheel spins are integrated beside rapier. Stability limits of the step:
//! [`crate::stability`].
//!
//! A settled start comes from the equations of motion that [`crate::direct`] integrates. After that
//! the motion depends on rapier alone.

mod bodies;
mod damping;
mod joints;
mod step_control;

use crate::drive::{Drive, DriveResponse, wheel_acceleration};
use crate::engine::{Balance, Engine, Instant, WheelLoad};
use crate::error::{NoTruth, PlantError};
use crate::ground::{Ground, GroundForces, OneContact, WheelMotion};
use crate::setup::{PlantSetup, StartKind};
use crate::start::Start;
use crate::truth::Truth;
use bodies::Bodies;
use damping::{DampedContact, Damping};
use robhaz_model::{Bar, Robot, Vec2, WheelCommand, cross};
use robhaz_terrain::Contact;
use step_control::{StepControl, WheelState};

/// Steps before time zero at a settled start, in which the gaps of the joints become stationary. N
/// then changes by less than 10 uN after 100 steps.
const SETTLING_STEPS: u64 = 200;

/// A simulation with rapier2d.
pub struct RapierEngine {
    robot: Robot,
    ground: Ground,
    drive: Drive,
    /// Commands of the wheels.
    commands: [WheelCommand; 3],
    bodies: Bodies,
    wheels: [Wheel; 3],
    /// Number of steps so far. Time is this number times the step, without accumulated rounding.
    steps: u64,
    steps_per_period: u64,
    step: f64,
    /// Number of parts and pieces of steps so far.
    parts_taken: u64,
    /// Impulse and work since the start. Without [`PlantSetup::balance`] only the work of the
    /// motors is integrated.
    balance: Balance,
    carries_balance: bool,
    /// Mean angular accelerations of links 1 and 2 over the last integration, rad/s^2.
    link_accelerations: [f64; 2],
    step_control: StepControl,
    damping: Damping,
}

/// Rotation of a wheel, which is not part of rapier's bodies.
#[derive(Clone, Copy, Debug, Default)]
struct Wheel {
    /// Absolute spin, rad/s, forward positive.
    spin: f64,
    /// Rotation relative to its link since the start, rad.
    angle: f64,
    /// Integral of the speed error, rad.
    integral: f64,
}

/// Forces and torques on links and wheels at one instant.
#[derive(Clone, Copy, Debug, Default)]
struct Loads {
    /// What the drives do.
    drives: [DriveResponse; 3],
    motions: [WheelMotion; 3],
    /// Forces and torques on the wheels, without the motors.
    wheels: [WheelLoad; 3],
    /// Torque of the end stops on link 1, N m.
    stop_torque: f64,
    /// Elastic energy of all contacts, J.
    contact_energy: f64,
    wheel_state: WheelState,
}

impl RapierEngine {
    /// The robot at its start.
    ///
    /// # Errors
    /// [`PlantError`] where it does not settle.
    pub(crate) fn new(setup: &PlantSetup, start: &Start) -> Result<Self, PlantError> {
        let geometry = &setup.robot.geometry;
        let steps_per_period = steps_per_period(setup.period, setup.engine.step);
        let step = setup.period / steps_per_period as f64;
        let state = &start.state;
        let link_rates = [state.rates[2], state.rates[3]];
        let mut engine = Self {
            robot: setup.robot.clone(),
            ground: Ground::new(setup),
            drive: setup.drive.clone(),
            commands: Default::default(),
            bodies: Bodies::new(&setup.robot, start, step),
            wheels: [0, 1, 2].map(|i| Wheel {
                spin: state.omega[i] - link_rates[geometry.carriers[i].index()],
                angle: 0.0,
                integral: start.integrals[i],
            }),
            steps: 0,
            steps_per_period,
            step,
            parts_taken: 0,
            balance: Balance::default(),
            carries_balance: setup.balance,
            link_accelerations: [0.0; 2],
            step_control: StepControl::new(setup, step),
            damping: Damping::new(setup.robot.mass.wheel),
        };
        if setup.engine.start == StartKind::Settled {
            engine.settle()?;
        }
        Ok(engine)
    }

    fn time(&self) -> f64 {
        // Exact below 2^53 steps.
        let steps = self.steps as f64;
        steps * self.step
    }

    /// Advances by one step, divided as [`StepControl`] asks. Fills in wheels, stop and pin forces
    /// of `truth`. Returns the elastic energy of all contacts at the start of the step, J.
    fn advance(&mut self, mut truth: Option<&mut Truth>) -> Result<f64, PlantError> {
        let time = self.time();
        let mut loads = self.loads(time, truth.as_deref_mut())?;
        let contact_energy = loads.contact_energy;
        let knows = self.damping.begin(self.step)
            && !(0..3).any(|i| self.ground.meets(&loads.motions[i], self.step));
        let control = &mut self.step_control;
        let (parts, impact) = control.divide(&loads.wheel_state, self.step, knows);
        let length = self.step / f64::from(parts);
        // The pin forces of the first integration belong to the instant of the truth.
        let mut pins = truth.map(|truth| (truth, self.bodies.pin_arms(&self.robot.geometry)));
        for part in 0..parts {
            let begin = time + f64::from(part) * length;
            if part > 0 {
                loads = self.loads(begin, None)?;
            }
            let pieces = self.step_control.pieces(&loads.wheel_state, length);
            let piece_length = length / f64::from(pieces);
            for piece in 0..pieces {
                if piece > 0 {
                    loads = self.loads(begin + f64::from(piece) * piece_length, None)?;
                }
                self.integrate(&mut loads, piece_length, impact);
                if let Some((truth, arms)) = pins.take() {
                    self.bodies.pin_forces(truth, &arms, piece_length);
                }
            }
            self.parts_taken += u64::from(pieces);
        }
        self.steps += 1;
        Ok(contact_energy)
    }

    /// Forces and torques at the current state. Fills in wheels and stop of `truth`.
    fn loads(&mut self, time: f64, mut truth: Option<&mut Truth>) -> Result<Loads, PlantError> {
        let (geometry, drive) = (&self.robot.geometry, &self.drive);
        let rates = self.bodies.link_rates();
        let angles = [Bar::Link1, Bar::Link2].map(|bar| self.bodies.bar(bar).rotation().angle());
        let mut loads = Loads::default();
        // Velocities at the end of a step are those in its middle (leapfrog). Compared with a later
        // set speed they would lead, and the robot would be ahead by its way in half a step.
        let of_velocities = time - 0.5 * self.bodies.last_step();
        for i in 0..3 {
            let wheel = &self.wheels[i];
            let omega = wheel.spin + rates[geometry.carriers[i].index()];
            let motion = self.bodies.wheel_motion(geometry, i, wheel.spin);
            let below = |why: NoTruth| why.at(time);
            let mut ground = GroundForces::default();
            let contacts = self.damping.present(i);
            let rolling = self.ground.rolling_moment(1.0, wheel.spin);
            let each = |contact: &Contact, forces: &OneContact| {
                contacts.push(DampedContact::new(contact, forces, rolling));
            };
            let acted = self.ground.act(&motion, &mut ground, each);
            acted.map_err(below)?;
            let planned = drive.set_speed(i, of_velocities, geometry.wheel_radius);
            let response = drive.response(self.commands[i], planned, omega, wheel.integral);
            if let Some(truth) = truth.as_deref_mut() {
                let of_wheel = &mut truth.wheels[i];
                (of_wheel.angle, of_wheel.omega) = (wheel.angle, omega);
                of_wheel.torque = response.torque;
                let written = self.ground.write_truth(&ground, &motion, of_wheel);
                written.map_err(below)?;
            }
            loads.drives[i] = response;
            loads.motions[i] = motion;
            loads.wheels[i] = WheelLoad::new(&ground, drive.loss_torque(omega));
            loads.contact_energy += ground.energy;
            let state = &mut loads.wheel_state;
            state.normal_force = state.normal_force.max(ground.normal_force);
            state.approach = state.approach.max(ground.approach);
        }
        let stop = (geometry.stop).torque(angles[0] - angles[1], rates[0] - rates[1]);
        loads.stop_torque = stop;
        if let Some(truth) = truth {
            truth.stop_torque = stop;
        }
        Ok(loads)
    }

    /// Integrates bars and wheel spins over `step` (s).
    fn integrate(&mut self, loads: &mut Loads, step: f64, impact: bool) {
        let before = self.bodies.link_rates();
        let spin_rates = self.apply(loads, step, impact);
        self.bodies.step(step);
        let rates = self.bodies.link_rates();
        self.link_accelerations = [0, 1].map(|i| (rates[i] - before[i]) / step);
        for (i, wheel) in self.wheels.iter_mut().enumerate() {
            let carrier = self.robot.geometry.carriers[i].index();
            let omega_before = wheel.spin + before[carrier];
            wheel.integral += step * loads.drives[i].integral_rate;
            wheel.spin += step * spin_rates[i];
            let omega = wheel.spin + rates[carrier];
            wheel.angle += step * omega;
            self.balance.motor_work += step * loads.drives[i].torque * 0.5 * (omega_before + omega);
        }
        if self.carries_balance {
            self.add_to_balance(loads, [before, rates], step);
        }
    }

    /// Applies the forces that are held over `step` (s) to the links. Returns the rates of the
    /// wheels' absolute spins, rad/s^2.
    fn apply(&mut self, loads: &mut Loads, step: f64, impact: bool) -> [f64; 3] {
        let (geometry, mass) = (&self.robot.geometry, &self.robot.mass);
        let mut torques = [loads.stop_torque, -loads.stop_torque];
        let mut forces = [Vec2::zeros(); 2];
        let mut spin_rates = [0.0; 3];
        let centres = self.bodies.link_centres();
        for (i, spin_rate) in spin_rates.iter_mut().enumerate() {
            let carrier = geometry.carriers[i].index();
            let (change, torque_change) = self.damping.change(i, step, impact);
            let wheel = &mut loads.wheels[i];
            wheel.force += change;
            wheel.ground_torque += torque_change;
            // The acceleration of the link is that of the last integration. Its weight
            // J_wheel/(J_wheel + J_rotor) is 8 %.
            let drive = loads.drives[i].torque - wheel.gear_torque;
            let alpha_link = self.link_accelerations[carrier];
            let omega_rate = wheel_acceleration(drive, wheel.ground_torque, alpha_link, mass);
            let through_gear = drive - mass.rotor_inertia * omega_rate;
            *spin_rate = (through_gear - wheel.ground_torque) / mass.wheel_inertia;
            forces[carrier] += wheel.force;
            // Torques are counter-clockwise; the forward spin is clockwise.
            let arm = loads.motions[i].centre - centres[carrier];
            torques[carrier] += through_gear + cross(arm, wheel.force);
        }
        self.bodies.hold(forces, torques);
        spin_rates
    }

    /// Adds impulse and work of `loads` over a step (s) to the balance: half of the step with the
    /// speeds before it, half with the current ones. `rates` are those of links 1 and 2 before the
    /// step and now, rad/s.
    fn add_to_balance(&mut self, loads: &Loads, rates: [[f64; 2]; 2], step: f64) {
        let half = 0.5 * step;
        for i in 0..3 {
            let carrier = self.robot.geometry.carriers[i];
            let spin = self.wheels[i].spin;
            let now = self.bodies.wheel_motion(&self.robot.geometry, i, spin);
            for (motion, rates) in [loads.motions[i], now].iter().zip(rates) {
                let omega = motion.spin + rates[carrier.index()];
                (self.balance).add_wheel(&loads.wheels[i], motion, omega, half);
            }
        }
        let opening: f64 = rates.map(|[first, second]| first - second).iter().sum();
        self.balance.stop_work += half * loads.stop_torque * opening;
    }

    /// Takes the steps before time zero, with a set speed of zero.
    fn settle(&mut self) -> Result<(), PlantError> {
        let speed = std::mem::take(&mut self.drive.speed);
        for _ in 0..SETTLING_STEPS {
            self.advance(None)?;
            self.steps = 0;
        }
        self.parts_taken = 0;
        self.balance = Balance::default();
        self.drive.speed = speed;
        for wheel in &mut self.wheels {
            wheel.angle = 0.0;
        }
        Ok(())
    }
}

impl Engine for RapierEngine {
    fn mean_step(&self) -> f64 {
        // Exact below 2^53 steps.
        self.time() / self.parts_taken.max(1) as f64
    }

    fn command(&mut self, commands: [WheelCommand; 3]) {
        self.commands = commands;
    }

    fn next_instant(&mut self, instant: &mut Instant) -> Result<(), PlantError> {
        instant.balance = self.balance;
        instant.truth = self.bodies.kinematics(&self.robot.geometry, self.time());
        instant.contact_energy = self.advance(Some(&mut instant.truth))?;
        for _ in 1..self.steps_per_period {
            self.advance(None)?;
        }
        Ok(())
    }
}

/// Smallest number of equal steps in a period (s) that are not longer than `step` (s).
fn steps_per_period(period: f64, step: f64) -> u64 {
    // The factor compensates rounding: 1 ms contains exactly ten steps of 0.1 ms.
    (period / step * (1.0 - 1e-9)).ceil().max(1.0) as u64
}
