//! A Kalman filter of fixed size: state, covariance, scalar measurements one after the other.

/// State estimate and its covariance.
///
/// The `CONSIDERED` states from `FIRST` on are consider states (Schmidt-Kalman filter; S. F. Schmidt,
/// 1966):
/// their variance and correlations count, but no measurement corrects them or reduces their
/// variance. For states of low observability, which the linearised filter would correct wrongly.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Kalman<const N: usize, const FIRST: usize = 0, const CONSIDERED: usize = 0> {
    /// State.
    pub x: [f64; N],
    /// Covariance, symmetric.
    pub p: [[f64; N]; N],
}

/// A measurement minus its prediction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Innovation {
    /// In the measurement's unit.
    pub value: f64,
    /// Predicted variance.
    pub variance: f64,
}

/// A combination `h' x` of the states.
#[derive(Clone, Copy, Debug)]
pub struct Projection<const N: usize> {
    /// `h' x`.
    pub value: f64,
    /// Its variance `h' P h`.
    pub variance: f64,
    /// Covariances `P h` of all states with it.
    pub ph: [f64; N],
}

impl Innovation {
    /// Normalised innovation squared, `value^2/variance`: chi-square with one degree of freedom if
    /// the filter is consistent.
    pub fn nis(&self) -> f64 {
        self.value * self.value / self.variance
    }

    /// The variance with which it corrects: beyond `gate` standard deviations inflated until it lies
    /// there. `None` where a number is not finite.
    pub fn inflated(&self, gate: f64) -> Option<f64> {
        let nis = self.nis();
        // Written so that a NaN is rejected too.
        let finite = self.variance > 0.0 && nis < f64::INFINITY;
        finite.then(|| self.variance * (nis / (gate * gate)).max(1.0))
    }
}

/// States that are exactly zero.
impl<const N: usize, const FIRST: usize, const CONSIDERED: usize> Default
    for Kalman<N, FIRST, CONSIDERED>
{
    fn default() -> Self {
        Self::new([0.0; N], [0.0; N])
    }
}

impl<const N: usize, const FIRST: usize, const CONSIDERED: usize> Kalman<N, FIRST, CONSIDERED> {
    /// Independent states with the given standard deviations.
    pub fn new(x: [f64; N], sigma: [f64; N]) -> Self {
        let mut p = [[0.0; N]; N];
        for i in 0..N {
            p[i][i] = sigma[i] * sigma[i];
        }
        Self { x, p }
    }

    /// A state and its standard deviation.
    #[inline]
    pub fn estimated(&self, state: usize) -> (f64, f64) {
        let variance = self.p[state][state].clamp(0.0, f64::INFINITY);
        (self.x[state], robhaz_model::sqrt(variance))
    }

    /// Sets a state to a value with a standard deviation, independent of all others. A state of `N`
    /// or more changes nothing.
    pub fn set(&mut self, state: usize, value: f64, sigma: f64) {
        for (k, row) in self.p.iter_mut().enumerate() {
            for (j, entry) in row.iter_mut().enumerate() {
                if k == state || j == state {
                    *entry = if k == j { sigma * sigma } else { 0.0 };
                }
            }
        }
        if let Some(x) = self.x.get_mut(state) {
            *x = value;
        }
    }

    /// `h' x` and its variance `h' P h`, for the entries of h that are not zero: pairs of state and
    /// value. A state of `N` or more counts for nothing.
    pub fn project<const K: usize>(&self, h: &[(usize, f64); K]) -> Projection<N> {
        let mut ph = [0.0; N];
        for &(j, value) in h {
            if let Some(row) = self.p.get(j) {
                for i in 0..N {
                    ph[i] += row[i] * value;
                }
            }
        }
        let combine = |of: &[f64; N]| {
            let mut sum = 0.0;
            for &(j, value) in h {
                sum += of.get(j).map_or(0.0, |entry| entry * value);
            }
            sum
        };
        Projection {
            value: combine(&self.x),
            variance: combine(&ph),
            ph,
        }
    }

    /// Measurement update by an innovation of the size `y` with the row `h` of the measurement
    /// matrix and the noise variance `r`, without a gate. A number that is not finite changes nothing. Returns the innovation.
    pub fn update<const K: usize>(&mut self, h: &[(usize, f64); K], y: f64, r: f64) -> Innovation {
        let projection = self.project(h);
        let found = Innovation {
            value: y,
            variance: projection.variance + r,
        };
        if let Some(s) = found.inflated(f64::INFINITY) {
            self.apply(&projection.ph, y, s);
        }
        found
    }

    /// `x += K innovation` and `P -= K S K'` with the gain `K = P h/S`, zero for consider states.
    pub fn apply(&mut self, ph: &[f64; N], innovation: f64, s: f64) {
        let considered = FIRST..FIRST + CONSIDERED;
        let root = 1.0 / robhaz_model::sqrt(s);
        // K S K' as k k' is symmetric to the bit.
        let k = ph.map(|value| value * root);
        let step = root * innovation;
        // Whole rows are fastest; the considered states, and what they have among themselves, come back.
        let mut kept = ([0.0; CONSIDERED], [[0.0; CONSIDERED]; CONSIDERED]);
        kept.0.copy_from_slice(&self.x[considered.clone()]);
        for (kept, row) in kept.1.iter_mut().zip(&self.p[considered.clone()]) {
            kept.copy_from_slice(&row[considered.clone()]);
        }
        for (x, ki) in self.x.iter_mut().zip(k) {
            *x += ki * step;
        }
        for (row, ki) in self.p.iter_mut().zip(k) {
            for (entry, kj) in row.iter_mut().zip(k) {
                *entry -= ki * kj;
            }
        }
        self.x[considered.clone()].copy_from_slice(&kept.0);
        for (row, kept) in self.p[considered.clone()].iter_mut().zip(&kept.1) {
            row[considered.clone()].copy_from_slice(kept);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::positive;
    use nalgebra::{Matrix3, Vector3};
    use proptest::prelude::*;

    proptest! {
        /// Equivalence: the scalar update is the conditional of the joint Gaussian, here in the
        /// information form `P+^-1 = P^-1 + h h'/r`, `P+^-1 x+ = P^-1 x + h z/r`. Conditions stay
        /// below 1e3: 1e-9 leaves three digits.
        #[test]
        fn update_is_the_conditional_gaussian(
            root in prop::array::uniform9(-1.0_f64..1.0), x in prop::array::uniform3(-2.0_f64..2.0),
            h in prop::array::uniform2(-2.0_f64..2.0), z in -3.0_f64..3.0, r in 0.01_f64..2.0,
        ) {
            let p = positive::<3>(&root);
            let mut filter: Kalman<3> = Kalman { x, p: [0, 1, 2].map(|i| [0, 1, 2].map(|j| p[(i, j)])) };
            let row = [(0, h[0]), (2, h[1])];
            let full = Vector3::new(h[0], 0.0, h[1]);
            let x = Vector3::from(x);
            let projection = filter.project(&row);
            prop_assert!((projection.variance - full.dot(&(p * full))).abs() < 1e-12 * (1.0 + projection.variance));
            filter.update(&row, z - full.dot(&x), r);

            let information = p.try_inverse().expect("positive") + full * full.transpose() / r;
            let after = information.try_inverse().expect("positive");
            let expected = after * (p.try_inverse().expect("positive") * x + full * (z / r));
            for i in 0..3 {
                prop_assert!((filter.x[i] - expected[i]).abs() < 1e-9);
                for j in 0..3 {
                    prop_assert!((filter.p[i][j] - after[(i, j)]).abs() < 1e-9);
                    prop_assert!(filter.p[i][j].to_bits() == filter.p[j][i].to_bits(), "not symmetric");
                }
            }
        }

        /// Closed form: with the gain `K` of Schmidt's filter, that of Kalman's but zero for
        /// consider states, the covariance is Joseph's form `(I - K h') P (I - K h')' + K r K'`,
        /// which holds for any gain. Conditions as above.
        #[test]
        fn considered_states_follow_josephs_form(
            root in prop::array::uniform9(-1.0_f64..1.0), h in prop::array::uniform3(-2.0_f64..2.0),
            z in -3.0_f64..3.0, r in 0.01_f64..2.0,
        ) {
            let p = positive::<3>(&root);
            let x = [1.0, -2.0, 0.5];
            let mut filter: Kalman<3, 2, 1> = Kalman { x, p: [0, 1, 2].map(|i| [0, 1, 2].map(|j| p[(i, j)])) };
            filter.update(&[(0, h[0]), (1, h[1]), (2, h[2])], z, r);

            let h = Vector3::from(h);
            let mut k = p * h / (h.dot(&(p * h)) + r);
            k.z = 0.0;
            let left = Matrix3::identity() - k * h.transpose();
            let after = left * p * left.transpose() + k * r * k.transpose();
            let expected = Vector3::from(x) + k * z;
            for i in 0..3 {
                prop_assert!((filter.x[i] - expected[i]).abs() < 1e-9);
                for j in 0..3 {
                    prop_assert!((filter.p[i][j] - after[(i, j)]).abs() < 1e-9);
                }
            }
            prop_assert!(filter.x[2].to_bits() == x[2].to_bits());
            prop_assert!(filter.p[2][2].to_bits() == p[(2, 2)].to_bits());
        }
    }
}
