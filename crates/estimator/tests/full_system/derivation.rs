//! Static equilibrium of the four bars as the paper derives it: eqs. (1) and (4) to (8), and the
//! least squares for the normal forces.
//!
//! The estimators do not run this code. They use [`robhaz_estimator::statics::Equilibrium`], which
//! gives the same eq. (8) at a tenth of the cost. The tests beside this file hold both against each
//! other, and show how the equations follow from each other.
//!
//! A wheel belongs to the link that carries it. Signs and the order of unknowns:
//!
//! ```text
//! x   = [T1 N1 T2 N2 T3 N3 Qx Qy | Px Py Rx Ry Sx Sy]      x_c | x_u
//! P on the body from link 1, Q on link 1 from link 2, R on link 3 from link 2, S on the body from link 3
//! rows: link 1 and link 2 (x, y, moment about Q) | link 3 (x, y, moment about R), body (x, y, moment about P)
//! ```
//!
//! The paper prints G as 14x12 and F as 14x1; they are 12x14 and 12x1. It prints F_c as 8x1; it is
//! 6x1.

use nalgebra::{SMatrix, SVector};
use robhaz_model::{Bar, GRAVITY, Geometry, Pin, PointMasses, Posture, Vec2, cross};

/// A matrix of eq. (4) is singular: P lies on the line RS, or the contacts leave a normal force
/// undetermined.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Singular {
    /// Which matrix.
    pub matrix: &'static str,
}

/// Eq. (1), `G x = F`: 12 equations, 14 unknowns. Rows in N and N m.
#[derive(Clone, Debug)]
pub struct FullSystem {
    /// G, 12x14.
    pub g: SMatrix<f64, 12, 14>,
    /// F, 12x1: the weights.
    pub f: SVector<f64, 12>,
}

impl FullSystem {
    /// Equilibrium in a posture, with wheels of radius `r` touching the ground at the given contact
    /// angles (rad).
    ///
    /// The arm from axle to contact is the wheel radius; the penetration, 0.6 % of it, is
    /// neglected.
    pub fn new(
        geometry: &Geometry,
        masses: &PointMasses,
        posture: &Posture,
        contact_angle: &[f64; 3],
    ) -> Self {
        let mut g = SMatrix::<f64, 12, 14>::zeros();
        let mut f = SVector::<f64, 12>::zeros();
        let pin = |pin| posture.pin_from_q(geometry, pin);
        let (p, r, s) = (pin(Pin::P), pin(Pin::R), pin(Pin::S));

        for (i, angle) in contact_angle.iter().enumerate() {
            let (sin, cos) = libm::sincos(*angle);
            let (t, n) = (Vec2::new(cos, sin), Vec2::new(-sin, cos));
            let axle = posture.axle_from_q(geometry, i);
            let contact = axle - n * geometry.wheel_radius;
            let row = 3 * geometry.carriers[i].index();
            add_force(&mut g, row, 2 * i, t, contact);
            add_force(&mut g, row, 2 * i + 1, n, contact);
            add_weight(&mut f, row, masses.wheel, axle);
        }
        let (x, y) = (Vec2::x(), Vec2::y());
        // (row of the bar, first column of the pin, sign, arm from the bar's moment point)
        let pins = [
            (0, 6, 1.0, Vec2::zeros()),
            (3, 6, -1.0, Vec2::zeros()),
            (0, 8, -1.0, p),
            (9, 8, 1.0, Vec2::zeros()),
            (3, 10, -1.0, r),
            (6, 10, 1.0, Vec2::zeros()),
            (6, 12, -1.0, s - r),
            (9, 12, 1.0, s - p),
        ];
        for (row, column, sign, arm) in pins {
            add_force(&mut g, row, column, x * sign, arm);
            add_force(&mut g, row, column + 1, y * sign, arm);
        }
        let cg = |bar| posture.cg_from_q(geometry, bar);
        add_weight(&mut f, 0, masses.links[0], cg(Bar::Link1));
        add_weight(&mut f, 3, masses.links[1], cg(Bar::Link2));
        add_weight(&mut f, 6, masses.links[2], cg(Bar::Link3) - r);
        add_weight(&mut f, 9, masses.body, cg(Bar::Body) - p);
        Self { g, f }
    }
}

/// A unit force along `direction` at `arm` from the moment point, in the three rows of a bar from
/// `row`.
fn add_force(g: &mut SMatrix<f64, 12, 14>, row: usize, column: usize, direction: Vec2, arm: Vec2) {
    g[(row, column)] += direction.x;
    g[(row + 1, column)] += direction.y;
    g[(row + 2, column)] += cross(arm, direction);
}

/// Adds the weight of `mass` (kg) at `arm` (m) from the moment point.
fn add_weight(f: &mut SVector<f64, 12>, row: usize, mass: f64, arm: Vec2) {
    f[row + 1] += mass * GRAVITY;
    f[row + 2] += mass * GRAVITY * arm.x;
}

/// Eqs. (4) to (7): `C x_u = F_u` for link 3 and body, `A x_c + B x_u = F_c` for links 1 and 2.
#[derive(Clone, Debug)]
pub struct BlockForm {
    /// A, 6x8.
    pub a: SMatrix<f64, 6, 8>,
    /// B, 6x6.
    pub b: SMatrix<f64, 6, 6>,
    /// C, 6x6.
    pub c: SMatrix<f64, 6, 6>,
    /// F_c, 6x1.
    pub f_c: SVector<f64, 6>,
    /// F_u, 6x1.
    pub f_u: SVector<f64, 6>,
}

impl BlockForm {
    /// Eq. (4): the blocks of G. The block below A is zero, so x_u follows without x_c.
    pub fn new(full: &FullSystem) -> Self {
        Self {
            a: full.g.fixed_view::<6, 8>(0, 0).into_owned(),
            b: full.g.fixed_view::<6, 6>(0, 8).into_owned(),
            c: full.g.fixed_view::<6, 6>(6, 8).into_owned(),
            f_c: full.f.fixed_rows::<6>(0).into_owned(),
            f_u: full.f.fixed_rows::<6>(6).into_owned(),
        }
    }

    /// Eq. (6): the forces in P, R and S, `x_u = [Px Py Rx Ry Sx Sy]`, N.
    ///
    /// # Errors
    /// [`Singular`] where P lies on the line RS.
    pub fn pin_forces(&self) -> Result<SVector<f64, 6>, Singular> {
        self.c.lu().solve(&self.f_u).ok_or(Singular { matrix: "C" })
    }

    /// Eq. (7): the right-hand side of `A x_c = F_c - B x_u`.
    pub fn right_side(&self, x_u: &SVector<f64, 6>) -> SVector<f64, 6> {
        self.f_c - self.b * x_u
    }
}

/// Eq. (8), `H x' = F'` with `x' = [T1 N1 T2 N2 T3 N3]`: 4 equations.
///
/// Rows: horizontal and vertical force on links 1 and 2 together (Q cancels), moment of link 1 and
/// of link 2 about Q. Rows are in N and N m; the paper states neither H nor weights, and the result
/// of least squares depends on that choice.
#[derive(Clone, Debug)]
pub struct ReducedSystem {
    /// H, 4x6.
    pub h: SMatrix<f64, 4, 6>,
    /// F', 4x1.
    pub f: SVector<f64, 4>,
}

/// Least-squares normal forces of eq. (8), and their residual.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LeastSquares {
    /// N of the front, middle and rear wheel, N.
    pub normal_force: [f64; 3],
    /// Residual of eq. (8): horizontal force (N), vertical force (N), moments of link 1 and 2 about
    /// Q (N m).
    pub residual: [f64; 4],
}

impl ReducedSystem {
    /// Eliminates Q from eq. (7) by adding the force rows of links 1 and 2; Q has no moment about
    /// itself.
    pub fn new(block: &BlockForm, x_u: &SVector<f64, 6>) -> Self {
        let right = block.right_side(x_u);
        let mut h = SMatrix::<f64, 4, 6>::zeros();
        let mut f = SVector::<f64, 4>::zeros();
        for (row, parts) in [(0, [0, 3]), (1, [1, 4])] {
            for part in parts {
                for column in 0..6 {
                    h[(row, column)] += block.a[(part, column)];
                }
                f[row] += right[part];
            }
        }
        for (row, part) in [(2, 2), (3, 5)] {
            for column in 0..6 {
                h[(row, column)] = block.a[(part, column)];
            }
            f[row] = right[part];
        }
        Self { h, f }
    }

    /// Least squares for the three N with the three T known (N): 4 equations, 3 unknowns, rows
    /// in N and N m, unscaled.
    ///
    /// # Errors
    /// [`Singular`] where the contacts leave a normal force undetermined.
    pub fn normal_forces(&self, traction: &[f64; 3]) -> Result<LeastSquares, Singular> {
        let mut h_n = SMatrix::<f64, 4, 3>::zeros();
        let mut right = self.f;
        for (i, t) in traction.iter().enumerate() {
            h_n.set_column(i, &self.h.column(2 * i + 1));
            right -= self.h.column(2 * i) * *t;
        }
        let qr = h_n.qr();
        let n = qr
            .r()
            .solve_upper_triangular(&(qr.q().transpose() * right))
            .ok_or(Singular { matrix: "H_N" })?;
        let residual = right - h_n * n;
        Ok(LeastSquares {
            normal_force: n.into(),
            residual: residual.into(),
        })
    }
}
