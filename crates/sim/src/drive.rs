//! The drive of a wheel: eq. (2) with separate inertias of wheel and rotor, losses in the gear, and
//! speed control; set speeds that differ from wheel to wheel for a time.

use robhaz_model::{MassSet, WheelCommand, quintic};

/// Speed control and losses of the three drives.
#[derive(Clone, Debug, PartialEq)]
pub struct Drive {
    /// Set speed of travel, m/s; the wheels' set speed is this over the wheel radius, times
    /// [`Self::scalings`].
    pub speed: f64,
    /// Proportional gain Kp, N m s.
    pub kp: f64,
    /// Integral gain Ki, N m.
    pub ki: f64,
    /// Largest motor torque at the wheel, N m.
    pub torque_limit: f64,
    /// Tracking time constant T_t of the anti-windup, s: see [`Self::controlled`].
    pub tracking_time: f64,
    /// Viscous damping B in the wheel module, N m s.
    pub viscous_damping: f64,
    /// Coulomb friction F in the gear, at the wheel, N m.
    pub gear_friction: f64,
    /// Time before the start, in which the set speed is zero, s.
    pub start_time: f64,
    /// Duration of the smooth start from rest to the set speed, and of every change by
    /// [`Self::scalings`], s.
    pub ramp_time: f64,
    /// Times in which single wheels have another set speed. Those of one wheel do not overlap.
    pub scalings: Vec<SpeedScaling>,
}

/// A time in which chosen wheels have their set speed times a factor.
///
/// The factor changes smoothly, like the set speed at the start: from 1 beginning at `from`, and
/// back to 1 beginning at `to`, each over the ramp time of the drive. In a time shorter than the
/// ramp time the factor is not reached.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpeedScaling {
    /// Whether it acts on the front, middle and rear wheel.
    pub wheels: [bool; 3],
    /// Time at which the factor begins to change from 1, s.
    pub from: f64,
    /// Time at which it begins to change back, s.
    pub to: f64,
    /// Factor, -. Zero stops the wheels, a negative one reverses them.
    pub factor: f64,
}

impl SpeedScaling {
    /// What it adds to the factor 1 at time `t` (s), -.
    pub(crate) fn change(&self, t: f64, ramp_time: f64) -> f64 {
        let share = |start: f64| quintic(1.0, ramp(t, start, ramp_time));
        (self.factor - 1.0) * (share(self.from) - share(self.to))
    }

    /// The times at which a change begins or ends, s.
    pub(crate) fn changes(&self, ramp_time: f64) -> impl Iterator<Item = f64> {
        let ends = [self.from, self.to].into_iter();
        ends.flat_map(move |end| [end, end + ramp_time])
    }
}

/// Share of a ramp of `duration` (s) that has passed at time `t` (s), 0 to 1. Without duration it
/// jumps at `start` (s).
pub(crate) fn ramp(t: f64, start: f64, duration: f64) -> f64 {
    if duration > 0.0 {
        ((t - start) / duration).clamp(0.0, 1.0)
    } else {
        f64::from(t >= start)
    }
}

/// What a drive does at one instant.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DriveResponse {
    /// Motor torque at the wheel, N m.
    pub torque: f64,
    /// Rate of the integral of the speed error, rad/s.
    pub integral_rate: f64,
}

impl Default for Drive {
    /// The PI drive: 0.20 m/s, Kp = 5 N m s, Ki = 50 N m, 10 N m, B = 0.15 N m s, no Coulomb
    /// friction, start at 0.8 s over 0.6 s.
    fn default() -> Self {
        Self {
            speed: 0.20,
            kp: 5.0,
            ki: 50.0,
            torque_limit: 10.0,
            tracking_time: 0.1,
            viscous_damping: 0.15,
            gear_friction: 0.0,
            start_time: 0.8,
            ramp_time: 0.6,
            scalings: Vec::new(),
        }
    }
}

impl Drive {
    /// Set speed of a wheel (0 front, 1 middle, 2 rear) at time `t` (s), rad/s: that of the start,
    /// times the factor of the wheel.
    pub fn set_speed(&self, wheel: usize, t: f64, wheel_radius: f64) -> f64 {
        self.start_speed(t, wheel_radius) * self.factor(wheel, t)
    }

    /// Set wheel speed without scalings at time `t` (s), rad/s: rest until the start, then a
    /// quintic ramp (no jump in acceleration).
    #[inline]
    pub(crate) fn start_speed(&self, t: f64, wheel_radius: f64) -> f64 {
        let share = ramp(t, self.start_time, self.ramp_time);
        quintic(self.speed / wheel_radius, share)
    }

    /// Factor of a wheel's set speed at time `t` (s), -.
    #[inline]
    pub(crate) fn factor(&self, wheel: usize, t: f64) -> f64 {
        let of_wheel = self.scalings.iter().filter(|s| s.wheels[wheel]);
        of_wheel.fold(1.0, |sum, s| sum + s.change(t, self.ramp_time))
    }

    /// Set speed of travel at time `t` (s), m/s: the middle one of the three wheels' speeds at the
    /// rim. The other two wheels, or one of them, keep a single wheel from deciding the robot's
    /// speed.
    pub fn travel_speed(&self, t: f64, wheel_radius: f64) -> f64 {
        let mut speeds = [0, 1, 2].map(|wheel| self.set_speed(wheel, t, wheel_radius));
        speeds.sort_by(f64::total_cmp);
        wheel_radius * speeds[1]
    }

    /// Range of the distances from its start that a robot with wheels of this radius (m) has at its
    /// set speed, without slip, within `duration` (s): the lowest and the highest one, m.
    pub fn planned_travel(&self, duration: f64, wheel_radius: f64) -> [f64; 2] {
        /// Number of steps of the trapezoidal rule. A scaling that is shorter than a step moves the
        /// robot by less than its wheel radius in any usual run.
        const STEPS: u32 = 10_000;
        if self.scalings.is_empty() {
            let time = duration - self.start_time - 0.5 * self.ramp_time;
            let travel = self.speed * time.max(0.0);
            return [travel.min(0.0), travel.max(0.0)];
        }
        let step = duration / f64::from(STEPS);
        let (mut travel, mut range) = (0.0_f64, [0.0_f64; 2]);
        for k in 0..STEPS {
            let at = |k: u32| self.travel_speed(step * f64::from(k), wheel_radius);
            travel += 0.5 * step * (at(k) + at(k + 1));
            range = [range[0].min(travel), range[1].max(travel)];
        }
        range
    }

    /// The next time after `t` (s) at which a scaling begins or ends to change a set speed, s.
    pub fn next_change(&self, t: f64) -> Option<f64> {
        let changes = self.scalings.iter().flat_map(|s| s.changes(self.ramp_time));
        changes.filter(|change| *change > t).reduce(f64::min)
    }

    /// A torque (N m) within the limit.
    #[inline]
    fn limited(&self, torque: f64) -> f64 {
        torque.max(-self.torque_limit).min(self.torque_limit)
    }

    /// Motor torque tau at the wheel, N m, within the limit, for a speed error e (rad/s) and its
    /// integral I (rad), and the rate of I with anti-windup by back-calculation:
    /// `dI/dt = e - (tau_w - tau)/(Ki T_t)`.
    ///
    /// `tau_w = Kp e + Ki I` is the torque before the limit, `tau` the torque within it, `T_t` the
    /// tracking time constant. Without saturation `dI/dt = e`. In saturation `Ki I` decays with
    /// `T_t` towards the value at which `tau_w` exceeds the limit by `Ki T_t e` only, so the motor
    /// leaves saturation when the error changes its sign. The rate is continuous where saturation
    /// starts and ends, as a solver with error control needs it. Source: K. J. Astrom and T.
    /// Hagglund, *Advanced PID Control*, ISA 2006, section 3.5.
    pub fn controlled(&self, error: f64, integral: f64) -> DriveResponse {
        let wanted = self.kp * error + self.ki * integral;
        self.tracking(error, wanted, self.limited(wanted))
    }

    fn tracking(&self, error: f64, wanted: f64, torque: f64) -> DriveResponse {
        let integral_rate = match self.ki > 0.0 {
            true => error - (wanted - torque) / (self.ki * self.tracking_time),
            false => error,
        };
        DriveResponse {
            torque,
            integral_rate,
        }
    }

    /// What a drive does under a command: `planned` is its planned set speed, `omega` the wheel
    /// speed (rad/s), `integral` that of the speed error (rad).
    ///
    /// Under a torque the integral follows it: `dI/dt = (tau - Ki I)/(Ki T_t)`, the
    /// back-calculation of [`Self::controlled`] with the commanded torque as the limit and
    /// without an error.
    #[inline]
    pub fn response(
        &self,
        command: WheelCommand,
        planned: f64,
        omega: f64,
        integral: f64,
    ) -> DriveResponse {
        let set_speed = match command {
            WheelCommand::Planned => planned,
            WheelCommand::Speed(speed) => speed,
            WheelCommand::Torque(torque) => {
                return self.tracking(0.0, self.ki * integral, self.limited(torque));
            }
        };
        self.controlled(set_speed - omega, integral)
    }

    /// Torque of viscous damping and Coulomb friction, N m: `B omega + F_g sign(omega)`, with the
    /// sign smoothed by [`coulomb_sign`].
    pub fn loss_torque(&self, omega: f64) -> f64 {
        let viscous = self.viscous_damping * omega;
        if self.gear_friction > 0.0 {
            viscous + self.gear_friction * coulomb_sign(omega)
        } else {
            viscous
        }
    }

    /// Largest slope of motor torque less losses over the wheel speed, N m s:
    /// `Kp + B + F/FRICTION_SPEED`.
    pub fn slope(&self) -> f64 {
        // All fields: the step limits of `rapier` follow from this slope.
        let Self {
            kp,
            viscous_damping,
            gear_friction,
            // Slower: `largest_integral_gain`.
            ki: _,
            tracking_time: _,
            // They have no slope over the wheel speed.
            speed: _,
            torque_limit: _,
            start_time: _,
            ramp_time: _,
            scalings: _,
        } = self;
        kp + viscous_damping + gear_friction / FRICTION_SPEED
    }
}

/// Wheel speed over which Coulomb friction changes its sign, rad/s: 1 mm/s at the rim, 0.5 % of the
/// default speed.
///
/// At standstill this law creeps instead of sticking. A smaller value would creep less but be
/// stiffer: 0.5 N m already brakes a wheel with a time constant of 1.9 ms, between the steps of
/// `rapier` (0.1 ms) and the pole of the drive (19 ms at Kp = 5 N m s).
pub const FRICTION_SPEED: f64 = 0.01;

/// Smoothed sign of a wheel speed (rad/s) in the law of Coulomb friction:
/// `tanh(omega/FRICTION_SPEED)`.
pub fn coulomb_sign(omega: f64) -> f64 {
    (omega / FRICTION_SPEED).tanh()
}

/// Angular acceleration of a wheel relative to its link, rad/s^2: eq. (2) with separate inertias of
/// wheel and rotor, solved for the spin relative to the link.
///
/// `drive` is `tau - B omega - F_g sign(omega)` (N m), `ground` is `d T` (N m),
/// `alpha_link` is counter-clockwise (rad/s^2).
pub fn wheel_acceleration(drive: f64, ground: f64, alpha_link: f64, mass: &MassSet) -> f64 {
    let (wheel, rotor) = (mass.wheel_inertia, mass.rotor_inertia);
    (drive - ground + wheel * alpha_link) / (wheel + rotor)
}

#[cfg(test)]
mod tests;
