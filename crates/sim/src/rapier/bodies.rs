//! Bars and pins as rapier knows them: rigid bodies and impulse joints.

use super::joints::{self, Lump};
use crate::ground::WheelMotion;
use crate::start::Start;
use crate::truth::{BarTruth, Truth};
use rapier2d::prelude::*;
use robhaz_model::{Bar, Geometry, Pin, Robot, Suspension, Vec2, cross, perp, rotate};

/// Rapier's stabilisation iterations after a change of the step. They remove the velocities that
/// correct the gaps of the joints.
const STABILIZATIONS_AT_A_CHANGE: usize = 20;

/// The four bars with the masses of their wheels, and the four pins.
pub struct Bodies {
    world: PhysicsWorld,
    bars: [RigidBodyHandle; 4],
    /// Each bar with its wheels, in the order of [`Bar::ALL`].
    lumps: [Lump; 4],
    pins: [ImpulseJointHandle; 4],
}

impl Bodies {
    /// The bars at their start, for steps of `step` (s).
    pub fn new(robot: &Robot, start: &Start, step: f64) -> Self {
        let robot = &with_four_masses(robot);
        let mut world = PhysicsWorld::default();
        let p = &mut world.integration_parameters;
        p.dt = step;
        // External forces stay constant over all solver iterations, so one iteration with a short
        // step is more accurate.
        p.num_solver_iterations = 1;
        p.num_internal_pgs_iterations = joints::iterations(robot);
        p.max_ccd_substeps = 0;
        world.gravity = Vector::new(0.0, -robot.gravity);

        let lumps = Bar::ALL.map(|bar| Lump::new(robot, bar));
        let bars = Bar::ALL.map(|bar| {
            let (at, lump) = (start.bars[bar as usize], lumps[bar as usize]);
            let centre = rotate(lump.centre, at.angle);
            let mass = MassProperties::new(to_rapier(lump.centre), lump.mass, lump.inertia);
            world.insert_body(
                RigidBodyBuilder::dynamic()
                    .translation(to_rapier(at.position))
                    .rotation(at.angle)
                    .linvel(to_rapier(at.velocity + perp(centre) * at.rate))
                    .angvel(at.rate)
                    .additional_mass_properties(mass)
                    .can_sleep(false),
            )
        });
        // Rapier does this in its first step. Until then the centres of mass would be those of the
        // bare bars.
        for handle in bars {
            if let Some(body) = world.bodies.get_mut(handle) {
                body.recompute_mass_properties_from_colliders(&world.colliders);
            }
        }
        let geometry = &robot.geometry;
        let pins = Pin::ALL.map(|pin| {
            let (receiver, giver) = pin.bars();
            let at = geometry.pins.get(pin);
            let joint = RevoluteJointBuilder::new()
                .local_anchor1(to_rapier(at - geometry.cg(receiver)))
                .local_anchor2(to_rapier(at - geometry.cg(giver)));
            world.insert_impulse_joint(bars[receiver as usize], bars[giver as usize], joint)
        });
        Self {
            world,
            bars,
            lumps,
            pins,
        }
    }

    /// A bar.
    pub fn bar(&self, bar: Bar) -> &RigidBody {
        &self.world.bodies[self.bars[bar as usize]]
    }

    /// Angular rates of links 1 and 2, rad/s.
    pub fn link_rates(&self) -> [f64; 2] {
        [Bar::Link1, Bar::Link2].map(|bar| self.bar(bar).angvel())
    }

    /// Centres of mass of links 1 and 2 with their wheels, m.
    pub fn link_centres(&self) -> [Vec2; 2] {
        [Bar::Link1, Bar::Link2].map(|bar| from_rapier(self.bar(bar).center_of_mass()))
    }

    /// Motion of a wheel (0 front, 1 middle, 2 rear) with its absolute spin (rad/s).
    pub fn wheel_motion(&self, geometry: &Geometry, wheel: usize, spin: f64) -> WheelMotion {
        let link = self.bar(geometry.carriers[wheel].bar());
        let nominal = geometry.axle_on_carrier(wheel);
        let centre = link.position().transform_point(to_rapier(nominal));
        WheelMotion {
            wheel,
            centre: from_rapier(centre),
            velocity: from_rapier(link.velocity_at_point(centre)),
            spin,
        }
    }

    /// Truth of bars and pin positions at the current state, at `time` (s).
    pub fn kinematics(&self, geometry: &Geometry, time: f64) -> Truth {
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
            time,
            body: bar(Bar::Body),
            links: Bar::LINKS.map(bar),
            ..Truth::default()
        };
        for (i, pin) in Pin::ALL.into_iter().enumerate() {
            let (a, b) = pin.bars();
            let image = |bar: Bar| {
                let nominal = geometry.pins.get(pin) - geometry.cg(bar);
                from_rapier(self.bar(bar).position().transform_point(to_rapier(nominal)))
            };
            let (first, second) = (image(a), image(b));
            truth.pins[i].position = 0.5 * (first + second);
            truth.loop_error = truth.loop_error.max((first - second).norm());
        }
        truth
    }

    /// Poses at the pins, from which rapier's impulses are converted to forces.
    pub fn pin_arms(&self, geometry: &Geometry) -> [PinArms; 4] {
        Pin::ALL.map(|pin| {
            let (receiver, giver) = pin.bars();
            let arm = |bar: Bar| {
                let nominal =
                    geometry.pins.get(pin) - geometry.cg(bar) - self.lumps[bar as usize].centre;
                rotate(nominal, self.bar(bar).rotation().angle())
            };
            let inverse = |bar: Bar| {
                let lump = &self.lumps[bar as usize];
                (1.0 / lump.mass, 1.0 / lump.inertia)
            };
            PinArms {
                axis: rotate(Vec2::x(), self.bar(receiver).rotation().angle()),
                arms: [arm(receiver), arm(giver)],
                inverse: [inverse(receiver), inverse(giver)],
            }
        })
    }

    /// Mean pin forces over the last integration, of the length `step` (s), with the poses before
    /// it.
    pub fn pin_forces(&self, truth: &mut Truth, arms: &[PinArms; 4], step: f64) {
        for (i, handle) in self.pins.into_iter().enumerate() {
            if let Some(joint) = self.world.impulse_joints.get(handle) {
                let [first, second] = [joint.impulses[0], joint.impulses[1]];
                truth.pins[i].force = arms[i].force(first, second, step);
            }
        }
    }

    /// Forces (N, at the centres of mass) and torques (N m) on links 1 and 2 from now on.
    pub fn hold(&mut self, forces: [Vec2; 2], torques: [f64; 2]) {
        for (i, link) in [Bar::Link1, Bar::Link2].into_iter().enumerate() {
            if let Some(body) = self.world.bodies.get_mut(self.bars[link as usize]) {
                body.reset_forces(false);
                body.reset_torques(false);
                body.add_force(to_rapier(forces[i]), false);
                body.add_torque(torques[i], false);
            }
        }
    }

    /// Integrates over `step` (s).
    pub fn step(&mut self, step: f64) {
        let parameters = &mut self.world.integration_parameters;
        // The velocities that correct the gaps of a long step would appear as forces, many times as
        // large over a short step.
        let same = (parameters.dt - step).abs() < 1e-9 * step;
        parameters.num_internal_stabilization_iterations =
            if same { 1 } else { STABILIZATIONS_AT_A_CHANGE };
        parameters.dt = step;
        self.world.step();
    }

    /// Length of the last integration, s.
    pub fn last_step(&self) -> f64 {
        self.world.integration_parameters.dt
    }
}

/// The robot whose four bars all have a mass, as rapier needs them. Body and link 3 of a bogie move
/// as one: each gets half of the body, with the same centre of mass.
fn with_four_masses(robot: &Robot) -> Robot {
    let mut robot = robot.clone();
    if robot.geometry.suspension != Suspension::FourBar {
        let mass = &mut robot.mass;
        mass.body *= 0.5;
        mass.body_inertia *= 0.5;
        mass.links[2] = mass.body;
        mass.link_inertias[2] = mass.body_inertia;
    }
    robot
}

fn to_rapier(v: Vec2) -> Vector {
    Vector::new(v.x, v.y)
}

fn from_rapier(v: Vector) -> Vec2 {
    Vec2::new(v.x, v.y)
}

/// Poses of two bars at their pin, before a step: pin forces follow from the impulses of rapier's
/// joints.
pub(super) struct PinArms {
    /// Direction of the x axis of the first bar.
    axis: Vec2,
    /// From the centres of mass to the pin, m.
    arms: [Vec2; 2],
    /// Inverse mass (1/kg) and inverse inertia (1/(kg m^2)) of both bars.
    inverse: [(f64, f64); 2],
}

impl PinArms {
    /// Force on the first bar, N, from the impulses (N s) of rapier's two rows in a step `dt` (s).
    ///
    /// Rapier orthogonalises the rows of a joint (Gram-Schmidt, in the metric of the inverse
    /// masses). The second impulse therefore acts along a combination of both axes, and `d01/d00`
    /// is its share along the first one.
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
