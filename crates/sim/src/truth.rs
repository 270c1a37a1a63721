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
    /// Whether it slides: its slip is beyond the peak of the friction law
    /// ([`FrictionLaw::slip_limit`](crate::friction::FrictionLaw::slip_limit)).
    pub slides: bool,
}

/// Up to two contacts of a wheel, from rear to front: a slice of fixed capacity.
///
/// Very rough ground can touch a wheel at more than two places. The list then has the two contacts
/// with the largest N.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ContactList {
    entries: [ContactTruth; 2],
    len: usize,
}

impl ContactList {
    /// Becomes a list of one contact: the usual case, without a copy of an empty list.
    pub fn set(&mut self, contact: ContactTruth) {
        if self.len > 1 {
            *self = Self::default();
        }
        (self.entries[0], self.len) = (contact, 1);
    }

    /// Appends a contact. In a full list it replaces the contact with the smallest N, if its own N
    /// is larger.
    pub fn push(&mut self, contact: ContactTruth) {
        if let Some(free) = self.entries.get_mut(self.len) {
            *free = contact;
            self.len += 1;
            return;
        }
        let [first, second] = self.entries;
        let least = first.normal_force.min(second.normal_force);
        if contact.normal_force > least {
            let kept = match first.normal_force > least {
                true => first,
                false => second,
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

/// The single contact whose force on the axle and whose traction are those of all contacts of a
/// wheel together.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct EquivalentContact {
    /// Normal force N >= 0, N.
    pub normal_force: f64,
    /// Traction T, N: the sum of all tractions.
    pub traction: f64,
    /// Contact angle gamma, rad.
    pub angle: f64,
}

/// State of a wheel, and the forces of the ground on it.
///
/// Normal force, traction, contact angle, penetration and slip speed describe the wheel as a whole.
/// With one contact they are those of the contact; with several, the fields say how they are
/// combined.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct WheelTruth {
    /// Centre, m.
    pub position: Vec2,
    /// Spin relative to the carrying link since the start, rad, forward positive (what an encoder
    /// counts).
    pub angle: f64,
    /// Spin speed relative to the carrying link, rad/s, forward positive.
    pub omega: f64,
    /// Motor torque at the wheel, N m, forward positive.
    pub torque: f64,
    /// Normal force N >= 0, N. Several contacts: magnitude of the vector sum of their normal
    /// forces.
    pub normal_force: f64,
    /// Traction T, N, driving forward positive. Several contacts: sum of their tractions.
    pub traction: f64,
    /// Contact angle gamma, rad. Several contacts: angle of the tangent perpendicular to the vector
    /// sum of their normal forces. No contact: slope of the nearest ground.
    pub contact_angle: f64,
    /// Penetration, m. Several contacts: the largest one. No contact: the gap, negative.
    pub penetration: f64,
    /// Slip speed at the contact with the largest penetration, m/s, positive when the rim is faster
    /// than the wheel's centre.
    pub slip_speed: f64,
    /// Magnitude of the slip speed beyond which this contact slides, m/s
    /// ([`FrictionLaw::slip_limit`](crate::friction::FrictionLaw::slip_limit)). No contact: that of
    /// the nearest ground.
    pub slip_limit: f64,
    /// Number of contacts.
    pub contacts: u32,
    /// Force of the ground on the wheel, N: the sum of `N_i n_i + T_i t_i` over all contacts.
    pub force: Vec2,
    /// Whether the wheel slides: it has a contact, and every one of its contacts slides.
    pub slides: bool,
    /// The contacts one by one.
    pub contact_list: ContactList,
}

impl WheelTruth {
    /// The equivalent single contact: what an estimator with one contact a wheel can know.
    ///
    /// The ground acts on the axle with a force F, the sum of `N_i n_i + T_i t_i`, and a moment r T
    /// with T = sum of T_i (the arms r - g_i differ by a few tenths of a percent). One contact has
    /// the same F and T: `N = sqrt(|F|^2 - T^2)` at the angle gamma with
    /// `F = N n(gamma) + T t(gamma)`. With one contact it is that contact. In the air N = T = 0 at
    /// the slope of the nearest ground.
    ///
    /// `None` if |F| < |T|, as between walls that nearly face each other: no single contact has
    /// these forces.
    pub fn equivalent_contact(&self) -> Option<EquivalentContact> {
        let traction = self.traction;
        let (mut normal_force, mut angle) = (self.normal_force, self.contact_angle);
        if self.contacts > 1 {
            normal_force = (self.force.norm_squared() - traction * traction).sqrt();
            // With vectors as complex numbers F = (T + i N) t: t is F (T - i N) up to its length.
            let tangent = self.force * traction - perp(self.force) * normal_force;
            if tangent != Vec2::zeros() {
                angle = tangent.y.atan2(tangent.x);
            }
        }
        // The root of a negative number is not a number.
        (!normal_force.is_nan()).then_some(EquivalentContact {
            normal_force,
            traction,
            angle,
        })
    }
}

/// Position of a pin and the force it carries.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PinTruth {
    /// Position, m.
    pub position: Vec2,
    /// Force on the first bar of [`Pin::bars`] from the second, N.
    pub force: Vec2,
}

/// True motion and forces of the robot at one instant, in SI units. Signs are those of the crate
/// `robhaz-model`.
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
            link => &self.links[link as usize - 1],
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
        &self.pins[pin as usize]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Property: for any order of three contacts, the list keeps the two with the largest N, in
    /// their order.
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

    /// Unit tangent and normal at a contact angle, rad.
    fn axes(angle: f64) -> (Vec2, Vec2) {
        let t = Vec2::new(angle.cos(), angle.sin());
        (t, perp(t))
    }

    /// A wheel on two contacts of angle (rad), N and T (N).
    fn on_two([a, b]: [(f64, f64, f64); 2]) -> WheelTruth {
        let force = |(angle, normal, traction): (f64, f64, f64)| {
            let (t, n) = axes(angle);
            n * normal + t * traction
        };
        WheelTruth {
            contacts: 2,
            force: force(a) + force(b),
            traction: a.2 + b.2,
            ..WheelTruth::default()
        }
    }

    /// Equivalence: the equivalent contact has the force and the traction of both contacts,
    /// whatever they are, and N >=
    /// 0. With both at one angle it is their sum.
    #[test]
    fn the_equivalent_contact_has_the_same_force_and_traction() {
        let mut found = 0;
        for k in 0..2000 {
            let wave =
                |i: u32, scale: f64| scale * (f64::from(k) * (0.7 + 0.37 * f64::from(i))).sin();
            let contact = |i: u32| {
                let normal = 60.0 + wave(i, 55.0);
                (wave(i + 1, 3.0), normal, normal * wave(i + 2, 0.9))
            };
            let wheel = on_two([contact(0), contact(3)]);
            let exists = wheel.force.norm() >= wheel.traction.abs();
            assert_eq!(wheel.equivalent_contact().is_some(), exists, "{k}");
            let Some(equivalent) = wheel.equivalent_contact() else {
                continue;
            };
            found += 1;
            let (t, n) = axes(equivalent.angle);
            let force = n * equivalent.normal_force + t * equivalent.traction;
            // Forces of a hundred newtons, rounded.
            assert!((force - wheel.force).norm() < 1e-11, "{k}");
            assert!(equivalent.normal_force >= 0.0);
            assert!((equivalent.traction - wheel.traction).abs() == 0.0);
        }
        assert!(found > 500 && found < 2000, "{found}");

        let same = on_two([(0.3, 20.0, 4.0), (0.3, 30.0, -9.0)]);
        let equivalent = same.equivalent_contact().unwrap_or_default();
        assert!((equivalent.normal_force - 50.0).abs() < 1e-12);
        assert!((equivalent.angle - 0.3).abs() < 1e-12);
    }

    /// Equivalence: with one contact the equivalent contact is that contact, bit for bit; in the
    /// air it is unloaded.
    #[test]
    fn with_one_contact_it_is_that_contact() {
        for contacts in [0, 1] {
            let wheel = WheelTruth {
                contacts,
                normal_force: 43.7,
                traction: -60.1,
                contact_angle: 0.123,
                ..WheelTruth::default()
            };
            let expected = EquivalentContact {
                normal_force: 43.7,
                traction: -60.1,
                angle: 0.123,
            };
            assert_eq!(wheel.equivalent_contact(), Some(expected));
        }
    }
}
