//! Time-correlated errors and their equivalent white noise.

/// A first-order Gauss-Markov process, given by its stationary standard deviation (in the unit of
/// its quantity) and its correlation time (s).
#[derive(Clone, Copy, Debug)]
pub struct GaussMarkov {
    /// Standard deviation.
    pub sigma: f64,
    /// Correlation time, s.
    pub time: f64,
}

impl GaussMarkov {
    /// A process with the correlation time `time` (s).
    pub const fn new(sigma: f64, time: f64) -> Self {
        Self { sigma, time }
    }

    /// The process at `speed_ratio` times the speed: the standard deviation times the ratio, the
    /// time over the ratio.
    pub fn at_speed(self, speed_ratio: f64) -> Self {
        Self {
            sigma: self.sigma * speed_ratio,
            time: self.time / speed_ratio,
        }
    }

    /// Variance of the white noise, at samples every `dt` (s, much shorter than `time`), whose mean
    /// over a long time is as uncertain: `sigma^2 2 time/dt`, from the integral of the
    /// autocorrelation `sigma^2 exp(-|t|/time)`.
    pub fn white(self, dt: f64) -> f64 {
        self.sigma * self.sigma * 2.0 * self.time / dt
    }
}
