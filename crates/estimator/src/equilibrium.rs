//! Eq. (8) written directly, `H x' = F'`: the same four equations that [`crate::statics`] derives from eq. (1), at a tenth of
//! the cost, with inertial loads where they are known and with its one redundancy as a parity check.

use crate::arms::{Arms, Turning};
use nalgebra::{Matrix3, Vector4};
use robhaz_model::{Bar, Carrier, GRAVITY, MassSet, PointMasses, Vec2, cross};

/// What gravity and acceleration ask for on one part: `m (a + g)` at its centre of mass and `I alpha`, counter-clockwise.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Load {
    /// N.
    pub force: Vec2,
    /// N m.
    pub torque: f64,
}

/// The loads of all parts.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Loads {
    /// Bars in the order of [`Bar::ALL`].
    pub bars: [Load; 4],
    /// Wheels 1 to 3, at their axles.
    pub wheels: [Load; 3],
}

impl Loads {
    /// Gravity alone: static equilibrium, as in the paper.
    pub fn at_rest(masses: &PointMasses) -> Self {
        Self::uniform(masses, Vec2::new(0.0, GRAVITY))
    }

    /// Every mass held against the same `acceleration`, m/s^2.
    pub fn uniform(masses: &PointMasses, acceleration: Vec2) -> Self {
        let weight = |mass: f64| Load {
            force: acceleration * mass,
            torque: 0.0,
        };
        Self {
            bars: [
                weight(masses.body),
                weight(masses.links[0]),
                weight(masses.links[1]),
                weight(masses.links[2]),
            ],
            wheels: [weight(masses.wheel); 3],
        }
    }

    /// Gravity and inertia (d'Alembert): Q accelerates with `q` (m/s^2), bars turn as in `turning`, wheels spin up
    /// relative to their links with `spin` (rad/s^2, forward positive).
    ///
    /// The rotor is an armature between link and wheel: its torque is inside the sum of both and does not appear.
    pub fn moving(
        mass: &MassSet,
        masses: &PointMasses,
        arms: &Arms,
        carriers: &[Carrier; 3],
        q: Vec2,
        turning: &Turning,
        spin: &[f64; 3],
    ) -> Self {
        let (centres, axles) = arms.accelerations(carriers, q, turning);
        let up = Vec2::new(0.0, GRAVITY);
        let points = [
            masses.body,
            masses.links[0],
            masses.links[1],
            masses.links[2],
        ];
        let inertias = [
            mass.body_inertia,
            mass.link_inertias[0],
            mass.link_inertias[1],
            mass.link_inertias[2],
        ];
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

/// Eq. (8). Rows: horizontal and vertical force on links 1 and 2 together, N; moments of link 1 and of link 2 about Q
/// over the lever, N. A lever of 1 m gives the paper's rows in N m.
#[derive(Clone, Copy, Debug)]
pub struct Equilibrium {
    /// Columns of H for T1 to T3.
    pub h_t: [Vector4<f64>; 3],
    /// Columns of H for N1 to N3.
    pub h_n: [Vector4<f64>; 3],
    /// F'.
    pub f: Vector4<f64>,
    /// Forces in P (on the body from link 1), R (on link 3 from link 2) and S (on the body from link 3), N: eq. (6).
    pub pins: [Vec2; 3],
    /// Direction of the tangent of each contact.
    pub tangents: [Vec2; 3],
    /// Contact points relative to Q, m.
    pub contacts: [Vec2; 3],
    inverse_lever: f64,
}

impl Equilibrium {
    /// The equations in a posture. `contact_angle` in rad; wheels touch at the wheel radius (the penetration is 0.6 % of it).
    ///
    /// Body and link 3 come first, eq. (6): their moments about P and R hold S alone. `None` where P lies on the line RS.
    pub fn new(
        arms: &Arms,
        carriers: &[Carrier; 3],
        wheel_radius: f64,
        loads: &Loads,
        contact_angle: &[f64; 3],
        lever: f64,
    ) -> Option<Self> {
        let (f, pins) = Self::right_of(arms, carriers, loads, lever);
        if !(pins[2].x.is_finite() && pins[2].y.is_finite()) {
            return None;
        }
        let inverse_lever = 1.0 / lever;
        let mut found = Self {
            h_t: [Vector4::zeros(); 3],
            h_n: [Vector4::zeros(); 3],
            f,
            pins,
            tangents: [Vec2::zeros(); 3],
            contacts: [Vec2::zeros(); 3],
            inverse_lever,
        };
        for i in 0..3 {
            let (sin, cos) = libm::sincos(contact_angle[i]);
            let (t, n) = (Vec2::new(cos, sin), Vec2::new(-sin, cos));
            let contact = arms.axles[i] - n * wheel_radius;
            found.h_t[i] = column(t, cross(contact, t) * inverse_lever, carriers[i]);
            found.h_n[i] = column(n, cross(contact, n) * inverse_lever, carriers[i]);
            found.tangents[i] = t;
            found.contacts[i] = contact;
        }
        Some(found)
    }

    /// F' and the forces in P, R and S, N, for given loads: linear in them. Not finite where P lies on the line RS.
    pub fn right_of(
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
            match carriers[i] {
                Carrier::Link1 => f.z += moment,
                Carrier::Link2 => f.w += moment,
            }
        }
        (f, [p, r, s])
    }

    /// `F' - H_T T`: what the normal forces must balance, for tractions in N.
    pub fn right_side(&self, traction: &[f64; 3]) -> Vector4<f64> {
        self.f - self.h_t[0] * traction[0] - self.h_t[1] * traction[1] - self.h_t[2] * traction[2]
    }

    /// Change of `H x'` with the contact angle of wheel `i`, N/rad: the forces turn and the contact moves along the rim.
    pub fn by_contact_angle(
        &self,
        i: usize,
        carrier: Carrier,
        wheel_radius: f64,
        normal_force: f64,
        traction: f64,
    ) -> Vector4<f64> {
        let t = self.tangents[i];
        let n = Vec2::new(-t.y, t.x);
        let turned = n * traction - t * normal_force;
        let moment = cross(self.contacts[i], turned) + wheel_radius * normal_force;
        column(turned, moment * self.inverse_lever, carrier)
    }

    /// Least squares for the normal forces, N: `(H_N' H_N)^-1 H_N' y`. The condition of H_N is 6 to 9, so that the
    /// normal equations lose two digits of sixteen. `None` where the contacts leave a normal force undetermined.
    pub fn least_squares(&self) -> Option<LeastSquaresInverse> {
        let [a, b, c] = &self.h_n;
        let m = Matrix3::new(
            a.dot(a),
            a.dot(b),
            a.dot(c), //
            a.dot(b),
            b.dot(b),
            b.dot(c), //
            a.dot(c),
            b.dot(c),
            c.dot(c),
        );
        let det = m.determinant();
        let scale = m.m11 * m.m22 * m.m33;
        // Written so that a NaN fails too.
        if !(det > 1e-12 * scale) {
            return None;
        }
        let adjugate = Matrix3::new(
            m.m22 * m.m33 - m.m23 * m.m32,
            m.m13 * m.m32 - m.m12 * m.m33,
            m.m12 * m.m23 - m.m13 * m.m22,
            m.m23 * m.m31 - m.m21 * m.m33,
            m.m11 * m.m33 - m.m13 * m.m31,
            m.m13 * m.m21 - m.m11 * m.m23,
            m.m21 * m.m32 - m.m22 * m.m31,
            m.m12 * m.m31 - m.m11 * m.m32,
            m.m11 * m.m22 - m.m12 * m.m21,
        );
        Some(LeastSquaresInverse {
            rows: [0, 1, 2].map(|i| {
                (a * adjugate[(i, 0)] + b * adjugate[(i, 1)] + c * adjugate[(i, 2)]) / det
            }),
        })
    }

    /// The one combination of the rows that holds no normal force: unit vector `w` with `w' H_N = 0`.
    ///
    /// `w' (F' - H_T T)` is the parity residual, N: zero for consistent loads, tractions and contact angles.
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
        let norm = libm::sqrt(w.norm_squared());
        if !(norm > 0.0) {
            return None;
        }
        // The horizontal row positive, so that the sign does not depend on the order of the wheels.
        Some(w * (libm::copysign(1.0, w.x) / norm))
    }

    /// Force in Q on link 1 from link 2, N: what the ground, P and the loads of link 1 leave over.
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
                q -= Vec2::new(-t.y, t.x) * normal_force[i];
            }
        }
        q
    }
}

fn column(force: Vec2, moment: f64, carrier: Carrier) -> Vector4<f64> {
    match carrier {
        Carrier::Link1 => Vector4::new(force.x, force.y, moment, 0.0),
        Carrier::Link2 => Vector4::new(force.x, force.y, 0.0, moment),
    }
}

/// The left inverse of `H_N` that least squares uses, 3x4.
#[derive(Clone, Copy, Debug)]
pub struct LeastSquaresInverse {
    /// Its rows.
    pub rows: [Vector4<f64>; 3],
}

impl LeastSquaresInverse {
    /// Normal forces, N, for a right side `F' - H_T T`.
    pub fn solve(&self, right: &Vector4<f64>) -> [f64; 3] {
        [0, 1, 2].map(|i| self.rows[i].dot(right))
    }
}
