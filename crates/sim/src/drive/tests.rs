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
            let rate = |shift: f64| drive.controlled(error + shift, integral).integral_rate;
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
            let half = integral + 0.5e-4 * drive.controlled(error, integral).integral_rate;
            integral += 1e-4 * drive.controlled(error, half).integral_rate;
            let expected = end + (start - end) * (-1e-4 * f64::from(step) / tracking_time).exp();
            assert!((integral - expected).abs() < 1e-6, "{integral} {expected}");
        }
    }
    let drive = Drive::default();
    let at_limit = drive.torque_limit / drive.ki;
    assert!((drive.controlled(1e-6, at_limit).torque - 10.0).abs() < 1e-12);
    assert!(drive.controlled(-1e-6, at_limit).torque < 10.0);
}

/// Equivalence: without integral gain, and without saturation, the rate is the error, to the
/// bit.
#[test]
fn without_saturation_the_integral_is_that_of_the_error() {
    let soft = Drive {
        ki: 0.0,
        ..Drive::default()
    };
    assert_eq!(
        soft.controlled(3.0, 0.0).integral_rate.to_bits(),
        3.0_f64.to_bits()
    );
    let rate = Drive::default().controlled(0.3, 0.1).integral_rate;
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
        drive.controlled(2.0 - 1.7, 0.01).torque.to_bits()
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
    assert!((drive.controlled(0.0, integral).torque - (3.0 - left)).abs() < 1e-5);
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
    let rate = |omega| wheel_acceleration(-drive.loss_torque(omega), 0.0, 0.0, &MassSet::caption());
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
