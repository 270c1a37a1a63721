//! Link angle by a Kalman filter of gyroscope and inclinometer.

mod inclination;

use super::kalman::{Innovation, Kalman};
use super::smoothing::smoothing_time;
use crate::common::{IMPACT_LASTS, LONGEST_BEYOND_GATE, SMOOTHING, TYPICAL};
use crate::deviation::{GATE, root_sum_square};
use crate::frame::{IMPACT, Inputs, LONGEST_GAP, LinkReading, SHORTEST_STEP};
use crate::settings::NoiseBudget;

/// Angle of one link and bias of its gyroscope.
///
/// The gyroscope drives the angle, the inclinometer corrects it. An inclinometer measures the
/// specific force: the filter subtracts the estimated acceleration of the link, and gives the
/// reading less weight while the link accelerates.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LinkAngleKalman {
    /// States [`ANGLE`] and [`BIAS`].
    filter: Kalman<2>,
    /// Angular rate: the last reading without its bias, rad/s.
    pub rate: f64,
    /// Low-pass filtered angular rate, rad/s.
    pub smooth_rate: f64,
    /// Rate over the time in which a wheel moves by [`Self::WAY`], rad/s, without lag: see
    /// [`Self::follow_ground`].
    pub ground_rate: f64,
    /// Low pass behind it, rad/s.
    followed: f64,
    /// Angular acceleration, rad/s^2: the derivative of the low-pass filtered rate.
    pub acceleration: f64,
    /// Variance of the unmodelled angular acceleration, rad^2/s^4: see
    /// [`Self::unmodelled_acceleration`].
    unmodelled: f64,
    /// Angular acceleration of a jump that is not confirmed, rad/s^2.
    unconfirmed: f64,
    /// Mean square of the angular acceleration of an impact, rad^2/s^4: see
    /// [`Self::impact_acceleration`].
    struck: f64,
    /// Expected reading of the inclinometer after its low pass, rad: angle of the link, and what
    /// its acceleration adds.
    expected: f64,
    /// Time since the gyroscope was last read, s.
    unread: f64,
    /// The same of the inclinometer.
    silent: f64,
    /// Of the last inclinations, if all were outliers.
    outliers: Option<Outliers>,
    /// What a rate that follows from the angle of a joint errs by in addition to the gyroscope's
    /// noise, rad/s.
    pub joint_noise: f64,
    /// Whether it has had its first reading.
    pub started: bool,
}

/// Inclinations that are outliers one after the other.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Outliers {
    /// Innovation of the last one, rad.
    apart: f64,
    /// For how long there have been such, s.
    time: f64,
    /// An innovation, rad, and for how long those after it have been the same, s.
    constant: (f64, f64),
}

/// Angle of the link, rad.
const ANGLE: usize = 0;
/// Bias of the gyroscope, rad/s.
const BIAS: usize = 1;

impl LinkAngleKalman {
    /// Random walk of the rate while the gyroscope is not read, rad/s/sqrt(s).
    /// Guard: rates of some tenths of rad/s within a tenth of a second.
    const UNREAD_WALK: f64 = 0.5;
    /// Least variance of an unmodelled acceleration, rad^2/s^4: of 0.01 rad/s^2, which is some
    /// hundredths of a newton of N.
    /// Guard.
    const LEAST_UNMODELLED: f64 = 1e-4;
    /// Time for which inclinations may be outliers that do not contradict the gyroscope, s: longer than any impact.
    /// Guard.
    const OUTLIERS: f64 = 0.2;
    /// Angle between inclinometer and gyroscope up to which the gyroscope is believed, rad: what an unstated lag of some
    /// tenths of a second makes of rough ground.
    /// Chosen.
    const LAGS: f64 = 0.05;
    /// Relative error of an inclinometer's lag: tolerance of a low pass.
    /// Data sheet: tolerance of the capacitors of a low pass.
    const LAG_ERROR: f64 = 0.2;

    /// A filter that waits for its first reading.
    pub fn new(budget: &NoiseBudget) -> Self {
        let noise = budget.inclinometer_noise();
        Self {
            filter: Kalman::new([0.0; 2], [noise, budget.rate_bias]),
            ..Self::default()
        }
    }

    /// Starts at an inclination (rad) that was read `age` seconds ago, with a rate (rad/s).
    pub fn start(&mut self, inclination: f64, age: f64, rate: f64) {
        self.started = true;
        self.filter.x[ANGLE] = inclination;
        self.expected = inclination;
        self.rate = rate;
        self.smooth_rate = rate;
        (self.ground_rate, self.followed) = (rate, rate);
        let turned = Self::UNREAD_WALK * age.min(LONGEST_GAP);
        self.filter.p[ANGLE][ANGLE] += turned * turned;
    }

    /// Standard deviation of a rate at one sample, rad/s.
    fn rate_noise(&self, budget: &NoiseBudget) -> f64 {
        root_sum_square(budget.rate_noise, self.joint_noise)
    }

    /// Jumps of the gyroscope: the turn (rad) that readings have shown that were left out, and the
    /// change (rad/s) of one that is left out now, over `dt` (s). It can be an impact that no reading
    /// has confirmed yet: the link's acceleration errs by it.
    pub fn jump(&mut self, budget: &NoiseBudget, turn: f64, left_out: f64, dt: f64) {
        if turn.abs() > 0.0 {
            self.filter.x[ANGLE] += turn;
            self.unread = 0.0;
        }
        let smoothing = smoothing_time(self.rate_noise(budget) / TYPICAL.rate_noise);
        self.unconfirmed = left_out / smoothing;
        self.struck *= libm::exp(-dt / IMPACT_LASTS);
        self.strike(left_out, dt);
    }

    /// The rate has changed by `change` (rad/s) within `dt` (s), as only an impact can.
    fn strike(&mut self, change: f64, dt: f64) {
        let acceleration = change / dt.max(SHORTEST_STEP);
        self.struck = self.struck.max(acceleration * acceleration);
    }

    /// Way of a wheel along the ground over which its direction hardly changes, m.
    /// Chosen.
    const WAY: f64 = 1e-3;
    /// Longest time for which the gyroscope's noise is averaged, s: that of a robot at 0.01 m/s.
    /// Chosen: with 0.5 a robot that drives at 0.02 m/s onto a kerb errs by more than it states.
    const LONGEST: f64 = 0.1;

    /// Time in which a wheel at `speed` (m/s) moves by that way, s: within it the gyroscope's noise is
    /// averaged where its rate serves for the direction of a wheel.
    pub fn ground_time(speed: f64) -> f64 {
        Self::WAY / speed.max(Self::WAY / Self::LONGEST)
    }

    /// Advances the rate of the direction of wheels, for a robot at `speed` (m/s), by `dt` (s): a low
    /// pass, whose lag the link's acceleration makes up for. The acceleration is as noisy as the rate
    /// over its own low pass: it makes up for no longer lag.
    pub fn follow_ground(&mut self, speed: f64, dt: f64) {
        let time = Self::ground_time(speed);
        self.followed -= libm::expm1(-dt / time) * (self.rate - self.followed);
        self.ground_rate = self.followed + time.min(SMOOTHING) * self.acceleration;
    }

    /// Advances a filter that has started by `dt` (s) to the readings of one instant.
    /// `force_angle`: angle between the specific force and gravity at the inclinometer, rad, as
    /// estimated, positive for a forward acceleration. Returns the innovation of the inclination
    /// (rad), if there is one.
    pub fn update(
        &mut self,
        budget: &NoiseBudget,
        dt: f64,
        readings: &LinkReading,
        force_angle: f64,
    ) -> Option<Innovation> {
        let (last, held) = (self.rate, self.unread > 0.0);
        let since = (self.silent + dt).min(f64::MAX);
        self.silent = match readings.inclination {
            Some(_) => 0.0,
            None => since,
        };
        self.predict(budget, dt, readings.rate);
        // The low-pass filtered rate takes over a change that only an impact can cause.
        let change = self.rate - last;
        let noise = GATE * core::f64::consts::SQRT_2 * self.rate_noise(budget);
        if !held && readings.rate.is_some() && change.abs() > noise.max(IMPACT * dt) {
            self.smooth_rate += change;
            self.followed += change;
            self.strike(change, dt);
        }
        self.smooth(budget, dt);
        let expected = budget.specific_force;
        let force_angle = if expected { force_angle } else { 0.0 };
        self.expect(budget, dt, force_angle);
        let inclination = readings.inclination?;
        let innovation = self.correct(budget, inclination, force_angle);
        self.compare(&innovation, since);
        Some(innovation)
    }

    /// Notes for how long the inclinometer has contradicted the gyroscope, by an innovation `since` (s) the last one. One of
    /// both is wrong, and the gate keeps the angle with the gyroscope: it errs by as much as they are apart.
    fn compare(&mut self, innovation: &Innovation, since: f64) {
        if innovation.nis() <= GATE * GATE {
            self.outliers = None;
            return;
        }
        let Outliers { time, constant, .. } = self.outliers.unwrap_or(Outliers {
            apart: innovation.value,
            time: -since,
            constant: (innovation.value, -since),
        });
        let (before, lasts) = constant;
        let changed = innovation.value - before;
        let is_same = changed * changed < GATE * GATE * innovation.variance;
        self.outliers = Some(Outliers {
            apart: innovation.value,
            time: time + since,
            constant: if is_same {
                (before, lasts + since)
            } else {
                (innovation.value, 0.0)
            },
        });
    }

    /// Whether the inclinometer has contradicted the gyroscope for longer than outliers last.
    pub(crate) fn contradicts(&self) -> bool {
        self.apart().abs() > 0.0
    }

    /// Angle by the inclinometer less that by the gyroscope then, rad; 0 else.
    pub(crate) fn apart(&self) -> f64 {
        let contradiction = self
            .outliers
            .filter(|outliers| outliers.time > Self::OUTLIERS);
        contradiction.map_or(0.0, |outliers| outliers.apart)
    }

    /// Passes the inclinometer's expected reading, with its `force_angle` from gravity (rad)
    /// included, through its low pass.
    fn expect(&mut self, budget: &NoiseBudget, dt: f64, force_angle: f64) {
        let now = self.filter.x[ANGLE] + force_angle;
        let lag = budget.inclination_lag;
        let follow = || -libm::expm1(-dt / lag);
        let weight = if lag > 0.0 { follow() } else { 1.0 };
        self.expected += weight * (now - self.expected);
    }

    /// Integrates the rate over `dt` (s) by the trapezoidal rule.
    fn predict(&mut self, budget: &NoiseBudget, dt: f64, rate: Option<f64>) {
        let last = self.rate;
        let mut walk = self.rate_noise(budget) * dt;
        match rate {
            Some(rate) => {
                self.rate = rate - self.filter.x[BIAS];
                self.unread = 0.0;
            }
            None => {
                // The integral of a walk: its variance grows with the third power of the time.
                self.unread = (self.unread + dt).min(LONGEST_GAP);
                walk += Self::UNREAD_WALK * self.unread * robhaz_model::sqrt(dt);
                if self.unread > Inputs::STALE_AFTER {
                    // Without an inclinometer that corrects it, it is soon that of a link at rest.
                    self.rate *= libm::exp(-dt / LONGEST_GAP);
                }
            }
        }
        let Kalman { x, p } = &mut self.filter;
        x[ANGLE] += 0.5 * (self.rate + last) * dt;
        p[ANGLE][ANGLE] += dt * (dt * p[BIAS][BIAS] - 2.0 * p[ANGLE][BIAS]) + walk * walk;
        p[ANGLE][BIAS] -= dt * p[BIAS][BIAS];
        p[BIAS][ANGLE] = p[ANGLE][BIAS];
        p[BIAS][BIAS] += budget.rate_walk * budget.rate_walk * dt;
    }

    /// Low-pass filtered rate and its derivative, and what they miss.
    fn smooth(&mut self, budget: &NoiseBudget, dt: f64) {
        if dt > 0.0 {
            let noise = self.rate_noise(budget);
            let smoothing = smoothing_time(noise / TYPICAL.rate_noise);
            let ahead = self.rate - self.smooth_rate - smoothing * self.acceleration;
            let of_jump = if ahead.abs() > GATE * noise {
                ahead * ahead / (smoothing * smoothing)
            } else {
                0.0
            };
            let weight = robhaz_model::low_pass_share(dt, smoothing);
            let unmodelled = of_jump.max((1.0 - weight) * self.unmodelled);
            let counts = unmodelled > Self::LEAST_UNMODELLED;
            self.unmodelled = if counts { unmodelled } else { 0.0 };
            let change = weight * (self.rate - self.smooth_rate);
            self.smooth_rate += change;
            self.acceleration += weight * (change / dt - self.acceleration);
        }
    }

    /// Standard deviation of the inclinometer's reading from the error of its lag while the link
    /// turns, rad.
    pub(crate) fn late(&self, budget: &NoiseBudget) -> f64 {
        Self::LAG_ERROR * budget.inclination_lag * self.smooth_rate.abs()
    }

    /// Angle, rad.
    pub fn angle(&self) -> f64 {
        self.filter.x[ANGLE]
    }

    /// Standard deviation of the angle, rad: the filter's, and the bias of the inclinometer, which
    /// is not observable.
    pub fn angle_sigma(&self, budget: &NoiseBudget) -> f64 {
        root_sum_square(self.settled_sigma(), budget.inclination_bias)
    }

    /// Standard deviation of the angle against the mean of the inclinometer's readings, rad,
    /// without its bias.
    pub(crate) fn settled_sigma(&self) -> f64 {
        root_sum_square(self.filter.estimated(ANGLE).1, self.apart())
    }

    /// Whether the angle is hardly known: no reading has shown it for a while.
    pub(crate) fn is_uncertain(&self) -> bool {
        /// Half a degree: errors of the angle that move N by a hundredth.
        /// Guard.
        const UNCERTAIN: f64 = 8.7e-3;
        self.settled_sigma() > UNCERTAIN
    }

    /// Whether the angle is no longer to be believed: hardly known for so long that what the filters have found meanwhile
    /// is wrong; or off its inclinometer by the same angle for a second. Then the gyroscope has erred, and turns with the
    /// inclinometer again. One that still errs moves the angle on, and an inclinometer with the wrong sign changes with
    /// the ground.
    pub(crate) fn is_lost(&self) -> bool {
        let silent = self.silent > LONGEST_GAP && self.is_uncertain();
        let off = self.outliers.is_some_and(|outliers| {
            let (_, lasts) = outliers.constant;
            lasts > LONGEST_BEYOND_GATE && outliers.apart.abs() > Self::LAGS
        });
        silent || off
    }

    /// Standard deviation of the error of [`Self::acceleration`] while the link turns to and fro,
    /// rad/s^2; zero while nothing but noise parts the rate from its low pass.
    ///
    /// At a constant acceleration a low pass of time constant s lags by s times the acceleration. A
    /// rate that is farther ahead, by d, has changed within s, and the derivative of the low pass
    /// errs by d/s. It holds for s, since a link that turns to and fro crosses its low pass.
    pub fn unmodelled_acceleration(&self) -> f64 {
        let jump = self.unconfirmed * self.unconfirmed;
        robhaz_model::sqrt(self.unmodelled.max(jump))
    }

    /// Standard deviation of the same within an impact, rad/s^2, which changes the rate between two
    /// readings; it decays within [`IMPACT_LASTS`].
    pub fn impact_acceleration(&self) -> f64 {
        robhaz_model::sqrt(self.struck)
    }

    /// Standard deviation of the constant error of the rate, rad/s: the gyroscope's bias, and all of a
    /// rate that has been missing for long.
    pub fn rate_bias_sigma(&self) -> f64 {
        let missing = self.unread > Inputs::STALE_AFTER;
        let walked = || Self::UNREAD_WALK * robhaz_model::sqrt(self.unread);
        root_sum_square(self.rate_bias().1, if missing { walked() } else { 0.0 })
    }

    /// Bias of the gyroscope and its standard deviation, rad/s.
    pub fn rate_bias(&self) -> (f64, f64) {
        self.filter.estimated(BIAS)
    }
}

#[cfg(test)]
mod tests;
