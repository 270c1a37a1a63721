//! Spin and ground torque of one wheel, and what resists it.

use crate::deviation::{GATE, UNIFORM, root_sum_square};
use crate::filters::{COUNT_SIGMA, Innovation, TorqueObserver, WheelParameters, smoothing_time};
use crate::frame::{Held, Inputs, LONGEST_GAP};
use crate::nominal::Nominal;
use crate::resistance::Resistance;
use crate::settings::NoiseBudget;
use crate::statics::Traction;
use robhaz_model::GRAVITY;

/// The observer of one wheel, with what it hands from sample to sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Wheel {
    pub observer: TorqueObserver,
    /// Last torque reading, N m.
    torque: f64,
    /// Spin speed, rad/s.
    speed: f64,
    /// Mean of the spin speed, rad/s.
    mean_speed: f64,
    /// Smoothed sign of the spin, by which friction in gears and ground resists: -1 to 1.
    pub friction_share: f64,
    /// Low-pass filtered derivative of the spin speed, rad/s^2.
    pub acceleration: f64,
    /// Whether the reading of the motor torque repeats itself to the bit: it is none.
    pub stuck: bool,
    /// Standard deviation of a motor torque that has been missing for long, N m; 0 of one that is read.
    unread: f64,
}

impl Wheel {
    /// Speed over which gear friction rises once the direction is certain, rad/s: 1 mm/s at the
    /// rim.
    /// Guard.
    const FRICTION_SPEED: f64 = 0.01;
    /// Longest time over which the speed counts that shows the direction of friction, s.
    /// Guard.
    const LONGEST_MEAN: f64 = 0.3;
    /// Errors of time stamps that are no fault of the clock, s: readings that wait for a driver.
    /// Guard; held by `tests/check/clock_faults.rs`.
    const JITTER: f64 = 0.01;
    /// Random walk of a motor torque while it is not read, N m/sqrt(s), for a second: then it may be any.
    /// Guard: half of the drive's torque within 0.1 s.
    const UNREAD_TORQUE_WALK: f64 = 5.0;

    /// A wheel at rest.
    pub fn new() -> Self {
        Self {
            observer: TorqueObserver::new(TorqueObserver::AT_REST),
            torque: 0.0,
            speed: 0.0,
            mean_speed: 0.0,
            friction_share: 0.0,
            acceleration: 0.0,
            stuck: false,
            unread: 0.0,
        }
    }

    /// The wheel may be spinning: for a start after a gap.
    pub fn reset_speed(&mut self) {
        self.observer = TorqueObserver::new(TorqueObserver::SPINNING);
    }

    /// Smoothed sign of the spin at `speed` with the standard deviation `sigma`, rad/s, by which friction acts:
    /// -1 to 1. None of it within the gate: the observed speed of a wheel at rest changes its sign
    /// at random, which must not look like a wheel that turns without friction.
    fn share_of_friction(speed: f64, sigma: f64) -> f64 {
        let uncertain = GATE * sigma;
        let certain = (speed.abs() - uncertain).max(0.0);
        let full = Self::FRICTION_SPEED * Self::FRICTION_SPEED + uncertain * uncertain;
        libm::copysign((certain / robhaz_model::sqrt(full)).min(1.0), speed)
    }

    /// Finds the share of friction by the spin speed, or by its mean over as long as the angle needs to show 1 mm/s
    /// at the rim. The noise of the speed must not count: it is that of the torque, too.
    fn follow_direction(&mut self, parameters: &WheelParameters, dt: f64) {
        let (speed, sigma) = self.observer.speed();
        let of_angle = core::f64::consts::SQRT_2 * parameters.encoder_sigma;
        let time = (GATE * of_angle / Self::FRICTION_SPEED).min(Self::LONGEST_MEAN);
        let weight = robhaz_model::low_pass_share(dt, time);
        self.mean_speed += weight * (speed - self.mean_speed);
        // What a low pass leaves of errors that are independent from sample to sample.
        let left = sigma * robhaz_model::sqrt(weight / (2.0 - weight));
        let of_mean = root_sum_square(of_angle / time, left);
        let [by_speed, by_mean] = [
            Self::share_of_friction(speed, sigma),
            Self::share_of_friction(self.mean_speed, of_mean),
        ];
        self.friction_share = if by_mean.abs() > by_speed.abs() {
            by_mean
        } else {
            by_speed
        };
    }

    /// Torque behind gears of this efficiency (N m) for one before them: driving loses what braking gains.
    /// At rest, where gears hold either way, it is that before them.
    fn behind_gears(&self, torque: f64, efficiency: f64) -> f64 {
        if !(efficiency < 1.0) {
            return torque;
        }
        let driving = self.friction_share * libm::copysign(1.0, torque);
        torque * libm::exp(driving * libm::log(efficiency))
    }

    /// Advances wheel `i` by `dt` (s) to the readings of one instant. `alpha` is the angular
    /// acceleration of the wheel's link, rad/s^2. Returns the innovation of the encoder's angle
    /// (rad), if there is one.
    pub fn update(
        &mut self,
        nominal: &Nominal,
        inputs: &Inputs,
        i: usize,
        alpha: f64,
        dt: f64,
    ) -> Option<Innovation> {
        let (torque, angle) = (&inputs.motor_torque[i], &inputs.encoder[i].angle);
        let parameters = self.parameters(nominal, torque);
        if inputs.encoder[i].new_zero {
            self.observer.started = false;
        }
        if angle.age > LONGEST_GAP {
            self.reset_speed();
        } else if dt > 0.0 {
            let mean = 0.5 * (torque.value + self.torque) + torque.late / dt;
            let behind = self.behind_gears(mean, nominal.settings.gear_efficiency);
            self.observer.predict(&parameters, dt, behind, alpha);
        }
        self.torque = torque.value;
        let age = if self.stuck { 1.0 } else { torque.age };
        let walked = || Self::UNREAD_TORQUE_WALK * robhaz_model::sqrt(age.min(1.0));
        self.unread = if age > Inputs::STALE_AFTER {
            walked()
        } else {
            0.0
        };
        let read = angle.now();
        let innovation = read.and_then(|angle| self.observer.measure(&parameters, angle));
        let speed = self.observer.speed().0;
        if dt > 0.0 && self.observer.settled() {
            let smoothing = smoothing_time(parameters.encoder_sigma / COUNT_SIGMA);
            let weight = robhaz_model::low_pass_share(dt, smoothing);
            let rate = (speed - self.speed) / dt;
            self.acceleration += weight * (rate - self.acceleration);
        }
        self.speed = speed;
        self.follow_direction(&parameters, dt);
        innovation
    }

    /// Turn of the wheel (rad, in the direction of its speed) up to an `angle` (rad) that is read
    /// `dt` (s) after the last frame, if it is more than any torque explains. Of the held reading
    /// of the motor torque only its age counts.
    ///
    /// The torque that is read, and a robot that rolls down a slope of 30 degrees, by half of g,
    /// change the speed by an acceleration a, and the angle by a dt^2/2.
    pub fn too_far(&self, nominal: &Nominal, torque: &Held, angle: f64, dt: f64) -> Option<f64> {
        let parameters = self.parameters(nominal, torque);
        let (turn, sigma) = self.observer.turn(&parameters, angle, dt)?;
        let turn = libm::copysign(1.0, self.speed) * turn;
        let inertia = parameters.wheel_inertia + parameters.rotor_inertia;
        let acceleration =
            0.5 * GRAVITY / nominal.robot.geometry.wheel_radius + self.torque.abs() / inertia;
        let explained = self.speed.abs() * (dt + Self::JITTER) + 0.5 * acceleration * dt * dt;
        (turn > explained + GATE * sigma).then_some(turn)
    }

    fn parameters(&self, nominal: &Nominal, torque: &Held) -> WheelParameters {
        let (robot, settings) = (&nominal.robot, &nominal.settings);
        let (budget, read) = (&settings.budget, torque.fresh());
        WheelParameters {
            wheel_inertia: robot.mass.wheel_inertia,
            rotor_inertia: robot.mass.rotor_inertia,
            viscous_damping: settings.viscous_damping,
            encoder_sigma: encoder_sigma(budget, self.speed),
            torque_sigma: budget.torque_noise,
            rim_speed: robot.geometry.wheel_radius * self.speed,
            unread_walk: if read { 0.0 } else { Self::UNREAD_TORQUE_WALK },
        }
    }

    /// Spin speed relative to the link, rad/s; `None` before the observer has settled.
    pub fn settled_speed(&self) -> Option<f64> {
        self.observer.settled().then_some(self.observer.speed().0)
    }

    /// The torque reading less the torque that accelerates the rotor, N m, for a damping in N m s:
    /// a smooth value, exact enough for gain errors of a few percent.
    pub fn steady_torque(&self, viscous_damping: f64) -> f64 {
        self.observer.ground_torque().0 + viscous_damping * self.speed
    }

    /// Torque of the ground, N m, and its standard deviation. The observer takes the motor torque as read:
    /// the encoder shows the difference of both torques alone.
    pub fn ground_torque(&self) -> (f64, f64) {
        let (torque, observed) = self.observer.ground_torque();
        (torque, root_sum_square(observed, self.unread))
    }

    /// Share of the sum of the resistance that this wheel has under a `load`, over the mean one, signed as
    /// its spin, -.
    pub fn resisted(&self, resistance: &Resistance, load: f64) -> f64 {
        self.friction_share * resistance.under(load)[0]
    }

    /// Traction under a `load`, over the mean one, less the `error` of the torque reading (N m). Gears and
    /// ground may bear a part of the torque of a wheel of unknown direction, and the split of the wheels'
    /// `resistance` errs: both count in the standard deviation.
    pub fn traction(
        &self,
        nominal: &Nominal,
        resistance: &Resistance,
        load: f64,
        error: f64,
    ) -> Traction {
        let (torque, observed) = self.ground_torque();
        let share = self.friction_share;
        let inverse = 1.0 / nominal.robot.geometry.wheel_radius;
        let [_, by_sum] = resistance.under(load);
        let left = share * resistance.left_under(load);
        let rests = (1.0 - share * share) * resistance.held * resistance.held;
        Traction {
            value: (torque - error) * inverse,
            observed: observed * inverse,
            lasts: self.observer.error_time(),
            resisted: robhaz_model::sqrt(left * left + rests) * inverse,
            by_offset: -inverse,
            by_resistance: -share * by_sum * inverse,
            by_gain: -self.steady_torque(nominal.settings.viscous_damping) * inverse,
        }
    }

    /// Deviations of the coefficient of rolling resistance of this wheel: what the sum of the resistance
    /// leaves, signed as the spin, and what a wheel has that rests.
    pub fn rolling_left(&self, resistance: &Resistance) -> [f64; 2] {
        let share = self.friction_share;
        let rests = robhaz_model::sqrt(1.0 - share * share);
        [resistance.left * share, resistance.at_rest * rests]
    }

    /// For tests: a wheel observed at `speed` (rad/s) under a motor torque (N m).
    #[cfg(test)]
    pub fn observed(parameters: &WheelParameters, torque: f64, speed: f64) -> Self {
        let mut wheel = Self::new();
        wheel.observer.measure(parameters, 0.0);
        for k in 1..200 {
            wheel.observer.predict(parameters, 1e-3, torque, 0.0);
            let angle = speed * 1e-3 * f64::from(k);
            wheel.observer.measure(parameters, angle);
        }
        wheel.speed = speed;
        wheel.friction_share = Self::share_of_friction(speed, 1e-4);
        wheel
    }
}

/// Standard deviation of a wheel angle, rad: the count, uniform over its width, and the time
/// stamp's error at this speed (rad/s).
fn encoder_sigma(budget: &NoiseBudget, speed: f64) -> f64 {
    /// A twentieth of a micrometre at the rim. With an exact angle the observer would not correct
    /// its other states.
    /// Guard.
    const LEAST: f64 = 5e-7;
    let exact = !(budget.encoder_counts > 0.0);
    let count = 2.0 * core::f64::consts::PI / budget.encoder_counts * UNIFORM;
    let count = if exact { 0.0 } else { count };
    root_sum_square(count.max(LEAST), speed * budget.jitter)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::filters::WheelParameters;
    use crate::testing::Random;

    /// Property: a wheel at rest has no direction, however fine its encoder and rare its readings.
    #[test]
    fn a_wheel_at_rest_has_no_direction() {
        let parameters = WheelParameters {
            wheel_inertia: 0.0009,
            rotor_inertia: 0.0029,
            viscous_damping: 0.044,
            encoder_sigma: COUNT_SIGMA,
            torque_sigma: 0.05,
            rim_speed: 0.0,
            unread_walk: 0.0,
        };
        let mut random = Random::new();
        for dt in [0.001, 0.02, 0.05] {
            let mut wheel = Wheel::new();
            for k in 0..500 {
                let torque = parameters.torque_sigma * random.normal();
                wheel.observer.predict(&parameters, dt, torque, 0.0);
                wheel.observer.measure(&parameters, 0.0);
                wheel.follow_direction(&parameters, dt);
                assert!(
                    wheel.friction_share.abs() < 1e-9,
                    "{dt} s, {k}: {}",
                    wheel.friction_share
                );
            }
        }
    }

    /// Property: the angle of a wheel with 752 counts, read at 200 Hz, shows in which direction it turns at 80 mm/s,
    /// though the speed at one sample is uncertain by a fifth. Friction then acts in full, with no share of the
    /// speed's noise.
    #[test]
    fn coarse_encoders_show_the_direction_of_friction() {
        let parameters = WheelParameters {
            wheel_inertia: 0.0009,
            rotor_inertia: 0.0029,
            viscous_damping: 0.044,
            encoder_sigma: 2.0 * core::f64::consts::PI / 752.0 * UNIFORM,
            torque_sigma: 0.05,
            rim_speed: 0.08,
            unread_walk: 0.0,
        };
        let mut random = Random::new();
        let mut wheel = Wheel::new();
        let (dt, omega) = (0.005, 0.8);
        for k in 0..2000 {
            let torque =
                parameters.viscous_damping * omega + parameters.torque_sigma * random.normal();
            wheel.observer.predict(&parameters, dt, torque, 0.0);
            let count = parameters.encoder_sigma / UNIFORM;
            let angle = libm::floor(omega * dt * f64::from(k) / count) * count;
            wheel.observer.measure(&parameters, angle);
            wheel.follow_direction(&parameters, dt);
            if k > 200 {
                assert!(wheel.friction_share > 0.95, "{k}: {}", wheel.friction_share);
            }
        }
    }
}
