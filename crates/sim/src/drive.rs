//! The drive of a wheel: eq. (2) with separate inertias of wheel and rotor, losses in the gear, and
//! speed control.

use crate::scaling::{SpeedScaling, quintic, ramp};
use robhaz_model::{MassSet, WheelCommand};

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
    /// Tracking time constant T_t of the anti-windup, s: see [`Self::integral_rate`].
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

    /// Motor torque at the wheel, N m, for a speed error `e` (rad/s) and its integral (rad), within
    /// the limit.
    pub fn torque(&self, error: f64, integral: f64) -> f64 {
        self.limited(self.kp * error + self.ki * integral)
    }

    /// A torque (N m) within the limit.
    #[inline]
    fn limited(&self, torque: f64) -> f64 {
        torque.max(-self.torque_limit).min(self.torque_limit)
    }

    /// Rate of the integral I of the error e, rad/s, with anti-windup by back-calculation:
    /// `dI/dt = e - (tau_w - tau)/(Ki T_t)`.
    ///
    /// `tau_w = Kp e + Ki I` is the torque before the limit, `tau` the torque within it, `T_t` the
    /// tracking time constant. Without saturation `dI/dt = e`. In saturation `Ki I` decays with
    /// `T_t` towards the value at which `tau_w` exceeds the limit by `Ki T_t e` only, so the motor
    /// leaves saturation when the error changes its sign. The rate is continuous where saturation
    /// starts and ends, as a solver with error control needs it. Source: K. J. Astrom and T.
    /// Hagglund, *Advanced PID Control*, ISA 2006, section 3.5.
    pub fn integral_rate(&self, error: f64, integral: f64) -> f64 {
        let wanted = self.kp * error + self.ki * integral;
        let excess = wanted - self.limited(wanted);
        if self.ki > 0.0 {
            error - excess / (self.ki * self.tracking_time)
        } else {
            error
        }
    }

    /// What a drive does under a command: `planned` is its planned set speed, `omega` the wheel
    /// speed (rad/s), `integral` that of the speed error (rad).
    ///
    /// Under a torque the integral follows it: `dI/dt = (tau - Ki I)/(Ki T_t)`, the
    /// back-calculation of [`Self::integral_rate`] with the commanded torque as the limit and
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
            WheelCommand::Torque(torque) => return self.response_to_torque(torque, integral),
        };
        let error = set_speed - omega;
        DriveResponse {
            torque: self.torque(error, integral),
            integral_rate: self.integral_rate(error, integral),
        }
    }

    fn response_to_torque(&self, torque: f64, integral: f64) -> DriveResponse {
        let torque = self.limited(torque);
        DriveResponse {
            torque,
            integral_rate: if self.ki > 0.0 {
                (torque - self.ki * integral) / (self.ki * self.tracking_time)
            } else {
                0.0
            },
        }
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
mod tests {
    use super::*;

    #[test]
    fn starts_smoothly_and_reaches_the_set_speed() {
        let drive = Drive::default();
        for wheel in 0..3 {
            assert!(drive.set_speed(wheel, 0.8, 0.1) == 0.0);
            assert!((drive.set_speed(wheel, 1.1, 0.1) - 1.0).abs() < 1e-14);
            assert!((drive.set_speed(wheel, 1.4, 0.1) - 2.0).abs() < 1e-14);
            assert!((drive.set_speed(wheel, 9.0, 0.1) - 2.0).abs() < 1e-14);
        }
    }

    /// Closed form: a scaling begins at `from`, has its factor from one ramp later to `to`, and
    /// ends one ramp after `to`; halfway through a ramp the factor is the mean. Other wheels keep
    /// the set speed. A scaling that begins where another ends leads from factor to factor.
    #[test]
    fn scalings_change_the_set_speed_of_their_wheels() {
        let scaling = |from, to, factor| SpeedScaling {
            wheels: [true, false, true],
            from,
            to,
            factor,
        };
        let drive = Drive {
            scalings: vec![scaling(6.0, 16.0, 1.5), scaling(16.0, 18.0, -1.0)],
            ..Drive::default()
        };
        for (t, factor) in [
            (5.0, 1.0),
            (6.0, 1.0),
            (6.3, 1.25),
            (6.6, 1.5),
            (16.0, 1.5),
            (16.3, 0.25),
            (16.6, -1.0),
            (18.0, -1.0),
            (18.3, 0.0),
            (18.6, 1.0),
            (30.0, 1.0),
        ] {
            for wheel in [0, 2] {
                let found = drive.set_speed(wheel, t, 0.1);
                assert!((found - 2.0 * factor).abs() < 1e-13, "{t} s: {found}");
            }
            assert!((drive.set_speed(1, t, 0.1) - 2.0).abs() < 1e-14);
            // Two of three wheels are scaled.
            assert!((drive.travel_speed(t, 0.1) - 0.2 * factor).abs() < 1e-14);
        }
        let mut changes = Vec::new();
        let mut t = 0.0;
        while let Some(next) = drive.next_change(t) {
            changes.push((next * 10.0).round());
            t = next + 1e-6;
        }
        assert_eq!(changes, [60.0, 66.0, 160.0, 166.0, 180.0, 186.0]);
    }

    /// Closed form: each ramp takes half its time from a constant speed. The trapezoidal rule on 10
    /// 000 points errs by micrometres.
    #[test]
    fn the_planned_travel_turns_with_the_set_speed() {
        let mut drive = Drive::default();
        let found = drive.planned_travel(20.0, 0.1);
        assert!(found[0] == 0.0 && (found[1] - 0.2 * 18.9).abs() < 1e-12);
        drive.scalings.push(SpeedScaling {
            wheels: [true; 3],
            from: 5.0,
            to: 30.0,
            factor: -1.0,
        });
        let [lowest, highest] = drive.planned_travel(20.0, 0.1);
        // The speed is zero in the middle of the ramp at 5 s; back at -0.2 m/s for 14.4 s from 5.6
        // s on.
        let ramp: f64 = (0..1000)
            .map(|i| drive.travel_speed(5.0 + 3e-4 * (f64::from(i) + 0.5), 0.1) * 3e-4)
            .sum();
        let top = 0.2 * 3.9 + ramp;
        assert!((highest - top).abs() < 1e-5, "{highest} {top}");
        assert!((lowest - (0.2 * 3.9 - 0.2 * 14.4)).abs() < 1e-5, "{lowest}");
    }

    /// Continuity: the set speed and its first two derivatives do not jump, as at the start: over 1
    /// us the second difference quotient changes by at most the third derivative of the quintic,
    /// 60/T^3, times 1 us.
    #[test]
    fn scalings_are_as_smooth_as_the_start() {
        let drive = Drive {
            scalings: vec![SpeedScaling {
                wheels: [true; 3],
                from: 6.0,
                to: 8.0,
                factor: 0.0,
            }],
            ..Drive::default()
        };
        let h = 1e-3;
        let second = |t: f64| {
            let at = |t: f64| drive.set_speed(0, t, 0.1);
            (at(t + h) - 2.0 * at(t) + at(t - h)) / (h * h)
        };
        let most = 2.0 * 60.0 / 0.6_f64.powi(3) * h;
        for i in 0..4000 {
            let t = 5.0 + 1e-3 * f64::from(i);
            assert!((second(t + h) - second(t)).abs() < 1.01 * most, "{t} s");
        }
    }

    /// Continuity: at the start of saturation the rate of the integral has a kink but no jump, for
    /// errors of both signs. The slopes of the rate over the error are at most 1 + Kp/(Ki T_t) = 2.
    #[test]
    fn the_integral_rate_does_not_jump_at_saturation() {
        let drive = Drive::default();
        for limit in [-10.0, 10.0] {
            for error in [-3.0, -0.1, 0.1, 3.0] {
                let integral = (limit - drive.kp * error) / drive.ki;
                let rate = |shift: f64| drive.integral_rate(error + shift, integral);
                assert!((rate(1e-9) - rate(-1e-9)).abs() <= 4e-9);
                assert!((rate(0.0) - error).abs() < 1e-12);
            }
        }
    }

    /// Closed form: with a constant error in saturation, `Ki I` approaches
    /// `limit + (Ki T_t - Kp) e` with exp(-t/T_t). With T_t = Kp/Ki this is the limit, and the
    /// motor leaves saturation when the error changes its sign.
    #[test]
    fn back_calculation_tracks_the_limit() {
        for tracking_time in [0.05, 0.1, 0.4] {
            let drive = Drive {
                tracking_time,
                ..Drive::default()
            };
            let (error, start) = (3.0, 0.1);
            let end = (10.0 + (drive.ki * tracking_time - drive.kp) * error) / drive.ki;
            let mut integral = start;
            for step in 1..=4000 {
                // Midpoint rule, 0.1 ms: third order in 1e-4/0.05.
                let half = integral + 0.5e-4 * drive.integral_rate(error, integral);
                integral += 1e-4 * drive.integral_rate(error, half);
                let expected =
                    end + (start - end) * (-1e-4 * f64::from(step) / tracking_time).exp();
                assert!((integral - expected).abs() < 1e-6, "{integral} {expected}");
            }
        }
        let drive = Drive::default();
        let at_limit = drive.torque_limit / drive.ki;
        assert!((drive.torque(1e-6, at_limit) - 10.0).abs() < 1e-12);
        assert!(drive.torque(-1e-6, at_limit) < 10.0);
    }

    /// Equivalence: without integral gain, and without saturation, the rate is the error, to the
    /// bit.
    #[test]
    fn without_saturation_the_integral_is_that_of_the_error() {
        let soft = Drive {
            ki: 0.0,
            ..Drive::default()
        };
        assert_eq!(soft.integral_rate(3.0, 0.0).to_bits(), 3.0_f64.to_bits());
        let rate = Drive::default().integral_rate(0.3, 0.1);
        assert_eq!(rate.to_bits(), 0.3_f64.to_bits());
    }

    /// Equivalence and closed form: planned and commanded set speeds give the bits of the PI
    /// control; under a torque the integral approaches tau/Ki with exp(-t/T_t), so that a set speed
    /// at the wheel's speed then begins at this torque.
    #[test]
    fn commands_reach_the_drive() {
        let drive = Drive::default();
        let planned = drive.response(WheelCommand::Planned, 2.0, 1.7, 0.01);
        let speed = drive.response(WheelCommand::Speed(2.0), 9.0, 1.7, 0.01);
        assert_eq!(planned, speed);
        assert_eq!(
            planned.torque.to_bits(),
            drive.torque(2.0 - 1.7, 0.01).to_bits()
        );
        let mut integral = 0.02;
        for step in 1..=4000 {
            let rate = |i: f64| drive.response(WheelCommand::Torque(3.0), 2.0, 1.7, i);
            assert!((rate(integral).torque - 3.0).abs() < 1e-15);
            let half = integral + 0.5e-4 * rate(integral).integral_rate;
            integral += 1e-4 * rate(half).integral_rate;
            let expected = 0.06 - 0.04 * (-1e-4 * f64::from(step) / drive.tracking_time).exp();
            // Midpoint rule: (1e-4/0.1)^2 of the change.
            assert!((integral - expected).abs() < 1e-7, "{integral} {expected}");
        }
        let left = drive.ki * 0.04 * (-0.4 / drive.tracking_time).exp();
        assert!((drive.torque(0.0, integral) - (3.0 - left)).abs() < 1e-5);
        let beyond = drive.response(WheelCommand::Torque(-99.0), 2.0, 1.7, 0.0);
        assert!((beyond.torque + drive.torque_limit).abs() < 1e-15);
    }

    /// Speed of a free wheel with 0.5 N m of gear friction and no damping, after `steps` steps of
    /// `dt` (s) from 2 rad/s, by the classical Runge-Kutta method, rad/s.
    fn slowed_down(dt: f64, steps: u32) -> f64 {
        let drive = Drive {
            viscous_damping: 0.0,
            gear_friction: 0.5,
            ..Drive::default()
        };
        let rate =
            |omega| wheel_acceleration(-drive.loss_torque(omega), 0.0, 0.0, &MassSet::caption());
        (0..steps).fold(2.0, |omega, _| {
            let a = rate(omega);
            let b = rate(omega + 0.5 * dt * a);
            let c = rate(omega + 0.5 * dt * b);
            let d = rate(omega + dt * c);
            omega + dt / 6.0 * (a + 2.0 * b + 2.0 * c + d)
        })
    }

    /// Closed form: Coulomb friction slows a free wheel down linearly, with F t/J. Until it stops
    /// the speed follows sinh(omega/w) = sinh(omega_0/w) exp(-F t/(J w)), with w = FRICTION_SPEED.
    #[test]
    fn gear_friction_slows_a_free_wheel_down_linearly() {
        let inertia = 0.0075 + 0.0864;
        for ms in [100, 200, 300, 370] {
            let expected = 2.0 - 0.5 / inertia * 1e-3 * f64::from(ms);
            let found = slowed_down(1e-4, 10 * ms);
            // Far from the change of sign: 1 - tanh is below exp(-2 * 0.02/0.01) for the last
            // milliseconds.
            assert!(
                (found - expected).abs() < 1e-4,
                "{ms} ms: {found} {expected}"
            );
        }
        for ms in [374, 376, 380, 390] {
            let time = 1e-3 * f64::from(ms);
            // ln(2 sinh(200)) is 200 to the last digit.
            let log = 2.0 / FRICTION_SPEED - 0.5 * time / (inertia * FRICTION_SPEED);
            let expected = FRICTION_SPEED * (0.5 * log.exp()).asinh();
            let found = slowed_down(1e-4, 10 * ms);
            // Fourth order: (1e-4/1.9e-3)^4 of FRICTION_SPEED.
            assert!(
                (found - expected).abs() < 1e-6,
                "{ms} ms: {found} {expected}"
            );
        }
    }

    /// Property: the losses oppose the motion in both directions, with all of F from three times
    /// FRICTION_SPEED on.
    #[test]
    fn losses_oppose_the_motion() {
        let drive = Drive {
            gear_friction: 0.5,
            ..Drive::default()
        };
        assert!(drive.loss_torque(0.0) == 0.0);
        for omega in [1e-3, 0.03, 2.0] {
            assert!((drive.loss_torque(-omega) + drive.loss_torque(omega)).abs() < 1e-15);
            let coulomb = drive.loss_torque(omega) - 0.15 * omega;
            assert!(coulomb > 0.0 && coulomb <= 0.5);
            // tanh(3) = 0.995
            assert!(omega < 0.03 || coulomb > 0.995 * 0.5);
        }
    }
}
