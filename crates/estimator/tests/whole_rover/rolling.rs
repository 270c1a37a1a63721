//! Rolling resistance of a whole rover that drives on level ground.

use crate::rover::{equilibrium, level_frame, open_source_rover, triple_bogie, typical};
use robhaz_estimator::EstimatorSettings;
use robhaz_estimator::whole::{Joints, WholeEstimator, WholeFrame, WholeMotion};
use robhaz_model::{GRAVITY, WholeRover};

/// Coefficient of the rolling resistance: sand.
const RESISTANCE: f64 = 0.15;

/// N of a rover that rolls steadily, forward at a `sign` of 1, and its torques are those of the
/// resistance alone.
fn truth(rover: &WholeRover, sign: f64) -> [f64; 6] {
    let motion = WholeMotion::at_rest(GRAVITY, 0.0, 0.0);
    let mut rows = equilibrium(rover, &Joints::default(), &motion, &[0.0; 6]);
    rows.roll(&[sign * RESISTANCE; 6], &[sign; 6]);
    rows.solve(&[0.0; 6], &typical())
        .expect("determined")
        .normal
}

/// The last estimate of N, and the coefficient found with its deviation, after 10 s at 0.2 m/s. Where it
/// yaws (rad/s, of one direction with the speed), the wheels of its outer side push forward, those of the
/// inner side backward, with half of their loads.
fn found(rover: &WholeRover, sign: f64, yaw: f64) -> ([f64; 6], (f64, f64)) {
    let mut settings = EstimatorSettings::kalman();
    settings.viscous_damping = 0.0;
    settings.budget.gear_friction = 0.0;
    settings.budget.rolling_resistance = 0.1;
    // What else a constant torque may be.
    (
        settings.budget.torque_offset,
        settings.budget.inclination_bias,
    ) = (1e-3, 1e-4);
    let mut estimator = WholeEstimator::new(rover, settings, [1e-3; 2]).expect("a rover");
    let (normal, radius) = (truth(rover, sign), rover.side.geometry.wheel_radius);
    let mut last = None;
    let (mut way, dt) = (0.0, 0.01);
    for k in 0..1400 {
        let time = dt * f64::from(k);
        // Two seconds of rest, two until the whole speed: the inertia asks for a hundredth of the weight.
        let share = ((time - 2.0) / 2.0).clamp(0.0, 1.0);
        let speed = 0.2 * share * share * (3.0 - 2.0 * share);
        way += speed * dt;
        let tick = if k % 2 == 0 { 1e-6 } else { -1e-6 };
        let rolls = if speed > 0.0 { sign } else { 0.0 };
        let frame = level_frame(time);
        let rates = frame
            .rates
            .map(|rate| rate.map(|rate| rate + rolls * speed / 0.2 * yaw));
        last = Some(estimator.update(&WholeFrame {
            wheel_angle: [0, 1, 2, 3, 4, 5].map(|i: usize| {
                let outer = if i < 3 { -1.0 } else { 1.0 };
                let longer = outer * rover.half_tracks[i % 3] * yaw / 0.2;
                Some(sign * way / radius * (1.0 + longer))
            }),
            // A torque that repeats its last bit counts as stuck.
            motor_torque: [0, 1, 2, 3, 4, 5].map(|i: usize| {
                let outer = if i < 3 { -1.0 } else { 1.0 };
                let push = if yaw > 0.0 { 0.5 * outer } else { 0.0 };
                Some(rolls * (RESISTANCE + push) * radius * normal[i] + tick)
            }),
            rates: [frame.rates[0], frame.rates[1], rates[2]],
            ..frame
        }));
    }
    let estimate = last.expect("a frame").expect("an estimate");
    let report = estimate.sides[0].kalman.expect("of kalman");
    (
        estimate.normal_force,
        report.reading_errors.rolling_resistance,
    )
}

/// Closed form: wheels of free gears whose torques only turn them against rolling resistance. N is that
/// of the nine rows with each N ahead of its axle by the radius times the coefficient, which moves it by
/// up to a tenth of the mean load; forward and backward. Within half a percent of the mean load: the
/// prior of the coefficient leaves that of it.
#[test]
fn rolling_resistance_moves_the_forces_of_a_whole_rover() {
    for rover in [open_source_rover(), triple_bogie(0.2)] {
        let mean = rover.side.mean_wheel_load();
        let level = equilibrium(
            &rover,
            &Joints::default(),
            &WholeMotion::at_rest(GRAVITY, 0.0, 0.0),
            &[0.0; 6],
        );
        let level = level.solve(&[0.0; 6], &typical()).expect("determined");
        for sign in [1.0, -1.0] {
            let ((normal, (coefficient, sigma)), truth) =
                (found(&rover, sign, 0.0), truth(&rover, sign));
            println!(
                "{sign} {coefficient} +- {sigma} {normal:.2?} {truth:.2?} level {:.2?}",
                level.normal
            );
            let error = (coefficient - RESISTANCE).abs();
            assert!(
                error < 0.01 && error < 2.0 * sigma,
                "{coefficient} +- {sigma}"
            );
            let (mut largest, mut moved) = (0.0_f64, 0.0_f64);
            for i in 0..6 {
                largest = largest.max((normal[i] - truth[i]).abs() / mean);
                moved = moved.max((level.normal[i] - truth[i]).abs() / mean);
            }
            assert!(moved > 0.05 && largest < 0.005, "{moved} {largest}");
        }
    }
}

/// Property: the sum of the tractions of a rover that turns with dragged wheels shows their resistance: it is found
/// within a quarter of its prior deviation, and within two of its own.
#[test]
fn a_turn_with_dragged_wheels_shows_their_resistance() {
    for sign in [1.0, -1.0] {
        let (_, (coefficient, sigma)) = found(&open_source_rover(), sign, 0.3);
        let error = (coefficient - RESISTANCE).abs();
        assert!(
            error < 2.0 * sigma && error < 0.025 && sigma < 0.05,
            "{sign}: {coefficient} +- {sigma}"
        );
    }
}
