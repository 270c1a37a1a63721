//! Gravity and inertial loads of the robot's parts (d'Alembert).

use super::arms::{Arms, Turning};
use robhaz_model::{Carrier, GRAVITY, MassSet, PointMasses, Vec2};

/// Required force and moment of one part: `m (a + g)` at its centre of mass, `I alpha`
/// counter-clockwise.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Load {
    /// N.
    pub force: Vec2,
    /// N m.
    pub torque: f64,
}

/// Accelerations of the linkage.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LinkageMotion {
    /// Acceleration of Q, m/s^2.
    pub q: Vec2,
    /// Rates and angular accelerations of the bars.
    pub turning: Turning,
    /// Spin accelerations of the wheels relative to their links, rad/s^2, forward positive.
    pub spin: [f64; 3],
}

/// The loads of all parts.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Loads {
    /// Bars in the order of [`robhaz_model::Bar::ALL`].
    pub bars: [Load; 4],
    /// Wheels 1 to 3, at their axles.
    pub wheels: [Load; 3],
}

/// Values of body and links in the order of [`robhaz_model::Bar::ALL`].
fn of_bars(body: f64, [link1, link2, link3]: [f64; 3]) -> [f64; 4] {
    [body, link1, link2, link3]
}

impl Loads {
    /// Gravity of Earth alone: static equilibrium, as in the paper.
    pub fn at_rest(masses: &PointMasses) -> Self {
        Self::uniform(masses, Vec2::new(0.0, GRAVITY))
    }

    /// Every mass under the same `acceleration`, m/s^2.
    pub fn uniform(masses: &PointMasses, acceleration: Vec2) -> Self {
        let weight = |mass: f64| Load {
            force: acceleration * mass,
            torque: 0.0,
        };
        Self {
            bars: of_bars(masses.body, masses.links).map(weight),
            wheels: [weight(masses.wheel); 3],
        }
    }

    /// The loads of a robot that is heavier by a `factor` in all its parts.
    pub fn of_heavier(mut self, factor: f64) -> Self {
        for load in self.bars.iter_mut().chain(&mut self.wheels) {
            load.force *= factor;
            load.torque *= factor;
        }
        self
    }

    /// Gravity, m/s^2, and inertia (d'Alembert).
    ///
    /// The rotor is an armature between link and wheel: its torque is internal to both and does not
    /// appear.
    pub fn moving(
        mass: &MassSet,
        masses: &PointMasses,
        arms: &Arms,
        carriers: &[Carrier; 3],
        motion: &LinkageMotion,
        gravity: f64,
    ) -> Self {
        let LinkageMotion { q, turning, spin } = motion;
        let (centres, axles) = arms.accelerations(carriers, *q, turning);
        let up = Vec2::new(0.0, gravity);
        let points = of_bars(masses.body, masses.links);
        let inertias = of_bars(mass.body_inertia, mass.link_inertias);
        let bar = |i: usize| Load {
            force: (centres[i] + up) * points[i],
            torque: inertias[i] * turning.accelerations[i],
        };
        let wheel = |i: usize| Load {
            force: (axles[i] + up) * masses.wheel,
            torque: mass.wheel_inertia
                * (turning.accelerations[carriers[i].bar() as usize] - spin[i]),
        };
        Self {
            bars: [bar(0), bar(1), bar(2), bar(3)],
            wheels: [wheel(0), wheel(1), wheel(2)],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{angles, arms, equations, geometry, slopes};
    use proptest::prelude::*;
    use robhaz_model::{Bar, Geometry, Posture, cross};

    proptest! {
        /// Equivalence: a robot that accelerates uniformly is one at rest in a gravity that is
        /// turned and stronger.
        #[test]
        fn uniform_acceleration_is_turned_gravity(theta in angles(), slopes in slopes(), ax in -5.0_f64..5.0, ay in -5.0_f64..5.0) {
            let (geometry, mass) = (Geometry::a(), MassSet::caption());
            let masses = mass.true_points();
            let uniform = LinkageMotion { q: Vec2::new(ax, ay), ..LinkageMotion::default() };
            let arms1 = arms(&geometry, theta);
            let accelerated = Loads::moving(&mass, &masses, &arms1, &geometry.carriers, &uniform, GRAVITY);
            // In the turned frame "up" is the direction of a + g.
            let specific = Vec2::new(ax, ay + GRAVITY);
            let turn = libm::atan2(specific.x, specific.y);
            let arms2 = arms(&geometry, theta.map(|angle| angle + turn));
            let at_rest = Loads::at_rest(&masses);
            let normal = |arms: &Arms, loads: &Loads, slopes: [f64; 3]| {
                let e = equations(&geometry, arms, loads, &slopes, 0.2);
                e.least_squares().map(|inverse| inverse.solve(&e.f))
            };
            let found = normal(&arms1, &accelerated, slopes).expect("regular");
            let expected = normal(&arms2, &at_rest, slopes.map(|angle| angle + turn));
            // The two force rows turn as a pair, which least squares does not see.
            let expected = expected.expect("regular").map(|n| n * specific.norm() / GRAVITY);
            for i in 0..3 {
                prop_assert!((found[i] - expected[i]).abs() < 1e-9, "{found:?} {expected:?}");
            }
        }

        /// Newton and Euler for the whole robot: the force rows hold the change of its momentum,
        /// the sum of the moment rows that of its angular momentum about Q; pins cancel. Momenta by
        /// central differences of positions along a path (h = 1e-4: rounding over h^2 gives 1e-7 of
        /// a moment).
        #[test]
        fn inertial_loads_are_the_change_of_momentum(
            theta in angles(), w in prop::array::uniform2(-1.0_f64..1.0), a in prop::array::uniform2(-3.0_f64..3.0),
            q in prop::array::uniform2(-3.0_f64..3.0), spin in prop::array::uniform3(-9.0_f64..9.0), is_b in any::<bool>(),
        ) {
            let (geometry, mass) = (geometry(is_b), MassSet::caption());
            let masses = mass.true_points();
            let q = Vec2::new(q[0], q[1]);
            let now = arms(&geometry, theta);
            let turning = now.turning(w, a);
            let loads = Loads::moving(&mass, &masses, &now, &geometry.carriers, &LinkageMotion { q, turning, spin }, GRAVITY);
            let e = equations(&geometry, &now, &loads, &[0.0; 3], 1.0);

            let h = 1e-4;
            let path = |t: f64| {
                let theta = [0, 1].map(|i| theta[i] + w[i] * t + 0.5 * a[i] * t * t);
                let posture = Posture::close(&geometry, theta[0], theta[1]).expect("inside the stops");
                (posture, q * (0.5 * t * t))
            };
            let [before, at, after] = [-h, 0.0, h].map(path);
            let second = |x: f64, y: f64, z: f64| (z - 2.0 * y + x) / (h * h);
            let (mut force, mut moment) = (Vec2::zeros(), 0.0);
            let mut add = |of: &dyn Fn(&Posture) -> Vec2, kg: f64, inertia: f64, angle: &dyn Fn(&Posture) -> f64| {
                let place = |(posture, q): &(Posture, Vec2)| of(posture) + q;
                let (p0, p1, p2) = (place(&before), place(&at), place(&after));
                let specific = (p2 - p1 * 2.0 + p0) / (h * h) + Vec2::new(0.0, GRAVITY);
                force += specific * kg;
                moment += kg * cross(p1, specific) + inertia * second(angle(&before.0), angle(&at.0), angle(&after.0));
            };
            for bar in Bar::ALL {
                let (kg, inertia) = mass.of(bar);
                add(&|p| p.cg_from_q(&geometry, bar), kg, inertia, &|p| p.angle(bar));
            }
            for i in 0..3 {
                let carrier = geometry.carriers[i].bar();
                add(&|p| p.axle_from_q(&geometry, i), mass.wheel, mass.wheel_inertia, &|p| p.angle(carrier));
            }
            moment -= mass.wheel_inertia * spin.iter().sum::<f64>();
            prop_assert!((Vec2::new(e.f.x, e.f.y) - force).norm() < 1e-4, "{} {force}", e.f);
            prop_assert!((e.f.z + e.f.w - moment).abs() < 1e-4, "{} {moment}", e.f);
        }
    }

    /// Newton: a freely falling robot has neither contact nor pin forces.
    #[test]
    fn free_fall_has_no_forces() {
        let (geometry, mass) = (Geometry::a(), MassSet::caption());
        let now = arms(&geometry, [0.1, -0.2]);
        let loads = Loads::moving(
            &mass,
            &mass.true_points(),
            &now,
            &geometry.carriers,
            &LinkageMotion {
                q: Vec2::new(0.0, -GRAVITY),
                ..LinkageMotion::default()
            },
            GRAVITY,
        );
        assert_eq!(loads, Loads::default());
        let e = equations(&geometry, &now, &loads, &[0.1, 0.0, -0.1], 0.2);
        let normal = e.least_squares().expect("regular").solve(&e.f);
        assert!(normal.iter().all(|n| n.abs() <= 0.0), "{normal:?}");
        assert_eq!(e.pins, [Vec2::zeros(); 3]);
    }
}
