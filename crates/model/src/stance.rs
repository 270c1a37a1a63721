//! The robot on level ground in its nominal pose: clearances, static wheel loads, and reasons why
//! it cannot stand.

use crate::{Bar, Geometry, Pin, Robot, Vec2, cross};
use nalgebra::{Matrix3, Vector3};

/// Names of the wheels, for messages.
const WHEELS: [&str; 3] = ["front", "middle", "rear"];

/// Reason why a robot cannot stand on level ground in its nominal pose.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum StanceError {
    /// A wheel and the next one overlap.
    #[error(
        "the {} and the {} wheel overlap: their axles are {distance:.4} m apart; allowed: at least twice the wheel radius, {:.4} m",
        WHEELS[*wheel],
        WHEELS[wheel + 1],
        2.0 * radius
    )]
    WheelsOverlap {
        /// Index of the front one of the two, 0 or 1.
        wheel: usize,
        /// Distance of the two axles, m.
        distance: f64,
        /// Radius of the wheels, m.
        radius: f64,
    },
    /// A pin is not above the ground.
    #[error(
        "pin {pin:?} is not above the ground: its y is {height} m; allowed: above 0, where the wheels stand"
    )]
    PinBelowGround {
        /// The pin.
        pin: Pin,
        /// Its height above the ground, m.
        height: f64,
    },
    /// A bar's centre of mass is not above the ground.
    #[error(
        "the centre of mass of {} is not above the ground: its y is {height} m; allowed: above 0, where the wheels stand",
        bar.name()
    )]
    CentreBelowGround {
        /// The bar.
        bar: Bar,
        /// Its height above the ground, m.
        height: f64,
    },
    /// The robot's centre of mass is ahead of the front axle.
    #[error(
        "the robot tips forward: its centre of mass is {:.0} mm ahead of the front wheel (axle at x = {axle} m); allowed: between the axles of the rear and the front wheel",
        (1e3 * by).max(1.0)
    )]
    TipsForward {
        /// Distance in x by which it is ahead, m.
        by: f64,
        /// x of the front axle, m.
        axle: f64,
    },
    /// The robot's centre of mass is behind the rear axle.
    #[error(
        "the robot tips backward: its centre of mass is {:.0} mm behind the rear wheel (axle at x = {axle} m); allowed: between the axles of the rear and the front wheel",
        (1e3 * by).max(1.0)
    )]
    TipsBackward {
        /// Distance in x by which it is behind, m.
        by: f64,
        /// x of the rear axle, m.
        axle: f64,
    },
    /// Equilibrium needs a negative or zero normal force at a wheel: the linkage folds.
    #[error(
        "the linkage folds: on level ground the static normal force of the {} wheel would be {load:.2} N; allowed: above 0 at every wheel",
        WHEELS[*wheel]
    )]
    Folds {
        /// Index of the wheel.
        wheel: usize,
        /// Static normal force that equilibrium needs there, N; at most 0.
        load: f64,
    },
    /// The static loads are not determined: a link's only axle is at the x of pin Q.
    #[error(
        "the static wheel loads are not determined: the only axle of a link is at the x of pin Q; allowed: ahead of it or behind it"
    )]
    Undetermined,
}

impl Geometry {
    /// Checks, in the nominal pose, that wheels do not overlap and that pins and centres of mass
    /// are above the ground y = 0.
    ///
    /// # Errors
    /// The first [`StanceError`] found.
    pub fn check_clearance(&self) -> Result<(), StanceError> {
        for wheel in 0..2 {
            let distance = (self.axles[wheel] - self.axles[wheel + 1]).norm();
            // Wheels that touch do not overlap; the factor allows for rounding.
            if distance < 2.0 * self.wheel_radius * (1.0 - 1e-9) {
                return Err(StanceError::WheelsOverlap {
                    wheel,
                    distance,
                    radius: self.wheel_radius,
                });
            }
        }
        for pin in self.suspension.pins() {
            let (pin, height) = (*pin, self.pins.get(*pin).y);
            if height <= 0.0 {
                return Err(StanceError::PinBelowGround { pin, height });
            }
        }
        for bar in self.suspension.bars() {
            let (bar, height) = (*bar, self.cg(*bar).y);
            if height <= 0.0 {
                return Err(StanceError::CentreBelowGround { bar, height });
            }
        }
        Ok(())
    }
}

impl Robot {
    /// Centre of mass of the whole robot in the nominal pose, m.
    pub fn centre_of_mass(&self) -> Vec2 {
        let bars = Bar::ALL.map(|bar| self.geometry.cg(bar) * self.mass.of(bar).0);
        let of_bars: Vec2 = bars.iter().sum();
        let of_wheels: Vec2 = self.geometry.axles.iter().sum::<Vec2>() * self.mass.wheel;
        (of_bars + of_wheels) / self.mass.total()
    }

    /// Normal forces of the wheels at rest on level ground in the nominal pose, without traction,
    /// N. They can be negative. `None` if they are not determined.
    ///
    /// By virtual work: one equation for raising the robot, and one each for turning link 1 and
    /// link 2 about Q while body and link 3 follow.
    pub fn static_loads(&self) -> Option<[f64; 3]> {
        let (geometry, mass) = (&self.geometry, &self.mass);
        let pins = &geometry.pins;
        let (p, r, s) = (pins.p - pins.q, pins.r - pins.q, pins.s - pins.q);
        // Rates of body and link 3 per rate of links 1 and 2, from the closed loop.
        let (c, d) = (s - p, s - r);
        let det = -cross(c, d);
        let body = [cross(p, d) / det, -cross(r, d) / det];
        let link3 = [-cross(c, p) / det, cross(c, r) / det];
        // Vertical velocities per unit rate of each link.
        let arm = |at: Vec2| at.x - pins.q.x;
        let mut matrix = Matrix3::from_element(1.0);
        let mut right = Vector3::new(mass.total(), 0.0, 0.0);
        for link in 0..2 {
            let own = if link == 0 { Bar::Link1 } else { Bar::Link2 };
            let (pin_p, pin_r) = if link == 0 { (p.x, 0.0) } else { (0.0, r.x) };
            let of_body = pin_p + body[link] * (geometry.body_cg.x - pins.p.x);
            let of_link3 = pin_r + link3[link] * (geometry.link_cg[2].x - pins.r.x);
            let rises = [arm(geometry.cg(own)), of_body, of_link3];
            let rises = [own, Bar::Body, Bar::Link3].into_iter().zip(rises);
            right[1 + link] = rises.map(|(bar, rise)| mass.of(bar).0 * rise).sum();
            for (i, axle) in geometry.axles.iter().enumerate() {
                let carries = geometry.carriers[i].index() == link;
                let rise = if carries { arm(*axle) } else { 0.0 };
                matrix[(1 + link, i)] = rise;
                right[1 + link] += mass.wheel * rise;
            }
        }
        let loads = matrix.lu().solve(&(right * self.gravity))?;
        let finite = loads.iter().all(|n| n.is_finite());
        finite.then_some(loads.into())
    }

    /// Checks that the robot can stand on level ground: its centre of mass is above the wheelbase
    /// and all wheels are loaded.
    ///
    /// # Errors
    /// The first [`StanceError`] found; those of [`Geometry::check_clearance`] come first.
    pub fn check_stance(&self) -> Result<(), StanceError> {
        self.geometry.check_clearance()?;
        let (centre, [front, _, rear]) = (self.centre_of_mass(), self.geometry.axles);
        if centre.x >= front.x {
            let (by, axle) = (centre.x - front.x, front.x);
            return Err(StanceError::TipsForward { by, axle });
        }
        if centre.x <= rear.x {
            let (by, axle) = (rear.x - centre.x, rear.x);
            return Err(StanceError::TipsBackward { by, axle });
        }
        let loads = self.static_loads().ok_or(StanceError::Undetermined)?;
        match loads.iter().enumerate().find(|(_, load)| **load <= 0.0) {
            Some((wheel, load)) => Err(StanceError::Folds { wheel, load: *load }),
            None => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Carrier, GRAVITY};

    fn robot(geometry: Geometry) -> Robot {
        Robot {
            geometry,
            ..Robot::default_a()
        }
    }

    /// Closed form: the loads are those of the statics by hand for both geometries, to the stated
    /// digits. Their sum is the weight, and their moment that of the centre of mass.
    #[test]
    fn static_loads_are_those_of_the_closed_form() {
        for (geometry, expected) in [
            (Geometry::a(), [43.58, 48.05, 45.71]),
            (Geometry::b(), [46.21, 45.65, 45.48]),
        ] {
            let robot = robot(geometry);
            let Some(loads) = robot.static_loads() else {
                panic!("determined");
            };
            for (load, expected) in loads.iter().zip(expected) {
                assert!((load - expected).abs() < 0.005, "{load} {expected}");
            }
            let weight = robot.mass.total() * GRAVITY;
            assert!((loads.iter().sum::<f64>() - weight).abs() < 1e-10);
            let moment: f64 = loads
                .iter()
                .zip(&robot.geometry.axles)
                .map(|(n, axle)| n * axle.x)
                .sum();
            assert!((moment - weight * robot.centre_of_mass().x).abs() < 1e-10);
            assert_eq!(robot.check_stance(), Ok(()));
        }
    }

    /// Closed form of a rocker-bogie on level ground: the bogie, with the weight W_b of its parts,
    /// balances about Q; what it carries there and the rocker's parts balance about the front
    /// wheel.
    #[test]
    fn static_loads_of_a_rocker_bogie() {
        let mut robot = robot(Geometry::a());
        robot.geometry.make_bogie(Carrier::Link1);
        (robot.mass.links[2], robot.mass.link_inertias[2]) = (0.0, 0.0);
        assert_eq!(
            (robot.geometry.check(), robot.mass.check()),
            (Ok(()), Ok(()))
        );
        let (g, m) = (&robot.geometry, &robot.mass);
        let [x1, x2, x3] = g.axles.map(|axle| axle.x);
        let q = g.pins.q.x;
        let rocker = [
            (m.body, g.body_cg.x),
            (m.links[0], g.link_cg[0].x),
            (m.wheel, x1),
        ];
        let bogie = [(m.links[1], g.link_cg[1].x), (m.wheel, x2), (m.wheel, x3)];
        let weight = |parts: &[(f64, f64)]| GRAVITY * parts.iter().map(|(m, _)| m).sum::<f64>();
        let moment = |parts: &[(f64, f64)], x: f64| {
            GRAVITY * parts.iter().map(|(m, at)| m * (at - x)).sum::<f64>()
        };
        // Moments of the rocker about the front axle: the force in Q, then N1.
        let in_q = moment(&rocker, x1) / (q - x1);
        let n1 = weight(&rocker) - in_q;
        // Moments of the bogie about the rear axle: N2.
        let n2 = (moment(&bogie, x3) + in_q * (q - x3)) / (x2 - x3);
        let n3 = weight(&bogie) + in_q - n2;
        let found = robot.static_loads().expect("determined");
        for (found, expected) in found.into_iter().zip([n1, n2, n3]) {
            assert!((found - expected).abs() < 1e-9, "{found} {expected}");
        }
    }

    /// Boundary: each reason is found just beyond its limit, with the right values, and not just
    /// before it.
    #[test]
    fn each_reason_is_found_at_its_limit() {
        let mut g = Geometry::a();
        g.wheel_radius = 0.15;
        assert_eq!(g.check_clearance(), Ok(()));
        g.wheel_radius = 0.1501;
        assert!(matches!(
            g.check_clearance(),
            Err(StanceError::WheelsOverlap { wheel: 0, .. })
        ));
        let mut g = Geometry::a();
        g.pins.q.y = 1e-6;
        assert_eq!(g.check_clearance(), Ok(()));
        g.pins.q.y = -0.02;
        let found = StanceError::PinBelowGround {
            pin: Pin::Q,
            height: -0.02,
        };
        assert_eq!(g.check_clearance(), Err(found));

        // The body has 5 of 14 kg: the robot's centre of mass moves by 5/14 of the body's.
        for (side, axle) in [(1.0, 0.3), (-1.0, -0.3)] {
            for (beyond, tips) in [(0.04, true), (-0.001, false)] {
                let mut robot = robot(Geometry::a());
                let way = side * (0.3 + beyond) - robot.centre_of_mass().x;
                robot.geometry.body_cg.x += way * 14.0 / 5.0;
                let found = robot.check_stance();
                let by = match found {
                    Err(StanceError::TipsForward { by, axle: at }) if side > 0.0 => {
                        assert!((at - axle).abs() < 1e-15);
                        Some(by)
                    }
                    Err(StanceError::TipsBackward { by, axle: at }) if side < 0.0 => {
                        assert!((at - axle).abs() < 1e-15);
                        Some(by)
                    }
                    // Just inside the wheelbase, a wheel at the other end would need a negative
                    // load.
                    Err(StanceError::Folds { load, .. }) if !tips => {
                        assert!(load <= 0.0);
                        None
                    }
                    other => panic!("{other:?}"),
                };
                assert_eq!(by.is_some(), tips);
                assert!(by.is_none_or(|by| (by - 0.04).abs() < 1e-12));
            }
        }
        // The wheel below Q has no moment arm, so its load is not determined.
        let mut g = Geometry::a();
        g.pins.q.x = g.axles[0].x;
        assert!(robot(g).check_stance().is_err());
    }
}
