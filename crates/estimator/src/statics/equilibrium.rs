//! Eq. (8) written directly, `H x' = F'`: the four equations that the paper derives from eq. (1),
//! at a tenth of the cost, for any loads, with their redundancy as a parity residual. The
//! derivation is in `tests/full_system`.

use super::arms::Arms;
use super::loads::Loads;
use nalgebra::{Matrix3, Vector3, Vector4};
use robhaz_model::{Bar, Carrier, Geometry, Vec2, cross, perp};

/// Eq. (8). Rows: horizontal and vertical force on links 1 and 2 together, N; moments of link 1 and
/// of link 2 about Q over the lever, N. A lever of 1 m gives the paper's rows in N m.
#[derive(Clone, Copy, Debug)]
pub struct Equilibrium {
    /// Columns of H for T1 to T3.
    pub h_t: [Vector4<f64>; 3],
    /// Columns of H for N1 to N3.
    pub h_n: [Vector4<f64>; 3],
    /// F'.
    pub f: Vector4<f64>,
    /// Forces in P (on the body from link 1), R (on link 3 from link 2) and S (on the body from
    /// link 3), N: eq. (6).
    pub pins: [Vec2; 3],
    /// Direction of the tangent of each contact.
    pub tangents: [Vec2; 3],
    /// Contact points relative to Q, m.
    pub contacts: [Vec2; 3],
    inverse_lever: f64,
}

impl Equilibrium {
    /// Sine of the angle PSR below which P, R and S count as on one line: rounding leaves less, and
    /// no robot has less.
    /// Guard.
    const STRAIGHT: f64 = 1e-9;

    /// The equations in a posture, for contact angles in rad and a lever in m. The arm from axle to
    /// contact is the wheel radius, m; the penetration, 0.6 % of it, is neglected.
    ///
    /// `None` where P lies on the line RS.
    #[inline(always)]
    pub fn new(
        arms: &Arms,
        carriers: &[Carrier; 3],
        wheel_radius: f64,
        loads: &Loads,
        contact_angle: &[f64; 3],
        lever: f64,
    ) -> Option<Self> {
        let (c, d) = (arms.s - arms.p, arms.s - arms.r);
        let (area, sides) = (cross(c, d), c.norm_squared() * d.norm_squared());
        let (f, pins) = Self::load_side(arms, carriers, loads, lever);
        let straight = !(area * area > Self::STRAIGHT * Self::STRAIGHT * sides);
        if straight || !(pins[2].x.is_finite() && pins[2].y.is_finite()) {
            return None;
        }
        let inverse_lever = 1.0 / lever;
        let tangents = contact_angle.map(|angle| {
            let (sin, cos) = libm::sincos(angle);
            Vec2::new(cos, sin)
        });
        let contacts = [0, 1, 2].map(|i| arms.axles[i] - perp(tangents[i]) * wheel_radius);
        let column = |i: usize, force: Vec2| {
            let moment = cross(contacts[i], force) * inverse_lever;
            column(force, moment, carriers[i])
        };
        Some(Self {
            h_t: [0, 1, 2].map(|i| column(i, tangents[i])),
            h_n: [0, 1, 2].map(|i| column(i, perp(tangents[i]))),
            f,
            pins,
            tangents,
            contacts,
            inverse_lever,
        })
    }

    /// With each N acting `ahead` (m) of its contact along the tangent, by rolling resistance.
    pub fn rolling(mut self, ahead: &[f64; 3], carriers: &[Carrier; 3]) -> Self {
        for i in 0..3 {
            self.h_n[i] += self.by_shift(ahead[i], carriers[i]);
        }
        self
    }

    /// What moving a normal force of 1 N of a wheel of this link by `ahead` (m) along its tangent adds to
    /// H x'.
    pub fn by_shift(&self, ahead: f64, carrier: Carrier) -> Vector4<f64> {
        column(Vec2::zeros(), ahead * self.inverse_lever, carrier)
    }

    /// F' and the forces in P, R and S, N, for given loads: linear in the loads. Not finite where P
    /// lies on the line RS.
    ///
    /// Body and link 3 come first, eq. (6): S is the only unknown in their moments about P and R.
    pub fn load_side(
        arms: &Arms,
        carriers: &[Carrier; 3],
        loads: &Loads,
        lever: f64,
    ) -> (Vector4<f64>, [Vec2; 3]) {
        let [body, link1, link2, link3] = loads.bars;
        let [body_centre, link1_centre, link2_centre, link3_centre] = arms.centres;
        let (c, d) = (arms.s - arms.p, arms.s - arms.r);
        let on_body = cross(body_centre - arms.p, body.force) + body.torque;
        let on_link3 = cross(link3_centre - arms.r, link3.force) + link3.torque;
        // c x S = on_body, d x S = -on_link3.
        let s = (d * on_body + c * on_link3) / cross(c, d);
        let (p, r) = (body.force - s, link3.force + s);

        let inverse_lever = 1.0 / lever;
        let force = link1.force + link2.force + p + r;
        let mut f = Vector4::new(
            force.x,
            force.y,
            (cross(link1_centre, link1.force) + link1.torque + cross(arms.p, p)) * inverse_lever,
            (cross(link2_centre, link2.force) + link2.torque + cross(arms.r, r)) * inverse_lever,
        );
        for i in 0..3 {
            let load = &loads.wheels[i];
            let moment = (cross(arms.axles[i], load.force) + load.torque) * inverse_lever;
            f.x += load.force.x;
            f.y += load.force.y;
            f[2 + carriers[i].index()] += moment;
        }
        (f, [p, r, s])
    }

    /// Right-hand side `y = F' - H_T T` of `H_N N = y`, N, for tractions in N.
    pub fn right_side(&self, traction: &[f64; 3]) -> Vector4<f64> {
        self.f - self.h_t[0] * traction[0] - self.h_t[1] * traction[1] - self.h_t[2] * traction[2]
    }

    /// Derivative of `H x'` by the contact angle of wheel `i` with the forces `[N, T]` (N), N/rad:
    /// the forces turn and the contact moves along the rim.
    pub fn by_contact_angle(
        &self,
        i: usize,
        geometry: &Geometry,
        [n, t]: [f64; 2],
    ) -> Vector4<f64> {
        let tangent = self.tangents[i];
        let turned = perp(tangent) * t - tangent * n;
        let moment = cross(self.contacts[i], turned) + geometry.wheel_radius * n;
        column(turned, moment * self.inverse_lever, geometry.carriers[i])
    }

    /// Least squares for the normal forces, N: `(H_N' H_N)^-1 H_N' y`. The condition number of H_N
    /// is 6 to 9, so the normal equations lose two digits of sixteen. `None` where the contacts
    /// leave a normal force undetermined.
    #[inline(always)]
    pub fn least_squares(&self) -> Option<LeastSquaresInverse> {
        let [a, b, c] = &self.h_n;
        let (ab, ac, bc) = (a.dot(b), a.dot(c), b.dot(c));
        let x = Vector3::new(a.dot(a), ab, ac);
        let y = Vector3::new(ab, b.dot(b), bc);
        let z = Vector3::new(ac, bc, c.dot(c));
        let det = Matrix3::from_columns(&[x, y, z]).determinant();
        // Written so that a NaN fails too.
        if !(det > 1e-12 * (x.x * y.y * z.z)) {
            return None;
        }
        let inverse = 1.0 / det;
        // A row of the adjugate gives a row of the inverse.
        let row = |of: Vector3<f64>| (a * of.x + b * of.y + c * of.z) * inverse;
        Some(LeastSquaresInverse {
            rows: [row(y.cross(&z)), row(z.cross(&x)), row(x.cross(&y))],
        })
    }

    /// Parity direction: the unit vector `w` with `w' H_N = 0`. It combines the rows so that no
    /// normal force is left.
    ///
    /// `w' (F' - H_T T)` is the parity residual, N: zero for exact loads, tractions and contact
    /// angles.
    #[inline(always)]
    pub fn parity_direction(&self) -> Option<Vector4<f64>> {
        let [a, b, c] = &self.h_n;
        let minor = |i: usize, j: usize, k: usize| {
            a[i] * (b[j] * c[k] - b[k] * c[j]) - b[i] * (a[j] * c[k] - a[k] * c[j])
                + c[i] * (a[j] * b[k] - a[k] * b[j])
        };
        let w = Vector4::new(
            minor(1, 2, 3),
            -minor(0, 2, 3),
            minor(0, 1, 3),
            -minor(0, 1, 2),
        );
        let norm = robhaz_model::sqrt(w.norm_squared());
        if !(norm > 0.0) {
            return None;
        }
        // The horizontal row positive, so that the sign does not depend on the order of the wheels.
        Some(w * (libm::copysign(1.0, w.x) / norm))
    }

    /// Force in Q on link 1 from link 2, N, from the force balance of link 1.
    pub fn force_in_q(
        &self,
        loads: &Loads,
        carriers: &[Carrier; 3],
        normal_force: &[f64; 3],
        traction: &[f64; 3],
    ) -> Vec2 {
        let mut q = loads.bars[Bar::Link1 as usize].force + self.pins[0];
        for i in 0..3 {
            if carriers[i] == Carrier::Link1 {
                let t = self.tangents[i];
                q += loads.wheels[i].force - t * traction[i];
                q -= perp(t) * normal_force[i];
            }
        }
        q
    }
}

/// Column of H for a unit force on a link with its moment over the lever.
fn column(force: Vec2, moment: f64, carrier: Carrier) -> Vector4<f64> {
    match carrier {
        Carrier::Link1 => Vector4::new(force.x, force.y, moment, 0.0),
        Carrier::Link2 => Vector4::new(force.x, force.y, 0.0, moment),
    }
}

/// The least-squares left inverse of `H_N`, 3x4.
#[derive(Clone, Copy, Debug)]
pub struct LeastSquaresInverse {
    /// Its rows.
    pub rows: [Vector4<f64>; 3],
}

impl LeastSquaresInverse {
    /// Normal forces, N, for a right-hand side `F' - H_T T`, N.
    pub fn solve(&self, right: &Vector4<f64>) -> [f64; 3] {
        [0, 1, 2].map(|i| self.rows[i].dot(right))
    }
}

/// Eq. (8) at one instant, with its least-squares inverse and its redundancy.
pub(crate) struct Equations {
    /// Positions on the linkage.
    pub arms: Arms,
    /// Angles of links 1 and 2, rad.
    pub link_angles: [f64; 2],
    /// Gravity, and inertial loads where they are known.
    pub loads: Loads,
    /// H and F'.
    pub equilibrium: Equilibrium,
    /// Left inverse of H_N.
    pub inverse: LeastSquaresInverse,
    /// Unit vector `w` with `w' H_N = 0`; `None` where the contacts leave it undefined.
    pub parity_direction: Option<Vector4<f64>>,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{angles, arms, equations, geometry, slopes};
    use proptest::prelude::*;
    use robhaz_model::{Geometry, MassSet};

    proptest! {
        /// `H x'` changes with a contact angle as central differences do: at h = 1e-6 these err by
        /// 1e-9 of the forces.
        #[test]
        fn by_contact_angle_is_the_derivative(
            theta in angles(), slopes in slopes(), i in 0..3_usize, n in 0.0_f64..100.0, t in -30.0_f64..30.0, is_b in any::<bool>(),
        ) {
            let geometry = geometry(is_b);
            let arms = arms(&geometry, theta);
            let loads = Loads::default();
            let at = |change: f64| {
                let mut slopes = slopes;
                slopes[i] += change;
                let e = equations(&geometry, &arms, &loads, &slopes, 0.2);
                e.h_t[i] * t + e.h_n[i] * n
            };
            let h = 1e-6;
            let difference = (at(h) - at(-h)) / (2.0 * h);
            let found = equations(&geometry, &arms, &loads, &slopes, 0.2)
                .by_contact_angle(i, &geometry, [n, t]);
            prop_assert!((found - difference).norm() < 1e-6, "{found} {difference}");
        }

        /// The parity direction is a unit vector, normal to H_N, and the residual of least squares
        /// is the projection of the right-hand side on it: `y - H_N N = w (w' y)`.
        #[test]
        fn parity_is_the_residual_of_least_squares(
            theta in angles(), slopes in slopes(), y in prop::array::uniform4(-100.0_f64..100.0), is_b in any::<bool>(),
        ) {
            let geometry = geometry(is_b);
            let e = equations(&geometry, &arms(&geometry, theta), &Loads::default(), &slopes, 0.2);
            let w = e.parity_direction().expect("H_N has rank 3");
            prop_assert!((w.norm() - 1.0).abs() < 1e-12 && w.x >= 0.0);
            let y = Vector4::from(y);
            let normal = e.least_squares().expect("regular").solve(&y);
            let mut left = y;
            for i in 0..3 {
                prop_assert!(w.dot(&e.h_n[i]).abs() < 1e-12);
                left -= e.h_n[i] * normal[i];
            }
            prop_assert!((left - w * w.dot(&y)).norm() < 1e-9, "{left}");
        }
    }

    #[test]
    fn a_straight_line_through_p_r_s_is_refused() {
        let mut now = arms(&Geometry::a(), [0.0; 2]);
        now.p = now.s + (now.s - now.r) * 0.5;
        let loads = Loads::at_rest(&MassSet::caption().true_points());
        let carriers = Geometry::a().carriers;
        assert!(Equilibrium::new(&now, &carriers, 0.1, &loads, &[0.0; 3], 1.0).is_none());
    }
}
