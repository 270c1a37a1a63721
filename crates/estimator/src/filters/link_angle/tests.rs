//! Tests of the filter of a link's angle.

use super::*;
use crate::filters::ComplementaryFilter;
use crate::testing::Random;

fn readings(rate: Option<f64>, inclination: Option<f64>) -> LinkReading {
    LinkReading {
        rate,
        inclination,
        rate_error: 0.0,
    }
}

/// A budget with a gyroscope whose bias is unknown.
fn biased() -> NoiseBudget {
    NoiseBudget {
        rate_bias: 0.02,
        ..NoiseBudget::typical()
    }
}

/// Readings with a constant gyro bias and the budget's white noises: angle and bias are found, and
/// errors are within four of the standard deviations stated. The bias takes sqrt(3) sigma/(t^1.5
/// sqrt(rate)) to be known from the inclinometer: 1e-5 rad/s after 10 s.
#[test]
fn a_gyro_bias_is_found() {
    let (budget, bias, dt) = (biased(), 0.013, 1e-3);
    let mut filter = LinkAngleKalman::new(&budget);
    filter.start(0.0, 0.0, 0.2 + bias);
    let mut random = Random::new();
    for k in 0..10_000 {
        let t = dt * f64::from(k);
        let (angle, rate) = (0.2 * libm::sin(t), 0.2 * libm::cos(t));
        let read_rate = rate + bias + budget.rate_noise * random.normal();
        let read_angle = angle + budget.inclination_noise * random.normal();
        filter.update(
            &budget,
            dt,
            &readings(Some(read_rate), Some(read_angle)),
            0.0,
        );
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

/// Under an acceleration of 2 m/s^2 at 2 Hz the inclinometer errs by 0.2 rad. With the estimated
/// acceleration subtracted, and less weight, the angle stays; the paper's filter follows by
/// amplitude/(crossover time times frequency) = 0.2/(0.5 4 pi) = 0.03 rad. The settled filter,
/// which corrects 0.96 of a difference a second, would follow the acceleration's error (0.04 rad)
/// by twice 0.04 0.96/(4 pi) = 6 mrad at full weight.
#[test]
fn an_accelerated_inclinometer_does_not_carry_the_angle_away() {
    let (budget, dt) = (NoiseBudget::typical(), 1e-3);
    let mut filter = LinkAngleKalman::new(&budget);
    filter.start(0.0, 0.0, 0.0);
    let mut paper = ComplementaryFilter {
        crossover_time: 0.5,
        last: None,
    };
    for _ in 0..2000 {
        filter.update(&budget, dt, &readings(Some(0.0), Some(0.0)), 0.0);
    }
    let (mut worst, mut of_paper) = (0.0_f64, 0.0_f64);
    for k in 0..5000 {
        let t = dt * f64::from(k);
        let forward = 2.0 * libm::sin(4.0 * core::f64::consts::PI * t);
        let read = forward / robhaz_model::GRAVITY;
        // The estimated acceleration errs by a fifth.
        filter.update(&budget, dt, &readings(Some(0.0), Some(read)), 0.8 * read);
        worst = worst.max(filter.angle().abs());
        of_paper = of_paper.max(paper.update(dt, 0.0, read).abs());
    }
    assert!(of_paper > 0.02, "{of_paper}");
    assert!(worst < 0.5 * 0.006, "{worst}");
}

/// An unknown pulse (2 m/s^2 for 50 ms) moves the angle no further than its weight over 50 ms
/// allows.
#[test]
fn an_unknown_pulse_moves_the_angle_by_little() {
    let (budget, dt) = (NoiseBudget::typical(), 1e-3);
    let mut filter = LinkAngleKalman::new(&budget);
    filter.start(0.0, 0.0, 0.0);
    for _ in 0..2000 {
        filter.update(&budget, dt, &readings(Some(0.0), Some(0.0)), 0.0);
    }
    for _ in 0..50 {
        filter.update(&budget, dt, &readings(Some(0.0), Some(0.2)), 0.0);
    }
    // In the steady state each reading weighs p/r = rate_noise dt/inclination_noise = 1e-3: 50 of
    // them 5 %.
    assert!(
        filter.angle() > 0.0 && filter.angle() < 0.05 * 0.2,
        "{}",
        filter.angle()
    );
}

/// Without its gyroscope or its inclinometer the standard deviation of an angle grows from frame to
/// frame.
#[test]
fn missing_readings_raise_the_deviation() {
    let (budget, dt) = (NoiseBudget::typical(), 1e-3);
    let mut settled = LinkAngleKalman::new(&budget);
    settled.start(0.0, 0.0, 0.0);
    for _ in 0..2000 {
        settled.update(&budget, dt, &readings(Some(0.0), Some(0.0)), 0.0);
    }
    for (rate, inclination) in [(None, Some(0.0)), (Some(0.0), None), (None, None)] {
        let mut filter = settled;
        let mut last = settled.angle_sigma(&budget);
        for _ in 0..10 {
            filter.update(&budget, dt, &readings(rate, inclination), 0.0);
            let sigma = filter.angle_sigma(&budget);
            assert!(sigma > last, "{rate:?} {inclination:?}: {sigma} {last}");
            last = sigma;
        }
    }
}

/// Closed form: a link that turns evenly at w (rad/s), and a low pass of the inclinometer with the
/// time constant s: the reading is the angle less w s. The expected reading is the same, so that
/// the angle does not err.
#[test]
fn an_inclinometer_that_lags_is_expected_to() {
    let budget = NoiseBudget {
        inclination_lag: 0.02,
        ..NoiseBudget::typical()
    };
    let (w, dt) = (0.5, 1e-3);
    let mut filter = LinkAngleKalman::new(&budget);
    filter.start(0.0, 0.0, w);
    for k in 1..1000 {
        let t = dt * f64::from(k);
        let lag = budget.inclination_lag;
        let read = w * (t + lag * libm::expm1(-t / lag));
        filter.update(&budget, dt, &readings(Some(w), Some(read)), 0.0);
    }
    // The discrete low pass of a ramp is half a sample, 2.5e-4 rad, ahead; without the lag the
    // angle would be 1e-2 behind.
    let error = filter.angle() - w * 0.999;
    assert!(error.abs() < 2.5e-4, "{error}");
}

/// Closed form: at any constant acceleration nothing is unmodelled; a step d of the rate leaves d
/// over the time constant of the low pass, less what one sample of the low pass takes. It decays
/// with that time constant.
#[test]
fn a_step_of_the_rate_is_an_unmodelled_acceleration() {
    let budget = NoiseBudget::typical();
    let s = crate::common::SMOOTHING;
    let mut link = LinkAngleKalman::new(&budget);
    link.start(0.0, 0.0, 0.0);
    let (dt, acceleration) = (1e-3, 2.0);
    let mut rate = 0.0;
    let update = |link: &mut LinkAngleKalman, rate: f64| {
        link.update(&budget, dt, &readings(Some(rate), None), 0.0);
    };
    for _ in 0..1000 {
        rate += acceleration * dt;
        update(&mut link, rate);
    }
    // The start of the acceleration has decayed for 50 time constants, and the lag of the
    // derivative is within the gate.
    assert!(link.unmodelled_acceleration() < 1e-9);

    let step = 0.01;
    rate += step;
    update(&mut link, rate);
    assert!(step > GATE * budget.rate_noise);
    let expected = step / s;
    let found = link.unmodelled_acceleration();
    // The rate is up to two samples of the acceleration ahead of its discrete low pass: 4e-3 of
    // 1e-2 rad/s.
    assert!(
        (found - expected).abs() < 0.5 * expected,
        "{found} {expected}"
    );
    for _ in 0..200 {
        update(&mut link, rate);
    }
    assert!(link.unmodelled_acceleration() < 0.1 * found);
}

/// Closed form: a jump d of the rate between two readings is an acceleration d/dt of an impact, left out
/// or not, and falls by e within twice the time that it lasts; one that wheels can follow is none.
#[test]
fn a_jump_of_the_rate_is_an_impact() {
    let budget = NoiseBudget::typical();
    let dt = 1e-3;
    let jump = 2.0 * IMPACT * dt;
    let mut link = LinkAngleKalman::new(&budget);
    link.start(0.0, 0.0, 0.0);
    let mut update = |rate: f64, left_out: f64| {
        link.jump(&budget, 0.0, left_out, dt);
        link.update(&budget, dt, &readings(Some(rate), None), 0.0);
        link.impact_acceleration()
    };
    assert_eq!(update(0.4 * IMPACT * dt, 0.0).to_bits(), 0.0_f64.to_bits());
    for (rate, left_out) in [(jump, 0.0), (jump, jump)] {
        assert!((update(rate, left_out) - 2.0 * IMPACT).abs() < 0.41 * IMPACT);
        let before = update(rate, 0.0);
        let after = (0..10).fold(before, |_, _| update(rate, 0.0));
        assert!(
            (before / after - 1.0_f64.exp()).abs() < 1e-9,
            "{before} {after}"
        );
    }
}

/// A rate that is 0.2 rad/s off, beyond what the inclinometer corrects, moves the angle by nearly 0.2 t. What both are apart
/// is a deviation from 0.3 s on. As long as the rate errs, the link is not lost: which of both is right no reading
/// shows. One that has erred for a second has left the angle off by the same amount for another one: lost. Nor is a link
/// whose inclinometer lags by 0.2 s on waves of 0.15 rad/s, 0.03 rad behind, or has outliers.
#[test]
fn a_contradicted_angle_is_lost() {
    let budget = NoiseBudget::typical();
    let dt = 5e-3;
    let run_every =
        |every: u32, rate: &dyn Fn(f64) -> f64, inclination: &dyn Fn(f64) -> f64, end: f64| {
            let mut link = LinkAngleKalman::new(&budget);
            link.start(inclination(0.0), 0.0, rate(0.0));
            let steps = (end / dt).round() as u32;
            let mut lost = false;
            for k in 1..=steps {
                let time = dt * f64::from(k);
                let inclination = (k % every == 0).then(|| inclination(time));
                link.update(&budget, dt, &readings(Some(rate(time)), inclination), 0.0);
                lost |= link.is_lost();
            }
            (link, lost)
        };
    let run = |rate: &dyn Fn(f64) -> f64, inclination: &dyn Fn(f64) -> f64, end: f64| {
        run_every(1, rate, inclination, end)
    };
    let (link, lost) = run(&|_| 0.2, &|_| 0.0, 0.3);
    assert!(link.contradicts() && !lost);
    // One step of 1 mrad is not yet in it.
    let difference = link.settled_sigma() - link.angle();
    assert!(difference.abs() < 2e-3, "{difference}");
    assert!(!run(&|_| 0.2, &|_| 0.0, 5.0).1);
    let for_a_second = |t: f64| if t < 1.0 { 0.2 } else { 0.0 };
    assert!(!run(&for_a_second, &|_| 0.0, 1.9).1);
    assert!(run(&for_a_second, &|_| 0.0, 2.1).1);
    // Two readings of an inclinometer at 10 Hz more.
    assert!(run_every(20, &for_a_second, &|_| 0.0, 2.3).1);

    let lagging = |t: f64| 0.15 * (1.0 - libm::cos(t - 0.2));
    let (link, lost) = run(&|t| 0.15 * libm::sin(t), &lagging, 20.0);
    assert!(!lost, "{}", link.apart());
    let outlier = |t: f64| if t.fract() > 0.9 { 0.5 } else { 0.0 };
    let (link, lost) = run(&|_| 0.0, &outlier, 9.8);
    assert!(!lost && !link.contradicts());
}
