//! The engine `rapier`: four bars as rigid bodies of rapier2d, each with the masses of its wheels, and four pins as
//! impulse joints.
//!
//! Rapier has no colliders here. Before each step, terrain contacts, contact force, friction, drive and stops are
//! evaluated with our own laws at the state at the start of the step. They are kept constant over the step, the normal
//! forces with the change that is expected in it (module `damping`). The wheel spins are integrated beside rapier.
//! Stability limits of the step: [`crate::stability`].
//!
//! A settled start comes from the equations of motion that [`crate::direct`] integrates. After that the motion depends
//! on rapier alone.

mod damping;
mod joints;
mod pins;
mod step_control;

use crate::balance::{Balance, WheelLoad};
use crate::drive::{Drive, wheel_acceleration};
use crate::engine::{Engine, Instant};
use crate::error::{BelowGround, PlantError};
use crate::ground::{AxleState, Ground, GroundForces, OneContact, WheelMotion};
use crate::setup::{PlantSetup, StartKind};
use crate::start::Start;
use crate::stop::stop_torque;
use crate::truth::{BarTruth, PinTruth, Truth};
use damping::{DampedContact, Damping};
use joints::Lump;
use pins::PinArms;
use rapier2d::prelude::*;
use robhaz_model::{Bar, Pin, Robot, Vec2, WheelCommand, cross, perp};
use robhaz_terrain::Contact;
use step_control::{Division, StepControl, WheelState};

pub use step_control::MOST_PARTS;

/// Rapier's stabilisation iterations after a change of the step. They remove the velocities that correct the gaps of
/// the joints.
const STABILIZATIONS_AT_A_CHANGE: usize = 20;
/// Steps before time zero at a settled start, in which the gaps of the joints become stationary. N then changes by less
/// than 10 uN after 100 steps.
const SETTLING_STEPS: u64 = 200;

/// A simulation with rapier2d.
pub struct RapierEngine {
    robot: Robot,
    ground: Ground,
    drive: Drive,
    /// Commands of the wheels.
    commands: [WheelCommand; 3],
    world: PhysicsWorld,
    bars: [RigidBodyHandle; 4],
    /// Each bar with its wheels, in the order of [`Bar::ALL`].
    lumps: [Lump; 4],
    pins: [ImpulseJointHandle; 4],
    wheels: [Wheel; 3],
    /// Number of steps so far. Time is this number times the step, without accumulated rounding.
    steps: u64,
    steps_per_period: u64,
    step: f64,
    /// Number of parts and pieces of steps so far.
    parts_taken: u64,
    /// Impulse and work since the start. Without [`PlantSetup::balance`] only the work of the motors is integrated.
    balance: Balance,
    carries_balance: bool,
    /// Mean angular accelerations of links 1 and 2 over the last integration, rad/s^2.
    link_accelerations: [f64; 2],
    step_control: StepControl,
    damping: Damping,
    /// Remaining steps before time zero.
    settling_steps: u64,
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
    /// Motor torques less the losses in the gears, N m.
    drive_torques: [f64; 3],
    /// Rates of the integrals of the speed errors, rad/s.
    integral_rates: [f64; 3],
    /// Motor torques, N m.
    motor_torques: [f64; 3],
    motions: [WheelMotion; 3],
    /// Forces and torques on the wheels, without the motors.
    wheels: [WheelLoad; 3],
    /// Torque of the end stops on link 1, N m.
    stop_torque: f64,
    /// Elastic energy of all contacts, J.
    contact_energy: f64,
    wheel_state: WheelState,
}

/// Motion of the wheel on `link` with its axle at `nominal` in the frame of the link (m) and the absolute spin `spin`
/// (rad/s).
fn wheel_motion(link: &RigidBody, nominal: Vec2, spin: f64) -> WheelMotion {
    let centre = link.position().transform_point(to_rapier(nominal));
    WheelMotion {
        centre: from_rapier(centre),
        velocity: from_rapier(link.velocity_at_point(centre)),
        spin,
    }
}

fn to_rapier(v: Vec2) -> Vector {
    Vector::new(v.x, v.y)
}

fn from_rapier(v: Vector) -> Vec2 {
    Vec2::new(v.x, v.y)
}

/// Rate of change of a vector `v` that rotates at `rate` (rad/s).
fn derivative(rate: f64, v: Vec2) -> Vec2 {
    perp(v) * rate
}

impl RapierEngine {
    /// The robot at its start.
    pub(crate) fn new(setup: &PlantSetup, start: &Start) -> Self {
        let geometry = &setup.robot.geometry;
        let mut world = PhysicsWorld::default();
        let steps_per_period = steps_per_period(setup.period, setup.step);
        #[expect(clippy::cast_precision_loss, reason = "a count of steps")]
        let step = setup.period / steps_per_period as f64;
        let p = &mut world.integration_parameters;
        p.dt = step;
        // External forces stay constant over all solver iterations, so one iteration with a short step is more
        // accurate.
        p.num_solver_iterations = 1;
        p.num_internal_pgs_iterations = joints::iterations(&setup.robot);
        p.max_ccd_substeps = 0;
        world.gravity = Vector::new(0.0, -robhaz_model::GRAVITY);

        let lumps = Bar::ALL.map(|bar| Lump::new(&setup.robot, bar));
        let bars = Bar::ALL.map(|bar| {
            let (at, lump) = (start.bars[bar as usize], lumps[bar as usize]);
            let centre = robhaz_model::rotate(lump.centre, at.angle);
            world.insert_body(
                RigidBodyBuilder::dynamic()
                    .translation(to_rapier(at.position))
                    .rotation(at.angle)
                    .linvel(to_rapier(at.velocity + derivative(at.rate, centre)))
                    .angvel(at.rate)
                    .additional_mass_properties(MassProperties::new(
                        to_rapier(lump.centre),
                        lump.mass,
                        lump.inertia,
                    ))
                    .can_sleep(false),
            )
        });
        // Rapier does this in its first step. Until then the centres of mass would be those of the bare bars.
        for handle in bars {
            if let Some(body) = world.bodies.get_mut(handle) {
                body.recompute_mass_properties_from_colliders(&world.colliders);
            }
        }
        let pins = Pin::ALL.map(|pin| {
            let (receiver, giver) = pin.bars();
            let at = geometry.pins.get(pin);
            let joint = RevoluteJointBuilder::new()
                .local_anchor1(to_rapier(at - geometry.cg(receiver)))
                .local_anchor2(to_rapier(at - geometry.cg(giver)));
            world.insert_impulse_joint(bars[receiver as usize], bars[giver as usize], joint)
        });
        let state = &start.state;
        let link_rates = [state.rates[2], state.rates[3]];
        Self {
            robot: setup.robot.clone(),
            ground: Ground::new(setup),
            drive: setup.drive.clone(),
            commands: Default::default(),
            world,
            bars,
            lumps,
            pins,
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
            settling_steps: match setup.start {
                StartKind::Settled => SETTLING_STEPS,
                StartKind::Raw => 0,
            },
        }
    }

    fn time(&self) -> f64 {
        #[expect(clippy::cast_precision_loss, reason = "exact below 2^53 steps")]
        let steps = self.steps as f64;
        steps * self.step
    }

    fn bar(&self, bar: Bar) -> &RigidBody {
        &self.world.bodies[self.bars[bar as usize]]
    }

    /// Truth of bars and pin positions at the current state.
    fn kinematics(&self) -> Truth {
        let bar = |bar: Bar| {
            let b = self.bar(bar);
            BarTruth {
                position: from_rapier(b.translation()),
                angle: b.rotation().angle(),
                velocity: from_rapier(b.velocity_at_point(b.translation())),
                rate: b.angvel(),
            }
        };
        let mut truth = Truth {
            time: self.time(),
            body: bar(Bar::Body),
            links: Bar::LINKS.map(bar),
            ..Truth::default()
        };
        let geometry = &self.robot.geometry;
        for (i, pin) in Pin::ALL.into_iter().enumerate() {
            let (a, b) = pin.bars();
            let image = |bar: Bar| {
                let nominal = geometry.pins.get(pin) - geometry.cg(bar);
                from_rapier(self.bar(bar).position().transform_point(to_rapier(nominal)))
            };
            let (first, second) = (image(a), image(b));
            truth.pins[i] = PinTruth {
                position: 0.5 * (first + second),
                force: Vec2::zeros(),
            };
            truth.loop_error = truth.loop_error.max((first - second).norm());
        }
        truth
    }

    /// Advances by one step, divided as [`StepControl`] asks. Fills in wheels, stop and pin forces of `truth`. Returns
    /// the elastic energy of all contacts at the start of the step, J.
    fn advance(&mut self, mut truth: Option<&mut Truth>) -> Result<f64, PlantError> {
        let time = self.time();
        let mut loads = self.loads(time, truth.as_deref_mut())?;
        let contact_energy = loads.contact_energy;
        let knows = self.damping.begin(self.step)
            && !(0..3).any(|i| self.ground.meets(i, &loads.motions[i], self.step));
        let Division { parts, impact } =
            self.step_control
                .divide(&loads.wheel_state, self.step, knows);
        let length = self.step / f64::from(parts);
        // The pin forces of the first integration belong to the instant of the truth.
        let mut pins = truth.map(|truth| (truth, self.pin_arms()));
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
                    self.pin_forces(truth, &arms, piece_length);
                }
            }
            self.parts_taken += u64::from(pieces);
        }
        self.steps += 1;
        Ok(contact_energy)
    }

    /// Mean pin forces over the last integration, of the length `step` (s).
    fn pin_forces(&self, truth: &mut Truth, arms: &[PinArms; 4], step: f64) {
        for (i, handle) in self.pins.into_iter().enumerate() {
            if let Some(joint) = self.world.impulse_joints.get(handle) {
                let [first, second] = [joint.impulses[0], joint.impulses[1]];
                truth.pins[i].force = arms[i].force(first, second, step);
            }
        }
    }

    /// Forces and torques at the current state. Fills in wheels and stop of `truth`.
    fn loads(&mut self, time: f64, mut truth: Option<&mut Truth>) -> Result<Loads, PlantError> {
        let geometry = &self.robot.geometry;
        let bodies = &self.world.bodies;
        let links = [Bar::Link1, Bar::Link2].map(|bar| &bodies[self.bars[bar as usize]]);
        let rates = links.map(RigidBody::angvel);
        let angles = links.map(|link| link.rotation().angle());
        let mut loads = Loads::default();
        // Velocities at the end of a step are those in its middle (leapfrog). Compared with a later set speed they would
        // lead, and the robot would be ahead by its way in half a step.
        let of_velocities = time - 0.5 * self.world.integration_parameters.dt;
        for i in 0..3 {
            let carrier = geometry.carriers[i].index();
            let (link, link_rate) = (links[carrier], rates[carrier]);
            let wheel = &self.wheels[i];
            let omega = wheel.spin + link_rate;
            let motion = wheel_motion(link, geometry.axle_on_carrier(i), wheel.spin);
            let below = |error: BelowGround| error.at(time, i);
            let mut ground = GroundForces::default();
            let contacts = self.damping.present(i);
            let rolling = self.ground.rolling_moment(wheel.spin);
            let each = |contact: &Contact, forces: &OneContact| {
                contacts.push(DampedContact::new(contact, forces, rolling));
            };
            self.ground
                .act_each(i, &motion, &mut ground, each)
                .map_err(below)?;
            let planned = self
                .drive
                .set_speed(i, of_velocities, geometry.wheel_radius);
            let drive = self
                .drive
                .response(self.commands[i], planned, omega, wheel.integral);
            let torque = drive.torque;
            let gear_torque = self.drive.loss_torque(omega);
            let drive_torque = torque - gear_torque;
            if let Some(truth) = truth.as_deref_mut() {
                let axle = AxleState {
                    angle: wheel.angle,
                    omega,
                    torque,
                };
                self.ground
                    .write_truth(i, &ground, &motion, axle, &mut truth.wheels[i])
                    .map_err(below)?;
            }
            loads.drive_torques[i] = drive_torque;
            loads.integral_rates[i] = drive.integral_rate;
            loads.motor_torques[i] = torque;
            loads.motions[i] = motion;
            loads.wheels[i] = WheelLoad::new(&ground, gear_torque);
            loads.contact_energy += ground.energy;
            let state = &mut loads.wheel_state;
            state.normal_force = state.normal_force.max(ground.normal_force);
            state.approach = state.approach.max(ground.approach);
        }
        let stop = stop_torque(&geometry.stop, angles[0] - angles[1], rates[0] - rates[1]);
        loads.stop_torque = stop;
        if let Some(truth) = truth {
            truth.stop_torque = stop;
        }
        Ok(loads)
    }

    /// Integrates bars and wheel spins over `step` (s).
    fn integrate(&mut self, loads: &mut Loads, step: f64, impact: bool) {
        let before = self.link_rates();
        let spin_rates = self.apply(loads, step, impact);
        let parameters = &mut self.world.integration_parameters;
        // The velocities that correct the gaps of a long step would appear as forces, many times as large over a short
        // step.
        let same = (parameters.dt - step).abs() < 1e-9 * step;
        parameters.num_internal_stabilization_iterations =
            if same { 1 } else { STABILIZATIONS_AT_A_CHANGE };
        parameters.dt = step;
        self.world.step();
        let rates = self.link_rates();
        self.link_accelerations = [0, 1].map(|i| (rates[i] - before[i]) / step);
        for (i, wheel) in self.wheels.iter_mut().enumerate() {
            let carrier = self.robot.geometry.carriers[i].index();
            let omega_before = wheel.spin + before[carrier];
            wheel.integral += step * loads.integral_rates[i];
            wheel.spin += step * spin_rates[i];
            let omega = wheel.spin + rates[carrier];
            wheel.angle += step * omega;
            self.balance.motor_work += step * loads.motor_torques[i] * 0.5 * (omega_before + omega);
        }
        if self.carries_balance {
            self.add_to_balance(loads, [before, rates], step);
        }
    }

    /// Applies the forces that are held over `step` (s) to the links. Returns the rates of the wheels' absolute spins,
    /// rad/s^2.
    fn apply(&mut self, loads: &mut Loads, step: f64, impact: bool) -> [f64; 3] {
        let (geometry, mass) = (&self.robot.geometry, &self.robot.mass);
        let mut torques = [loads.stop_torque, -loads.stop_torque];
        let mut forces = [Vec2::zeros(); 2];
        let mut spin_rates = [0.0; 3];
        let links = [Bar::Link1, Bar::Link2].map(|bar| self.bars[bar as usize]);
        let centres = links.map(|link| from_rapier(self.world.bodies[link].center_of_mass()));
        for (i, spin_rate) in spin_rates.iter_mut().enumerate() {
            let carrier = geometry.carriers[i].index();
            let (change, torque_change) = self.damping.change(i, step, impact);
            let wheel = &mut loads.wheels[i];
            wheel.force += change;
            wheel.ground_torque += torque_change;
            // The acceleration of the link is that of the last integration. Its weight J_wheel/(J_wheel + J_rotor) is 8
            // %.
            let omega_rate = wheel_acceleration(
                loads.drive_torques[i],
                wheel.ground_torque,
                self.link_accelerations[carrier],
                mass.wheel_inertia,
                mass.rotor_inertia,
            );
            let through_gear = loads.drive_torques[i] - mass.rotor_inertia * omega_rate;
            *spin_rate = (through_gear - wheel.ground_torque) / mass.wheel_inertia;
            forces[carrier] += wheel.force;
            // Torques are counter-clockwise; the forward spin is clockwise.
            let arm = loads.motions[i].centre - centres[carrier];
            torques[carrier] += through_gear + cross(arm, wheel.force);
        }
        for (i, link) in links.into_iter().enumerate() {
            if let Some(body) = self.world.bodies.get_mut(link) {
                body.reset_forces(false);
                body.reset_torques(false);
                body.add_force(to_rapier(forces[i]), false);
                body.add_torque(torques[i], false);
            }
        }
        spin_rates
    }

    /// Adds impulse and work of `loads` over a step (s) to the balance: half of the step with the speeds before it,
    /// half with the current ones. `rates` are those of links 1 and 2 before the step and now, rad/s.
    fn add_to_balance(&mut self, loads: &Loads, rates: [[f64; 2]; 2], step: f64) {
        let half = 0.5 * step;
        for i in 0..3 {
            let carrier = self.robot.geometry.carriers[i];
            let link = self.bar(carrier.bar());
            let now = wheel_motion(
                link,
                self.robot.geometry.axle_on_carrier(i),
                self.wheels[i].spin,
            );
            for (motion, rates) in [loads.motions[i], now].iter().zip(rates) {
                let omega = motion.spin + rates[carrier.index()];
                self.balance
                    .add_wheel(i, &loads.wheels[i], motion, omega, half);
            }
        }
        let opening: f64 = rates.map(|[first, second]| first - second).iter().sum();
        self.balance.stop_work += half * loads.stop_torque * opening;
    }

    /// Angular rates of links 1 and 2, rad/s.
    fn link_rates(&self) -> [f64; 2] {
        [Bar::Link1, Bar::Link2].map(|bar| self.bar(bar).angvel())
    }

    /// Takes the steps before time zero, with a set speed of zero.
    fn settle(&mut self) -> Result<(), PlantError> {
        let speed = std::mem::take(&mut self.drive.speed);
        for _ in 0..std::mem::take(&mut self.settling_steps) {
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

    /// Poses at the pins, from which rapier's impulses are converted to forces.
    fn pin_arms(&self) -> [PinArms; 4] {
        let geometry = &self.robot.geometry;
        Pin::ALL.map(|pin| {
            let (receiver, giver) = pin.bars();
            let arm = |bar: Bar| {
                let nominal =
                    geometry.pins.get(pin) - geometry.cg(bar) - self.lumps[bar as usize].centre;
                robhaz_model::rotate(nominal, self.bar(bar).rotation().angle())
            };
            let inverse = |bar: Bar| {
                let lump = &self.lumps[bar as usize];
                (1.0 / lump.mass, 1.0 / lump.inertia)
            };
            PinArms {
                axis: robhaz_model::rotate(Vec2::x(), self.bar(receiver).rotation().angle()),
                arms: [arm(receiver), arm(giver)],
                inverse: [inverse(receiver), inverse(giver)],
            }
        })
    }
}

impl Engine for RapierEngine {
    fn mean_step(&self) -> f64 {
        #[expect(clippy::cast_precision_loss, reason = "exact below 2^53 steps")]
        let mean = self.time() / self.parts_taken.max(1) as f64;
        mean
    }

    fn command(&mut self, commands: [WheelCommand; 3]) {
        self.commands = commands;
    }

    fn next_instant(&mut self, instant: &mut Instant) -> Result<(), PlantError> {
        if self.settling_steps > 0 {
            self.settle()?;
        }
        instant.balance = self.balance;
        instant.truth = self.kinematics();
        instant.contact_energy = self.advance(Some(&mut instant.truth))?;
        for _ in 1..self.steps_per_period {
            self.advance(None)?;
        }
        Ok(())
    }
}

/// Smallest number of equal steps in a period (s) that are not longer than `step` (s).
fn steps_per_period(period: f64, step: f64) -> u64 {
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a count of steps"
    )]
    // The factor compensates rounding: 1 ms contains exactly ten steps of 0.1 ms.
    let steps = (period / step * (1.0 - 1e-9)).ceil().max(1.0) as u64;
    steps
}
