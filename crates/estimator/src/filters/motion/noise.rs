//! Errors that last, as a filter of independent samples must take them.

/// An error with a standard deviation (in the unit of its measurement) and a correlation time (s).
#[derive(Clone, Copy, Debug)]
pub struct LastingError {
    /// Standard deviation.
    pub sigma: f64,
    /// Correlation time, s.
    pub time: f64,
}

impl LastingError {
    /// An error that lasts for `time` (s).
    pub const fn new(sigma: f64, time: f64) -> Self {
        Self { sigma, time }
    }

    /// The same error of ground that passes `speed_ratio` times as fast.
    pub fn at_speed(self, speed_ratio: f64) -> Self {
        Self {
            sigma: self.sigma * speed_ratio,
            time: self.time / speed_ratio,
        }
    }

    /// Variance of the white noise, at samples every `dt` (s), whose mean over a long time is as uncertain:
    /// `sigma^2 2 time/dt`, from the integral of the autocorrelation `sigma^2 exp(-|t|/time)`.
    pub fn white(self, dt: f64) -> f64 {
        self.sigma * self.sigma * 2.0 * self.time / dt
    }
}
