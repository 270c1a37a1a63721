//! The solver's state vector.

use crate::mechanics::State;
use crate::start::Start;
use nalgebra::{SVector, Vector4};
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
    let (state, [a, b]) = (&start.state, start.state.angles);
    let coordinates = Vector4::new(state.q.x, state.q.y, a, b);
    joined(coordinates, state.rates, state.omega, start.integrals)
}

/// The solver's state, or its derivative, from the parts in their order.
#[inline]
pub(super) fn joined(q: Vector4<f64>, v: Vector4<f64>, omega: [f64; 3], integral: [f64; 3]) -> Y {
    let ([o1, o2, o3], [i1, i2, i3]) = (omega, integral);
    Y::from([
        q[0], q[1], q[2], q[3], v[0], v[1], v[2], v[3], o1, o2, o3, i1, i2, i3,
    ])
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
