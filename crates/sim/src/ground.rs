//! The ground under one wheel: terrain, contact and friction put together, eqs. (10) and (11).

use crate::contact::ContactLaw;
use crate::friction::FrictionLaw;
use crate::plant::PlantSetup;
use crate::truth::WheelTruth;
use robhaz_model::Vec2;
use robhaz_terrain::{Contact, Terrain};

/// The ground, and what a wheel's forces on it depend on.
pub(crate) struct Ground {
    terrain: Terrain,
    contact: ContactLaw,
    friction: FrictionLaw,
    wheel_radius: f64,
    /// Kept from call to call for its storage.
    found: Vec<Contact>,
}

/// How a wheel moves.
#[derive(Clone, Copy)]
pub(crate) struct WheelMotion {
    /// Centre, m.
    pub centre: Vec2,
    /// Velocity of the centre, m/s.
    pub velocity: Vec2,
    /// Absolute spin, rad/s, forward positive.
    pub spin: f64,
}

/// What the ground does to one wheel.
#[derive(Clone, Copy)]
pub(crate) struct GroundForces {
    /// Sum of all contact forces, N.
    pub force: Vec2,
    /// Sum of d T over the contacts, N m: the torque that resists the forward spin.
    pub torque: f64,
    normal_force: f64,
    traction: f64,
    contact_angle: f64,
    penetration: f64,
    slip_speed: f64,
    contacts: u32,
}

impl Ground {
    pub fn new(setup: &PlantSetup) -> Self {
        Self {
            terrain: setup.terrain.clone(),
            contact: setup.contact,
            friction: setup.friction,
            wheel_radius: setup.robot.geometry.wheel_radius,
            found: Vec::with_capacity(4),
        }
    }

    /// Forces of all contacts of a wheel. The error is the x (m) of a wheel whose centre is below the ground.
    pub fn act(&mut self, wheel: &WheelMotion) -> Result<GroundForces, f64> {
        self.terrain
            .contacts(wheel.centre, self.wheel_radius, &mut self.found);
        let mut sum = GroundForces {
            force: Vec2::zeros(),
            torque: 0.0,
            normal_force: 0.0,
            traction: 0.0,
            contact_angle: 0.0,
            penetration: f64::NEG_INFINITY,
            slip_speed: 0.0,
            contacts: 0,
        };
        let mut normal_sum = Vec2::zeros();
        for contact in &self.found {
            let (t, n, arm) = axes(contact, wheel)?;
            let penetration = self.wheel_radius - arm;
            let normal_force = self
                .contact
                .normal_force(penetration, -wheel.velocity.dot(&n));
            let slip_speed = wheel.spin * arm - wheel.velocity.dot(&t);
            let traction = self.friction.coefficient(slip_speed) * normal_force;
            normal_sum += n * normal_force;
            sum.force += n * normal_force + t * traction;
            sum.torque += arm * traction;
            sum.traction += traction;
            sum.contacts += 1;
            if penetration > sum.penetration {
                sum.penetration = penetration;
                sum.slip_speed = slip_speed;
                sum.contact_angle = contact.angle;
            }
        }
        sum.normal_force = normal_sum.norm();
        if sum.contacts > 1 && sum.normal_force > 0.0 {
            sum.contact_angle = (-normal_sum.x).atan2(normal_sum.y);
        }
        Ok(sum)
    }

    /// For the record only: of a wheel in the air, the gap to the nearest ground and its slope.
    pub fn or_gap(
        &self,
        mut forces: GroundForces,
        wheel: &WheelMotion,
    ) -> Result<GroundForces, f64> {
        if forces.contacts == 0
            && let Some(nearest) = self.terrain.nearest(wheel.centre)
        {
            let (t, _, arm) = axes(&nearest, wheel)?;
            forces.penetration = self.wheel_radius - arm;
            forces.contact_angle = nearest.angle;
            forces.slip_speed = wheel.spin * arm - wheel.velocity.dot(&t);
        }
        Ok(forces)
    }
}

/// Tangent, normal and the arm from the contact to the wheel's centre, m; the error is the wheel's x below the ground.
fn axes(contact: &Contact, wheel: &WheelMotion) -> Result<(Vec2, Vec2, f64), f64> {
    // Written so that a NaN fails too.
    if contact.distance > 0.0 {
        Ok((contact.tangent(), contact.normal(), contact.distance))
    } else {
        Err(wheel.centre.x)
    }
}

impl GroundForces {
    /// The wheel's part of a truth: position (m), spin angle (rad) and speed (rad/s), motor torque (N m).
    pub fn truth(&self, position: Vec2, angle: f64, omega: f64, torque: f64) -> WheelTruth {
        WheelTruth {
            position,
            angle,
            omega,
            torque,
            normal_force: self.normal_force,
            traction: self.traction,
            contact_angle: self.contact_angle,
            penetration: self.penetration,
            slip_speed: self.slip_speed,
            contacts: self.contacts,
        }
    }
}
