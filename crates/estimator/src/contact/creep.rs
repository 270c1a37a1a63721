//! Creep of a rolling wheel: slip speed = creep times T/N while the wheel sticks.

/// The linear creep law of one wheel at one instant.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Creep {
    /// Creep speed, the slip speed at T = N by the linear law, m/s.
    pub speed: f64,
    /// T/N.
    pub ratio: f64,
}

impl Creep {
    /// T/N from which slip is no longer linear in it.
    const LINEAR_RATIO: f64 = 0.2;
    /// T/N from which wheels may slide on poor ground.
    const SLIDING_RATIO: f64 = 0.31;

    /// Slip speed by the linear law, m/s.
    pub fn slip(&self) -> f64 {
        self.speed * self.ratio
    }

    /// Factor on the variance of the slip speed for what the linear law leaves out: it grows with the fourth power of T/N
    /// over 0.2 and with the eighth over 0.31.
    pub fn variance_factor(&self) -> f64 {
        let fourth_power = |limit: f64| {
            let square = self.ratio * self.ratio / (limit * limit);
            square * square
        };
        let nonlinear = fourth_power(Self::LINEAR_RATIO);
        let sliding = fourth_power(Self::SLIDING_RATIO);
        1.0 + (nonlinear + sliding * sliding)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Closed form: at the limit ratios the factor has grown by the terms stated.
    #[test]
    fn the_variance_grows_beyond_the_linear_range() {
        let factor = |ratio| Creep { speed: 0.01, ratio }.variance_factor();
        let powers = |ratio: f64| 1.0 + (ratio / 0.2).powi(4) + (ratio / 0.31).powi(8);
        for ratio in [0.0, -0.1, 0.2, 0.31, 1.0] {
            // Rounding of a dozen operations.
            assert!((factor(ratio) - powers(ratio)).abs() < 1e-12 * powers(ratio));
        }
    }
}
