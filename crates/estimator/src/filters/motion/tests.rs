//! Tests of the motion filter as a whole.

use super::coupled::JointMeasurement;
use super::filter::MotionFilter;
use super::parity::ParityResidual;
use super::rolling::RollingWheel;
use super::tuning;
use crate::filters::GaussMarkov;
use crate::filters::Innovation;
use crate::settings::{ContactAngles, NoiseBudget};
use crate::state::{
    self, CONTACT_ANGLE, COUNT, CREEP, RESISTANCE, TORQUE_GAIN, TORQUE_OFFSET, VELOCITY,
};
use crate::testing::Random;
use nalgebra::SMatrix;
use robhaz_model::Vec2;

const DT: f64 = 1e-3;

/// A wheel of exact readings that stands.
fn exact() -> RollingWheel {
    RollingWheel {
        relative: Vec2::zeros(),
        smooth_relative: Vec2::zeros(),
        angle: 0.0,
        rim_speed: Some(0.0),
        turns: true,
        ratio: 0.0,
        moment_of_load: 4.5,
        resisted: 1.0,
        load_sigma: 0.0,
        torque: 0.0,
        bias_sigma: 0.0,
        noise_sigma: 0.0,
        joint_noise: 0.0,
        across_sigma: 0.0,
        settled: true,
        noise_time: 5e-3,
        torque_sigma: 0.05,
        rim_sigma: 0.0,
        product_time: tuning::SLIP.time,
    }
}

fn wheel(random: &mut Random) -> RollingWheel {
    RollingWheel {
        relative: Vec2::new(random.normal(), random.normal()) * 0.02,
        smooth_relative: Vec2::zeros(),
        angle: 0.2 * random.normal(),
        rim_speed: Some(0.2 + 0.01 * random.normal()),
        ratio: (0.3 * random.normal()).clamp(-1.0, 1.0),
        torque: random.normal(),
        bias_sigma: 1e-3,
        noise_sigma: 1e-3,
        ..exact()
    }
}

/// Checks a parity residual and corrects the states by it.
fn check(
    motion: &mut MotionFilter,
    gradient: &[f64; state::INPUTS],
    value: f64,
    variance: f64,
    dt: f64,
) -> (Innovation, bool) {
    let residual = ParityResidual {
        value,
        gradient: *gradient,
        variance,
        of_push: 0.0,
        observed: [GaussMarkov::new(0.0, 0.0); 3],
    };
    motion.check_parity(&residual, dt, true)
}

/// Asymmetry and the least eigenvalue of the covariance scaled to a correlation (whose trace is the
/// number of states).
fn defects(motion: &MotionFilter) -> (bool, f64) {
    let p = &motion.filter.p;
    let symmetric = (0..COUNT).all(|i| (0..i).all(|j| p[i][j].to_bits() == p[j][i].to_bits()));
    let scaled =
        SMatrix::<f64, COUNT, COUNT>::from_fn(|i, j| p[i][j] / libm::sqrt(p[i][i] * p[j][j]));
    (symmetric, scaled.symmetric_eigenvalues().min())
}

/// Over 20 000 steps of random readings, gaps and outliers the covariance stays symmetric to the
/// bit and positive. At the start nothing is known, then states differ in certainty by up to 1e4:
/// rounding in the scaled matrix is 1e-12.
#[test]
fn covariance_stays_symmetric_and_positive() {
    covariance_stays_right(ContactAngles::Given);
    covariance_stays_right(ContactAngles::Unknown);
}

fn covariance_stays_right(angles: ContactAngles) {
    let budget = NoiseBudget::typical();
    let mut motion = MotionFilter::new(&budget, angles);
    let mut random = Random::new();
    let mut least = f64::INFINITY;
    for k in 0..20_000_u32 {
        let dt = if k % 997 == 0 { 0.4 } else { DT };
        let links = if k % 300 < 20 { 3.0 } else { 0.0 };
        let measured = [0.1, links];
        motion.predict(
            &budget,
            dt,
            [k % 3 != 0, k % 500 > 100, true],
            &[0.0; 3],
            measured,
        );
        let wheels = [0, 1, 2].map(|i| (k % 70 != i).then(|| wheel(&mut random)));
        motion.roll(&budget, &wheels, dt, k % 5 != 0);
        let h = core::array::from_fn(|_| 5.0 * random.normal());
        let value = if k % 100 == 0 { 1e6 } else { random.normal() };
        check(&mut motion, &h, value, 0.5, dt);
        if k % 100 == 0 {
            let (symmetric, eigenvalue) = defects(&motion);
            assert!(symmetric, "step {k}");
            least = least.min(eigenvalue);
        }
    }
    assert!(least > 1e-12, "{least}");
    assert!(motion.filter.x.iter().all(|x| x.is_finite()));
}

/// Wheels that roll on known slopes at a known rim speed determine the velocity: along the ground,
/// at the speed of the rims.
#[test]
fn rolling_determines_the_velocity() {
    let budget = NoiseBudget::typical();
    let mut motion = MotionFilter::new(&budget, ContactAngles::Given);
    let (slope, speed) = (0.2_f64, 0.2);
    for _ in 0..2000 {
        motion.predict(&budget, DT, [true; 3], &[0.0; 3], [0.0; 2]);
        let wheel = RollingWheel {
            angle: slope,
            rim_speed: Some(speed),
            ..exact()
        };
        motion.roll(&budget, &[Some(wheel); 3], DT, true);
    }
    let along = Vec2::new(libm::cos(slope), libm::sin(slope)) * speed;
    // The contact angles' own error, 2 deg over three wheels, turns the velocity; along the ground
    // the prior of the acceleration pulls by less than 1e-3.
    assert!(
        (motion.velocity() - along).norm() < 0.01 * speed,
        "{}",
        motion.velocity()
    );
}

/// Contact angles with errors of 6 deg correct the direction of the velocity, not its size: without
/// encoders the speed changes by less than a fifth within a second. Linearised about the contact
/// angles, the constraints would stop the robot within that second.
#[test]
fn wrong_slopes_do_not_slow_the_robot_down() {
    let budget = NoiseBudget {
        contact_angle: 0.1,
        ..NoiseBudget::typical()
    };
    let mut motion = MotionFilter::new(&budget, ContactAngles::Given);
    motion.filter.x[VELOCITY.of(0)] = 0.2;
    let mut random = Random::new();
    let keep = libm::exp(-DT / budget.contact_angle_time);
    let fresh = budget.contact_angle * libm::sqrt(1.0 - keep * keep);
    let mut errors = [0.0; 3];
    for _ in 0..1000 {
        motion.predict(&budget, DT, [true; 3], &[0.0; 3], [0.0; 2]);
        let wheels = errors.each_mut().map(|error| {
            *error = keep * *error + fresh * random.normal();
            Some(RollingWheel {
                relative: Vec2::new(0.0, 2e-3 * random.normal()),
                smooth_relative: Vec2::zeros(),
                angle: *error,
                rim_speed: None,
                bias_sigma: 0.0,
                noise_sigma: 2e-3,
                ..wheel(&mut random)
            })
        });
        motion.roll(&budget, &wheels, DT, true);
    }
    let speed = libm::sqrt(motion.velocity().norm_squared());
    assert!((speed - 0.2).abs() < 0.04, "{}", motion.velocity());
}

/// A parity residual beyond its prediction counts as unmodelled load, less two standard deviations.
/// The load decays with its time constant, and measurements are down-weighted meanwhile.
#[test]
fn an_impact_becomes_unmodelled_load_and_decays() {
    let budget = NoiseBudget::typical();
    let h = [0.0; state::INPUTS];
    let mut motion = MotionFilter::new(&budget, ContactAngles::Given);
    let impact = check(&mut motion, &h, 20.0, 1.0, DT);
    assert!(!impact.1 && impact.0.nis() > 300.0);
    let expected = 400.0 - 4.0 * impact.0.variance;
    // Rounding of 400 N^2.
    assert!((motion.unmodelled_load() - expected).abs() < 1e-9);
    assert!(motion.is_after_impact());
    for _ in 0..100 {
        motion.predict(&budget, DT, [true; 3], &[0.0; 3], [0.0; 2]);
    }
    let decayed = expected * libm::exp(-0.1 / crate::common::SMOOTHING);
    assert!((motion.unmodelled_load() - decayed).abs() < 1e-9 * expected);
    // The prediction of the residual itself does not change: its NIS shows impacts.
    let innovation = check(&mut motion, &h, 0.0, 1.0, DT).0;
    assert!((innovation.variance - 1.0).abs() < 1e-12);
    for _ in 0..1000 {
        motion.predict(&budget, DT, [true; 3], &[0.0; 3], [0.0; 2]);
    }
    assert_eq!(motion.unmodelled_load().to_bits(), 0.0_f64.to_bits());
}

/// A rejected parity residual corrects no state; an accepted one corrects the states that explain
/// it. Torque gains are never corrected.
#[test]
fn parity_corrects_the_states_that_explain_it() {
    let budget = NoiseBudget::typical();
    let mut h = [0.0; state::INPUTS];
    h[TORQUE_OFFSET.of(0)] = 10.0;
    h[TORQUE_GAIN.of(0)] = 10.0;
    let new = MotionFilter::new(&budget, ContactAngles::Given);
    let mut motion = new;
    // The residual corresponds to an offset of -0.05 N m: value + h x = 0.
    let accepted = check(&mut motion, &h, 0.5, 1e-4, DT);
    assert!(accepted.1 && accepted.0.nis() < 1.0);
    let x = motion.filter.x[TORQUE_OFFSET.of(0)];
    assert!(x < 0.0 && x > -0.05, "{x}");
    assert!(
        motion.filter.p[TORQUE_OFFSET.of(0)][TORQUE_OFFSET.of(0)]
            < new.filter.p[TORQUE_OFFSET.of(0)][TORQUE_OFFSET.of(0)]
    );
    assert_eq!(
        motion.filter.estimated(TORQUE_GAIN.of(0)),
        new.filter.estimated(TORQUE_GAIN.of(0))
    );
    let mut motion = new;
    assert!(!check(&mut motion, &h, 100.0, 1e-4, DT).1);
    assert_eq!(motion.filter, new.filter);
    let residual = ParityResidual {
        value: 0.5,
        gradient: h,
        variance: 1e-4,
        of_push: 0.0,
        observed: [GaussMarkov::new(0.0, 0.0); 3],
    };
    motion.check_parity(&residual, DT, false);
    assert_eq!(motion.filter, new.filter);
}

/// A filter without contact angles that moves at 0.2 m/s on level ground and is sure of it, and a
/// wheel whose readings agree.
fn rolling_without_angles() -> (MotionFilter, RollingWheel) {
    let mut motion = MotionFilter::new(&NoiseBudget::typical(), ContactAngles::Unknown);
    motion.filter.x[VELOCITY.of(0)] = 0.2;
    for i in 0..3 {
        motion.filter.p[CONTACT_ANGLE.of(i)][CONTACT_ANGLE.of(i)] = 1e-4;
    }
    for v in VELOCITY.all() {
        motion.filter.p[v][v] = 1e-6;
    }
    let mut random = Random::new();
    let wheel = RollingWheel {
        relative: Vec2::zeros(),
        angle: 0.0,
        rim_speed: Some(0.2),
        ratio: 0.0,
        ..wheel(&mut random)
    };
    (motion, wheel)
}

/// A wheel that meets a kerb moves away from its ground: its contact angle becomes as uncertain as
/// the change of direction, and the velocity stays. A wheel that seems to enter the ground shows a
/// wrong velocity, and its contact angle stays.
#[test]
fn only_a_velocity_away_from_the_ground_shows_an_edge() {
    let budget = NoiseBudget::typical();
    for upwards in [true, false] {
        let (mut motion, mut wheel) = rolling_without_angles();
        let lift = if upwards { 0.1 } else { -0.1 };
        wheel.relative = Vec2::new(0.0, lift);
        wheel.smooth_relative = wheel.relative;
        wheel.rim_speed = None;
        let velocity = motion.filter.p[VELOCITY.of(1)][VELOCITY.of(1)];
        motion.roll(&budget, &[Some(wheel), None, None], DT, true);
        let (angle, sigma) = motion.input(CONTACT_ANGLE.of(0));
        let change = libm::atan(0.5);
        if upwards {
            assert!(sigma > 0.3 * change, "{sigma}");
            assert!(angle < 0.0, "{angle}");
        } else {
            assert!(sigma < 0.05 * change, "{sigma}");
            let opened = motion.filter.p[VELOCITY.of(1)][VELOCITY.of(1)];
            assert!(opened > 10.0 * velocity, "{opened}");
        }
        assert!(motion.is_after_impact());
    }
}

/// A wheel that turns without slip under a small T/N tells nothing of its creep: the T/N may be a
/// torque offset. Under a T/N well beyond the offset's reach it does, as long as it surely does not
/// slide.
#[test]
fn creep_is_learned_from_wheels_that_surely_pull() {
    let budget = NoiseBudget::typical();
    for (ratio, learns) in [(0.05, false), (0.2, true), (0.6, false)] {
        let (mut motion, mut wheel) = rolling_without_angles();
        // Known friction, so that offset and gain alone decide what is sure.
        motion.filter.p[RESISTANCE.of(0)][RESISTANCE.of(0)] = 1e-6;
        wheel.ratio = ratio;
        let before = motion.filter.x[CREEP.of(0)];
        for _ in 0..100 {
            motion.roll(&budget, &[Some(wheel), None, None], DT, true);
        }
        let change = (motion.filter.x[CREEP.of(0)] - before).abs();
        // In parts of the creep speed.
        assert_eq!(change > 0.01, learns, "{ratio}: {change}");
    }
}

/// Closed form: an error of the direction of 0.02 with a small variance turns the velocity by it,
/// also backwards. A robot that stands takes none.
#[test]
fn the_direction_is_corrected() {
    for forward in [1.0, -1.0] {
        let (mut motion, _) = rolling_without_angles();
        motion.filter.x[VELOCITY.of(0)] = 0.2 * forward;
        motion.filter.x[VELOCITY.of(1)] = 0.0;
        let mut stands = motion;
        let before = motion.filter.p[VELOCITY.of(1)][VELOCITY.of(1)];
        let change = motion.correct_direction(0.02, 1e-8);
        // The velocity errs by 0.01 m/s or more, 0.05 rad: the gain is 1 - 1e-8/0.05^2.
        assert!((change + 0.02).abs() < 1e-5, "{change}");
        let velocity = motion.velocity();
        assert!((velocity.y / velocity.x + 0.02).abs() < 1e-5);
        assert!(motion.filter.p[VELOCITY.of(1)][VELOCITY.of(1)] < 0.01 * before);

        stands.filter.x[VELOCITY.of(0)] = 0.0;
        let before = stands;
        assert!(stands.correct_direction(0.02, 1e-8).abs() < 1e-300);
        assert_eq!(stands, before);
    }
}

/// Closed form: mapped ground moves the contact angle, known to 0.01 rad, to the mean weighted by
/// the inverse variances. It turns the velocity that the direction constraint has tied to that
/// angle, too. A robot that stands takes nothing.
#[test]
fn mapped_terrain_corrects_a_contact_angle() {
    let (mut motion, _) = rolling_without_angles();
    let mut stands = motion;
    motion.correct_contact_angle(1, 0.0, 0.03, 3e-4);
    let (error, sigma) = motion.input(CONTACT_ANGLE.of(1));
    // A prior variance of 1e-4 beside 3e-4: a quarter of the way, and three quarters of the
    // variance.
    assert!((error + 0.25 * 0.03).abs() < 1e-12, "{error}");
    assert!((sigma * sigma - 0.75e-4).abs() < 1e-12, "{sigma}");
    assert_eq!(
        motion.input(CONTACT_ANGLE.of(0)).0.to_bits(),
        0.0_f64.to_bits()
    );

    stands.filter.x[VELOCITY.of(0)] = 0.0;
    let before = stands;
    stands.correct_contact_angle(1, 0.0, 0.03, 3e-4);
    assert_eq!(stands, before);

    let (mut tied, _) = rolling_without_angles();
    let covariance = 0.9 * 0.01 * 1e-3;
    // The error of the angle is what is read too much: a velocity that rises too little goes with
    // it.
    tied.filter.p[VELOCITY.of(1)][CONTACT_ANGLE.of(1)] = -covariance;
    tied.filter.p[CONTACT_ANGLE.of(1)][VELOCITY.of(1)] = -covariance;
    let before = tied.velocity().y;
    tied.correct_contact_angle(1, 0.0, 0.03, 3e-4);
    let turned = tied.velocity().y - before;
    // covariance/(1e-4 + 3e-4) of the innovation.
    assert!(
        (turned - covariance / 4e-4 * 0.03).abs() < 1e-12,
        "{turned}"
    );
}

/// Closed form: without measurements an unknown contact angle reverts to the slope that the posture
/// shows, by `exp(-distance/length)`.
#[test]
fn unknown_contact_angles_revert_along_the_ground() {
    let (mut motion, _) = rolling_without_angles();
    let steps = 400;
    for _ in 0..steps {
        let still = [0.0; 2];
        motion.predict(&NoiseBudget::typical(), DT, [false; 3], &[0.1; 3], still);
    }
    let distance = 0.2 * DT * f64::from(steps);
    let expected = 0.1 * (1.0 - libm::exp(-distance / tuning::SLOPE_LENGTH));
    for i in 0..3 {
        let angle = -motion.input(CONTACT_ANGLE.of(i)).0;
        // Rounding of 400 steps.
        assert!((angle - expected).abs() < 1e-12, "{angle} {expected}");
    }
}

/// The slip of a wheel whose N is not known says nothing of its torque: the offset and its deviation
/// stay, however the wheel slips. With a known N they change.
#[test]
fn slip_shows_no_torque_without_a_known_load() {
    let budget = NoiseBudget::typical();
    let offset = |motion: &MotionFilter| motion.input(TORQUE_OFFSET.of(0));
    let found = |load_sigma: f64| {
        let mut motion = MotionFilter::new(&budget, ContactAngles::Given);
        let mut random = Random::new();
        let slips = RollingWheel {
            relative: Vec2::zeros(),
            angle: 0.0,
            rim_speed: Some(0.21),
            ratio: 0.2,
            load_sigma,
            ..wheel(&mut random)
        };
        let grips = RollingWheel {
            rim_speed: Some(0.2),
            ratio: 0.0,
            load_sigma: 0.0,
            ..slips
        };
        for _ in 0..500 {
            motion.predict(&budget, DT, [true; 3], &[0.0; 3], [0.0; 2]);
            motion.roll(&budget, &[Some(slips), Some(grips), Some(grips)], DT, true);
        }
        offset(&motion)
    };
    let (known, unknown) = (found(0.05), found(1.5));
    let prior = budget.torque_offset;
    assert!(known.0.abs() > 0.1 * prior, "{known:?}");
    // The random walk over half a second adds less than 1e-3 of the deviation.
    assert!(unknown.0.abs() < 1e-12, "{unknown:?}");
    assert!((unknown.1 / prior - 1.0).abs() < 1e-3, "{unknown:?}");
}

/// Closed form: two velocities that are as uncertain as each other, of which a difference is exactly known, take
/// half of it each; the difference is known then, and their sum is as before.
#[test]
fn a_difference_of_both_sides_moves_each_by_half() {
    let filter = || {
        let mut motion = MotionFilter::new(&NoiseBudget::typical(), ContactAngles::Unknown);
        motion.couple();
        motion
    };
    let [mut left, mut right] = [filter(), filter()];
    let state = VELOCITY.of(1);
    let variance = left.filter.p[state][state];
    let measurement = JointMeasurement {
        innovation: 0.5 * variance.sqrt(),
        rows: [[(state, 1.0)], [(state, -1.0)]],
        sigma: 0.0,
        white: 0.0,
    };
    let found = MotionFilter::correct_both(&mut left, &mut right, &measurement);
    // Rounding.
    let near = |a: f64, b: f64| (a - b).abs() < 1e-12 * variance.sqrt();
    assert!(near(found.variance, 2.0 * variance));
    let [a, b] = [left.filter.x[state], right.filter.x[state]];
    assert!(near(a - b, measurement.innovation) && near(a + b, 0.0));
    let again = MotionFilter::correct_both(&mut left, &mut right, &measurement);
    assert!(near(again.variance, 0.0), "{again:?}");
    let covariance = left.guests_of_other()[state][state];
    let of_sum = left.filter.p[state][state] + right.filter.p[state][state] + 2.0 * covariance;
    assert!(near(of_sum, 2.0 * variance), "{of_sum} {variance}");
}
