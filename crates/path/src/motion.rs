//! Equations of motion of the robot along the path, at one place.
//!
//! While all wheels touch the ground the robot has one degree of freedom: its place sigma on the
//! path, with the mean speed sigma' of the wheels' centres. With the tangent u = d(Q, theta_1,
//! theta_2)/d sigma, eq. (8) with inertial loads is
//!
//! ```text
//! sum over contacts of (N_k n_k + T_k t_k) + M e = F' + sigma'' F_a + sigma'^2 F_c
//! ```
//!
//! F_a are the loads of the accelerations u, F_c those of du/d sigma and of the rates u at constant
//! speed. M is the torque of an end stop, e its column: a spring, so M is known from the posture,
//! until a wheel would be pulled to the ground. Then that wheel lifts, and M is what the others
//! need. The posture is still taken as that of three wheels on the ground, which is exact where the
//! wheel lifts by little. The spin of the wheels is left out: a disc has 8 % of the inertia of its
//! mass.

use crate::balance::{GroundContact, add_equations, by_wheel, columns_of};
use crate::mechanism::{OnGround, Tangent};
use crate::setup::Tractions;
use microlp::{ComparisonOp, OptimizationDirection, Problem};
use nalgebra::{Matrix4, Vector4};
use robhaz_estimator::statics::{Arms, Equilibrium, LinkageMotion, Loads};
use robhaz_model::{Geometry, Robot, Vec2};

/// Forces at given ratios T/N, and the acceleration that they give.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Forced {
    /// sigma'', m/s^2.
    pub acceleration: f64,
    /// N of each wheel, N.
    pub normal_force: [f64; 3],
    /// T of each wheel, N.
    pub traction: [f64; 3],
}

/// The equations at one place.
#[derive(Clone, Debug)]
pub struct Motion {
    /// The contacts.
    pub contacts: Vec<GroundContact>,
    /// Columns of N and T of each contact.
    columns: Vec<[Vector4<f64>; 2]>,
    /// F', N.
    gravity: Vector4<f64>,
    /// F_a, kg.
    inertia: Vector4<f64>,
    /// F_c, kg/m.
    centripetal: Vector4<f64>,
    /// e, 1/m, and M, N m.
    stop: (Vector4<f64>, f64),
    /// Speed of each wheel's centre, and rate of the link that carries it times the wheel radius,
    /// for sigma' = 1 m/s, -.
    pub rates: [(f64, f64); 3],
}

impl Motion {
    /// The equations for a robot on its contacts, with the direction of its path and the derivative
    /// of that by sigma. `None` where the four-bar cannot close.
    pub fn new(
        robot: &Robot,
        on_ground: &OnGround,
        [tangent, turn]: [&Tangent; 2],
        contacts: &[GroundContact],
    ) -> Option<Self> {
        let (geometry, angles) = (&robot.geometry, on_ground.angles);
        let arms = Arms::new(geometry, angles[0], angles[1]).ok()?;
        let masses = robot.mass.true_points();
        let link = |i: usize| geometry.carriers[i].index();
        let load = |rates: [f64; 2], q: Vec2, accelerations: [f64; 2]| {
            let motion = LinkageMotion {
                q,
                turning: arms.turning(rates, accelerations),
                // So that the absolute spin, which is left out, is constant.
                spin: [0, 1, 2].map(|i| accelerations[link(i)]),
            };
            let (mass, carriers) = (&robot.mass, &geometry.carriers);
            let loads = Loads::moving(mass, &masses, &arms, carriers, &motion, robot.gravity);
            Equilibrium::load_side(&arms, &geometry.carriers, &loads, geometry.wheel_radius).0
        };
        let gravity = load([0.0; 2], Vec2::zeros(), [0.0; 2]);
        let found = Self {
            columns: columns_of(geometry, on_ground.q, contacts),
            contacts: contacts.to_vec(),
            inertia: load([0.0; 2], tangent.q, tangent.angles) - gravity,
            centripetal: load(tangent.angles, turn.q, turn.angles) - gravity,
            stop: end_stop(geometry, on_ground.opening()),
            rates: [0, 1, 2].map(|i| {
                let rate = tangent.angles[link(i)] * geometry.wheel_radius;
                (tangent.centres[i], rate)
            }),
            gravity,
        };
        found.gravity.iter().all(|f| f.is_finite()).then_some(found)
    }

    /// Forces at rest with the ratio T/N of each wheel as given, and T within limits.
    pub fn at_rest(&self, ratios: [f64; 3], limits: &Tractions) -> Option<Forced> {
        self.forced(ratios, &self.gravity, limits)
    }

    /// Acceleration without tractions, m/s^2, at the speed sigma' (m/s).
    pub fn coasting(&self, speed: f64) -> Option<f64> {
        let right = self.gravity + self.centripetal * (speed * speed);
        let forced = self.forced([0.0; 3], &right, &Tractions::FREE)?;
        Some(forced.acceleration)
    }

    /// The largest acceleration (`sign` 1) or deceleration (-1), m/s^2, at the speed sigma' (m/s):
    /// every wheel slides, or is at the torque limit. `mu` is the friction at a
    /// contact with a given mean. `None` where no N >= 0 balance the robot.
    pub fn thrust(
        &self,
        sign: f64,
        mu: &dyn Fn(f64) -> f64,
        speed: f64,
        limits: &Tractions,
    ) -> Option<f64> {
        let right = self.gravity + self.centripetal * (speed * speed);
        self.pushed(sign, mu, &right, limits)
    }

    /// sigma' behind an impact, m/s, by which a wheel changes to its contact at this place.
    /// `before` are the equations just before it, at the speed `speed` (m/s). All wheels slide
    /// during the impact, and none rebounds.
    pub fn after_impact(&self, before: &Self, speed: f64, mu: &dyn Fn(f64) -> f64) -> f64 {
        // Momentum in place of force: impulses of the contacts, F_a times sigma' on both sides.
        let right = before.inertia * -speed;
        let free = Self {
            stop: (Vector4::zeros(), 0.0),
            ..self.clone()
        };
        let found = free.pushed(1.0, mu, &right, &Tractions::FREE);
        found.map_or(0.0, |after| after.max(0.0).min(speed))
    }

    /// Four equations for three N and the acceleration, at given T/N. `None` with more than three
    /// contacts, or where a wheel would be pulled down.
    fn forced(&self, ratios: [f64; 3], right: &Vector4<f64>, limits: &Tractions) -> Option<Forced> {
        let columns: &[[Vector4<f64>; 2]; 3] = self.columns.as_slice().try_into().ok()?;
        let (stop, torque) = self.stop;
        let mut limited = [None; 3];
        let mut lifted = None;
        // Each pass finds one more wheel at a limit.
        for _ in 0..5 {
            let mut matrix = Matrix4::zeros();
            let mut right = *right;
            if lifted.is_none() {
                right -= stop * torque;
            }
            for (k, [normal, tangent]) in columns.iter().enumerate() {
                let column = match (lifted == Some(k), limited[k]) {
                    (true, _) => stop,
                    (false, Some(traction)) => {
                        right -= tangent * traction;
                        *normal
                    }
                    (false, None) => normal + tangent * ratios[k],
                };
                matrix.set_column(k, &column);
            }
            matrix.set_column(3, &-self.inertia);
            let x = matrix.lu().solve(&right)?;
            if !x.iter().all(|v| v.is_finite()) {
                return None;
            }
            let pulled = (0..3).min_by(|a, b| x[*a].total_cmp(&x[*b]));
            if let Some(k) = pulled.filter(|k| x[*k] < 0.0) {
                if lifted.is_some() || torque <= 0.0 {
                    return None;
                }
                lifted = Some(k);
                continue;
            }
            let normal = [0, 1, 2].map(|k| if lifted == Some(k) { 0.0 } else { x[k] });
            let wanted = [0, 1, 2].map(|k| ratios[k] * normal[k]);
            let allowed = wanted.map(|traction| limits.within(traction));
            let beyond =
                |k: &usize| limited[*k].is_none() && (allowed[*k] - wanted[*k]).abs() > 0.0;
            match (0..3).find(beyond) {
                Some(k) => limited[k] = Some(allowed[k]),
                None => {
                    let traction = [0, 1, 2].map(|k| limited[k].unwrap_or(wanted[k]));
                    return Some(Forced {
                        acceleration: x[3],
                        normal_force: by_wheel(&self.contacts, &normal),
                        traction: by_wheel(&self.contacts, &traction),
                    });
                }
            }
        }
        None
    }

    /// The largest acceleration (`sign` 1) or the least one (-1) with all wheels sliding, otherwise
    /// with the best distribution of tractions, by a linear program.
    fn pushed(
        &self,
        sign: f64,
        mu: &dyn Fn(f64) -> f64,
        right: &Vector4<f64>,
        limits: &Tractions,
    ) -> Option<f64> {
        let ratios = [0, 1, 2].map(|i| {
            let contact = self.contacts.iter().find(|c| c.wheel == i);
            contact.map_or(0.0, |c| sign * mu(c.mu))
        });
        if let Some(forced) = self.forced(ratios, right, limits) {
            return Some(forced.acceleration);
        }
        let mut problem = Problem::new(match sign > 0.0 {
            true => OptimizationDirection::Maximize,
            false => OptimizationDirection::Minimize,
        });
        let along = problem.add_var(1.0, (f64::NEG_INFINITY, f64::INFINITY));
        let mut columns = vec![(along, -self.inertia)];
        for (contact, [normal, tangent]) in self.contacts.iter().zip(&self.columns) {
            let n = problem.add_var(0.0, (0.0, f64::INFINITY));
            let t = problem.add_var(0.0, (-limits.braking, limits.driving));
            for side in [1.0, -1.0] {
                let row = [(t, side), (n, -mu(contact.mu))];
                problem.add_constraint(row, ComparisonOp::Le, 0.0);
            }
            columns.extend([(n, *normal), (t, *tangent)]);
        }
        if self.stop.1 > 0.0 {
            let torque = problem.add_var(0.0, (0.0, self.stop.1));
            columns.push((torque, self.stop.0));
        }
        add_equations(&mut problem, &columns, right);
        let solution = problem.solve().ok()?.into_solution().ok()?;
        Some(solution.var_value(along))
    }
}

/// Column of the torque of an end stop in eq. (8), with moments over the wheel radius, 1/m, and the
/// torque itself, N m, at an angle of pin Q (rad).
fn end_stop(geometry: &Geometry, opening: f64) -> (Vector4<f64>, f64) {
    let stop = &geometry.stop;
    let (above, below) = (opening - stop.upper, stop.lower - opening);
    // At the upper stop link 1 is pressed back, clockwise.
    let sign = if above > 0.0 { -1.0 } else { 1.0 };
    let arm = sign / geometry.wheel_radius;
    let torque = stop.stiffness * above.max(below).max(0.0);
    (Vector4::new(0.0, 0.0, arm, -arm), torque)
}
