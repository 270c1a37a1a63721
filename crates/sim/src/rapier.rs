//! The plant on rapier2d: seven rigid bodies, four pins and three axles as impulse joints, all forces from our own laws.
//!
//! Rapier sees no collider: terrain queries, contact, friction, drive and stops are evaluated here before each step, at the
//! state from which the step starts. How long a step may be: [`longest_step_for_contact`] and [`longest_step_for_friction`].

use crate::contact::ContactLaw;
use crate::drive::{Drive, wheel_acceleration};
use crate::friction::FrictionLaw;
use crate::ground::{Ground, WheelMotion};
use crate::plant::{Engine, PlantError, PlantSetup};
use crate::stop::stop_torque;
use crate::truth::{BarTruth, PinTruth, Truth};
use rapier2d::prelude::*;
use robhaz_model::{Bar, Pin, Robot, Vec2};

/// The library behind this engine; a test holds it against the locked version.
pub const LIBRARY: &str = "rapier2d 0.36.1";

/// The simulation on rapier2d, with all that acts on the robot.
pub struct RapierEngine {
    robot: Robot,
    ground: Ground,
    drive: Drive,
    world: PhysicsWorld,
    bars: [RigidBodyHandle; 4],
    wheels: [RigidBodyHandle; 3],
    pins: [ImpulseJointHandle; 4],
    /// Steps taken; time is this times the step, so that it does not drift.
    steps: u64,
    steps_per_period: u64,
    step: f64,
    /// Integral of each wheel's speed error, rad.
    integrals: [f64; 3],
    /// Angular rates of links 1 and 2 one step ago, rad/s.
    previous_rates: [f64; 2],
    /// Spin of each wheel relative to its link since the start, rad.
    spins: [f64; 3],
}

fn to_rapier(v: Vec2) -> Vector {
    Vector::new(v.x, v.y)
}

fn from_rapier(v: Vector) -> Vec2 {
    Vec2::new(v.x, v.y)
}

impl RapierEngine {
    /// Puts the robot on its ground in the nominal pose, at rest, sunk by the static penetration of the mean wheel load.
    pub fn new(setup: &PlantSetup) -> Self {
        let (geometry, mass) = (&setup.robot.geometry, &setup.robot.mass);
        let mut world = PhysicsWorld::default();
        let steps_per_period = steps_per_period(setup.period, setup.step);
        #[expect(clippy::cast_precision_loss, reason = "a count of steps")]
        let step = setup.period / steps_per_period as f64;
        let p = &mut world.integration_parameters;
        p.dt = step;
        // External forces are held over solver iterations: one only, and a short step instead.
        p.num_solver_iterations = 1;
        p.num_internal_pgs_iterations = 4;
        p.num_internal_stabilization_iterations = 4;
        p.max_ccd_substeps = 0;
        world.gravity = Vector::new(0.0, -robhaz_model::GRAVITY);

        let sunk = Vec2::new(
            0.0,
            -setup
                .contact
                .static_penetration(setup.robot.mean_wheel_load()),
        );
        let mut insert = |position: Vec2, mass: f64, inertia: f64| {
            world.insert_body(
                RigidBodyBuilder::dynamic()
                    .translation(to_rapier(position + sunk))
                    .additional_mass_properties(MassProperties::new(Vector::ZERO, mass, inertia))
                    .can_sleep(false),
            )
        };
        let bars = Bar::ALL.map(|bar| {
            let (m, i) = match bar {
                Bar::Body => (mass.body, mass.body_inertia),
                Bar::Link1 => (mass.links[0], mass.link_inertias[0]),
                Bar::Link2 => (mass.links[1], mass.link_inertias[1]),
                Bar::Link3 => (mass.links[2], mass.link_inertias[2]),
            };
            insert(geometry.cg(bar), m, i)
        });
        let wheels = geometry
            .axles
            .map(|axle| insert(axle, mass.wheel, mass.wheel_inertia));
        let pins = Pin::ALL.map(|pin| {
            let (receiver, giver) = pin.bars();
            let at = geometry.pins.get(pin);
            let joint = RevoluteJointBuilder::new()
                .local_anchor1(to_rapier(at - geometry.cg(receiver)))
                .local_anchor2(to_rapier(at - geometry.cg(giver)));
            world.insert_impulse_joint(bars[receiver as usize], bars[giver as usize], joint)
        });
        for (i, wheel) in wheels.iter().enumerate() {
            let link = geometry.carriers[i].bar();
            let joint = RevoluteJointBuilder::new()
                .local_anchor1(to_rapier(geometry.axles[i] - geometry.cg(link)))
                .local_anchor2(Vector::ZERO);
            world.insert_impulse_joint(bars[link as usize], *wheel, joint);
        }
        Self {
            robot: setup.robot.clone(),
            ground: Ground::new(setup),
            drive: setup.drive,
            world,
            bars,
            wheels,
            pins,
            steps: 0,
            steps_per_period,
            step,
            integrals: [0.0; 3],
            previous_rates: [0.0; 2],
            spins: [0.0; 3],
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
                velocity: from_rapier(b.linvel()),
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

    /// Forces at the state now, then one step of rapier. Fills in the wheels of `truth` where one is asked for.
    fn advance(&mut self, mut truth: Option<&mut Truth>) -> Result<(), PlantError> {
        let (geometry, mass) = (self.robot.geometry.clone(), self.robot.mass.clone());
        let time = self.time();
        let rates = [self.bar(Bar::Link1).angvel(), self.bar(Bar::Link2).angvel()];
        let angles = [
            self.bar(Bar::Link1).rotation().angle(),
            self.bar(Bar::Link2).rotation().angle(),
        ];
        for handle in self.bars.iter().chain(&self.wheels) {
            if let Some(body) = self.world.bodies.get_mut(*handle) {
                body.reset_forces(false);
                body.reset_torques(false);
            }
        }
        let mut link_torques = [0.0; 2];
        for i in 0..3 {
            let carrier = geometry.carriers[i].index();
            let link_rate = rates[carrier];
            let (centre, velocity, turn, spin_rate) = {
                let wheel = &self.world.bodies[self.wheels[i]];
                (
                    from_rapier(wheel.translation()),
                    from_rapier(wheel.linvel()),
                    wheel.rotation().angle(),
                    wheel.angvel(),
                )
            };
            let omega = link_rate - spin_rate;
            self.spins[i] = unwrapped(self.spins[i], angles[carrier] - turn);

            let motion = WheelMotion {
                centre,
                velocity,
                spin: -spin_rate,
            };
            let below = |x| PlantError::WheelBelowGround {
                time,
                wheel: i + 1,
                x,
            };
            let ground = self.ground.act(&motion).map_err(below)?;
            let error = self.drive.set_speed(time, geometry.wheel_radius) - omega;
            let torque = self.drive.torque(error, self.integrals[i]);
            let drive_torque = torque - self.drive.loss_torque(omega);
            // The rotor is an armature that rapier does not know: its reaction is added to the torque between link and
            // wheel, with the link's acceleration of the last step (its weight J_wheel/(J_wheel + J_rotor) is 8 %).
            let alpha_link = (link_rate - self.previous_rates[carrier]) / self.step;
            let omega_rate = wheel_acceleration(
                drive_torque,
                ground.torque,
                alpha_link,
                mass.wheel_inertia,
                mass.rotor_inertia,
            );
            let through_gear = drive_torque - mass.rotor_inertia * omega_rate;
            link_torques[carrier] += through_gear;
            self.integrals[i] += self.step * self.drive.integral_rate(error, self.integrals[i]);

            if let Some(body) = self.world.bodies.get_mut(self.wheels[i]) {
                body.add_force(to_rapier(ground.force), false);
                // Counter-clockwise; the forward spin is clockwise.
                body.add_torque(ground.torque - through_gear, false);
            }
            if let Some(truth) = truth.as_deref_mut() {
                let ground = self.ground.or_gap(ground, &motion).map_err(below)?;
                truth.wheels[i] = ground.truth(centre, self.spins[i], omega, torque);
            }
        }
        let stop = stop_torque(&geometry.stop, angles[0] - angles[1], rates[0] - rates[1]);
        link_torques[0] += stop;
        link_torques[1] -= stop;
        for (bar, torque) in [Bar::Link1, Bar::Link2].into_iter().zip(link_torques) {
            if let Some(body) = self.world.bodies.get_mut(self.bars[bar as usize]) {
                body.add_torque(torque, false);
            }
        }
        if let Some(truth) = truth {
            truth.stop_torque = stop;
        }
        self.previous_rates = rates;
        self.world.step();
        self.steps += 1;
        Ok(())
    }

    /// What undoing rapier's joint rows needs, from the poses before a step.
    fn pin_arms(&self) -> [PinArms; 4] {
        let geometry = &self.robot.geometry;
        Pin::ALL.map(|pin| {
            let (receiver, giver) = pin.bars();
            let arm = |bar: Bar| {
                let nominal = geometry.pins.get(pin) - geometry.cg(bar);
                robhaz_model::rotate(nominal, self.bar(bar).rotation().angle())
            };
            let inverse = |bar: Bar| {
                let (m, i) = match bar {
                    Bar::Body => (self.robot.mass.body, self.robot.mass.body_inertia),
                    Bar::Link1 => (self.robot.mass.links[0], self.robot.mass.link_inertias[0]),
                    Bar::Link2 => (self.robot.mass.links[1], self.robot.mass.link_inertias[1]),
                    Bar::Link3 => (self.robot.mass.links[2], self.robot.mass.link_inertias[2]),
                };
                (1.0 / m, 1.0 / i)
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
        self.step
    }

    /// The first step of a period also tells the pins' forces, which belong to the same instant as the truth.
    fn next_truth(&mut self) -> Result<Truth, PlantError> {
        let mut truth = self.kinematics();
        let arms = self.pin_arms();
        self.advance(Some(&mut truth))?;
        for (i, handle) in self.pins.into_iter().enumerate() {
            if let Some(joint) = self.world.impulse_joints.get(handle) {
                truth.pins[i].force =
                    arms[i].force(joint.impulses[0], joint.impulses[1], self.step);
            }
        }
        for _ in 1..self.steps_per_period {
            self.advance(None)?;
        }
        Ok(truth)
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
        let ey = Vec2::new(-ex.y, ex.x);
        let (mut d00, mut d01) = (0.0, 0.0);
        for (r, (inverse_mass, inverse_inertia)) in self.arms.iter().zip(self.inverse) {
            let (cx, cy) = (robhaz_model::cross(*r, ex), robhaz_model::cross(*r, ey));
            d00 += inverse_mass + cx * cx * inverse_inertia;
            d01 += cx * cy * inverse_inertia;
        }
        (ex * (first - d01 / d00 * second) + ey * second) / dt
    }
}

/// Longest step, s, at which the explicit contact force is stable: a bare wheel (kg) on the contact's damping decays with
/// `c/m`, and an explicit step must stay below twice the time constant. 0.15 ms for the default robot.
///
/// In a concave corner two contacts damp one wheel: at a constant c (no ramp) N then rings for some steps.
pub fn longest_step_for_contact(contact: &ContactLaw, robot: &Robot) -> f64 {
    2.0 * robot.mass.wheel / contact.damping
}

/// Longest step, s, at which the explicit friction is stable: near rest T rises with `3 mu_s / (2 v_s) N` per slip speed,
/// against the inertia of wheel and rotor at the rim and the robot's mass. At twice the mean load, which the main course
/// reaches: 1.1 ms for the default ground, 0.11 ms for v_s = 2 mm/s.
pub fn longest_step_for_friction(friction: &FrictionLaw, robot: &Robot) -> f64 {
    let mass = &robot.mass;
    let slope = 1.5 * friction.mu_s / friction.v_s * 2.0 * robot.mean_wheel_load();
    let rim = robot.geometry.wheel_radius.powi(2) / (mass.wheel_inertia + mass.rotor_inertia);
    2.0 / (slope * (rim + 3.0 / mass.total()))
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

/// The angle equal to `angle` up to whole turns that is nearest to `previous`, rad.
fn unwrapped(previous: f64, angle: f64) -> f64 {
    let turn = 2.0 * std::f64::consts::PI;
    angle + turn * ((previous - angle) / turn).round()
}
