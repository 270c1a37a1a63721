//! How uneven the ground is under the wheels of one side.

use crate::deviation::WITHIN;

/// Height of the middle wheel above the line of the others, m: its mean, and its variance about it, over
/// the length of the robot.
///
/// The mean shows ground only as far as the bias of the inclinometers does not explain it; what
/// varies about it is ground, less the noise of the angles.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Unevenness {
    /// m.
    mean: f64,
    /// m^2.
    variance: f64,
    /// Way over which both are, m; 0 before the robot moves.
    way: f64,
}

impl Unevenness {
    /// Longest way over which the mean is, over the length between the outer wheels.
    /// Chosen; insensitive.
    const LENGTHS: f64 = 1.0;

    /// Compressions of a wheel by which its neighbours are lifted off even ground, of three wheels on a line.
    /// Definition.
    const LIFTS: f64 = 3.0;

    /// Takes a `height` (m) with the variance of its noise (m^2), a `way` (m) after the last, of a robot
    /// of this `length` (m). Heights beyond a few compressions of a wheel, `given` (m), lift no more.
    pub fn update(&mut self, height: f64, noise: f64, given: f64, way: f64, length: f64) {
        self.way = (self.way + way).min(Self::LENGTHS * length);
        if !(self.way > 0.0) {
            // At rest the angles settle.
            self.mean = height;
            return;
        }
        let weight = way / self.way;
        let lifts = Self::LIFTS * given;
        let apart = (height - self.mean).max(-lifts).min(lifts);
        self.mean += weight * apart;
        let seen = apart * apart - noise;
        self.variance += weight * ((1.0 - weight) * seen - self.variance);
    }

    /// Mean square, m^2, where the heights may have a bias of this standard deviation, m.
    pub fn square(&self, bias: f64) -> f64 {
        let explained = WITHIN * bias;
        self.variance.max(0.0) + (self.mean * self.mean - explained * explained).max(0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Closed form: a bias is no ground, heights of a sine have half of its square, and noise none.
    #[test]
    fn what_varies_is_ground() {
        let (length, step) = (0.4, 1e-3);
        let found = |height: &dyn Fn(f64) -> f64, noise: f64, bias: f64| {
            let mut of = Unevenness::default();
            for i in 0..4000 {
                of.update(height(f64::from(i) * step), noise, 1e-2, step, length);
            }
            of.square(bias)
        };
        assert!(found(&|_| 1.9e-3, 0.0, 1e-3) == 0.0);
        let beyond = found(&|_| 3e-3, 0.0, 1e-3);
        // Rounding.
        assert!((beyond - 5e-6).abs() < 1e-15, "{beyond}");
        let sine = found(&|x| 2e-3 * f64::sin(x / 0.05), 0.0, 1e-3);
        // The mean over 0.4 m follows the wave by an eighth, 2 % of its square.
        assert!((sine / 2e-6 - 1.0).abs() < 0.05, "{sine}");
        let noise = found(
            &|x| {
                if (x / step).round() % 2.0 == 0.0 {
                    1e-3
                } else {
                    -1e-3
                }
            },
            1e-6,
            1e-3,
        );
        assert!(noise < 1e-8, "{noise}");
    }
}
