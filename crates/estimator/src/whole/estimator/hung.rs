//! A rate of the body's sensor that hangs by itself.

/// Whether one rate of the body repeats its value by itself: a gyroscope has noise, where an angle may rest.
#[derive(Clone, Copy, Debug)]
pub(super) struct Hung {
    last: Option<f64>,
    /// For how long it has been the same while the wheels turned, s, and how often.
    same: (f64, u32),
    /// The least change so far, rad/s.
    step: f64,
}

impl Default for Hung {
    fn default() -> Self {
        Self {
            last: None,
            same: (0.0, 0),
            step: f64::INFINITY,
        }
    }
}

impl Hung {
    /// Time (s) and number of equal readings from which on a noisy one is none. As `check` has it.
    /// Chosen.
    const LONGEST: (f64, u32) = (1.0, 20);
    /// Step over its noise from which on equal ones show nothing: of three two are equal by chance, twenty once
    /// in 3000. As `check` has it.
    /// Definition.
    const COARSE: f64 = 2.0;

    /// Takes a rate with this white noise (rad/s) after a time `dt` (s; 0 while no wheel turns).
    pub fn take(&mut self, rate: Option<f64>, dt: f64, noise: f64) -> bool {
        let Some((now, last)) = rate.zip(core::mem::replace(&mut self.last, rate)) else {
            self.same = (0.0, 0);
            return false;
        };
        let (time, count) = &mut self.same;
        let change = (now - last).abs();
        if change > 0.0 || now.abs() <= 0.0 {
            (*time, *count) = (0.0, 0);
        } else {
            *time += dt;
            *count = count.saturating_add(u32::from(dt > 0.0));
        }
        if change > 0.0 {
            self.step = self.step.min(change);
        }
        let is_coarse = self.step < f64::INFINITY && self.step > Self::COARSE * noise;
        let (longest, most) = Self::LONGEST;
        noise > 0.0 && *time > longest && *count >= most && !is_coarse
    }
}
