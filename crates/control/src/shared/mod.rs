//! Shared traction: one speed control, its torque shared so that every wheel needs the same T/N.
//!
//! With the wheel speeds `omega_i`, their reference `omega_ref`, the set speed `omega_set` and the
//! gains of one wheel:
//!
//! ```text
//! e       = p omega_set - omega_ref                          p: pace, 1 unless a wheel slides
//! tau     = 3 (Kp e + Ki I)                                  torque of all wheels
//! dI/dt   = e - (tau - sum tau_i)/(3 Ki T_t)                 anti-windup by back-calculation
//! tau_i   = B omega_i + s_i (tau - sum B omega_j)            s_i = N_i/sum N_j
//! ```
//!
//! `B omega_i` keeps a wheel turning without traction, so `T_i = s_i (tau - sum B omega_j)/r`: T/N
//! is the same for all wheels. The torque is then corrected and limited, in this order:
//!
//! - slip: a wheel whose speed along the robot, `u_i = omega_i cos(gamma_i)`, differs from the
//!   others by more than the allowed difference gets Kp times the excess against it. One that spins
//!   gets less, one that stays behind more;
//! - load: a wheel without load gets `Kp (omega_ref - omega_i)` in addition, which holds its speed;
//! - `|tau_i|` is at most the torque limit.
//!
//! `omega_ref` is the mean of the speeds, each within the allowed difference of their median: a
//! wheel that spins or stands has little influence. The reference of `u_i` is the same mean of the
//! `u_i`.
//!
//! While a wheel slides the pace falls to a quarter, and then recovers in seconds: where the
//! dynamic coefficient is below the static one, the ground bears more at a small slip speed. A
//! wheel slides where the estimate says so, or where its `u_i` differs from the others by more than
//! twice the allowed difference. That difference grows with the paced set speed.
//!
//! N_i and gamma_i are those of the estimate, smoothed; N_i is drawn to the mean load where its
//! standard deviation is large. Without an estimate, and where its readings are stale or the
//! linkage is at a stop, all shares become equal.

use crate::input::{ControlInput, ControlSettings};
use robhaz_estimator::{Estimate, Flags};
use robhaz_model::{Robot, Units};

/// Allowed difference of a wheel speed from the others: a share of the set speed, -, and a part for
/// standstill, rad/s. It leaves room for creep (5 % of the speed at T = N for a slip stiffness of
/// 20) and for the turning of the links.
const DIFFERENCE: (f64, f64) = (0.15, 0.05);
/// Pace while a wheel slides, -.
pub const CRAWL: f64 = 0.25;
/// Time constant of slowing down to it, s: ten times that of the speed control of a wheel.
pub const SLOWING_TIME: f64 = 0.2;
/// Time of recovery from it to full pace, s.
pub const RECOVERY_TIME: f64 = 3.0;
/// Smallest cos(gamma) that is counted, -: a wheel on the edge of a kerb turns on the spot.
const STEEPEST: f64 = 0.5;
/// Prior standard deviation of N, as a share of the mean load: wide, since one wheel may carry the
/// load of two.
const LOAD_SPREAD: f64 = 0.5;
/// Share of the mean load below which a wheel counts as unloaded, -; without load it counts fully.
const UNLOADED: f64 = 0.1;
/// Time constant of the shares, s: 10 mm of travel at 0.2 m/s.
const SHARE_TIME: f64 = 0.05;
/// Longest time between samples that is integrated over, s.
const LONGEST_STEP: f64 = 0.1;

/// Time by which the control of a wheel's speed lags behind, s, at a rate of the samples (Hz): the
/// filter of the speed, one sample until a command acts, half of one because it is held.
pub fn lag(rate: f64) -> f64 {
    WheelSpeed::TIME_CONSTANT + 1.5 / rate
}

/// Largest Kp of one wheel, N m s, at a rate of the samples (Hz): 0.7 J/lag. A wheel in the air, of
/// inertia J, then has a phase margin of at least 90 deg - 0.7 rad = 50 deg without the integral.
pub fn largest_proportional_gain(robot: &Robot, rate: f64) -> f64 {
    0.7 * (robot.mass.wheel_inertia + robot.mass.rotor_inertia) / lag(rate)
}

/// Largest Ki/Kp, 1/s, at a rate of the samples (Hz): at the largest Kp the integral takes
/// atan(0.25/0.7) = 20 deg of the phase margin.
pub fn largest_integral_ratio(rate: f64) -> f64 {
    0.25 / lag(rate)
}

/// The control with its state from sample to sample.
#[derive(Clone, Debug)]
pub struct Shared {
    settings: ControlSettings,
    mean_load: f64,
    speeds: [WheelSpeed; 3],
    /// Smoothed normal forces that decide the shares, N.
    loads: [f64; 3],
    /// Smoothed cosines of the contact angles, -.
    cosines: [f64; 3],
    /// Share of the set speed, -.
    pace: f64,
    /// Unit of time of the robot, s: the times of this control are those of robot A.
    unit: f64,
    /// Integral of the speed error, rad; `None` before the first sample.
    integral: Option<f64>,
    /// Time of the last sample, s.
    time: f64,
    /// The last finite set speed, rad/s.
    set_speed: f64,
}

impl Shared {
    /// The control before its first sample.
    pub fn new(settings: &ControlSettings) -> Self {
        let mean_load = settings.robot.mean_wheel_load();
        Self {
            settings: settings.clone(),
            mean_load,
            speeds: Default::default(),
            loads: [mean_load; 3],
            cosines: [1.0; 3],
            pace: 1.0,
            unit: Units::of(&settings.robot).time,
            integral: None,
            time: 0.0,
            set_speed: 0.0,
        }
    }

    /// Motor torques of front, middle and rear wheel, N m.
    pub fn update(&mut self, input: &ControlInput<'_>) -> [f64; 3] {
        let (input, frame) = (input.holding(&mut self.set_speed), input.frame);
        let dt = match self.integral {
            None => 0.0,
            Some(_) => (frame.time - self.time).max(0.0).min(LONGEST_STEP),
        };
        self.time = frame.time;
        let mut speeds = [0.0; 3];
        for i in 0..3 {
            speeds[i] = self.speeds[i].update(frame.time, frame.wheel_angle[i]);
        }
        self.update_loads(input.estimate, dt / self.unit);
        let allowed = DIFFERENCE.0 * self.pace * input.set_speed.abs() + DIFFERENCE.1 / self.unit;
        let motion = self.motion(speeds, allowed);
        let slides = slides(input.estimate) || motion.differs(allowed);
        self.update_pace(slides, dt / self.unit);
        let error = self.pace * input.set_speed - motion.reference;
        // The first torques are those that the drives have.
        let held: f64 = input.torques().iter().flatten().sum();
        let integral = *self.integral.get_or_insert(if self.settings.ki > 0.0 {
            held / (3.0 * self.settings.ki)
        } else {
            0.0
        });
        let wanted = 3.0 * (self.settings.kp * error + self.settings.ki * integral);
        let torques = self.shared(wanted, &motion);
        if self.settings.ki > 0.0 {
            let excess = wanted - torques.iter().sum::<f64>();
            let rate = error - excess / (3.0 * self.settings.ki * self.settings.tracking_time);
            self.integral = Some(integral + dt * rate);
        }
        torques
    }

    /// Moves loads and cosines towards those of the estimate over `dt`, in units of the robot.
    fn update_loads(&mut self, estimate: Option<&Estimate>, dt: f64) {
        let trusted = estimate.filter(|e| {
            !e.flags.contains(Flags::SENSOR_STALE) && !e.flags.contains(Flags::AT_STOP)
        });
        let spread = LOAD_SPREAD * self.mean_load;
        let step = dt / (dt + SHARE_TIME);
        for i in 0..3 {
            let (load, cosine) = trusted.map_or((self.mean_load, 1.0), |estimate| {
                let sigma = estimate.sigma_normal(i).unwrap_or(0.0);
                let trust = spread * spread / (spread * spread + sigma * sigma);
                let load = self.mean_load + trust * (estimate.normal_force[i] - self.mean_load);
                (load, libm::cos(estimate.contact_angle[i]))
            });
            if load.is_finite() && cosine.is_finite() {
                self.loads[i] += (load.max(0.0) - self.loads[i]) * step;
                self.cosines[i] += (cosine.max(STEEPEST) - self.cosines[i]) * step;
            }
        }
    }

    /// Compares the wheel speeds (rad/s) with each other, for an allowed difference (rad/s).
    fn motion(&self, speeds: [f64; 3], allowed: f64) -> Motion {
        let mut along = [0.0; 3];
        for i in 0..3 {
            along[i] = speeds[i] * self.cosines[i];
        }
        let reference_along = mean_near_median(along, allowed);
        Motion {
            speeds,
            reference: mean_near_median(speeds, allowed),
            excess: along.map(|speed| beyond(speed - reference_along, allowed)),
        }
    }

    /// Slows down while a wheel slides, and recovers, over `dt`, in units of the robot.
    fn update_pace(&mut self, slides: bool, dt: f64) {
        self.pace = if slides {
            self.pace + (CRAWL - self.pace) * dt / (dt + SLOWING_TIME)
        } else {
            (self.pace + dt * (1.0 - CRAWL) / RECOVERY_TIME).min(1.0)
        };
    }

    /// The torques of the wheels, N m, for the torque of all (N m).
    fn shared(&self, wanted: f64, motion: &Motion) -> [f64; 3] {
        let losses = motion
            .speeds
            .map(|speed| self.settings.viscous_damping * speed);
        let traction = wanted - losses.iter().sum::<f64>();
        let total: f64 = self.loads.iter().sum();
        let mut torques = [0.0; 3];
        for i in 0..3 {
            let share = if total > 0.0 {
                self.loads[i] / total
            } else {
                1.0 / 3.0
            };
            let unloaded = (1.0 - self.loads[i] / (UNLOADED * self.mean_load)).max(0.0);
            let held = unloaded * (motion.reference - motion.speeds[i]);
            let torque =
                losses[i] + share * traction + self.settings.kp * (held - motion.excess[i]);
            torques[i] = torque
                .max(-self.settings.torque_limit)
                .min(self.settings.torque_limit);
        }
        torques
    }
}

/// The wheel speeds against each other.
struct Motion {
    /// rad/s
    speeds: [f64; 3],
    /// Mean near the median, rad/s.
    reference: f64,
    /// Parts of the speeds along the robot that differ from the others by more than allowed, rad/s.
    excess: [f64; 3],
}

impl Motion {
    /// Whether a wheel differs from the others by more than twice the allowed difference (rad/s).
    fn differs(&self, allowed: f64) -> bool {
        self.excess.iter().any(|excess| excess.abs() > allowed)
    }
}

/// Whether the estimate says that a wheel slides, or that the wheels spin in place.
fn slides(estimate: Option<&Estimate>) -> bool {
    estimate.is_some_and(|e| {
        let contacts = e.kalman.iter().flat_map(|k| &k.contact);
        e.flags.contains(Flags::SPINS_IN_PLACE) || contacts.into_iter().any(|c| c.sliding)
    })
}

/// The part of a value beyond +- a limit.
fn beyond(value: f64, limit: f64) -> f64 {
    value - value.max(-limit).min(limit)
}

/// Mean of the speeds, each within `allowed` of their median, rad/s.
fn mean_near_median(speeds: [f64; 3], allowed: f64) -> f64 {
    let [a, b, c] = speeds;
    let median = a.max(b).min(a.min(b).max(c));
    let near = |speed: f64| (speed - median).max(-allowed).min(allowed);
    median + (near(a) + near(b) + near(c)) / 3.0
}

/// Speed of a wheel from its encoder: differences of readings through a low-pass filter of first
/// order.
///
/// Quantisation of 160 000 counts a turn gives 1 mrad/s RMS at 1 kHz, 5 mN m at Kp = 5 N m s.
#[derive(Clone, Copy, Debug, Default)]
struct WheelSpeed {
    /// Last angle (rad) and its time (s).
    last: Option<(f64, f64)>,
    /// rad/s
    speed: f64,
}

impl WheelSpeed {
    /// Time constant of the filter, s. A wheel in the air follows its set speed with the time
    /// constant J/Kp = 19 ms for the default robot and gains.
    const TIME_CONSTANT: f64 = 5e-3;
    /// Largest plausible speed, rad/s: 20 m/s at the rim. An encoder that jumps farther was reset.
    const LARGEST: f64 = 200.0;

    /// Takes a reading (rad) at a time (s). Returns the speed, rad/s; without a reading the last
    /// one.
    pub fn update(&mut self, time: f64, angle: Option<f64>) -> f64 {
        let Some(angle) = angle.filter(|angle| angle.is_finite()) else {
            return self.speed;
        };
        if let Some((last_angle, last_time)) = self.last.replace((angle, time)) {
            let dt = time - last_time;
            let speed = (angle - last_angle) / dt;
            // Written so that a NaN fails.
            if dt > 0.0 && speed.abs() <= Self::LARGEST {
                self.speed += (speed - self.speed) * dt / (dt + Self::TIME_CONSTANT);
            }
        }
        self.speed
    }
}

#[cfg(test)]
mod tests;
