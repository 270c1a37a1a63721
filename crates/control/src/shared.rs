//! Shared traction: one speed control, its torque shared so that every wheel needs the same T/N.
//!
//! With the wheel speeds `omega_i`, their reference `omega_ref`, the set speed `omega_set` and the gains of one wheel:
//!
//! ```text
//! e       = omega_set - omega_ref
//! tau     = 3 (Kp e + Ki I)                                  torque of all wheels
//! dI/dt   = e - (tau - sum tau_i)/(3 Ki T_t)                 anti-windup by back-calculation
//! tau_i   = B omega_i + s_i (tau - sum B omega_j)            s_i = N_i/sum N_j
//! ```
//!
//! `B omega_i` keeps a wheel turning without traction, so `T_i = s_i (tau - sum B omega_j)/r`: T/N is the same for all
//! wheels. The torque is then corrected and limited, in this order:
//!
//! - slip: a wheel that turns faster than `omega_ref` by more than the allowed difference loses Kp times the excess, down
//!   to no torque;
//! - load: a wheel without load gets `Kp (omega_ref - omega_i)` in addition, which holds its speed;
//! - `|tau_i|` is at most the torque limit.
//!
//! `omega_ref` is the mean of the speeds, each within the allowed difference of their median: a wheel that spins or stands
//! has little influence.
//!
//! N_i is the estimated normal force, drawn to the mean load where its standard deviation is large, and smoothed. Without
//! an estimate, and where its readings are stale or the linkage is at a stop, all shares become equal.

use crate::controller::{ControlInput, ControlSettings};
use crate::wheel_speed::WheelSpeed;
use robhaz_estimator::{Estimate, Flags};

/// Allowed difference of a wheel speed from the others: a share of the set speed, -, and a part for standstill, rad/s. A
/// wheel on a slope of 40 deg turns 30 % faster than wheels on level ground.
const DIFFERENCE: (f64, f64) = (0.3, 0.1);
/// Standard deviation of N over wheels and time without any reading, as a share of the mean load: on rough ground loads
/// vary by about half.
const LOAD_SPREAD: f64 = 0.5;
/// Share of the mean load below which a wheel counts as unloaded, -; without load it counts fully.
const UNLOADED: f64 = 0.1;
/// Time constant of the shares, s: 10 mm of travel at 0.2 m/s.
const SHARE_TIME: f64 = 0.05;
/// Longest time between samples that is integrated over, s.
const LONGEST_STEP: f64 = 0.1;

/// The control with its state from sample to sample.
#[derive(Clone, Debug)]
pub struct Shared {
    kp: f64,
    ki: f64,
    torque_limit: f64,
    tracking_time: f64,
    viscous_damping: f64,
    mean_load: f64,
    speeds: [WheelSpeed; 3],
    /// Smoothed normal forces that decide the shares, N.
    loads: [f64; 3],
    /// Integral of the speed error, rad; `None` before the first sample.
    integral: Option<f64>,
    /// Time of the last sample, s.
    time: f64,
}

impl Shared {
    /// The control before its first sample.
    pub fn new(settings: &ControlSettings) -> Self {
        let mean_load = settings.robot.mean_wheel_load();
        Self {
            kp: settings.kp,
            ki: settings.ki,
            torque_limit: settings.torque_limit,
            tracking_time: settings.tracking_time,
            viscous_damping: settings.viscous_damping,
            mean_load,
            speeds: Default::default(),
            loads: [mean_load; 3],
            integral: None,
            time: 0.0,
        }
    }

    /// Motor torques of front, middle and rear wheel, N m.
    pub fn update(&mut self, input: &ControlInput<'_>) -> [f64; 3] {
        let frame = input.frame;
        let dt = match self.integral {
            None => 0.0,
            Some(_) => (frame.time - self.time).max(0.0).min(LONGEST_STEP),
        };
        self.time = frame.time;
        let mut speeds = [0.0; 3];
        for i in 0..3 {
            speeds[i] = self.speeds[i].update(frame.time, frame.wheel_angle[i]);
        }
        self.update_loads(input.estimate, dt);
        let allowed = DIFFERENCE.0 * input.set_speed.abs() + DIFFERENCE.1;
        let reference = reference(speeds, allowed);
        let error = input.set_speed - reference;
        // The first torques are those that the drives have.
        let held: f64 = frame.motor_torque.iter().flatten().sum();
        let integral = *self.integral.get_or_insert(if self.ki > 0.0 {
            held / (3.0 * self.ki)
        } else {
            0.0
        });
        let wanted = 3.0 * (self.kp * error + self.ki * integral);
        let torques = self.shared(wanted, speeds, reference, allowed);
        if self.ki > 0.0 {
            let excess = wanted - torques.iter().sum::<f64>();
            let rate = error - excess / (3.0 * self.ki * self.tracking_time);
            self.integral = Some(integral + dt * rate);
        }
        torques
    }

    /// Moves the loads towards those of the estimate over `dt` (s).
    fn update_loads(&mut self, estimate: Option<&Estimate>, dt: f64) {
        let trusted = estimate.filter(|e| {
            let bits = e.flags.bits();
            bits & (Flags::SENSOR_STALE.bits() | Flags::AT_STOP.bits()) == 0
        });
        let spread = LOAD_SPREAD * self.mean_load;
        for i in 0..3 {
            let found = trusted.map_or(self.mean_load, |estimate| {
                let sigma = estimate.sigma_normal(i).unwrap_or(0.0);
                let trust = spread * spread / (spread * spread + sigma * sigma);
                self.mean_load + trust * (estimate.normal_force[i] - self.mean_load)
            });
            if found.is_finite() {
                self.loads[i] += (found.max(0.0) - self.loads[i]) * dt / (dt + SHARE_TIME);
            }
        }
    }

    /// The torques of the wheels, N m, for the torque of all (N m), wheel speeds and their reference (rad/s), and the
    /// allowed difference (rad/s).
    fn shared(&self, wanted: f64, speeds: [f64; 3], reference: f64, allowed: f64) -> [f64; 3] {
        let losses = speeds.map(|speed| self.viscous_damping * speed);
        let traction = wanted - losses.iter().sum::<f64>();
        let total: f64 = self.loads.iter().sum();
        let mut torques = [0.0; 3];
        for i in 0..3 {
            let share = if total > 0.0 {
                self.loads[i] / total
            } else {
                1.0 / 3.0
            };
            let ahead = speeds[i] - reference;
            let torque = losses[i] + share * traction;
            let unloaded = (1.0 - self.loads[i] / (UNLOADED * self.mean_load)).max(0.0);
            let torque =
                without_slip(torque, self.kp * beyond(ahead, allowed)) - unloaded * self.kp * ahead;
            torques[i] = torque.max(-self.torque_limit).min(self.torque_limit);
        }
        torques
    }
}

/// A torque less its reduction for slip, N m. The reduction acts against the torque only, and at most to zero.
fn without_slip(torque: f64, reduction: f64) -> f64 {
    if torque > 0.0 {
        (torque - reduction.max(0.0)).max(0.0)
    } else {
        (torque - reduction.min(0.0)).min(0.0)
    }
}

/// The part of a value beyond +- a limit.
fn beyond(value: f64, limit: f64) -> f64 {
    value - value.max(-limit).min(limit)
}

/// Mean of the speeds, each within `allowed` of their median, rad/s.
fn reference(speeds: [f64; 3], allowed: f64) -> f64 {
    let [a, b, c] = speeds;
    let median = a.max(b).min(a.min(b).max(c));
    let near = |speed: f64| (speed - median).max(-allowed).min(allowed);
    median + (near(a) + near(b) + near(c)) / 3.0
}
