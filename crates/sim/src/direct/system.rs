//! The solver's state vector, and linear systems with the Jacobian of the equations of motion, `(s 1 - df/dy) x = b`.
//!
//! Coordinates and integrals of the speed errors are eliminated: `q' = v` gives `q = (b_q + v)/s`,
//! and the integral of a wheel depends on itself and on the wheel's speed alone. What is left are
//! seven equations for the rates v and the wheel speeds, instead of fourteen: an eighth of the work
//! of a factorisation.

use super::radau::System;
use crate::mechanics::State;
use crate::start::Start;
use nalgebra::{Complex, ComplexField, LU, SMatrix, SVector, U7, Vector4};
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

/// Number of equations that are left.
const LEFT: usize = 7;

/// df/dy of the equations of motion without the rows that are known: `q' = v`.
#[derive(Clone)]
pub(super) struct Jacobian {
    /// Derivatives of the accelerations of rates and wheel speeds by coordinates.
    pub by_position: SMatrix<f64, LEFT, 4>,
    /// By rates and wheel speeds.
    pub by_velocity: SMatrix<f64, LEFT, LEFT>,
    /// By the integrals of the speed errors.
    pub by_integral: SMatrix<f64, LEFT, 3>,
    /// Derivatives of the rate of each integral by its wheel's speed and by itself.
    pub integrals: [[f64; 2]; 3],
}

/// Factorised for a real s and a complex one.
pub(super) struct Factors {
    real: Reduced<f64>,
    pair: Reduced<Complex<f64>>,
}

impl System<SIZE> for Factors {
    type Jacobian = Jacobian;

    fn factorise(jacobian: &Jacobian, real: f64, pair: Complex<f64>) -> Option<Self> {
        Some(Self {
            real: Reduced::new(jacobian, real)?,
            pair: Reduced::new(jacobian, pair)?,
        })
    }

    fn solve_real(&self, right: &mut SVector<f64, SIZE>) {
        self.real.solve(right);
    }

    fn solve_pair(&self, right: &mut SVector<Complex<f64>, SIZE>) {
        self.pair.solve(right);
    }
}

/// The seven equations for one s.
struct Reduced<T: ComplexField<RealField = f64>> {
    /// 1/s.
    inverse: T,
    by_position: SMatrix<f64, LEFT, 4>,
    by_integral: SMatrix<f64, LEFT, 3>,
    /// Slope of each integral's rate over its wheel's speed.
    gain: [f64; 3],
    /// 1/(s - slope of each integral's rate over itself).
    integral: [T; 3],
    lu: LU<T, U7, U7>,
}

impl<T: ComplexField<RealField = f64> + Copy> Reduced<T> {
    /// `None` if the matrix is singular.
    fn new(jacobian: &Jacobian, s: T) -> Option<Self> {
        let inverse = T::one() / s;
        let integrals = jacobian.integrals;
        let integral = integrals.map(|[_, own]| T::one() / (s - T::from_real(own)));
        let gain = integrals.map(|[gain, _]| gain);
        let mut matrix = jacobian.by_velocity.map(|entry| T::from_real(-entry));
        for row in 0..LEFT {
            matrix[(row, row)] += s;
            for k in 0..4 {
                matrix[(row, k)] -= inverse.scale(jacobian.by_position[(row, k)]);
            }
            for k in 0..3 {
                let slope = jacobian.by_integral[(row, k)] * gain[k];
                matrix[(row, 4 + k)] -= integral[k].scale(slope);
            }
        }
        let lu = matrix.lu();
        lu.is_invertible().then_some(Self {
            inverse,
            by_position: jacobian.by_position,
            by_integral: jacobian.by_integral,
            gain,
            integral,
            lu,
        })
    }

    fn solve(&self, right: &mut SVector<T, SIZE>) {
        let mut left = SVector::<T, LEFT>::zeros();
        left.copy_from(&right.fixed_rows::<LEFT>(RATES));
        for k in 0..4 {
            let known = right[k] * self.inverse;
            for row in 0..LEFT {
                left[row] += known.scale(self.by_position[(row, k)]);
            }
        }
        for k in 0..3 {
            let known = right[INTEGRAL + k] * self.integral[k];
            for row in 0..LEFT {
                left[row] += known.scale(self.by_integral[(row, k)]);
            }
        }
        self.lu.solve_mut(&mut left);
        for k in 0..4 {
            right[k] = (right[k] + left[k]) * self.inverse;
        }
        for k in 0..3 {
            let from_speed = left[4 + k].scale(self.gain[k]);
            right[INTEGRAL + k] = (right[INTEGRAL + k] + from_speed) * self.integral[k];
        }
        right.fixed_rows_mut::<LEFT>(RATES).copy_from(&left);
    }
}
