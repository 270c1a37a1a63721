//! What the solver asks of a problem.

use nalgebra::{Complex, SVector};

/// The problem: `N` equations, and `Q` integrals that do not influence the solution.
pub(super) trait Model<const N: usize, const Q: usize> {
    /// How linear systems with df/dy are solved.
    type System: System<N>;

    /// f(t, y); `None` if it has no value.
    fn rates(&mut self, t: f64, y: &SVector<f64, N>) -> Option<SVector<f64, N>>;

    /// df/dy at a state with known rates. It may be approximate; only the speed of convergence
    /// depends on it.
    fn jacobian(
        &mut self,
        t: f64,
        y: &SVector<f64, N>,
        rates: &SVector<f64, N>,
    ) -> Option<<Self::System as System<N>>::Jacobian>;

    /// Rates of the integrals.
    fn integrands(&mut self, t: f64, y: &SVector<f64, N>) -> SVector<f64, Q>;

    /// Longest step from a state with known rates. It is called once for each step.
    fn longest_step(&mut self, t: f64, y: &SVector<f64, N>, rates: &SVector<f64, N>) -> f64;
}

/// Factorised matrices `s 1 - df/dy` for a real s and a complex one.
pub(super) trait System<const N: usize>: Sized {
    /// df/dy.
    type Jacobian;

    /// The factorisations; `None` if a matrix is singular.
    fn factorise(jacobian: &Self::Jacobian, real: f64, pair: Complex<f64>) -> Option<Self>;

    /// Solves the real system in place.
    fn solve_real(&self, right: &mut SVector<f64, N>);

    /// Solves the complex system in place.
    fn solve_pair(&self, right: &mut SVector<Complex<f64>, N>);
}
