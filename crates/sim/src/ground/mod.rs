//! Forces of the ground on one wheel: terrain, contact law (10) and friction law (11) combined.

use crate::contact::NormalForce;
use crate::error::NoTruth;
use crate::friction::Slip;
use crate::power::Power;
use crate::setup::PlantSetup;
use crate::truth::{ContactList, ContactTruth, WheelTruth};
use robhaz_model::{Vec2, direction};
use robhaz_terrain::Contact;

/// The ground with its laws, for wheels of one radius.
pub(crate) struct Ground {
    setup: PlantSetup,
    wheel_radius: f64,
    /// For the exponent of the contact law.
    power: Power,
    /// Contacts of each wheel at the last call of [`Ground::act`].
    pub found: [Vec<Contact>; 3],
    /// Where each wheel was last.
    hints: [usize; 3],
    has_corners: bool,
    /// Contacts at the last call of [`Ground::meets`].
    ahead: Vec<Contact>,
    /// Number of searches for contacts so far.
    #[cfg(test)]
    queries: u64,
}

/// Motion of a wheel.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct WheelMotion {
    /// Index of the wheel: 0 front, 1 middle, 2 rear.
    pub wheel: usize,
    /// Centre, m.
    pub centre: Vec2,
    /// Velocity of the centre, m/s.
    pub velocity: Vec2,
    /// Absolute spin, rad/s, forward positive.
    pub spin: f64,
}

/// Forces at one contact.
pub(crate) struct OneContact {
    truth: ContactTruth,
    /// N and its parts.
    pub normal: NormalForce,
    /// T/N, -.
    pub coefficient: f64,
    /// Speed of the wheel into the ground, m/s.
    pub approach: f64,
    /// Slip speed beyond which it slides, m/s.
    slip_limit: f64,
}

/// Forces of the ground on one wheel.
#[derive(Clone, Copy, Default)]
pub(crate) struct GroundForces {
    /// Sum of all contact forces, N.
    pub force: Vec2,
    /// Torque that resists the forward spin, N m: sum of d T and of the rolling resistance over the
    /// contacts.
    pub torque: f64,
    /// Magnitude of the normal forces' vector sum, N.
    pub normal_force: f64,
    traction: f64,
    /// Direction of the ground's tangent, of any length. Only the record uses its angle.
    tangent: Vec2,
    /// The contact with the largest penetration.
    deepest: ContactTruth,
    /// Its slip speed beyond which it slides, m/s.
    slip_limit: f64,
    /// Whether a contact grips.
    grips: bool,
    /// Number of contacts.
    pub contacts: u32,
    /// Elastic energy of the contacts, J.
    pub energy: f64,
    /// Largest speed of the wheel into the ground over its contacts, m/s; 0 without contact or if
    /// all speeds are outward.
    pub approach: f64,
}

impl Ground {
    pub fn new(setup: &PlantSetup) -> Self {
        Self {
            setup: setup.clone(),
            wheel_radius: setup.robot.geometry.wheel_radius,
            power: Power::new(setup.contact.exponent),
            found: Default::default(),
            hints: Default::default(),
            has_corners: setup.terrain.has_corners(),
            ahead: Vec::new(),
            #[cfg(test)]
            queries: 0,
        }
    }

    /// Forces of all contacts of a wheel; passes each contact with its forces to `each`.
    ///
    /// # Errors
    /// [`NoTruth::WheelBelowGround`]
    pub fn act(
        &mut self,
        motion: &WheelMotion,
        forces: &mut GroundForces,
        each: impl FnMut(&Contact, &OneContact),
    ) -> Result<(), NoTruth> {
        let wheel = motion.wheel;
        let (hint, found) = (&mut self.hints[wheel], &mut self.found[wheel]);
        (self.setup.terrain).contacts_near(motion.centre, self.wheel_radius, hint, found);
        #[cfg(test)]
        {
            self.queries += 1;
        }
        self.sum(&self.found[wheel], motion, forces, each)
    }

    /// Whether a wheel at the motion of the last call of [`Self::act`] will meet the ground at a further place within `time`, s. On ground
    /// without corners only a wheel in the air is asked for.
    pub fn meets(&mut self, motion: &WheelMotion, time: f64) -> bool {
        let found = &self.found[motion.wheel];
        if !self.has_corners && !found.is_empty() {
            return false;
        }
        let centre = motion.centre + motion.velocity * time;
        let (hint, ahead) = (&mut self.hints[motion.wheel], &mut self.ahead);
        (self.setup.terrain).contacts_near(centre, self.wheel_radius, hint, ahead);
        let known = |c: &Contact| found.iter().any(|f| is_same(f.normal(), c.normal()));
        !self.ahead.iter().all(known)
    }

    /// [`rolling_moment`](crate::friction::FrictionLaw::rolling_moment) of a wheel.
    #[inline]
    pub fn rolling_moment(&self, normal_force: f64, spin: f64) -> f64 {
        let law = &self.setup.friction;
        law.rolling_moment(normal_force, self.wheel_radius, spin)
    }

    /// Number of searches for contacts so far.
    #[cfg(test)]
    pub fn queries(&self) -> u64 {
        self.queries
    }

    /// Sums the forces of given contacts of a wheel, and passes each one to `each`.
    ///
    /// # Errors
    /// [`NoTruth::WheelBelowGround`]
    #[inline(always)]
    pub fn sum(
        &self,
        found: &[Contact],
        wheel: &WheelMotion,
        sum: &mut GroundForces,
        mut each: impl FnMut(&Contact, &OneContact),
    ) -> Result<(), NoTruth> {
        // The usual case, in half the time.
        if let [contact] = found {
            let one = self.one_contact(contact, wheel)?;
            each(contact, &one);
            let truth = &one.truth;
            let moment = self.rolling_moment(truth.normal_force, wheel.spin);
            *sum = GroundForces {
                force: truth.normal * truth.normal_force + contact.tangent * truth.traction,
                torque: contact.distance * truth.traction + moment,
                normal_force: truth.normal_force,
                traction: truth.traction,
                tangent: contact.tangent,
                deepest: *truth,
                slip_limit: one.slip_limit,
                grips: !truth.slides,
                contacts: 1,
                energy: one.normal.energy,
                approach: one.approach.max(0.0),
            };
            return Ok(());
        }
        *sum = GroundForces::default();
        let mut normal_sum = Vec2::zeros();
        for contact in found {
            if is_behind(contact, found) {
                continue;
            }
            let one = self.one_contact(contact, wheel)?;
            each(contact, &one);
            let truth = &one.truth;
            let pressing = truth.normal * truth.normal_force;
            normal_sum += pressing;
            sum.force += pressing + contact.tangent * truth.traction;
            sum.torque += contact.distance * truth.traction;
            sum.torque += self.rolling_moment(truth.normal_force, wheel.spin);
            sum.traction += truth.traction;
            sum.energy += one.normal.energy;
            sum.contacts += 1;
            sum.grips |= !truth.slides;
            sum.approach = sum.approach.max(one.approach);
            if sum.contacts == 1 || truth.penetration > sum.deepest.penetration {
                sum.normal_force = truth.normal_force;
                (sum.deepest, sum.slip_limit) = (one.truth, one.slip_limit);
                sum.tangent = contact.tangent;
            }
        }
        if sum.contacts > 1 {
            sum.normal_force = normal_sum.norm();
            if sum.normal_force > 0.0 {
                sum.tangent = Vec2::new(normal_sum.y, -normal_sum.x);
            }
        }
        Ok(())
    }

    /// Laws (10) and (11) at one contact.
    #[inline(always)]
    fn one_contact(&self, contact: &Contact, wheel: &WheelMotion) -> Result<OneContact, NoTruth> {
        // A NaN is below the ground, too.
        let arm = Some(contact.distance).filter(|arm| *arm > 0.0);
        let arm = arm.ok_or(NoTruth::WheelBelowGround {
            wheel: wheel.wheel + 1,
            x: wheel.centre.x,
        })?;
        let normal = contact.normal();
        let penetration = self.wheel_radius - arm;
        let approach = -wheel.velocity.dot(&normal);
        let law = self
            .setup
            .contact
            .at(penetration, approach, |g| self.power.of(g));
        let normal_force = law.force();
        let slip = Slip {
            rim: wheel.spin * arm,
            centre: wheel.velocity.dot(&contact.tangent),
        };
        let friction = self
            .setup
            .friction
            .at(&self.setup.stretches, contact.point.x);
        let slip_limit = friction.slip_limit(&slip);
        let coefficient = friction.coefficient(&slip);
        Ok(OneContact {
            truth: ContactTruth {
                point: contact.point,
                normal,
                normal_force,
                traction: coefficient * normal_force,
                penetration,
                slip_speed: slip.speed(),
                slides: slip.speed().abs() > slip_limit,
            },
            normal: law,
            coefficient,
            approach,
            slip_limit,
        })
    }

    /// Writes the truth of a wheel, but not its spin and motor torque,
    /// which the caller knows. The last call of [`Self::act`] for the wheel gave `forces` at the
    /// same motion. A wheel without contact gets gap, slope and slip speed at the nearest ground.
    ///
    /// # Errors
    /// [`NoTruth::WheelBelowGround`]
    pub fn write_truth(
        &self,
        forces: &GroundForces,
        wheel: &WheelMotion,
        truth: &mut WheelTruth,
    ) -> Result<(), NoTruth> {
        truth.position = wheel.centre;
        truth.normal_force = forces.normal_force;
        truth.traction = forces.traction;
        truth.contact_angle = direction(forces.tangent);
        truth.penetration = forces.deepest.penetration;
        truth.slip_speed = forces.deepest.slip_speed;
        truth.slip_limit = forces.slip_limit;
        truth.contacts = forces.contacts;
        truth.force = forces.force;
        truth.slides = forces.contacts > 0 && !forces.grips;
        match forces.contacts {
            // Its forces are those of the wheel: a second evaluation would cost time.
            1 => truth.contact_list.set(forces.deepest),
            _ => {
                truth.contact_list = ContactList::default();
                let found = &self.found[wheel.wheel];
                for contact in found.iter().filter(|c| !is_behind(c, found)) {
                    let one = self.one_contact(contact, wheel)?;
                    truth.contact_list.push(one.truth);
                }
            }
        }
        if forces.contacts == 0
            && let Some(nearest) = self.setup.terrain.nearest(wheel.centre)
        {
            let OneContact {
                truth: at,
                slip_limit,
                ..
            } = self.one_contact(&nearest, wheel)?;
            truth.contact_angle = direction(nearest.tangent);
            (truth.penetration, truth.slip_speed) = (at.penetration, at.slip_speed);
            truth.slip_limit = slip_limit;
        }
        Ok(())
    }
}

/// Whether two normals of a wheel, at most a step apart, belong to one contact. Contacts whose
/// normals differ by less are merged by the terrain; a wheel of 0.1 m at 3 m/s turns its normal by
/// 0.3 deg in 0.2 ms.
pub(crate) fn is_same(a: Vec2, b: Vec2) -> bool {
    const LEAST_COSINE: f64 = 0.99;
    a.dot(&b) > LEAST_COSINE
}

/// Whether a contact is on the far side of a thin wall that the wheel penetrates from the near
/// side: the centre is behind the contact's surface, and nearer to a surface that faces it. Such a
/// contact exerts no force.
fn is_behind(contact: &Contact, found: &[Contact]) -> bool {
    let nearer = |c: &Contact| c.distance > 0.0 && c.distance < -contact.distance;
    contact.distance < 0.0 && found.iter().any(nearer)
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test may stop at the first surprise")]
mod tests;
