//! The mass matrix of the four rates, and the solution of equations with it.

use nalgebra::{SMatrix, Vector4};
use robhaz_model::Vec2;

/// Mass matrix of the four rates. All masses move with Q, so it has the form
///
/// ```text
/// | m 1   L |   m  mass, 1 the unit matrix
/// | L'    I |   L  levers in two columns, I inertia
/// ```
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct MassMatrix {
    /// Mass m, kg.
    pub mass: f64,
    /// Derivatives of the momentum by the rates of links 1 and 2, kg m.
    pub levers: [Vec2; 2],
    /// Inertia about Q: I_11, I_12, I_22, kg m^2.
    pub inertia: [f64; 3],
}

impl MassMatrix {
    /// Adds a mass (kg) at a point whose velocity has these derivatives by the rates of links 1 and
    /// 2, m.
    pub fn add_mass(&mut self, mass: f64, [j1, j2]: [Vec2; 2]) {
        let (lever1, lever2) = (j1 * mass, j2 * mass);
        self.mass += mass;
        self.levers[0] += lever1;
        self.levers[1] += lever2;
        self.inertia[0] += lever1.dot(&j1);
        self.inertia[1] += lever1.dot(&j2);
        self.inertia[2] += lever2.dot(&j2);
    }

    /// Adds the inertia (kg m^2) of a bar whose rate has these derivatives by the rates of links 1
    /// and 2, -.
    pub fn add_inertia(&mut self, inertia: f64, [k1, k2]: [f64; 2]) {
        self.inertia[0] += inertia * (k1 * k1);
        self.inertia[1] += inertia * (k1 * k2);
        self.inertia[2] += inertia * (k2 * k2);
    }

    /// Eliminates the motion of Q. `None` if the matrix is not positive definite.
    pub fn factorised(&self) -> Option<Factorised> {
        let per_mass = 1.0 / self.mass;
        let arms = self.levers.map(|lever| lever * per_mass);
        let [i11, i12, i22] = self.inertia;
        let s11 = i11 - self.levers[0].dot(&arms[0]);
        let s12 = i12 - self.levers[0].dot(&arms[1]);
        let s22 = i22 - self.levers[1].dot(&arms[1]);
        let determinant = s11 * s22 - s12 * s12;
        if !(self.mass > 0.0 && s11 > 0.0 && determinant > 0.0) {
            return None;
        }
        let per_determinant = 1.0 / determinant;
        Some(Factorised {
            per_mass,
            arms,
            inverse: [s22, -s12, s11].map(|entry| entry * per_determinant),
        })
    }
}

/// A mass matrix, ready for the solution of equations.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Factorised {
    /// 1/kg.
    per_mass: f64,
    /// Levers over the mass, m.
    arms: [Vec2; 2],
    /// Entries 11, 12, 22 of the inverse of the inertia about the centre of all masses, 1/(kg m^2).
    inverse: [f64; 3],
}

impl Factorised {
    /// The accelerations (m/s^2, rad/s^2) under generalised forces (N, N m).
    pub fn solve(&self, right: &Vector4<f64>) -> Vector4<f64> {
        let force = Vec2::new(right[0], right[1]);
        let ([a, b], [i11, i12, i22]) = (self.arms, self.inverse);
        let (m1, m2) = (right[2] - a.dot(&force), right[3] - b.dot(&force));
        let (alpha1, alpha2) = (i11 * m1 + i12 * m2, i12 * m1 + i22 * m2);
        let of_q = force * self.per_mass - a * alpha1 - b * alpha2;
        Vector4::new(of_q.x, of_q.y, alpha1, alpha2)
    }

    /// The same for each column.
    pub fn solve_each<const M: usize>(&self, right: &SMatrix<f64, 4, M>) -> SMatrix<f64, 4, M> {
        let mut solution = *right;
        for mut column in solution.column_iter_mut() {
            let found = self.solve(&column.clone_owned());
            column.copy_from(&found);
        }
        solution
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Matrix4;

    /// Closed form: the solution times the full matrix is the right-hand side, and a matrix without
    /// inertia is refused.
    #[test]
    fn solutions_fulfil_the_equations() {
        let mut matrix = MassMatrix::default();
        assert!(matrix.factorised().is_none());
        for k in 1..6 {
            let k = f64::from(k);
            let column = |phase: f64| Vec2::new((k + phase).sin(), (2.0 * k - phase).cos());
            matrix.add_mass(0.7 * k, [column(0.1), column(0.9)]);
            matrix.add_inertia(0.02 * k, [k.sin(), k.cos()]);
        }
        let right = SMatrix::<f64, 4, 3>::from_fn(|row, column| {
            f64::from(u8::try_from(3 * row + 5 * column).unwrap_or(0)).sin()
        });
        let solved = matrix.factorised().map(|m| m.solve_each(&right));
        let ([a, b], [i11, i12, i22], m) = (matrix.levers, matrix.inertia, matrix.mass);
        let full = Matrix4::new(
            m, 0.0, a.x, b.x, 0.0, m, a.y, b.y, a.x, a.y, i11, i12, b.x, b.y, i12, i22,
        );
        let error = solved.map(|solved| (full * solved - right).amax());
        // Rounding of a well conditioned matrix.
        assert!(error.is_some_and(|error| error < 1e-13), "{error:?}");
        // A mass at Q alone turns nothing.
        let mut point = MassMatrix::default();
        point.add_mass(1.0, [Vec2::zeros(); 2]);
        assert!(point.factorised().is_none());
    }
}
