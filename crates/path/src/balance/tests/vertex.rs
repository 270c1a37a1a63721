//! The needed friction in closed form where three contacts limit it: the usual case. A second way
//! to what the linear programs find.
//!
//! With one contact a wheel and `T_i = s_i m N_i`, s_i = +-1, eq. (8) is four equations for N_1,
//! N_2, N_3 and m:
//!
//! ```text
//! sum of N_i a_i = F',   a_i = n_i + s_i m t_i     (n_i, t_i: columns of N and T)
//! ```
//!
//! It is the least m if the multipliers of the three conditions `s_i T_i <= m N_i` have one sign:
//! with y normal to all a_i they are l_i = s_i y.t_i, and the sum of l_i N_i is above 0 (Karush,
//! Kuhn, Tucker; sufficient, since m -> max |T|/N is quasi-convex where N > 0).

use nalgebra::{Matrix3, Matrix4, Vector4};

/// Largest number of steps of Newton's method; five suffice near the solution.
const MOST_STEPS: u32 = 12;
/// Newton's method has converged when m moves by less.
const CONVERGED: f64 = 1e-13;
/// Multipliers below this share of the largest one have no certain sign.
const CERTAIN: f64 = 1e-9;

/// A proven solution.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Vertex {
    /// Needed friction, -.
    pub m: f64,
    /// N of each contact, N.
    pub normal: [f64; 3],
    /// T of each contact, N.
    pub traction: [f64; 3],
}

/// The least m for the columns of N and T of three contacts, with the signs of T as given or all
/// reversed.
pub fn vertex(
    columns: &[[Vector4<f64>; 2]; 3],
    right: &Vector4<f64>,
    mut signs: [f64; 3],
    guess: f64,
) -> Option<Vertex> {
    let mut n = [right[1] / 3.0; 3];
    let mut m = guess;
    let mut converged = false;
    for _ in 0..MOST_STEPS {
        let mut matrix = Matrix4::zeros();
        let mut slope = Vector4::zeros();
        for i in 0..3 {
            matrix.set_column(i, &(columns[i][0] + columns[i][1] * (signs[i] * m)));
            slope += columns[i][1] * (signs[i] * n[i]);
        }
        matrix.set_column(3, &slope);
        // Linear in N: the new N follow from the new m.
        let solution = matrix.lu().solve(&(right + slope * m))?;
        let moved = solution[3] - m;
        n = [solution[0], solution[1], solution[2]];
        m = solution[3];
        if !moved.is_finite() {
            return None;
        }
        if moved.abs() < CONVERGED {
            converged = true;
            break;
        }
    }
    if m < 0.0 {
        (m, signs) = (-m, signs.map(|s| -s));
    }
    let is_valid = converged && n.iter().all(|n| *n > 0.0) && is_least(columns, &n, &signs, m);
    is_valid.then(|| Vertex {
        m,
        normal: n,
        traction: [0, 1, 2].map(|i| signs[i] * m * n[i]),
    })
}

/// The proof by the multipliers.
fn is_least(columns: &[[Vector4<f64>; 2]; 3], n: &[f64; 3], signs: &[f64; 3], m: f64) -> bool {
    let a = [0, 1, 2].map(|i| columns[i][0] + columns[i][1] * (signs[i] * m));
    let y = normal_to(&a);
    let multipliers = [0, 1, 2].map(|i| signs[i] * y.dot(&columns[i][1]));
    let sum: f64 = multipliers.iter().zip(n).map(|(l, n)| l * n).sum();
    let largest = multipliers.iter().fold(0.0_f64, |a, l| a.max(l.abs()));
    let certain = |l: &f64| l * sum.signum() > CERTAIN * largest;
    largest > 0.0 && multipliers.iter().all(certain)
}

/// A vector normal to three vectors: the generalised cross product.
fn normal_to(a: &[Vector4<f64>; 3]) -> Vector4<f64> {
    Vector4::from_fn(|j, _| {
        let minor = Matrix3::from_fn(|row, column| a[column][if row < j { row } else { row + 1 }]);
        if j % 2 == 0 {
            minor.determinant()
        } else {
            -minor.determinant()
        }
    })
}
