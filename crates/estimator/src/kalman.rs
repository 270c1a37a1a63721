//! A Kalman filter of fixed size: state, covariance, scalar measurements one after the other.

use crate::visit::Visit;

/// State estimate and its covariance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Kalman<const N: usize> {
    /// State.
    pub x: [f64; N],
    /// Covariance, symmetric.
    pub p: [[f64; N]; N],
}

/// How far a measurement was from what the filter expected.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Innovation {
    /// Measured minus expected.
    pub value: f64,
    /// Its expected variance.
    pub variance: f64,
}

impl Innovation {
    /// `value^2/variance`: chi-square with one degree of freedom if the filter is right.
    pub fn nis(&self) -> f64 {
        self.value * self.value / self.variance
    }
}

impl<const N: usize> Kalman<N> {
    /// Independent states with the given standard deviations.
    pub fn new(x: [f64; N], sigma: [f64; N]) -> Self {
        let mut p = [[0.0; N]; N];
        for i in 0..N {
            p[i][i] = sigma[i] * sigma[i];
        }
        Self { x, p }
    }

    /// `P h` for a row `h` given by its entries that are not zero.
    pub fn covariance_times<const K: usize>(&self, h: &[(usize, f64); K]) -> [f64; N] {
        let mut ph = [0.0; N];
        for &(j, value) in h {
            let row = &self.p[j];
            for i in 0..N {
                ph[i] += row[i] * value;
            }
        }
        ph
    }

    /// Takes a measurement whose difference from the expected value is `difference`, with the row `h` of its sensitivity
    /// and the variance `r` of its noise. Beyond `gate` standard deviations it is left out.
    ///
    /// Returns the innovation and whether it was used.
    pub fn update<const K: usize>(
        &mut self,
        h: &[(usize, f64); K],
        difference: f64,
        r: f64,
        gate: f64,
    ) -> (Innovation, bool) {
        let ph = self.covariance_times(h);
        let mut variance = r;
        for &(j, value) in h {
            variance += ph[j] * value;
        }
        let innovation = Innovation {
            value: difference,
            variance,
        };
        // Written so that a NaN is left out too.
        let used = variance > 0.0 && innovation.nis() <= gate * gate;
        if used {
            self.apply(&ph, difference, variance);
        }
        (innovation, used)
    }

    /// Takes a measurement of which `P h` and the innovation's variance are known already.
    pub fn apply(&mut self, ph: &[f64; N], difference: f64, variance: f64) {
        let inverse = 1.0 / variance;
        let step = difference * inverse;
        for i in 0..N {
            let gain = ph[i] * inverse;
            self.x[i] += ph[i] * step;
            for j in 0..N {
                self.p[i][j] -= gain * ph[j];
            }
        }
    }
}

impl<const N: usize> Visit for Kalman<N> {
    fn visit(&mut self, f: &mut impl FnMut(&mut f64)) {
        self.x.visit(f);
        self.p.visit(f);
    }
}
