//! True motion and forces at one instant.

use robhaz_model::{Bar, Pin, Robot, Vec2, perp};
use std::ops::Deref;

/// Pose and rates of a bar, at its centre of mass without wheels.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BarTruth {
    /// Centre of mass, m.
    pub position: Vec2,
    /// Rotation from the nominal pose, rad, counter-clockwise.
    pub angle: f64,
    /// Velocity of the centre of mass, m/s.
    pub velocity: Vec2,
    /// Angular rate, rad/s, counter-clockwise.
    pub rate: f64,
}

/// One contact of a wheel with the ground.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ContactTruth {
    /// Point of the ground, m.
    pub point: Vec2,
    /// Unit vector along the contact's normal, from the ground to the wheel's centre.
    pub normal: Vec2,
    /// Normal force N >= 0, N.
    pub normal_force: f64,
    /// Traction T, N, driving forward positive.
    pub traction: f64,
    /// Penetration, m.
    pub penetration: f64,
    /// Slip speed, m/s, positive when the rim is faster than the wheel's centre.
    pub slip_speed: f64,
}

/// Up to two contacts of a wheel, from rear to front: a slice of fixed capacity.
///
/// Very rough ground can touch a wheel at more than two places. The list then has the two contacts with the largest N.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ContactList {
    entries: [ContactTruth; 2],
    len: usize,
}

impl ContactList {
    /// Appends a contact. In a full list it replaces the contact with the smallest N, if its own N is larger.
    pub fn push(&mut self, contact: ContactTruth) {
        if let Some(free) = self.entries.get_mut(self.len) {
            *free = contact;
            self.len += 1;
            return;
        }
        let [first, second] = self.entries;
        let least = first.normal_force.min(second.normal_force);
        if contact.normal_force > least {
            let kept = if first.normal_force > least {
                first
            } else {
                second
            };
            self.entries = [kept, contact];
        }
    }
}

impl Deref for ContactList {
    type Target = [ContactTruth];

    fn deref(&self) -> &[ContactTruth] {
        &self.entries[..self.len]
    }
}

/// State of a wheel, and the forces of the ground on it.
///
/// Normal force, traction, contact angle, penetration and slip speed describe the wheel as a whole. With one contact
/// they are those of the contact; with several, the fields say how they are combined.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct WheelTruth {
    /// Centre, m.
    pub position: Vec2,
    /// Spin relative to the carrying link since the start, rad, forward positive (what an encoder counts).
    pub angle: f64,
    /// Spin speed relative to the carrying link, rad/s, forward positive.
    pub omega: f64,
    /// Motor torque at the wheel, N m, forward positive.
    pub torque: f64,
    /// Normal force N >= 0, N. Several contacts: magnitude of the vector sum of their normal forces.
    pub normal_force: f64,
    /// Traction T, N, driving forward positive. Several contacts: sum of their tractions.
    pub traction: f64,
    /// Contact angle gamma, rad. Several contacts: angle of the tangent perpendicular to the vector sum of their normal
    /// forces. No contact: slope of the nearest ground.
    pub contact_angle: f64,
    /// Penetration, m. Several contacts: the largest one. No contact: the gap, negative.
    pub penetration: f64,
    /// Slip speed at the contact with the largest penetration, m/s, positive when the rim is faster than the wheel's
    /// centre.
    pub slip_speed: f64,
    /// Magnitude of the slip speed beyond which this contact slides, m/s
    /// ([`FrictionLaw::slip_limit`](crate::friction::FrictionLaw::slip_limit)). No contact: that of the nearest ground.
    pub slip_limit: f64,
    /// Number of contacts.
    pub contacts: u32,
    /// The contacts one by one.
    pub contact_list: ContactList,
}

/// Position of a pin and the force it carries.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PinTruth {
    /// Position, m.
    pub position: Vec2,
    /// Force on the first bar of [`Pin::bars`] from the second, N.
    pub force: Vec2,
}

/// True motion and forces of the robot at one instant, in SI units. Signs are those of the crate `robhaz-model`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Truth {
    /// Time since the start, s.
    pub time: f64,
    /// The body.
    pub body: BarTruth,
    /// Links 1 to 3.
    pub links: [BarTruth; 3],
    /// Front, middle and rear wheel.
    pub wheels: [WheelTruth; 3],
    /// P, Q, R, S in the order of [`Pin::ALL`].
    pub pins: [PinTruth; 4],
    /// Torque of the end stops on link 1, N m.
    pub stop_torque: f64,
    /// Largest gap of a pin, m: distance between its positions on both bars.
    pub loop_error: f64,
}

impl Truth {
    /// One bar.
    pub fn bar(&self, bar: Bar) -> &BarTruth {
        match bar {
            Bar::Body => &self.body,
            Bar::Link1 => &self.links[0],
            Bar::Link2 => &self.links[1],
            Bar::Link3 => &self.links[2],
        }
    }

    /// Velocity of a wheel's centre, m/s, from the motion of its link.
    pub fn wheel_velocity(&self, robot: &Robot, wheel: usize) -> Vec2 {
        let link = self.bar(robot.geometry.carriers[wheel].bar());
        let arm = self.wheels[wheel].position - link.position;
        link.velocity + perp(arm) * link.rate
    }

    /// One pin.
    pub fn pin(&self, pin: Pin) -> &PinTruth {
        match pin {
            Pin::P => &self.pins[0],
            Pin::Q => &self.pins[1],
            Pin::R => &self.pins[2],
            Pin::S => &self.pins[3],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Property: for any order of three contacts, the list keeps the two with the largest N, in their order.
    #[test]
    fn the_list_keeps_the_largest_contacts() {
        for forces in [[1.0, 2.0, 3.0], [3.0, 1.0, 2.0], [2.0, 3.0, 1.0]] {
            let mut list = ContactList::default();
            assert!(list.is_empty());
            for normal_force in forces {
                list.push(ContactTruth {
                    normal_force,
                    ..ContactTruth::default()
                });
            }
            let found: Vec<f64> = list.iter().map(|contact| contact.normal_force).collect();
            let expected: Vec<f64> = forces.into_iter().filter(|force| *force > 1.5).collect();
            assert_eq!(found, expected);
        }
    }
}
