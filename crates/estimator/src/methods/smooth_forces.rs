//! Low-pass filtered forces of the wheels.

/// Low-pass filtered forces of the three wheels, N, about which sensitivities are linearised.
///
/// The noise of a torque must not be in both a residual and its gradient. The product would be a bias, and contact angles and torque
/// offsets would drift together.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct SmoothForces {
    /// N.
    pub normal: [f64; 3],
    /// T.
    pub traction: [f64; 3],
}

impl SmoothForces {
    /// Time constant, s: longer than the noise of the torque observer is correlated.
    const TIME: f64 = 0.2;
    /// Largest distance from the last forces, as a part of the mean wheel load.
    const LARGEST_LAG: f64 = 0.1;

    /// Those of a robot at rest: equal loads of `mean_load` (N), no traction.
    pub fn at_rest(mean_load: f64) -> Self {
        Self {
            normal: [mean_load; 3],
            traction: [0.0; 3],
        }
    }

    /// Advances by `dt` (s) to the forces N and T of the last estimate, N; `mean_load` is that of a wheel, N.
    pub fn follow(&mut self, mean_load: f64, normal: &[f64; 3], traction: &[f64; 3], dt: f64) {
        let weight = dt / (Self::TIME + dt);
        let most = Self::LARGEST_LAG * mean_load;
        let follow = |smooth: &mut f64, last: f64| {
            let lag = (1.0 - weight) * (last - *smooth);
            // `clamp` could panic.
            *smooth = last - lag.max(-most).min(most);
        };
        for i in 0..3 {
            follow(&mut self.normal[i], normal[i]);
            follow(&mut self.traction[i], traction[i]);
        }
    }
}
