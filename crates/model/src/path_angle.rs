//! The angle of a joint of the suspension and its rate, from readings of the angle and the wheels.

use crate::sqrt;

/// The rate of a joint of the suspension: the slope of its angle along the path times the speed of
/// the wheels, so that a robot at rest has no rate.
///
/// The slope is that of Kalman filters with the states angle and slope, whose derivative along the
/// path is white noise. How rough the ground is, and with it the density of that noise, is not
/// known: a bank of filters, from ground as rough as the wheels are large to a smooth one, each with
/// the likelihood of what it predicted over the last way as its weight (multiple-model estimation;
/// Bar-Shalom, Li, Kirubarajan, Estimation with Applications to Tracking and Navigation, 2001, ch.
/// 11.6).
///
/// `N` is the number of wheels whose encoders give the speed.
#[derive(Clone, Debug, PartialEq)]
pub struct PathAngle<const N: usize> {
    radius: f64,
    /// Standard deviation of a reading, rad.
    noise: f64,
    /// Time (s) and turn (rad) of the last reading of each wheel.
    turns: [Option<(f64, f64)>; N],
    /// Speed of each wheel between its last two readings, m/s.
    rolled: [Option<f64>; N],
    /// Way since the last reading of the angle, m.
    way: f64,
    /// Time of the last sample, s.
    time: Option<f64>,
    /// Speed of the wheels, low-pass filtered, m/s, and what it lags by, by the same low pass.
    speed: f64,
    lag: f64,
    /// The bank, from rough to smooth.
    bank: [Slope; MODELS],
    /// Whether there has been a reading.
    started: bool,
    /// Time of the last good reading of the angle, s.
    read: f64,
    /// Innovation of the last reading, rad, if it was left out as a jump.
    jumped: Option<f64>,
    /// Whether a reading that jumps counts, too.
    pub(crate) keeps_jumps: bool,
}

impl<const N: usize> PathAngle<N> {
    /// Least standard deviation of a reading, rad: a step of 16 bits. With 0 the slope
    /// would be a difference of two readings.
    const LEAST_NOISE: f64 = 1e-4;
    /// Square root of the density for wheels of 0.1 m, rad/m^1.5: 30 deg/m of slope change within a
    /// wheel radius, as on bumps of that size.
    const CURVATURE: f64 = 5.6;
    /// Density of each model of the bank over that of the one before: the slope's deviation changes
    /// by its power of 3/8, to a quarter.
    const SMOOTHER: f64 = 0.03;
    /// Way over which likelihoods count, in wheel radii.
    const MEMORY: f64 = 1.0;
    /// Least logarithm of a model's likelihood over the largest: it has to come back within some
    /// samples.
    const LEAST_LIKELIHOOD: f64 = -7.0;
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
    /// Time constant of the speed, s. While a robot starts or stops, its lag is one of the rate, which looks like
    /// another slope of the ground: it is stated.
    const SPEED_TIME: f64 = 0.05;

    /// For wheels of this radius (m), and readings with white noise (rad a sample).
    pub fn new(wheel_radius: f64, noise: f64) -> Self {
        let size = wheel_radius / 0.1;
        // Ground is as rough as the wheels are large.
        let rough = Self::CURVATURE * Self::CURVATURE / (size * size * size);
        Self {
            radius: wheel_radius,
            bank: core::array::from_fn(|k| Slope::new(rough * libm::pow(Self::SMOOTHER, k as f64))),
            started: false,
            noise: noise.max(Self::LEAST_NOISE),
            turns: [None; N],
            rolled: [None; N],
            way: 0.0,
            time: None,
            speed: 0.0,
            lag: 0.0,
            read: 0.0,
            jumped: None,
            keeps_jumps: false,
        }
    }

    /// As before its first reading.
    #[must_use]
    pub fn started_anew(&self) -> Self {
        Self {
            keeps_jumps: self.keeps_jumps,
            ..Self::new(self.radius, self.noise)
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
        let angle = angle.filter(|angle| angle.is_finite() && self.measure(time, *angle))?;
        Some((angle, self.slope() * self.speed))
    }

    /// Mean of the bank's slopes by their weights, rad/m.
    fn slope(&self) -> f64 {
        self.mean(|model| model.slope)
    }

    /// Mean over the bank.
    fn mean(&self, of: impl Fn(&Slope) -> f64) -> f64 {
        let (mut sum, mut weights) = (0.0, 0.0);
        for model in &self.bank {
            let weight = libm::exp(model.likelihood);
            sum += weight * of(model);
            weights += weight;
        }
        sum / weights
    }

    /// Standard deviation of the rate, rad/s. Its error does not last: the angle is read.
    pub fn rate_error(&self) -> f64 {
        let slope = self.slope();
        let variance = self.mean(|model| {
            let beside = model.slope - slope;
            model.covariance[2] + beside * beside
        });
        let of_lag = slope * self.lag;
        sqrt(self.speed * self.speed * variance + of_lag * of_lag)
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
        let (mut sum, mut size, mut count) = (0.0, 0.0, 0.0);
        let largest = Self::LARGEST_CHANGE * sqrt(radius / 0.1);
        for side in self.rolled.chunks(3) {
            let mut of_side = 0.0;
            for speed in side.iter().flatten() {
                if libm::fabs(libm::fabs(*speed) - libm::fabs(self.speed)) <= largest {
                    of_side += speed;
                    count += 1.0;
                }
            }
            sum += of_side;
            size += libm::fabs(of_side);
        }
        if count > 0.0 && dt > 0.0 {
            // On the spot the sides turn against each other: the way is that of the wheels.
            let opposed = libm::fabs(sum) < 0.5 * size;
            let speed = if opposed { size } else { sum } / count;
            self.way += speed * dt;
            let weight = crate::low_pass_share(dt, Self::SPEED_TIME);
            let lag = speed - self.speed;
            self.speed += weight * lag;
            self.lag += weight * (lag - self.lag);
        }
    }

    /// Time update over the way since the last good reading, and measurement update by an angle
    /// (rad) at `time` (s). Returns whether the angle counts.
    ///
    /// One beyond the gate does not, unless the one before was at least half as far out on the same
    /// side, or others were left out for long: then the filter starts anew with the slope that it has.
    fn measure(&mut self, time: f64, angle: f64) -> bool {
        let r = self.noise * self.noise;
        if !self.started {
            self.started = true;
            self.start(time, angle, true);
            return true;
        }
        let (ds, elapsed) = (self.way, time - self.read);
        let mut predicted = self.bank;
        for model in &mut predicted {
            *model = model.predicted(ds);
        }
        let [roughest, ..] = &predicted;
        let innovation = angle - roughest.angle;
        let reach = Self::GATE * sqrt(roughest.covariance[0] + r) + Self::LARGEST_RATE * elapsed;
        let jumps = !self.keeps_jumps && libm::fabs(innovation) > reach;
        let confirmed = |before: f64| innovation * before >= 0.5 * before * before;
        let stale = elapsed > Self::STALE_AFTER;
        let counts = self.jumped.is_some_and(|before| stale || confirmed(before));
        if jumps && !counts {
            self.jumped = Some(innovation);
            return false;
        }
        if jumps {
            self.start(time, angle, false);
            return true;
        }
        (self.read, self.way, self.jumped) = (time, 0.0, None);
        let remembered = libm::exp(-libm::fabs(ds) / (Self::MEMORY * self.radius));
        self.bank = predicted.map(|model| model.corrected(angle, r, remembered));
        self.share();
        true
    }

    /// All models at an angle (rad) read at `time` (s), with the slopes that they have, or `level`.
    fn start(&mut self, time: f64, angle: f64, level: bool) {
        let r = self.noise * self.noise;
        for model in &mut self.bank {
            model.angle = angle;
            model.covariance = [r, 0.0, Self::LEVEL];
            if level {
                model.slope = 0.0;
            }
        }
        (self.read, self.way, self.jumped) = (time, 0.0, None);
    }

    /// Weights relative to the largest. A model that has none left starts anew from the likeliest.
    fn share(&mut self) {
        let mut likeliest = self.bank[0];
        for model in &self.bank {
            if model.likelihood > likeliest.likelihood {
                likeliest = *model;
            }
        }
        for model in &mut self.bank {
            model.likelihood -= likeliest.likelihood;
            if model.likelihood.is_nan() || model.likelihood <= Self::LEAST_LIKELIHOOD {
                *model = Slope {
                    density: model.density,
                    likelihood: Self::LEAST_LIKELIHOOD,
                    ..likeliest
                };
            }
        }
    }
}

/// Number of models in the bank.
const MODELS: usize = 3;

/// A Kalman filter of angle and slope along the path for one density of the ground.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Slope {
    /// Density of the second derivative of the angle along the path, rad^2/m^3.
    density: f64,
    /// Angle, rad.
    angle: f64,
    /// Slope, rad/m.
    slope: f64,
    /// Covariance: angle, angle with slope, slope.
    covariance: [f64; 3],
    /// Logarithm of its likelihood over the last way, over the largest of the bank.
    likelihood: f64,
}

impl Slope {
    fn new(density: f64) -> Self {
        Self {
            density,
            angle: 0.0,
            slope: 0.0,
            covariance: [1.0, 0.0, 1.0],
            likelihood: 0.0,
        }
    }

    /// After a way, m.
    fn predicted(self, way: f64) -> Self {
        let [paa, pab, pbb] = self.covariance;
        let (length, q) = (libm::fabs(way), self.density);
        Self {
            angle: self.angle + way * self.slope,
            covariance: [
                paa + 2.0 * way * pab + way * way * pbb + q * length * length * length / 3.0,
                pab + way * pbb + q * way * length / 2.0,
                pbb + q * length,
            ],
            ..self
        }
    }

    /// By a reading (rad) with the variance `r`; of the likelihood so far a part is `remembered`.
    fn corrected(self, reading: f64, r: f64, remembered: f64) -> Self {
        let [paa, pab, pbb] = self.covariance;
        let (innovation, s) = (reading - self.angle, paa + r);
        let (ka, kb) = (paa / s, pab / s);
        Self {
            angle: self.angle + ka * innovation,
            slope: self.slope + kb * innovation,
            covariance: [(1.0 - ka) * paa, (1.0 - ka) * pab, pbb - kb * pab],
            likelihood: remembered * self.likelihood
                - 0.5 * (innovation * innovation / s + libm::log(s)),
            ..self
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Property: on a joint that turns evenly along the path, with noise, the rate errs by less than a
    /// tenth of what the roughest model errs by (its steady state, `v sqrt(sqrt(2) q^(3/4) r^(1/4))`
    /// with the densities q of the ground and r of the noise along the path), and no more than it
    /// states; where it begins to turn as
    /// on a bump of the wheel's size, within a centimetre it follows.
    #[test]
    fn smooth_ground_gives_a_smooth_rate() {
        let noise = 1.7e-3;
        let mut angle = PathAngle::<3>::new(0.1, noise);
        let mut state = 1_u64;
        let mut random = || {
            // Twelve uniform numbers less six: a variance of one.
            (0..12).fold(-6.0, |sum, _| {
                state = state
                    .wrapping_mul(6_364_136_223_846_793_005)
                    .wrapping_add(1);
                sum + (state >> 33) as f64 / f64::from(1_u32 << 31)
            })
        };
        let (mut square, mut stated, mut count) = (0.0, 0.0, 0.0);
        let mut after = 0.0;
        for k in 0..2000 {
            let t = 5e-3 * f64::from(k);
            let bump = (t - 8.0).max(0.0);
            let truth = 0.02 * t + 0.4 * bump;
            let read = Some(truth + noise * random());
            let found = angle.update(t, read, &[Some(2.0 * t); 3]);
            let (_, rate) = found.expect("a reading");
            if (2.0..8.0).contains(&t) {
                square += (rate - 0.02) * (rate - 0.02);
                stated += angle.rate_error() * angle.rate_error();
                count += 1.0;
            }
            if k == 1670 {
                after = rate;
            }
        }
        let (error, stated): (f64, f64) = (square / count, stated / count);
        let r = noise * noise * 5e-3 * 0.2;
        let roughest = 0.2
            * (core::f64::consts::SQRT_2 * angle.bank[0].density.powf(0.75) * r.powf(0.25)).sqrt();
        assert!(error.sqrt() < 0.1 * roughest, "{error}");
        // The smoothest ground of the bank is rougher than this one.
        let ratio = (stated / error).sqrt();
        assert!((0.7..3.0).contains(&ratio), "{ratio}");
        assert!((after - 0.42).abs() < 0.1, "{after}");
    }

    /// Closed form: on a joint that turns by 1 rad/m a robot that brakes from 0.2 m/s within 0.6 s has a rate that
    /// lags by no more than its acceleration times [`PathAngle::SPEED_TIME`], and none at rest after five such
    /// times.
    #[test]
    fn the_rate_stops_with_the_robot() {
        let mut angle = PathAngle::<3>::new(0.1, 1e-3);
        let (dt, lag) = (5e-3, 0.2 / 0.6 * PathAngle::<3>::SPEED_TIME);
        let mut way = 0.0;
        for k in 0..900 {
            let t = dt * f64::from(k);
            let speed = 0.2 * (1.0 - (t - 3.0) / 0.6).clamp(0.0, 1.0);
            way += speed * dt;
            let (_, rate) = angle
                .update(t, Some(way), &[Some(way / 0.1); 3])
                .expect("a reading");
            // A tenth for the slope, which is found within a wheel radius.
            assert!(
                t < 1.0 || (rate - speed).abs() < 1.1 * lag,
                "{t}: {rate} {speed}"
            );
            assert!(t < 3.85 || rate.abs() < 0.01 * lag, "{t}: {rate}");
        }
    }

    /// Closed form: on the spot the wheels of both sides turn against each other, and the rate of a joint that turns
    /// evenly with them is that turn.
    #[test]
    fn a_turn_on_the_spot_is_a_way() {
        let mut angle = PathAngle::<6>::new(0.1, 1e-3);
        let mut last = 0.0;
        for k in 0..800 {
            let t = 5e-3 * f64::from(k);
            let turn = Some(2.0 * t);
            let back = Some(-2.0 * t);
            let wheels = [back, back, back, turn, turn, turn];
            (_, last) = angle.update(t, Some(0.1 * t), &wheels).expect("a reading");
        }
        assert!((last - 0.1).abs() < 1e-3, "{last}");
    }
}
