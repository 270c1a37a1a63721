//! Angles and rates of links 1 and 2 from an inertial sensor in the body and the angle of pin Q, as
//! rovers have them.

use crate::{Geometry, Posture, Suspension, sqrt};

/// Readings of one sample; `None` where one is missing.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BodyReading {
    /// Turn of the body from the nominal pose, rad, nose up positive.
    pub inclination: Option<f64>,
    /// Angular rate of the body, rad/s, nose up positive.
    pub rate: Option<f64>,
    /// Angle theta_1 - theta_2 of pin Q from the nominal pose, rad.
    pub pin: Option<f64>,
    /// Turns of the wheels relative to their links, rad.
    pub wheels: [Option<f64>; 3],
}

/// What the sensors on links 1 and 2 would read.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LinkReadings {
    /// Turns from the nominal pose, rad, counter-clockwise.
    pub inclination: [Option<f64>; 2],
    /// Angular rates, rad/s, counter-clockwise.
    pub rate: [Option<f64>; 2],
}

/// The angle of pin Q gives the shape of the linkage, and with it the angle of each link against
/// the body. Its rate is its slope along the path times the speed of the wheels. The slope is that
/// of a Kalman filter with the states angle and slope, whose derivative along the path is white
/// noise of a density that follows from the wheels: so a robot at rest has no rate, and a slow one
/// a small error of it.
#[derive(Clone, Debug, PartialEq)]
pub struct BodyMount {
    geometry: Geometry,
    /// Standard deviation of a reading of the pin, rad.
    noise: f64,
    /// Density of the second derivative of the pin's angle along the path, rad^2/m^3.
    density: f64,
    /// Time (s) and turn (rad) of the last reading of each wheel.
    turns: [Option<(f64, f64)>; 3],
    /// Speed of each wheel between its last two readings, m/s.
    rolled: [Option<f64>; 3],
    /// Way since the last reading of the pin, m.
    way: f64,
    /// Time of the last sample, s.
    time: Option<f64>,
    /// Speed of the wheels, low-pass filtered, m/s.
    speed: f64,
    /// Angle (rad) and slope (rad/m) of the pin and their covariance at its last good reading.
    pin: Option<([f64; 2], [f64; 3])>,
    /// Time of the last good reading of the pin, s.
    read: f64,
    /// Innovation of the last reading of the pin, rad, if it was left out as a jump.
    jumped: Option<f64>,
    /// Whether a reading of the pin that jumps counts, too.
    keeps_jumps: bool,
}

impl BodyMount {
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

    /// For a robot, and readings of the pin with white noise (rad a sample).
    pub fn new(geometry: &Geometry, noise: f64) -> Self {
        let size = geometry.wheel_radius / 0.1;
        Self {
            // Ground is as rough as the wheels are large.
            density: Self::CURVATURE * Self::CURVATURE / (size * size * size),
            geometry: geometry.clone(),
            noise: noise.max(Self::LEAST_NOISE),
            turns: [None; 3],
            rolled: [None; 3],
            way: 0.0,
            time: None,
            speed: 0.0,
            pin: None,
            read: 0.0,
            jumped: None,
            keeps_jumps: false,
        }
    }

    /// The same, but every reading of the pin counts, also one that jumps: to look for such readings.
    #[must_use]
    pub fn keeping_jumps(self) -> Self {
        Self {
            keeps_jumps: true,
            ..self
        }
    }

    /// Standard deviation of the rate of pin Q at a `speed` (m/s), rad/s, for readings a `period`
    /// (s) apart: the steady state of the filter, `v sqrt(sqrt(2) q^(3/4) r^(1/4))` with the
    /// densities q of the ground and r of the noise along the path.
    pub fn rate_sigma(&self, speed: f64, period: f64) -> f64 {
        let (q, r) = (self.density, self.noise * self.noise * period * speed);
        let q34 = sqrt(q) * sqrt(sqrt(q));
        speed * sqrt(core::f64::consts::SQRT_2 * q34 * sqrt(sqrt(r)))
    }

    /// The readings of the links at `time`, s. Without a reading of the pin there are none but, of
    /// a bogie, those of the link that the body is fixed to; none of both where the linkage cannot
    /// close at the angle of the pin.
    ///
    /// A reading of the pin that jumps counts as missing until the next one confirms it, so that a
    /// single wrong reading changes nothing.
    pub fn links(&mut self, time: f64, reading: &BodyReading) -> LinkReadings {
        self.roll(time, &reading.wheels);
        let Some(opening) = reading.pin.filter(|angle| self.update(time, *angle)) else {
            return self.without_pin(reading);
        };
        let slope = self.pin.map_or(0.0, |([_, slope], _)| slope);
        let rate = slope * self.speed;
        let Ok(posture) = Posture::close(&self.geometry, opening, 0.0) else {
            return LinkReadings::default();
        };
        // With link 2 at rest link 1 turns as the pin, and the body with them.
        let [body, ..] = posture.rates(&self.geometry, rate, 0.0);
        let inclination = reading.inclination.map(|angle| angle - posture.body);
        let turning = reading.rate.map(|of_body| of_body - body);
        LinkReadings {
            inclination: [inclination.map(|angle| angle + opening), inclination],
            rate: [turning.map(|of_link2| of_link2 + rate), turning],
        }
    }

    fn without_pin(&self, reading: &BodyReading) -> LinkReadings {
        let mut found = LinkReadings::default();
        if let Suspension::Bogie { body } = self.geometry.suspension {
            let links = found.inclination.iter_mut().zip(&mut found.rate);
            if let Some((inclination, rate)) = links.into_iter().nth(body.index()) {
                (*inclination, *rate) = (reading.inclination, reading.rate);
            }
        }
        found
    }

    /// Way and speed by the wheels, each over the time since its own last reading: encoders may be
    /// slower than the samples, or have stamps of their own.
    fn roll(&mut self, time: f64, wheels: &[Option<f64>; 3]) {
        let dt = self.time.map_or(0.0, |last| time - last);
        self.time = Some(time);
        let radius = self.geometry.wheel_radius;
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
    fn update(&mut self, time: f64, angle: f64) -> bool {
        let r = self.noise * self.noise;
        let Some(([a, b], [paa, pab, pbb])) = self.pin else {
            self.pin = Some(([angle, 0.0], [r, 0.0, Self::LEVEL]));
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
            self.pin = Some(([angle, b], [r, 0.0, Self::LEVEL]));
            return true;
        }
        let (ka, kb) = (paa / (paa + r), pab / (paa + r));
        let state = [a + ds * b + ka * innovation, b + kb * innovation];
        let covariance = [(1.0 - ka) * paa, (1.0 - ka) * pab, pbb - kb * pab];
        self.pin = Some((state, covariance));
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Carrier;

    /// Closed form: a linkage that turns steadily along the path, seen from its body and its pin,
    /// gives the angles and rates of its links; of a four-bar through its loop, of a bogie on
    /// either link. What the start of filter and low pass leaves of the rates after 4 s is below
    /// 1e-6.
    #[test]
    fn links_are_found_from_the_body() {
        let bogie = |body| {
            let mut geometry = Geometry::b();
            geometry.make_bogie(body);
            geometry
        };
        for geometry in [Geometry::a(), bogie(Carrier::Link1), bogie(Carrier::Link2)] {
            let mut mount = BodyMount::new(&geometry, 1e-4);
            for k in 0..=4000 {
                let t = f64::from(k) * 1e-3;
                let (theta, rates) = ([0.1 + 0.03 * t, -0.05 - 0.02 * t], [0.03, -0.02]);
                let posture = Posture::close(&geometry, theta[0], theta[1]).expect("closes");
                let [body, ..] = posture.rates(&geometry, rates[0], rates[1]);
                let reading = BodyReading {
                    inclination: Some(posture.body),
                    rate: Some(body),
                    pin: Some(theta[0] - theta[1]),
                    wheels: [Some(2.0 * t); 3],
                };
                let found = mount.links(t, &reading);
                for i in 0..2 {
                    let (angle, rate) = (found.inclination[i], found.rate[i]);
                    assert!((angle.expect("a reading") - theta[i]).abs() < 1e-12);
                    let error = rate.expect("a reading") - rates[i];
                    assert!(t < 4.0 || error.abs() < 1e-6, "{error}");
                }
            }
        }
    }

    /// Equivalence: encoders at a quarter of the samples, each in frames of its own, give the rate
    /// of encoders in every sample; without the pin the link with the body keeps its readings.
    #[test]
    fn slow_encoders_give_the_same_rate() {
        let mut geometry = Geometry::b();
        geometry.make_bogie(Carrier::Link1);
        let [mut each, mut slow] = [0, 1].map(|_| BodyMount::new(&geometry, 1e-4));
        for k in 0..=4000_usize {
            let t = 1e-3 * k as f64;
            let reading = BodyReading {
                inclination: Some(0.0),
                rate: Some(0.0),
                pin: Some(0.05 * t),
                wheels: [Some(2.0 * t); 3],
            };
            let few = BodyReading {
                wheels: [0, 1, 2].map(|i| (k % 4 == i).then_some(2.0 * t)),
                ..reading
            };
            let [a, b] = [each.links(t, &reading), slow.links(t, &few)];
            let [a, b] = [a, b].map(|found| found.rate[1].expect("a reading"));
            assert!(k < 2000 || (a - b).abs() < 1e-4, "{a} {b}");
        }
        let found = slow.links(4.001, &BodyReading::default());
        assert_eq!(found, LinkReadings::default());
        let body = BodyReading {
            inclination: Some(0.1),
            ..BodyReading::default()
        };
        assert_eq!(slow.links(4.002, &body).inclination, [Some(0.1), None]);
    }

    /// Closed form: the stated deviation of the rate is the steady state of the filter, to 5 %: the
    /// way between readings is 3 % of the filter's length `(r/q)^(1/4)`.
    #[test]
    fn the_deviation_of_the_rate_is_that_of_the_filter() {
        let mut mount = BodyMount::new(&Geometry::a(), 2e-2);
        for k in 0..20_000 {
            let t = f64::from(k) * 1e-3;
            mount.roll(t, &[Some(2.0 * t); 3]);
            mount.update(t, 0.0);
        }
        let (_, [_, _, variance]) = mount.pin.expect("readings");
        let found = 0.2 * sqrt(variance);
        assert!((found / mount.rate_sigma(0.2, 1e-3) - 1.0).abs() < 0.05);
    }

    /// Equivalence: behind a single wrong reading of the pin, or of an encoder, the links are those of
    /// the readings without it. A step of the pin that stays counts from its second reading on.
    #[test]
    fn a_single_wrong_reading_changes_nothing() {
        let run = |pin: fn(u32) -> f64, wheel: fn(u32) -> f64| {
            let mut mount = BodyMount::new(&Geometry::a(), 2e-3);
            let mut links = [LinkReadings::default(); 100];
            for (k, links) in (0..).zip(&mut links) {
                let t = 1e-2 * f64::from(k);
                let reading = BodyReading {
                    inclination: Some(0.0),
                    rate: Some(0.0),
                    pin: Some(0.02 * t + pin(k)),
                    wheels: [Some(2.0 * t + wheel(k)), Some(2.0 * t), Some(2.0 * t)],
                };
                *links = mount.links(t, &reading);
            }
            links
        };
        let clean = run(|_| 0.0, |_| 0.0);
        let spike = run(|k| if k == 50 { -0.26 } else { 0.0 }, |_| 0.0);
        assert_eq!(spike[50], LinkReadings::default());
        assert_eq!(
            (&spike[..50], spike[52].inclination),
            (&clean[..50], clean[52].inclination)
        );
        for (found, expected) in spike[51..].iter().zip(&clean[51..]) {
            for (found, expected) in found.rate.iter().zip(&expected.rate) {
                let error = found.zip(*expected).map(|(a, b)| a - b).expect("rates");
                // A tenth of the rate that the pin has: one reading less.
                assert!(error.abs() < 2e-3, "{error}");
            }
        }
        let turned = run(|_| 0.0, |k| if k == 50 { 3.0 } else { 0.0 });
        assert_eq!(turned[99].inclination, clean[99].inclination);
        let step = run(|k| if k < 50 { 0.0 } else { 0.3 }, |_| 0.0);
        assert_eq!(step[50], LinkReadings::default());
        assert!(step[51].inclination.iter().all(Option::is_some));
    }

    /// Missing readings: without the pin's a four-bar has none; without the body's inclination it
    /// has rates. At rest these are 0.
    #[test]
    fn missing_readings_leave_what_they_show() {
        let mut mount = BodyMount::new(&Geometry::a(), 1e-3);
        let mut reading = BodyReading {
            inclination: Some(0.1),
            rate: Some(0.0),
            ..BodyReading::default()
        };
        assert_eq!(mount.links(0.0, &reading), LinkReadings::default());
        reading.pin = Some(0.05);
        let whole = mount.links(0.001, &reading);
        assert!(whole.inclination.iter().all(Option::is_some));
        assert_eq!(whole.rate, [Some(0.0); 2]);
        reading.inclination = None;
        let rates = mount.links(0.002, &reading);
        assert!(rates.inclination == [None; 2] && rates.rate.iter().all(Option::is_some));
    }
}
