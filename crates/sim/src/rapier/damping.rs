//! Normal forces that anticipate their change in a step.
//!
//! A bare wheel (mass m) on the damping c(g) of eq. (10) comes to rest within m/c = 75 us. A force
//! that is held over a step of 0.2 ms is stable only if it contains the change of dg/dt in this
//! step. Let L be the force at which dg/dt would not change, `m d2g/dt2 = L - N`. The implicit
//! midpoint rule with eq. (10) linearised holds over a step h
//!
//! ```text
//! F = max(0, (N + k_t h/2 dg/dt + w L)/(1 + w)),   w = h/(2 m) (c + h k_t),
//! ```
//!
//! with `N = k g^n + c dg/dt` and the tangent stiffness `k_t = k n g^(n - 1)` at the start of the
//! step. For h -> 0 this is N. The forces of the record are those of the law at its state, not F.
//!
//! L is measured: its mean over the last step, with the mean F' of the held force, is
//! `F' + m (change of dg/dt)/h`. The line through the means of the last two steps gives L of the
//! present one. The mean of the last step alone would leave an error of N of second order in h that
//! is six times the others at 0.2 ms.
//!
//! **Stability.** Let M be the mass that a contact moves, r = m/M and b = h c/m. The recursion of
//! dg/dt and F is stable up to b = 5.9 for every r <= 1 (up to 3.7 for r = 1.14). A wheel is a
//! point mass on its axle and the rest of the robot adds to it, so a bare wheel as m has r <= 1,
//! for all wheels together. n contacts of one wheel can share a direction and then move a wheel's
//! mass together, so each has the n-th part of it as m.
//!
//! In an impact L jumps. The steps are then so short that the law itself is held (b = 0.2 at the
//! default step).

use crate::contact::NormalForce;
use crate::ground::{OneContact, is_same};
use robhaz_model::Vec2;
use robhaz_terrain::Contact;

/// One contact at the start of a part of a step.
#[derive(Clone, Copy, Debug)]
pub(super) struct DampedContact {
    /// Unit vector along the normal.
    normal: Vec2,
    /// Force on the wheel for each newton of N, -.
    force: Vec2,
    /// Torque that resists the spin for each newton of N, m.
    torque: f64,
    /// N and its parts.
    law: NormalForce,
    /// Speed of the wheel into the ground dg/dt, m/s.
    approach: f64,
}

impl DampedContact {
    /// `rolling` is the moment of rolling resistance for each newton of N, m.
    pub fn new(contact: &Contact, forces: &OneContact, rolling: f64) -> Self {
        let normal = contact.normal();
        Self {
            normal,
            force: normal + contact.tangent * forces.coefficient,
            torque: contact.distance * forces.coefficient + rolling,
            law: forces.normal,
            approach: forces.approach,
        }
    }

    fn is(&self, known: &Known) -> bool {
        is_same(self.normal, known.normal)
    }
}

/// What is known of a contact during a step.
#[derive(Clone, Copy, Debug, Default)]
struct Known {
    /// Its normal in the last part.
    normal: Vec2,
    /// dg/dt at the start of the step, m/s.
    approach: f64,
    /// Integral of the held force since the start of the step, N s.
    impulse: f64,
    /// Of the step before: mean of the held force, N, and mean rate of dg/dt, m/s^2. Both give L
    /// for any m.
    before: Option<(f64, f64)>,
    /// L expected in this step, N.
    expected: Option<f64>,
    /// Whether it has lasted since the start of the step.
    whole: bool,
    /// Whether the last part had it.
    seen: bool,
}

/// The contacts of all wheels.
#[derive(Debug)]
pub(super) struct Damping {
    wheel_mass: f64,
    now: [Vec<DampedContact>; 3],
    known: [Vec<Known>; 3],
    /// Known contacts of a step that begins.
    next: Vec<Known>,
}

impl Damping {
    /// For wheels of this mass, kg.
    pub fn new(wheel_mass: f64) -> Self {
        Self {
            wheel_mass,
            now: Default::default(),
            known: Default::default(),
            next: Vec::new(),
        }
    }

    /// The list of the present contacts of a wheel, emptied.
    pub fn present(&mut self, wheel: usize) -> &mut Vec<DampedContact> {
        self.now[wheel].clear();
        &mut self.now[wheel]
    }

    /// Begins a step; the last one had the length `step` (s). Returns whether L is known for each
    /// present contact.
    pub fn begin(&mut self, step: f64) -> bool {
        let mut all = true;
        for (now, known) in self.now.iter().zip(&mut self.known) {
            self.next.clear();
            let mass = share(self.wheel_mass, now.len());
            for contact in now {
                let past = known.iter().find(|k| k.whole && contact.is(k));
                let last = past.map(|k| {
                    let rate = (contact.approach - k.approach) / step;
                    (k.impulse / step, rate)
                });
                let load = |(force, rate): (f64, f64)| force + mass * rate;
                let before = past.and_then(|k| k.before).or(last).map(load);
                all &= last.is_some();
                self.next.push(Known {
                    normal: contact.normal,
                    approach: contact.approach,
                    before: last,
                    expected: last.map(load).zip(before).map(|(l, b)| 2.0 * l - b),
                    whole: true,
                    ..Known::default()
                });
            }
            std::mem::swap(known, &mut self.next);
        }
        all
    }

    /// Changes of a wheel's forces between the start of a part of a step, of the length `part` (s),
    /// and those that are held over it: force, N, and torque that resists the spin, N m.
    pub fn change(&mut self, wheel: usize, part: f64, impact: bool) -> (Vec2, f64) {
        let (now, known) = (&self.now[wheel], &mut self.known[wheel]);
        let mass = share(self.wheel_mass, now.len());
        let (mut force, mut torque) = (Vec2::zeros(), 0.0);
        known.iter_mut().for_each(|k| k.seen = false);
        for contact in now {
            let (law, by_law) = (&contact.law, contact.law.force());
            let Some(known) = known.iter_mut().find(|k| contact.is(k)) else {
                known.push(Known {
                    normal: contact.normal,
                    seen: true,
                    ..Known::default()
                });
                continue;
            };
            let held = known.expected.filter(|_| !impact).map_or(by_law, |load| {
                let half = 0.5 * part;
                let stiffness = law.stiffness * half;
                let weight = half * (law.damping + law.stiffness * part) / mass;
                let explicit = law.unclamped + stiffness * contact.approach;
                ((explicit + weight * load) / (1.0 + weight)).max(0.0)
            });
            known.seen = true;
            known.normal = contact.normal;
            known.impulse += part * held;
            force += contact.force * (held - by_law);
            torque += contact.torque * (held - by_law);
        }
        known.retain(|k| k.seen);
        (force, torque)
    }
}

/// Mass that each of `count` contacts of a wheel moves at least, for a wheel of this mass, kg.
fn share(mass: f64, count: usize) -> f64 {
    let count = count as f64;
    mass / count
}

#[cfg(test)]
mod tests {
    use super::*;

    const WHEEL: f64 = 1.5;
    const DAMPING: f64 = 2e4;
    const LOAD: f64 = 45.0;

    /// Speeds dg/dt, m/s, at the starts of `count` steps of the length `b m/c`: a contact under a
    /// constant load that moves the mass m/r.
    fn speeds(r: f64, b: f64, count: usize) -> Vec<f64> {
        let step = b * WHEEL / DAMPING;
        let mut damping = Damping::new(WHEEL);
        let mut speed = 1e-5;
        let advance = |_| {
            let before = speed;
            let unclamped = LOAD + DAMPING * speed;
            damping.present(0).push(DampedContact {
                normal: Vec2::y(),
                force: Vec2::y(),
                torque: 0.0,
                law: NormalForce {
                    damping: DAMPING,
                    unclamped,
                    ..NormalForce::default()
                },
                approach: speed,
            });
            damping.begin(step);
            let (change, _) = damping.change(0, step, false);
            speed += step * r / WHEEL * (LOAD - unclamped - change.y);
            before
        };
        (0..count).map(advance).collect()
    }

    /// Closed form: a bare wheel is the midpoint rule, which multiplies dg/dt by
    /// `(1 - b/2)/(1 + b/2)` in a step. The first step is explicit, and measures L for the second.
    #[test]
    fn a_bare_wheel_follows_the_midpoint_rule() {
        for b in [0.01, 0.5, 1.0, 2.67, 3.0] {
            let found = speeds(1.0, b, 4);
            let expected = (1.0 - 0.5 * b) / (1.0 + 0.5 * b);
            for pair in found[1..].windows(2) {
                // L is a difference of speeds of 1e-5 m/s, rounded.
                assert!((pair[1] - expected * pair[0]).abs() < 1e-14, "{b}");
            }
        }
    }

    /// Stability: at three times m/c, the longest step, a contact comes to rest whatever mass it
    /// moves, and at twice this step some do not.
    #[test]
    fn every_mass_comes_to_rest_at_the_longest_step() {
        let largest = |r: f64, b: f64| {
            let found = speeds(r, b, 2000);
            found[1900..].iter().fold(0.0_f64, |m, v| m.max(v.abs()))
        };
        for k in 1..=114 {
            let r = 0.01 * f64::from(k);
            assert!(largest(r, 3.0) < 1e-12, "{r}");
        }
        assert!((1..=100).any(|k| largest(0.01 * f64::from(k), 6.5) > 1e-3));
    }
}
