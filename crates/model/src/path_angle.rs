//! The angle of a joint of the suspension and its rate, from readings of the angle and the wheels.

use crate::sqrt;

/// The rate of a joint of the suspension: the slope of its angle along the path times the speed of
/// the wheels. The slope is that of a Kalman filter with the states angle and slope, whose
/// derivative along the path is white noise of a density that follows from the wheels: so a robot
/// at rest has no rate, and a slow one a small error of it.
///
/// `N` is the number of wheels whose encoders give the speed.
#[derive(Clone, Debug, PartialEq)]
pub struct PathAngle<const N: usize> {
    radius: f64,
    /// Standard deviation of a reading, rad.
    noise: f64,
    /// Density of the second derivative of the angle along the path, rad^2/m^3.
    density: f64,
    /// Time (s) and turn (rad) of the last reading of each wheel.
    turns: [Option<(f64, f64)>; N],
    /// Speed of each wheel between its last two readings, m/s.
    rolled: [Option<f64>; N],
    /// Way since the last reading of the angle, m.
    way: f64,
    /// Time of the last sample, s.
    time: Option<f64>,
    /// Speed of the wheels, low-pass filtered, m/s.
    speed: f64,
    /// Angle (rad) and slope (rad/m) and their covariance at the last good reading.
    state: Option<([f64; 2], [f64; 3])>,
    /// Time of the last good reading of the angle, s.
    read: f64,
    /// Innovation of the last reading, rad, if it was left out as a jump.
    jumped: Option<f64>,
    /// Whether a reading that jumps counts, too.
    pub(crate) keeps_jumps: bool,
}

impl<const N: usize> PathAngle<N> {
    /// Least standard deviation of a reading of the pin, rad: a step of 16 bits. With 0 the slope
    /// would be a difference of two readings.
    const LEAST_NOISE: f64 = 1e-4;
    /// Square root of the density for wheels of 0.1 m, rad/m^1.5: 30 deg/m of slope change within a
    /// wheel radius, as on bumps of that size.
    const CURVATURE: f64 = 5.6;
    /// Variance of the slope before the first reading, rad^2/m^2: level ground.
    const LEVEL: f64 = 1e-2;
    /// Standard deviations beyond which a reading is a jump: once in 1.7 million samples.
    const GATE: f64 = 5.0;
    /// Rate of a pin that its slope along the path does not show, rad/s: an edge, wheels that slip.
    const LARGEST_RATE: f64 = 2.0;
    /// Time after which no further reading is left out, s.
    const STALE_AFTER: f64 = 0.1;
    /// Difference of a wheel's speed from the filtered one beyond which its encoder has jumped, m/s,
    /// for wheels of 0.1 m.
    const LARGEST_CHANGE: f64 = 2.0;
    /// Time constant of the speed, s.
    const SPEED_TIME: f64 = 0.2;

    /// For wheels of this radius (m), and readings with white noise (rad a sample).
    pub fn new(wheel_radius: f64, noise: f64) -> Self {
        let size = wheel_radius / 0.1;
        Self {
            radius: wheel_radius,
            // Ground is as rough as the wheels are large.
            density: Self::CURVATURE * Self::CURVATURE / (size * size * size),
            noise: noise.max(Self::LEAST_NOISE),
            turns: [None; N],
            rolled: [None; N],
            way: 0.0,
            time: None,
            speed: 0.0,
            state: None,
            read: 0.0,
            jumped: None,
            keeps_jumps: false,
        }
    }

    /// The angle (rad) read at `time` (s) and its rate (rad/s), with the turns of the `wheels`
    /// relative to their links (rad). `None` without a reading, and for one that jumps: it counts as
    /// missing until the next one confirms it.
    pub fn update(
        &mut self,
        time: f64,
        angle: Option<f64>,
        wheels: &[Option<f64>; N],
    ) -> Option<(f64, f64)> {
        self.roll(time, wheels);
        let angle = angle.filter(|angle| self.measure(time, *angle))?;
        let slope = self.state.map_or(0.0, |([_, slope], _)| slope);
        Some((angle, slope * self.speed))
    }

    /// Standard deviation of the rate at a `speed` (m/s), rad/s, for readings a `period`
    /// (s) apart: the steady state of the filter, `v sqrt(sqrt(2) q^(3/4) r^(1/4))` with the
    /// densities q of the ground and r of the noise along the path.
    pub fn rate_sigma(&self, speed: f64, period: f64) -> f64 {
        let (q, r) = (self.density, self.noise * self.noise * period * speed);
        let q34 = sqrt(q) * sqrt(sqrt(q));
        speed * sqrt(core::f64::consts::SQRT_2 * q34 * sqrt(sqrt(r)))
    }

    /// Way and speed by the wheels, each over the time since its own last reading: encoders may be
    /// slower than the samples, or have stamps of their own.
    fn roll(&mut self, time: f64, wheels: &[Option<f64>; N]) {
        let dt = self.time.map_or(0.0, |last| time - last);
        self.time = Some(time);
        let radius = self.radius;
        for ((last, rolled), now) in self.turns.iter_mut().zip(&mut self.rolled).zip(wheels) {
            let Some(now) = *now else {
                continue;
            };
            *rolled = (last.filter(|(then, _)| time > *then))
                .map(|(then, turn)| radius * (now - turn) / (time - then));
            *last = Some((time, now));
        }
        let (mut sum, mut count) = (0.0, 0.0);
        let largest = Self::LARGEST_CHANGE * sqrt(radius / 0.1);
        for speed in self.rolled.iter().flatten() {
            if libm::fabs(speed - self.speed) <= largest {
                sum += speed;
                count += 1.0;
            }
        }
        if count > 0.0 && dt > 0.0 {
            let speed = sum / count;
            self.way += speed * dt;
            self.speed += dt / (Self::SPEED_TIME + dt) * (speed - self.speed);
        }
    }

    /// Time update over the way since the last good reading, and measurement update by an angle
    /// (rad) at `time` (s). Returns whether the angle counts.
    ///
    /// One beyond the gate does not, unless the one before was at least half as far out on the same
    /// side, or others were left out for long: then the filter starts anew with the slope that it has.
    fn measure(&mut self, time: f64, angle: f64) -> bool {
        let r = self.noise * self.noise;
        let Some(([a, b], [paa, pab, pbb])) = self.state else {
            self.state = Some(([angle, 0.0], [r, 0.0, Self::LEVEL]));
            (self.read, self.way) = (time, 0.0);
            return true;
        };
        let (ds, elapsed) = (self.way, time - self.read);
        let (length, q) = (libm::fabs(ds), self.density);
        let paa = paa + 2.0 * ds * pab + ds * ds * pbb + q * length * length * length / 3.0;
        let pab = pab + ds * pbb + q * ds * length / 2.0;
        let pbb = pbb + q * length;
        let innovation = angle - (a + ds * b);
        let reach = Self::GATE * sqrt(paa + r) + Self::LARGEST_RATE * elapsed;
        let jumps = !self.keeps_jumps && libm::fabs(innovation) > reach;
        let confirmed = |before: f64| innovation * before >= 0.5 * before * before;
        let stale = elapsed > Self::STALE_AFTER;
        let counts = self.jumped.is_some_and(|before| stale || confirmed(before));
        if jumps && !counts {
            self.jumped = Some(innovation);
            return false;
        }
        (self.read, self.way, self.jumped) = (time, 0.0, None);
        if jumps {
            self.state = Some(([angle, b], [r, 0.0, Self::LEVEL]));
            return true;
        }
        let (ka, kb) = (paa / (paa + r), pab / (paa + r));
        let state = [a + ds * b + ka * innovation, b + kb * innovation];
        let covariance = [(1.0 - ka) * paa, (1.0 - ka) * pab, pbb - kb * pab];
        self.state = Some((state, covariance));
        true
    }
}
