//! The drive in the wheel: eq. (2) with its inertias told apart, losses in the gear, and the speed control.

use robhaz_model::Robot;

/// Speed control and losses of the three drives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drive {
    /// Set speed of travel, m/s; the wheels' set speed is this over the wheel radius.
    pub speed: f64,
    /// Proportional gain Kp, N m s.
    pub kp: f64,
    /// Integral gain Ki, N m.
    pub ki: f64,
    /// Greatest motor torque at the wheel, N m.
    pub torque_limit: f64,
    /// Viscous damping B in the wheel module, N m s.
    pub viscous_damping: f64,
    /// Coulomb friction F in the gear, at the wheel, N m.
    pub gear_friction: f64,
    /// Time of rest before the start, s.
    pub start_time: f64,
    /// Duration of the smooth start from rest to the set speed, s.
    pub ramp_time: f64,
}

impl Default for Drive {
    /// The PI drive: 0.20 m/s, Kp = 5 N m s, Ki = 50 N m, 10 N m, B = 0.15 N m s, no Coulomb friction, start at
    /// 0.8 s over 0.6 s.
    fn default() -> Self {
        Self {
            speed: 0.20,
            kp: 5.0,
            ki: 50.0,
            torque_limit: 10.0,
            viscous_damping: 0.15,
            gear_friction: 0.0,
            start_time: 0.8,
            ramp_time: 0.6,
        }
    }
}

impl Drive {
    /// Set wheel speed at time `t`, rad/s: rest until the start, then a quintic ramp (no jump in acceleration).
    pub fn set_speed(&self, t: f64, wheel_radius: f64) -> f64 {
        let u = if self.ramp_time > 0.0 {
            ((t - self.start_time) / self.ramp_time).clamp(0.0, 1.0)
        } else {
            f64::from(t >= self.start_time)
        };
        self.speed / wheel_radius * u * u * u * (10.0 + u * (-15.0 + 6.0 * u))
    }

    /// Motor torque at the wheel, N m, for a speed error `e` (rad/s) and its integral (rad), within the limit.
    pub fn torque(&self, error: f64, integral: f64) -> f64 {
        (self.kp * error + self.ki * integral).clamp(-self.torque_limit, self.torque_limit)
    }

    /// Rate of the integral of the error, rad/s: the error, or 0 while it would drive a saturated motor further.
    pub fn integral_rate(&self, error: f64, integral: f64) -> f64 {
        let wanted = self.kp * error + self.ki * integral;
        if wanted.abs() > self.torque_limit && wanted * error > 0.0 {
            0.0
        } else {
            error
        }
    }

    /// What viscous damping and Coulomb friction take of the motor torque, N m: `B omega + F sign(omega)`, the sign
    /// smoothed by [`coulomb_sign`].
    pub fn loss_torque(&self, omega: f64) -> f64 {
        self.viscous_damping * omega + self.gear_friction * coulomb_sign(omega)
    }

    /// Longest step, s, at which an explicit gear friction is stable: near standstill it brakes with `F/FRICTION_SPEED`
    /// against the inertia of wheel and rotor, and an explicit step must stay below twice the time constant. 3.8 ms for
    /// 0.5 N m in the default robot.
    pub fn longest_step(&self, robot: &Robot) -> f64 {
        let inertia = robot.mass.wheel_inertia + robot.mass.rotor_inertia;
        2.0 * inertia * FRICTION_SPEED / self.gear_friction
    }
}

/// Wheel speed over which Coulomb friction changes its sign, rad/s: 1 mm/s at the rim, half a per cent of the usual speed.
///
/// Shorter would say more of standstill, where this law creeps instead of sticking, but be stiffer: 0.5 N m already
/// brakes a wheel in 1.9 ms, between the steps of `rapier` (0.1 ms) and the drive's own pole (19 ms at Kp = 5 N m s).
pub const FRICTION_SPEED: f64 = 0.01;

/// Sign of a wheel speed (rad/s) as Coulomb friction sees it, smooth near zero: `tanh(omega/FRICTION_SPEED)`.
pub fn coulomb_sign(omega: f64) -> f64 {
    (omega / FRICTION_SPEED).tanh()
}

/// Angular acceleration of a wheel relative to its link, rad/s^2: eq. (2) with the inertias told apart,
/// `J_wheel (domega/dt - alpha_link) + J_rotor domega/dt = tau - B omega - F sign(omega) - d T`.
///
/// `drive_torque` is `tau - B omega - F sign(omega)` (N m), `ground_torque` is `d T` (N m), `alpha_link` is counter-clockwise (rad/s^2).
pub fn wheel_acceleration(
    drive_torque: f64,
    ground_torque: f64,
    alpha_link: f64,
    wheel_inertia: f64,
    rotor_inertia: f64,
) -> f64 {
    (drive_torque - ground_torque + wheel_inertia * alpha_link) / (wheel_inertia + rotor_inertia)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn starts_smoothly_and_reaches_the_set_speed() {
        let drive = Drive::default();
        assert!(drive.set_speed(0.8, 0.1) == 0.0);
        assert!((drive.set_speed(1.1, 0.1) - 1.0).abs() < 1e-14);
        assert!((drive.set_speed(1.4, 0.1) - 2.0).abs() < 1e-14);
        assert!((drive.set_speed(9.0, 0.1) - 2.0).abs() < 1e-14);
    }

    #[test]
    fn integral_stands_still_in_saturation_and_leaves_it() {
        let drive = Drive::default();
        assert!((drive.torque(3.0, 0.0) - 10.0).abs() < 1e-15);
        assert!(drive.integral_rate(3.0, 0.0) == 0.0);
        assert!((drive.integral_rate(-0.1, 0.5) + 0.1).abs() < 1e-15);
    }

    /// A free wheel with 0.5 N m of gear friction and no damping, from 2 rad/s on, after `steps` steps of `dt` by the classical
    /// Runge-Kutta method, rad/s.
    fn slowed_down(dt: f64, steps: u32) -> f64 {
        let drive = Drive {
            viscous_damping: 0.0,
            gear_friction: 0.5,
            ..Drive::default()
        };
        let rate = |omega| wheel_acceleration(-drive.loss_torque(omega), 0.0, 0.0, 0.0075, 0.0864);
        (0..steps).fold(2.0, |omega, _| {
            let a = rate(omega);
            let b = rate(omega + 0.5 * dt * a);
            let c = rate(omega + 0.5 * dt * b);
            let d = rate(omega + dt * c);
            omega + dt / 6.0 * (a + 2.0 * b + 2.0 * c + d)
        })
    }

    /// Closed form: Coulomb friction slows a free wheel down linearly, F t/J; to the end it is
    /// sinh(omega/w) = sinh(omega_0/w) exp(-F t/(J w)), w the speed of the sign's change.
    #[test]
    fn gear_friction_slows_a_free_wheel_down_linearly() {
        let inertia = 0.0075 + 0.0864;
        for ms in [100, 200, 300, 370] {
            let expected = 2.0 - 0.5 / inertia * 1e-3 * f64::from(ms);
            let found = slowed_down(1e-4, 10 * ms);
            // Far from the sign's change: 1 - tanh is below exp(-2 * 0.02/0.01) of F for the last milliseconds.
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
            // Fourth order: (1e-4/1.9e-3)^4 of the speed of the change.
            assert!(
                (found - expected).abs() < 1e-6,
                "{ms} ms: {found} {expected}"
            );
        }
    }

    /// Friction brakes in both directions alike, fully from three times the speed of the sign's change on, and B is its own.
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

    /// An explicit step below the longest one comes to rest, one above it does not.
    #[test]
    fn the_longest_step_is_the_limit_of_stability() {
        let robot = Robot::default_a();
        let drive = Drive {
            viscous_damping: 0.0,
            gear_friction: 0.5,
            ..Drive::default()
        };
        let longest = drive.longest_step(&robot);
        assert!((longest - 3.756e-3).abs() < 1e-8, "{longest}");
        let after = |dt: f64| {
            (0..1000).fold(1e-4_f64, |omega, _| {
                omega
                    + dt * wheel_acceleration(
                        -drive.loss_torque(omega),
                        0.0,
                        0.0,
                        robot.mass.wheel_inertia,
                        robot.mass.rotor_inertia,
                    )
            })
        };
        assert!(after(0.95 * longest).abs() < 1e-20);
        assert!(after(1.05 * longest).abs() > 1e-4);
    }
}
