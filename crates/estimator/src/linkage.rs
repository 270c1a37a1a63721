//! Linkage position from the inclinometers and gyros on link 1 and link 2 (Fig. 5).

use crate::kalman::Kalman;
use crate::settings::NoiseBudget;
use crate::visit::{Visit, visit_fields};

/// One link's angle from its rate gyroscope and its inclinometer: a complementary filter.
///
/// `d theta/dt = rate + (inclination - theta)/T`: the gyro is believed over times shorter than the crossover time T, the
/// inclinometer over longer ones. With exact readings the filter is exact up to the integration of the rate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LinkAngleFilter {
    crossover_time: f64,
    /// Angle and last rate.
    state: (f64, f64),
    started: bool,
}

impl LinkAngleFilter {
    /// `crossover_time` T, s, above 0.
    pub fn new(crossover_time: f64) -> Self {
        Self {
            crossover_time,
            state: (0.0, 0.0),
            started: false,
        }
    }

    /// Angle of the link, rad, after a reading `dt` seconds after the last one: `rate` in rad/s, `inclination` in rad.
    ///
    /// The first reading starts the filter at the inclinometer.
    pub fn update(&mut self, dt: f64, rate: f64, inclination: f64) -> f64 {
        let mut angle = inclination;
        if self.started {
            let (last, last_rate) = self.state;
            let predicted = last + 0.5 * (rate + last_rate) * dt;
            angle = predicted + (inclination - predicted) * dt / (self.crossover_time + dt);
        }
        self.state = (angle, rate);
        self.started = true;
        angle
    }
}

impl Visit for LinkAngleFilter {
    fn visit(&mut self, f: &mut impl FnMut(&mut f64)) {
        self.state.0.visit(f);
        self.state.1.visit(f);
        self.started.visit(f);
    }
}

/// One link's angle and its gyroscope's bias by a Kalman filter.
///
/// The gyroscope drives the angle, the inclinometer corrects it. An inclinometer feels the specific force: what is known
/// of the link's acceleration is taken off, and while the link is shaken the reading counts for less.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LinkAngleKalman {
    /// Angle (rad), bias of the gyroscope (rad/s).
    filter: Kalman<2>,
    /// Last rate without its bias, rad/s; smoothed; and its derivative, rad/s^2.
    rate: f64,
    smooth_rate: f64,
    acceleration: f64,
    /// Time since the gyroscope was last read, s.
    unread: f64,
    started: bool,
}

visit_fields!(LinkAngleKalman: filter, rate, smooth_rate, acceleration, unread, started);

impl LinkAngleKalman {
    /// Time over which the rate is smoothed for its derivative, s, with a noise of [`Self::NOISE`] a sample; with less noise less, down to
    /// the second.
    const SMOOTHING: (f64, f64) = (0.02, 0.001);
    /// Noise of a gyroscope, rad/s: 0.1 deg/s.
    const NOISE: f64 = 0.1 * core::f64::consts::PI / 180.0;
    /// Walk of the rate while no gyroscope reads it, rad/s/sqrt(s).
    const RATE_UNSEEN: f64 = 0.5;
    /// Time after which the last rate read stands for nothing, s: the walk is then as large as common rates.
    const RATE_HELD: f64 = 0.1;
    /// Time over which an error of the rate unseen lasts at most, s.
    const RATE_LASTS: f64 = 1.0;
    /// What is believed of an acceleration that is taken off: half of it may be wrong.
    const SHAKING: f64 = 0.5;
    /// Least noise of an inclinometer, rad, so that a budget of zero does not make the filter blind to its gyroscope.
    const LEAST_NOISE: f64 = 5e-4;
    /// Lag that an inclinometer may have, s: while the link turns it reads what was.
    const LAG: f64 = 0.02;

    /// A filter that waits for its first reading.
    pub fn new(budget: &NoiseBudget) -> Self {
        let tilt = libm::hypot(budget.inclination_noise, Self::LEAST_NOISE);
        Self {
            filter: Kalman::new([0.0; 2], [tilt, budget.rate_bias]),
            rate: 0.0,
            smooth_rate: 0.0,
            acceleration: 0.0,
            unread: 0.0,
            started: false,
        }
    }

    /// Whether it has had its first reading.
    pub fn started(&self) -> bool {
        self.started
    }

    /// Starts at an inclination (rad) that was read `age` seconds ago, with a rate (rad/s).
    pub fn start(&mut self, inclination: f64, age: f64, rate: f64) {
        self.started = true;
        self.filter.x[0] = inclination;
        self.rate = rate;
        self.smooth_rate = rate;
        let turned = Self::RATE_UNSEEN * age.min(Self::RATE_LASTS);
        self.filter.p[0][0] += turned * turned;
    }

    /// Goes on by `dt` (s). `rate` is the gyroscope's reading (rad/s), `inclination` the inclinometer's (rad), either `None` if
    /// it is not of this instant; `forward` the horizontal acceleration (m/s^2) that the inclinometer feels.
    pub fn update(
        &mut self,
        budget: &NoiseBudget,
        dt: f64,
        rate: Option<f64>,
        inclination: Option<f64>,
        forward: f64,
    ) {
        if !self.started {
            if let Some(angle) = inclination {
                self.start(angle, 0.0, rate.unwrap_or(0.0));
            }
            return;
        }
        let last = self.rate;
        let mut walk = budget.rate_noise * dt;
        match rate {
            Some(rate) => {
                self.rate = rate - self.filter.x[1];
                self.unread = 0.0;
            }
            None => {
                // The integral of a walk: its variance grows with the third power of the time.
                self.unread = (self.unread + dt).min(Self::RATE_LASTS);
                walk += Self::RATE_UNSEEN * self.unread * libm::sqrt(dt);
                if self.unread > Self::RATE_HELD {
                    self.rate = 0.0;
                }
            }
        }
        let Kalman { x, p } = &mut self.filter;
        x[0] += 0.5 * (self.rate + last) * dt;
        p[0][0] += dt * (dt * p[1][1] - 2.0 * p[0][1]) + walk * walk;
        p[0][1] -= dt * p[1][1];
        p[1][0] = p[0][1];
        p[1][1] += budget.rate_walk * budget.rate_walk * dt;
        if dt > 0.0 {
            let (longest, shortest) = Self::SMOOTHING;
            let smoothing = longest * (budget.rate_noise / Self::NOISE);
            let weight = dt / (smoothing.max(shortest).min(longest) + dt);
            let change = weight * (self.rate - self.smooth_rate);
            self.smooth_rate += change;
            self.acceleration += weight * (change / dt - self.acceleration);
        }
        if let Some(angle) = inclination {
            let felt = if budget.specific_force {
                forward / robhaz_model::GRAVITY
            } else {
                0.0
            };
            let noise = libm::hypot(budget.inclination_noise, Self::LEAST_NOISE);
            let shaken = Self::SHAKING * felt;
            let late = Self::LAG * self.smooth_rate;
            let r = noise * noise + shaken * shaken + late * late;
            let difference = angle - felt - self.filter.x[0];
            self.filter
                .update(&[(0, 1.0)], difference, r, f64::INFINITY);
        }
    }

    /// Angle, rad.
    pub fn angle(&self) -> f64 {
        self.filter.x[0]
    }

    /// Standard deviation of the angle, rad: the filter's, and the inclinometer's bias, which nothing tells.
    pub fn angle_sigma(&self, budget: &NoiseBudget) -> f64 {
        libm::hypot(
            libm::sqrt(self.filter.p[0][0].max(0.0)),
            budget.inclination_bias,
        )
    }

    /// Angular rate, rad/s.
    pub fn rate(&self) -> f64 {
        self.rate
    }

    /// Smoothed angular rate (rad/s) and its derivative (rad/s^2).
    pub fn turning(&self) -> (f64, f64) {
        (self.smooth_rate, self.acceleration)
    }

    /// Bias of the gyroscope and its standard deviation, rad/s.
    pub fn rate_bias(&self) -> (f64, f64) {
        (self.filter.x[1], libm::sqrt(self.filter.p[1][1].max(0.0)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::Random;

    /// Closed form: a biased gyro leaves an offset of bias times crossover time.
    #[test]
    fn a_gyro_bias_leaves_bias_times_crossover_time() {
        let mut filter = LinkAngleFilter::new(0.5);
        let mut angle = 0.0;
        for _ in 0..20_000 {
            angle = filter.update(1e-3, 0.02, 0.1);
        }
        assert!((angle - (0.1 + 0.02 * 0.5)).abs() < 1e-9, "{angle}");
    }

    /// Exact readings of a swinging link: the error is that of the trapezoidal rule, (w dt)^2/12 of the amplitude, at most.
    #[test]
    fn exact_readings_give_the_exact_angle() {
        let mut filter = LinkAngleFilter::new(0.5);
        let (dt, w, a) = (1e-3, 6.0, 0.3);
        for k in 0..5000 {
            let t = dt * f64::from(k);
            let truth = a * libm::sin(w * t);
            let angle = filter.update(dt, a * w * libm::cos(w * t), truth);
            assert!((angle - truth).abs() < a * (w * dt) * (w * dt) / 6.0);
        }
    }

    /// A budget with a gyroscope whose bias is unknown.
    fn biased() -> NoiseBudget {
        NoiseBudget {
            rate_bias: 0.02,
            ..NoiseBudget::typical()
        }
    }

    /// Readings with a constant gyro bias and the budget's white noises: angle and bias are found, and errors are within
    /// four of the standard deviations stated. The bias takes sqrt(3) sigma/(t^1.5 sqrt(rate)) to be known from the
    /// inclinometer: 1e-5 rad/s after 10 s.
    #[test]
    fn a_gyro_bias_is_found() {
        let (budget, bias, dt) = (biased(), 0.013, 1e-3);
        let mut filter = LinkAngleKalman::new(&budget);
        let mut random = Random::new();
        for k in 0..10_000 {
            let t = dt * f64::from(k);
            let (angle, rate) = (0.2 * libm::sin(t), 0.2 * libm::cos(t));
            let read_rate = rate + bias + budget.rate_noise * random.normal();
            let read_angle = angle + budget.inclination_noise * random.normal();
            filter.update(&budget, dt, Some(read_rate), Some(read_angle), 0.0);
            if k > 1000 {
                let (found, sigma) = filter.rate_bias();
                assert!(
                    (found - bias).abs() < 4.0 * sigma + 1e-4,
                    "{k}: {found} +- {sigma}"
                );
                let sigma = libm::sqrt(filter.filter.p[0][0]);
                assert!((filter.angle() - angle).abs() < 4.0 * sigma + 1e-4, "{k}");
            }
        }
        let (found, sigma) = filter.rate_bias();
        assert!(
            (found - bias).abs() < 3e-4 && sigma < 3e-4,
            "{found} +- {sigma}"
        );
    }

    /// Shaken back and forth with 2 m/s^2 at 2 Hz the inclinometer errs by 0.2 rad. Where the acceleration is told, it is taken
    /// off and counts for less, so that the angle stays; the paper's filter goes along by amplitude/(crossover time times
    /// frequency) = 0.2/(0.5 4 pi) = 0.03 rad. Of what is told wrong (0.04 rad) the settled filter, which takes in 0.96 of its
    /// difference a second, would follow with twice 0.04 0.96/(4 pi) = 6 mrad without counting it less.
    #[test]
    fn a_shaken_inclinometer_does_not_carry_the_angle_away() {
        let (budget, dt) = (NoiseBudget::typical(), 1e-3);
        let mut filter = LinkAngleKalman::new(&budget);
        let mut paper = LinkAngleFilter::new(0.5);
        for _ in 0..2000 {
            filter.update(&budget, dt, Some(0.0), Some(0.0), 0.0);
        }
        let (mut worst, mut of_paper) = (0.0_f64, 0.0_f64);
        for k in 0..5000 {
            let t = dt * f64::from(k);
            let forward = 2.0 * libm::sin(4.0 * core::f64::consts::PI * t);
            let read = forward / robhaz_model::GRAVITY;
            // An acceleration told with an error of a fifth.
            filter.update(&budget, dt, Some(0.0), Some(read), 0.8 * forward);
            worst = worst.max(filter.angle().abs());
            of_paper = of_paper.max(paper.update(dt, 0.0, read).abs());
        }
        assert!(of_paper > 0.02, "{of_paper}");
        assert!(worst < 0.5 * 0.006, "{worst}");
    }

    /// A pulse that nobody tells of (2 m/s^2 for 50 ms) moves the angle no further than its weight over 50 ms allows.
    #[test]
    fn an_untold_pulse_moves_the_angle_by_little() {
        let (budget, dt) = (NoiseBudget::typical(), 1e-3);
        let mut filter = LinkAngleKalman::new(&budget);
        for _ in 0..2000 {
            filter.update(&budget, dt, Some(0.0), Some(0.0), 0.0);
        }
        for _ in 0..50 {
            filter.update(&budget, dt, Some(0.0), Some(0.2), 0.0);
        }
        // In the steady state each reading weighs p/r = rate_noise dt/inclination_noise = 1e-3: 50 of them 5 %.
        assert!(
            filter.angle() > 0.0 && filter.angle() < 0.05 * 0.2,
            "{}",
            filter.angle()
        );
    }

    /// Without its gyroscope, and without its inclinometer, an angle is less sure from frame to frame.
    #[test]
    fn missing_readings_make_the_angle_less_sure() {
        let (budget, dt) = (NoiseBudget::typical(), 1e-3);
        let mut settled = LinkAngleKalman::new(&budget);
        for _ in 0..2000 {
            settled.update(&budget, dt, Some(0.0), Some(0.0), 0.0);
        }
        for (rate, inclination) in [(None, Some(0.0)), (Some(0.0), None), (None, None)] {
            let mut filter = settled;
            let mut last = settled.angle_sigma(&budget);
            for _ in 0..10 {
                filter.update(&budget, dt, rate, inclination, 0.0);
                let sigma = filter.angle_sigma(&budget);
                assert!(sigma > last, "{rate:?} {inclination:?}: {sigma} {last}");
                last = sigma;
            }
        }
    }
}
