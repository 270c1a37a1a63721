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
    /// T/N from which slip is no longer linear in it, -: on poor ground.
    /// Chosen; sensitive.
    const LINEAR_RATIO: f64 = 0.12;

    /// Slip speed by the linear law, m/s.
    pub fn slip(&self) -> f64 {
        self.speed * self.ratio
    }

    /// Factor on the variance of the slip speed for what the linear law leaves out: it grows with
    /// the fourth power of T/N.
    pub fn variance_factor(&self) -> f64 {
        let square = self.ratio * self.ratio / (Self::LINEAR_RATIO * Self::LINEAR_RATIO);
        1.0 + square * square
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Closed form: twice at the limit, 16 times more at twice the ratio.
    #[test]
    fn the_variance_grows_beyond_the_linear_range() {
        let factor = |ratio| Creep { speed: 0.01, ratio }.variance_factor();
        for (ratio, expected) in [(0.0, 1.0), (-0.12, 2.0), (0.24, 17.0)] {
            // Rounding of a dozen operations.
            assert!((factor(ratio) - expected).abs() < 1e-12 * expected);
        }
    }
}
