//! The plant on rapier2d: four bars as rigid bodies, each with the mass of its wheels, four pins as impulse joints; the wheels' spins
//! and all forces from our own laws.
//!
//! Rapier sees no collider: terrain queries, contact, friction, drive and stops are evaluated here before each step, at the
//! state from which the step starts. How long a step may be: [`crate::stability`].

use crate::balance::{Balance, WheelLoad};
use crate::contact::ContactLaw;
use crate::drive::{Drive, wheel_acceleration};
use crate::friction::FrictionLaw;
use crate::ground::{Ground, WheelMotion};
use crate::joints::{self, Lump};
use crate::plant::{Engine, Instant, PlantError, PlantSetup};
use crate::stability::{STABLE_SHARE, longest_step_for_friction};
use crate::start::{Start, StartKind};
use crate::stop::stop_torque;
use crate::truth::{BarTruth, PinTruth, Truth};
use rapier2d::prelude::*;
use robhaz_model::{Bar, Pin, Robot, Vec2, cross, perp};

/// The library behind this engine; a test holds it against the locked version.
pub const LIBRARY: &str = "rapier2d 0.36.1";

/// Parts of a step while a wheel is hit by an edge: 16 us resolve the 75 us in which a wheel is stopped. A load that makes the
/// friction stiff takes fewer.
pub const MOST_PARTS: u32 = 8;
/// Pieces of a part while an impact would make the friction unstable: on the default ground beyond 6.6 kN in eight parts.
const MOST_CUTS: u32 = 32;
/// Rapier's iterations that free the joints' speeds of what closes their gaps, where the step changes.
const RELAXATIONS_AT_A_CHANGE: usize = 20;
/// Steps before a settled start, in which the joints' errors come to rest too: after 100 N stays within 10 uN.
const SETTLING_STEPS: u64 = 200;

/// The simulation on rapier2d, with all that acts on the robot.
pub struct RapierEngine {
    robot: Robot,
    ground: Ground,
    drive: Drive,
    world: PhysicsWorld,
    bars: [RigidBodyHandle; 4],
    /// What moves with each bar, in the order of [`Bar::ALL`].
    lumps: [Lump; 4],
    pins: [ImpulseJointHandle; 4],
    wheels: [Wheel; 3],
    /// Steps taken; time is this times the step, so that it does not drift.
    steps: u64,
    steps_per_period: u64,
    step: f64,
    /// Parts of steps taken.
    parts_taken: u64,
    /// Impulse and work since the start; but for the motors' work zero unless they are asked for.
    balance: Balance,
    carries_balance: bool,
    /// Angular accelerations of links 1 and 2 over the last part of a step, rad/s^2.
    link_accelerations: [f64; 2],
    contact: ContactLaw,
    /// Penetration under the mean wheel load, m.
    rest: f64,
    /// Longest step for the friction times N, N s.
    friction_limit: f64,
    /// Steps still to be taken before time 0.
    settling_steps: u64,
}

/// The turn of a wheel's disc, which rapier does not know.
#[derive(Clone, Copy, Debug, Default)]
struct Wheel {
    /// Absolute spin, rad/s, forward positive.
    spin: f64,
    /// Turn relative to its link since the start, rad.
    angle: f64,
    /// Integral of the speed error, rad.
    integral: f64,
}

/// What acts on links and wheels at one instant.
#[derive(Clone, Copy, Debug, Default)]
struct Loads {
    /// On links 1 and 2, from the ground, N.
    forces: [Vec2; 2],
    /// On links 1 and 2 about their centres of mass with wheels, N m counter-clockwise.
    torques: [f64; 2],
    /// Rates of the wheels' absolute spins, rad/s^2.
    spin_rates: [f64; 3],
    /// Rates of the integrals of the speed errors, rad/s.
    integral_rates: [f64; 3],
    /// Motor torques, N m.
    motor_torques: [f64; 3],
    /// Motion of the wheels, and what acts on them beside the motors.
    motions: [WheelMotion; 3],
    wheels: [WheelLoad; 3],
    /// Torque of the end stops on link 1, N m.
    stop_torque: f64,
    /// In the springs of the contacts, J.
    contact_energy: f64,
    /// Greatest N of a wheel, N.
    normal_force: f64,
    /// Greatest speed of a wheel into the ground, m/s.
    approach: f64,
}

/// Motion of the wheel on `link` whose axle is at `nominal` in the link's own frame; `spin` is absolute, rad/s.
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

/// Of `v` turning with the rate `rate` (rad/s): its rate of change.
fn turning(rate: f64, v: Vec2) -> Vec2 {
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
        // External forces are held over solver iterations: one only, and a short step instead.
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
                    .linvel(to_rapier(at.velocity + turning(at.rate, centre)))
                    .angvel(at.rate)
                    .additional_mass_properties(MassProperties::new(
                        to_rapier(lump.centre),
                        lump.mass,
                        lump.inertia,
                    ))
                    .can_sleep(false),
            )
        });
        // Rapier would do so in its first step only: until then centres of mass would be those of the bare bars.
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
            drive: setup.drive,
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
            contact: setup.contact,
            friction_limit: friction_limit(setup),
            rest: setup
                .contact
                .static_penetration(setup.robot.mean_wheel_load()),
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

    /// Poses, rates and pin positions now; wheels only as far as the bodies tell.
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

    /// One step, in as many parts as the state needs. Fills in wheels, stop and pins of `truth` where one is asked for. Gives the energy
    /// in the contacts' springs at its start, J.
    fn advance(&mut self, mut truth: Option<&mut Truth>) -> Result<f64, PlantError> {
        let time = self.time();
        let mut loads = self.loads(time, truth.as_deref_mut())?;
        let contact_energy = loads.contact_energy;
        let parts = self.parts(&loads);
        let length = self.step / f64::from(parts);
        // The first part tells the pins' forces, which belong to the same instant as the truth.
        let mut pins = truth.map(|truth| (truth, self.pin_arms()));
        for part in 0..parts {
            let begin = time + f64::from(part) * length;
            if part > 0 {
                loads = self.loads(begin, None)?;
            }
            let cuts = self.cuts(&loads, length);
            let shorter = length / f64::from(cuts);
            for cut in 0..cuts {
                if cut > 0 {
                    loads = self.loads(begin + f64::from(cut) * shorter, None)?;
                }
                self.integrate(&loads, shorter);
                if let Some((truth, arms)) = pins.take() {
                    self.pin_forces(truth, &arms, shorter);
                }
            }
            self.parts_taken += u64::from(cuts);
        }
        self.steps += 1;
        Ok(contact_energy)
    }

    /// Forces in the pins over the last part of a step, of the length `step` (s).
    fn pin_forces(&self, truth: &mut Truth, arms: &[PinArms; 4], step: f64) {
        for (i, handle) in self.pins.into_iter().enumerate() {
            if let Some(joint) = self.world.impulse_joints.get(handle) {
                let [first, second] = [joint.impulses[0], joint.impulses[1]];
                truth.pins[i].force = arms[i].force(first, second, step);
            }
        }
    }

    /// How much a step (s) adds to the N of a wheel at most, N: damping and spring at the mean load.
    fn rise(&self, loads: &Loads, step: f64) -> f64 {
        let law = &self.contact;
        let tangent = law.stiffness * law.exponent * self.rest.powf(law.exponent - 1.0);
        (law.damping + tangent * step) * loads.approach
    }

    /// Into how many parts the next step is cut: a wheel driven into the ground so fast that a step would add more than the mean
    /// load to its N is hit. From the state alone, so that runs repeat.
    fn parts(&self, loads: &Loads) -> u32 {
        if self.rise(loads, self.step) > self.robot.mean_wheel_load() {
            return MOST_PARTS;
        }
        // The explicit friction, at the load as it is.
        (1..MOST_PARTS)
            .find(|parts| self.step < f64::from(*parts) * self.friction_limit / loads.normal_force)
            .unwrap_or(MOST_PARTS)
    }

    /// Into how many pieces a part of a step, `part` (s), is cut in its turn: an impact of kilonewtons can make the friction unstable
    /// in that part, and may start after the step's start.
    fn cuts(&self, loads: &Loads, part: f64) -> u32 {
        let load = loads.normal_force.max(self.rise(loads, part));
        if part * load < self.friction_limit / STABLE_SHARE {
            return 1;
        }
        (1..MOST_CUTS)
            .find(|cuts| part * load < f64::from(*cuts) * self.friction_limit)
            .unwrap_or(MOST_CUTS)
    }

    /// Forces at the state now.
    fn loads(&mut self, time: f64, mut truth: Option<&mut Truth>) -> Result<Loads, PlantError> {
        let (geometry, mass) = (&self.robot.geometry, &self.robot.mass);
        let bodies = &self.world.bodies;
        let links = [Bar::Link1, Bar::Link2].map(|bar| &bodies[self.bars[bar as usize]]);
        let rates = links.map(RigidBody::angvel);
        let angles = links.map(|link| link.rotation().angle());
        let centres = links.map(|link| from_rapier(link.center_of_mass()));
        let mut loads = Loads::default();
        let set_speed = self.drive.set_speed(time, geometry.wheel_radius);
        for i in 0..3 {
            let carrier = geometry.carriers[i].index();
            let (link, link_rate) = (links[carrier], rates[carrier]);
            let wheel = &self.wheels[i];
            let omega = wheel.spin + link_rate;
            let motion = wheel_motion(link, geometry.axle_on_carrier(i), wheel.spin);
            let below = |x| PlantError::WheelBelowGround {
                time,
                wheel: i + 1,
                x,
            };
            let ground = self.ground.act(&motion).map_err(below)?;
            let error = set_speed - omega;
            let torque = self.drive.torque(error, wheel.integral);
            let gear_torque = self.drive.loss_torque(omega);
            let drive_torque = torque - gear_torque;
            if let Some(truth) = truth.as_deref_mut() {
                let ground = self.ground.or_gap(ground, &motion).map_err(below)?;
                truth.wheels[i] = ground.truth(motion.centre, wheel.angle, omega, torque);
            }
            // The rotor's reaction needs the link's acceleration: that of the last step (its weight
            // J_wheel/(J_wheel + J_rotor) is 8 %).
            let omega_rate = wheel_acceleration(
                drive_torque,
                ground.torque,
                self.link_accelerations[carrier],
                mass.wheel_inertia,
                mass.rotor_inertia,
            );
            let through_gear = drive_torque - mass.rotor_inertia * omega_rate;
            loads.integral_rates[i] = self.drive.integral_rate(error, wheel.integral);
            loads.spin_rates[i] = (through_gear - ground.torque) / mass.wheel_inertia;
            loads.forces[carrier] += ground.force;
            // Counter-clockwise; the forward spin is clockwise.
            loads.torques[carrier] +=
                through_gear + cross(motion.centre - centres[carrier], ground.force);
            loads.motor_torques[i] = torque;
            loads.motions[i] = motion;
            loads.wheels[i] = WheelLoad::new(&ground, gear_torque);
            loads.contact_energy += ground.energy;
            loads.normal_force = loads.normal_force.max(ground.normal_force);
            loads.approach = loads.approach.max(ground.approach);
        }
        let stop = stop_torque(&geometry.stop, angles[0] - angles[1], rates[0] - rates[1]);
        loads.torques[0] += stop;
        loads.torques[1] -= stop;
        loads.stop_torque = stop;
        if let Some(truth) = truth {
            truth.stop_torque = stop;
        }
        Ok(loads)
    }

    /// One step of rapier, and of the wheels' spins.
    fn integrate(&mut self, loads: &Loads, step: f64) {
        let before = self.link_rates();
        for (i, bar) in [Bar::Link1, Bar::Link2].into_iter().enumerate() {
            if let Some(body) = self.world.bodies.get_mut(self.bars[bar as usize]) {
                body.reset_forces(false);
                body.reset_torques(false);
                body.add_force(to_rapier(loads.forces[i]), false);
                body.add_torque(loads.torques[i], false);
            }
        }
        let parameters = &mut self.world.integration_parameters;
        // What a long step has left of the pins' gaps and their speeds would be eight times the force over a short one.
        let same = (parameters.dt - step).abs() < 1e-9 * step;
        parameters.num_internal_stabilization_iterations =
            if same { 1 } else { RELAXATIONS_AT_A_CHANGE };
        parameters.dt = step;
        self.world.step();
        let rates = self.link_rates();
        self.link_accelerations = [0, 1].map(|i| (rates[i] - before[i]) / step);
        for (i, wheel) in self.wheels.iter_mut().enumerate() {
            let carrier = self.robot.geometry.carriers[i].index();
            let omega_before = wheel.spin + before[carrier];
            wheel.integral += step * loads.integral_rates[i];
            wheel.spin += step * loads.spin_rates[i];
            let omega = wheel.spin + rates[carrier];
            wheel.angle += step * omega;
            self.balance.motor_work += step * loads.motor_torques[i] * 0.5 * (omega_before + omega);
        }
        if self.carries_balance {
            self.add_to_balance(loads, [before, rates], step);
        }
    }

    /// What `loads` have done in a step (s): half of it at the speeds before, half at those now. `rates` are those of links 1 and 2
    /// before and now, rad/s.
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

    /// Steps before time 0 with the drive at rest.
    fn settle(&mut self) -> Result<(), PlantError> {
        let drive = self.drive;
        self.drive.speed = 0.0;
        for _ in 0..std::mem::take(&mut self.settling_steps) {
            self.advance(None)?;
            self.steps = 0;
        }
        self.parts_taken = 0;
        self.balance = Balance::default();
        self.drive = drive;
        for wheel in &mut self.wheels {
            wheel.angle = 0.0;
        }
        Ok(())
    }

    /// What undoing rapier's joint rows needs, from the poses before a step.
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

    fn next_instant(&mut self) -> Result<Instant, PlantError> {
        if self.settling_steps > 0 {
            self.settle()?;
        }
        let balance = self.balance;
        let mut truth = self.kinematics();
        let contact_energy = self.advance(Some(&mut truth))?;
        for _ in 1..self.steps_per_period {
            self.advance(None)?;
        }
        Ok(Instant {
            truth,
            contact_energy,
            balance,
        })
    }
}

/// Poses at a pin before a step: from these rapier's impulses become a force.
struct PinArms {
    /// x axis of the first bar.
    axis: Vec2,
    /// From the centres of mass to the pin, m.
    arms: [Vec2; 2],
    /// Inverse mass and inertia of both bars.
    inverse: [(f64, f64); 2],
}

impl PinArms {
    /// Force on the first bar, N, from the impulses of rapier's two rows.
    ///
    /// Rapier orthogonalises the rows of a joint (Gram-Schmidt, in the metric of the inverse masses), so that the second
    /// impulse acts along a mixture of both axes: `d01/d00` takes the first axis out of it again.
    fn force(&self, first: f64, second: f64, dt: f64) -> Vec2 {
        let ex = self.axis;
        let ey = perp(ex);
        let (mut d00, mut d01) = (0.0, 0.0);
        for (r, (inverse_mass, inverse_inertia)) in self.arms.iter().zip(self.inverse) {
            let (cx, cy) = (cross(*r, ex), cross(*r, ey));
            d00 += inverse_mass + cx * cx * inverse_inertia;
            d01 += cx * cy * inverse_inertia;
        }
        (ex * (first - d01 / d00 * second) + ey * second) / dt
    }
}

/// The longest step for the friction at 1 N, where the ground is roughest.
fn friction_limit(setup: &PlantSetup) -> f64 {
    let stretches = setup.stretches.iter().map(|s| s.mu_s);
    let friction = FrictionLaw {
        mu_s: stretches.fold(setup.friction.mu_s, f64::max),
        ..setup.friction
    };
    longest_step_for_friction(&friction, &setup.robot, 1.0)
}

/// Steps in one period so that none is longer than `step`.
fn steps_per_period(period: f64, step: f64) -> u64 {
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a count of steps"
    )]
    // A hair below the ratio: 1 ms in steps of 0.1 ms are ten, whatever the rounding.
    let steps = (period / step * (1.0 - 1e-9)).ceil().max(1.0) as u64;
    steps
}
