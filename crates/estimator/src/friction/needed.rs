//! Needed friction mu_n = T/N with its standard deviation.

use crate::statics::Forces;
use robhaz_model::Vec2;

/// Needed friction of a wheel, mu_n = T/N: what the force balance asks of the ground.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct NeededFriction {
    /// T/N, -, driving forward positive.
    pub value: f64,
    /// Its standard deviation, -.
    pub sigma: f64,
}

/// Part of T/N of a wheel that comes from its own torque offset: from the difference to the mean of
/// the three offsets.
///
/// The balance of the robot shows the sum of the offsets; nothing shows their differences where
/// wheels do not creep.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct OffsetShare {
    /// What the estimated difference has taken from T/N, -. The sum of
    /// [`crate::WheelFriction::needed`] and this errs by a force that stays the same while the
    /// offsets do.
    pub removed: f64,
    /// Standard deviation of the true difference's part by the data sheet, -.
    pub sigma: f64,
}

/// Forces of the three wheels at one instant, each wheel's with their covariance.
#[derive(Clone, Copy, Debug)]
pub(crate) struct JointForces {
    /// `[T1 N1 T2 N2 T3 N3]`, N.
    x: [f64; 6],
    /// Variance of T, covariance, and variance of N of each wheel, N^2.
    own: [[f64; 3]; 3],
}

impl JointForces {
    /// The forces of an estimate.
    pub fn new(forces: &Forces) -> Self {
        let [t1, t2, t3] = forces.traction;
        let [n1, n2, n3] = forces.normal;
        let p = &forces.covariance;
        let own = |t: usize, n: usize| [p[t][t], p[t][n], p[n][n]];
        Self {
            x: [t1, n1, t2, n2, t3, n3],
            own: [own(0, 1), own(2, 3), own(4, 5)],
        }
    }

    /// Conditions the forces, of the covariance `p` (N^2), on the direction of the velocity that
    /// the memory of the ground knows. `tangents`: directions of the tangents at the contacts;
    /// `error`: their common error, estimated minus true as dy/dx, and its standard deviation.
    ///
    /// The horizontal balance `sum (T cos gamma - N sin gamma) = m a` holds for the estimate at its
    /// own angles. At the true angles the sum differs by
    /// `-sum (T sin gamma + N cos gamma) d gamma`. This is a measurement of the sum: it separates
    /// the offsets and gains of the torques from the slope, which the motion filter alone cannot on
    /// even ground.
    pub fn know_direction(&mut self, p: &[[f64; 6]; 6], tangents: &[Vec2; 3], error: (f64, f64)) {
        let mut h = [0.0; 6];
        let mut by_direction = 0.0;
        for (i, tangent) in tangents.iter().enumerate() {
            let (cos, sin) = (tangent.x, tangent.y);
            (h[2 * i], h[2 * i + 1]) = (cos, -sin);
            let vertical = self.x[2 * i] * sin + self.x[2 * i + 1] * cos;
            // d gamma = cos^2 d(dy/dx)
            by_direction += vertical * cos * cos;
        }
        let (error, sigma) = error;
        let noise = by_direction * sigma;
        let dot = |row: &[f64; 6]| row.iter().zip(&h).map(|(a, b)| a * b).sum::<f64>();
        let ph = p.each_ref().map(dot);
        let variance = dot(&ph) + noise * noise;
        // Written so that a NaN fails too.
        if !(variance > 0.0) {
            return;
        }
        for (x, ph) in self.x.iter_mut().zip(&ph) {
            *x -= ph / variance * by_direction * error;
        }
        for (i, own) in self.own.iter_mut().enumerate() {
            let (t, n) = (2 * i, 2 * i + 1);
            for (entry, (a, b)) in own.iter_mut().zip([(t, t), (t, n), (n, n)]) {
                *entry -= ph[a] * ph[b] / variance;
            }
        }
    }

    /// Normal force of wheel `i`, N.
    pub fn normal(&self, i: usize) -> f64 {
        self.x[2 * i + 1]
    }

    /// T/N of wheel `i`. To first order its variance is that of `(T - mu N)/N`. Not finite without
    /// load.
    pub fn needed_friction(&self, i: usize) -> NeededFriction {
        let (t, n) = (self.x[2 * i], self.x[2 * i + 1]);
        let value = t / n;
        let [tt, tn, nn] = self.own[i];
        let variance = tt - 2.0 * value * tn + value * value * nn;
        NeededFriction {
            value,
            sigma: robhaz_model::sqrt(variance.clamp(0.0, f64::INFINITY)) / n,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn forces() -> Forces {
        let mut covariance = [[0.0; 6]; 6];
        for (i, row) in covariance.iter_mut().enumerate() {
            row[i] = if i % 2 == 0 { 1.0 } else { 0.25 };
        }
        Forces {
            traction: [20.0, -10.0, -7.0],
            normal: [40.0, 50.0, 47.0],
            covariance,
        }
    }

    /// The forces on level ground with a known error of the direction.
    fn with_direction(forces: &Forces, error: (f64, f64)) -> JointForces {
        let mut found = JointForces::new(forces);
        found.know_direction(&forces.covariance, &[Vec2::x(); 3], error);
        found
    }

    /// Closed form: independent errors of T and N, `sigma^2 = (s_T^2 + mu^2 s_N^2)/N^2`.
    #[test]
    fn the_deviation_is_that_of_a_quotient() {
        let found = JointForces::new(&forces()).needed_friction(0);
        assert!((found.value - 0.5).abs() < 1e-15);
        let expected = (1.0_f64 + 0.25 * 0.25).sqrt() / 40.0;
        assert!((found.sigma - expected).abs() < 1e-15);
    }

    /// Closed form: on level ground the sum of T is measured as it is less the weight times the
    /// error. Three equal variances of 1 N^2 share a change of the sum equally, and with a noise r
    /// each keeps `1 - 1/(3 + r)`.
    #[test]
    fn a_known_direction_measures_the_sum_of_tractions() {
        let weight = 137.0;
        for (error, sigma) in [(0.01, 1e-6), (-0.02, 0.01)] {
            let found = with_direction(&forces(), (error, sigma));
            let r: f64 = weight * sigma * weight * sigma;
            let change = -weight * error / (3.0 + r);
            let before = JointForces::new(&forces());
            for i in 0..3 {
                assert!((found.x[2 * i] - before.x[2 * i] - change).abs() < 1e-12);
                assert!((found.x[2 * i + 1] - before.x[2 * i + 1]).abs() < 1e-12);
                assert!((found.own[i][0] - (1.0 - 1.0 / (3.0 + r))).abs() < 1e-12);
                assert!((found.own[i][2] - 0.25).abs() < 1e-12);
            }
        }
    }

    /// Property: a direction of which nothing is known, and exact forces, change nothing.
    #[test]
    fn nothing_known_changes_nothing() {
        let found = with_direction(&forces(), (0.5, 1e9));
        for (a, b) in found.x.iter().zip(&JointForces::new(&forces()).x) {
            // The sum moves by 3 N^2/(137e9 N)^2 of its innovation.
            assert!((a - b).abs() < 1e-9);
        }
        let exact = Forces {
            traction: [1.0; 3],
            normal: [40.0; 3],
            covariance: [[0.0; 6]; 6],
        };
        let found = with_direction(&exact, (0.1, 0.0));
        assert!((found.needed_friction(1).value - 0.025).abs() < 1e-15);
    }
}
