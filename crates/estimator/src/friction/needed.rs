//! Needed friction mu_n = T/N with its standard deviation.

/// Needed friction of a wheel, mu_n = T/N: what the force balance asks of the ground.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct NeededFriction {
    /// T/N, -, driving forward positive.
    pub value: f64,
    /// Its standard deviation, -.
    pub sigma: f64,
}

/// Forces of the three wheels at one instant, with their covariance.
#[derive(Clone, Copy, Debug)]
pub(crate) struct JointForces {
    /// `[T1 N1 T2 N2 T3 N3]`, N.
    x: [f64; 6],
    /// Their covariance, N^2.
    p: [[f64; 6]; 6],
}

impl JointForces {
    /// Tractions and normal forces, N, and the covariance of `[T1 N1 T2 N2 T3 N3]`, N^2.
    pub fn new(traction: &[f64; 3], normal: &[f64; 3], covariance: &[[f64; 6]; 6]) -> Self {
        let [t1, t2, t3] = *traction;
        let [n1, n2, n3] = *normal;
        Self {
            x: [t1, n1, t2, n2, t3, n3],
            p: *covariance,
        }
    }

    /// Conditions the forces on the direction of the velocity that the memory of the ground knows. `contact_angle`: angles of the
    /// estimate, rad; `error`: their common error, estimated minus true as dy/dx, and its standard deviation.
    ///
    /// The horizontal balance `sum (T cos gamma - N sin gamma) = m a` holds for the estimate at its own angles. At the true angles
    /// the sum differs by `-sum (T sin gamma + N cos gamma) d gamma`. This is a measurement of the sum: it separates the offsets and
    /// gains of the torques from the slope, which the motion filter alone cannot on even ground.
    pub fn know_direction(&mut self, contact_angle: &[f64; 3], error: (f64, f64)) {
        let mut h = [0.0; 6];
        let mut by_direction = 0.0;
        for (i, gamma) in contact_angle.iter().enumerate() {
            let (sin, cos) = libm::sincos(*gamma);
            (h[2 * i], h[2 * i + 1]) = (cos, -sin);
            let vertical = self.x[2 * i] * sin + self.x[2 * i + 1] * cos;
            // d gamma = cos^2 d(dy/dx)
            by_direction += vertical * cos * cos;
        }
        let mut ph = [0.0; 6];
        for (entry, row) in ph.iter_mut().zip(&self.p) {
            *entry = row.iter().zip(&h).map(|(a, b)| a * b).sum();
        }
        let of_forces: f64 = ph.iter().zip(&h).map(|(a, b)| a * b).sum();
        let (error, sigma) = error;
        let noise = by_direction * sigma;
        let variance = of_forces + noise * noise;
        // Written so that a NaN fails too.
        if !(variance > 0.0) {
            return;
        }
        let step = -by_direction * error / variance;
        for i in 0..6 {
            self.x[i] += ph[i] * step;
            for j in 0..6 {
                self.p[i][j] -= ph[i] * ph[j] / variance;
            }
        }
    }

    /// Normal force of wheel `i`, N.
    pub fn normal(&self, i: usize) -> f64 {
        self.x[2 * i + 1]
    }

    /// T/N of wheel `i`. To first order its variance is that of `(T - mu N)/N`. Not finite without load.
    pub fn needed_friction(&self, i: usize) -> NeededFriction {
        let (t, n) = (2 * i, 2 * i + 1);
        let value = self.x[t] / self.x[n];
        let p = &self.p;
        let variance = p[t][t] - 2.0 * value * p[t][n] + value * value * p[n][n];
        NeededFriction {
            value,
            sigma: robhaz_model::sqrt(variance.max(0.0)) / self.x[n],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn forces() -> JointForces {
        let mut p = [[0.0; 6]; 6];
        for (i, row) in p.iter_mut().enumerate() {
            row[i] = if i % 2 == 0 { 1.0 } else { 0.25 };
        }
        JointForces::new(&[20.0, -10.0, -7.0], &[40.0, 50.0, 47.0], &p)
    }

    /// Closed form: independent errors of T and N, `sigma^2 = (s_T^2 + mu^2 s_N^2)/N^2`.
    #[test]
    fn the_deviation_is_that_of_a_quotient() {
        let found = forces().needed_friction(0);
        assert!((found.value - 0.5).abs() < 1e-15);
        let expected = (1.0_f64 + 0.25 * 0.25).sqrt() / 40.0;
        assert!((found.sigma - expected).abs() < 1e-15);
    }

    /// Closed form: on level ground the sum of T is measured as it is less the weight times the error. Three equal variances of 1 N^2
    /// share a change of the sum equally, and the sum keeps the variance `3 r/(3 + r)` of a noise r.
    #[test]
    fn a_known_direction_measures_the_sum_of_tractions() {
        let weight = 137.0;
        for (error, sigma) in [(0.01, 1e-6), (-0.02, 0.01)] {
            let mut found = forces();
            found.know_direction(&[0.0; 3], (error, sigma));
            let r: f64 = weight * sigma * weight * sigma;
            let change = -weight * error / (3.0 + r);
            let before = forces();
            for i in 0..3 {
                assert!((found.x[2 * i] - before.x[2 * i] - change).abs() < 1e-12);
                assert!((found.x[2 * i + 1] - before.x[2 * i + 1]).abs() < 1e-12);
            }
            let sum: f64 = [0, 2, 4]
                .iter()
                .flat_map(|i| [0, 2, 4].map(|j| found.p[*i][j]))
                .sum();
            assert!((sum - 3.0 * r / (3.0 + r)).abs() < 1e-9);
        }
    }

    /// Property: a direction of which nothing is known, and exact forces, change nothing.
    #[test]
    fn nothing_known_changes_nothing() {
        let mut found = forces();
        found.know_direction(&[0.1; 3], (0.5, 1e9));
        for (a, b) in found.x.iter().zip(&forces().x) {
            // The sum moves by 3 N^2/(137e9 N)^2 of its innovation.
            assert!((a - b).abs() < 1e-9);
        }
        let mut exact = JointForces::new(&[1.0; 3], &[40.0; 3], &[[0.0; 6]; 6]);
        exact.know_direction(&[0.0; 3], (0.1, 0.0));
        assert!((exact.needed_friction(1).value - 0.025).abs() < 1e-15);
    }
}
