//! The solver's state vector.

use crate::mechanics::State;
use crate::start::Start;
use nalgebra::SVector;
use robhaz_model::Vec2;

/// Number of equations.
pub(super) const SIZE: usize = 14;
/// Solver state: Q (m), angles of links 1 and 2 (rad), velocity of Q (m/s), rates of links 1 and 2
/// (rad/s), wheel spin speeds (rad/s), integrals of the speed errors (rad).
pub(super) type Y = SVector<f64, SIZE>;
/// Index of the first rate.
pub(super) const RATES: usize = 4;
/// Index of the first wheel speed.
pub(super) const OMEGA: usize = 8;
/// Index of the first integral of a speed error.
pub(super) const INTEGRAL: usize = 11;

/// The solver's state at time zero.
pub(super) fn start(start: &Start) -> Y {
    let state = &start.state;
    let mut y = Y::zeros();
    y.fixed_rows_mut::<4>(0).copy_from_slice(&[
        state.q.x,
        state.q.y,
        state.angles[0],
        state.angles[1],
    ]);
    y.fixed_rows_mut::<4>(RATES).copy_from(&state.rates);
    y.fixed_rows_mut::<3>(OMEGA).copy_from_slice(&state.omega);
    y.fixed_rows_mut::<3>(INTEGRAL)
        .copy_from_slice(&start.integrals);
    y
}

/// Coordinates and rates in the solver's state.
pub(super) fn state(y: &Y) -> State {
    State {
        q: Vec2::new(y[0], y[1]),
        angles: [y[2], y[3]],
        rates: y.fixed_rows::<4>(RATES).into_owned(),
        omega: [y[OMEGA], y[OMEGA + 1], y[OMEGA + 2]],
    }
}
