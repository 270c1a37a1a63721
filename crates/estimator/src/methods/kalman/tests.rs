//! Tests of `kalman` as a whole.

use super::*;
use crate::filters::WheelParameters;
use crate::frame::{Inputs, LinkReading, SensorFrame};
use crate::settings::{EstimatorSettings, Method};
use crate::state;
use crate::testing::Random;
use crate::{Estimator, Flags};
use nalgebra::Vector4;
use proptest::prelude::*;

proptest! {
    /// The columns are the derivatives of `y - H_N N` (N held) by each input, with all else
    /// recomputed from the changed input. Central differences at h = 1e-6 err by 1e-9 of 100 N;
    /// linear parts err by rounding over h, 1e-8.
    #[test]
    fn sensitivity_is_the_derivative(
        theta in prop::array::uniform2(-0.25_f64..0.25), slopes in prop::array::uniform3(-0.4_f64..0.4),
        states in prop::collection::vec(-0.1_f64..0.1, state::INPUTS), torques in prop::array::uniform3(-3.0_f64..3.0),
        speeds in prop::array::uniform3(-0.02_f64..0.02),
    ) {
        let nominal = Nominal::new(&Robot::default_a(), EstimatorSettings::kalman());
        let parameters = WheelParameters {
            wheel_inertia: 0.0075, rotor_inertia: 0.0864, viscous_damping: 0.15,
            encoder_sigma: 1e-5, torque_sigma: 0.1, rim_speed: 0.0,
            unread_walk: 0.0,
        };
        let method = KalmanMethod::DEFAULT;
        let mut filters = KalmanFilters::new(&nominal.robot, method, &nominal.settings.budget);
        for i in 0..3 {
            filters.wheels[i] = Wheel::observed(&parameters, torques[i], speeds[i]);
        }
        for (k, value) in states.iter().enumerate() {
            filters.motion.shift_input(k, *value);
        }
        let mut inputs = Inputs::default();
        for i in 0..3 {
            inputs.contact_angle[i].value = slopes[i];
        }
        let at = |filters: &KalmanFilters| {
            let arms = Arms::new(&nominal.robot.geometry, theta[0], theta[1]).expect("inside the stops");
            let equations = filters.equations(&nominal, &inputs, arms, theta).expect("regular");
            let right = filters.right_side(&nominal, &equations);
            (equations, right)
        };
        // The forces of the sample before: those of these equations, nearly.
        let (equations, right) = at(&filters);
        filters.last_normal_force = equations.inverse.solve(&right.value);
        filters.last_traction = filters.tractions(&nominal).map(|t| t.value);
        let (normal, right) = (filters.last_normal_force, at(&filters).1);
        let h = 1e-6;
        for k in 0..state::INPUTS {
            let residual = |change: f64| -> Vector4<f64> {
                let mut filters = filters;
                filters.motion.shift_input(k, change);
                let (equations, right) = at(&filters);
                let mut residual = right.value;
                for i in 0..3 {
                    residual -= equations.equilibrium.h_n[i] * normal[i];
                }
                residual
            };
            let difference = (residual(h) - residual(-h)) / (2.0 * h);
            let found = right.sensitivity[k];
            prop_assert!((found - difference).norm() < 1e-5, "input {k}: {found} {difference}");
        }
    }
}

/// Readings of a robot at rest on level ground. Inclinometers and gyroscopes have their white
/// noise. Torques have none: it would change the sign of the observed speeds at random.
fn at_rest(time: f64, torque: [f64; 3], budget: &NoiseBudget, random: &mut Random) -> SensorFrame {
    let mut link = || LinkReading {
        inclination: Some(budget.inclination_noise * random.normal()),
        rate: Some(budget.rate_noise * random.normal()),
        rate_error: 0.0,
    };
    let (link1, link2) = (link(), link());
    SensorFrame {
        time,
        wheel_angle: [Some(0.0); 3],
        motor_torque: torque.map(Some),
        link1,
        link2,
        contact_angle: [Some(0.0); 3],
        ..SensorFrame::default()
    }
}

/// At rest, without rolling constraints, only the parity residual depends on the torque offsets,
/// and on level ground on their sum alone (horizontal row; the moment rows have nearly equal arms).
/// So the sum is estimated. Differences, gear friction and gains are not observable: they keep the
/// mean and standard deviation of their prior.
#[test]
fn only_observable_errors_are_estimated() {
    let method = KalmanMethod {
        rolling: false,
        ..KalmanMethod::DEFAULT
    };
    let settings = EstimatorSettings {
        method: Method::Kalman(method),
        ..EstimatorSettings::kalman()
    };
    let budget = &settings.budget;
    let mut estimator = Estimator::new(&Robot::default_a(), settings);
    let mut random = Random::new();
    let offsets = [0.15, 0.05, 0.10];
    let mut last = None;
    for k in 0..20_000 {
        let frame = at_rest(1e-3 * f64::from(k), offsets, budget, &mut random);
        let estimate = estimator.update(&frame).expect("complete frames");
        assert_eq!(estimate.flags, Flags::NONE, "{k}");
        last = Some(estimate);
    }
    let errors = last
        .and_then(|e| e.kalman)
        .expect("kalman estimates errors")
        .reading_errors;
    let found = errors.torque_offset;
    let sum: f64 = found.iter().map(|f| f.0).sum();
    let sum_of_sigma: f64 = found.iter().map(|f| f.1).sum();
    // Contact angles off by 2 deg under 45 N act as 0.27 N m over all wheels; over 20 s they
    // average to a tenth.
    assert!((sum - 0.3).abs() < 0.06, "{found:?}");
    let p = offset_covariance(&estimator);
    let variance = |u: [f64; 3]| {
        let mut sum = 0.0;
        for i in 0..3 {
            for j in 0..3 {
                sum += u[i] * u[j] * p[i][j];
            }
        }
        sum
    };
    let prior = budget.torque_offset * budget.torque_offset;
    assert!(
        variance([1.0; 3]) < 0.1 * 3.0 * prior,
        "{}",
        variance([1.0; 3])
    );
    assert!(
        variance([1.0, 0.0, -1.0]) > 0.8 * 2.0 * prior,
        "{}",
        variance([1.0, 0.0, -1.0])
    );
    assert!((found[0].0 - found[2].0).abs() < 0.02, "{found:?}");
    assert!(sum_of_sigma > 2.0 * budget.torque_offset);
    let (friction, sigma) = errors.gear_friction;
    // The first frames, before the observed speeds have settled, change it a little.
    assert!(
        friction.abs() < 0.01 && sigma > 0.99 * budget.gear_friction,
        "{friction} +- {sigma}"
    );
}

/// Covariance of the torque offsets of an estimator `kalman`.
fn offset_covariance(estimator: &Estimator) -> [[f64; 3]; 3] {
    let motion = &estimator.kalman_filters().expect("kalman").motion;
    let offset = |i| state::TORQUE_OFFSET.of(i);
    [0, 1, 2].map(|i| [0, 1, 2].map(|j| motion.input_covariance(offset(i), offset(j))))
}

/// Newton: nothing counts while the rate follows its low pass. A link that turns with an angular
/// acceleration s may accelerate Q, and the whole mass M with it, by s times its longest arm. That
/// vertical force is borne by the wheels: the sum of N has at least the deviation M s arm.
/// Rounding.
#[test]
fn unmodelled_turning_counts_with_the_whole_mass() {
    let nominal = Nominal::new(&Robot::default_a(), EstimatorSettings::kalman());
    let (robot, budget) = (&nominal.robot, &nominal.settings.budget);
    let still = KalmanFilters::new(robot, KalmanMethod::DEFAULT, budget);
    let variance_of_sum = |filters: &KalmanFilters| {
        let arms = Arms::new(&robot.geometry, 0.0, 0.0).expect("the nominal pose");
        let equations = filters.equations(&nominal, &Inputs::default(), arms, [0.0; 2]);
        let equations = equations.expect("regular");
        let mut forces = Forces {
            normal: [0.0; 3],
            traction: [0.0; 3],
            covariance: [[0.0; 6]; 6],
        };
        let right = filters.right_side(&nominal, &equations);
        let turning = filters
            .links
            .each_ref()
            .map(LinkAngleKalman::unmodelled_acceleration);
        filters.consider_turning(
            turning,
            &nominal,
            &equations,
            &right.sensitivity,
            &mut forces,
        );
        forces.covariance.iter().flatten().sum::<f64>()
    };
    assert!(!(variance_of_sum(&still) > 0.0));
    for (link, wheel) in [(0, 0), (1, 2)] {
        let mut filters = still;
        filters.links[link].start(0.0, 0.0, 0.0);
        let readings = LinkReading {
            rate: Some(0.012),
            inclination: None,
            rate_error: 0.0,
        };
        filters.links[link].update(budget, 1e-3, &readings, 0.0);
        let sigma = filters.links[link].unmodelled_acceleration();
        assert!(sigma > 0.1, "{sigma}");
        let geometry = &robot.geometry;
        let arm = (geometry.axles[wheel] - geometry.pins.q).norm();
        let force = robot.mass.total() * sigma * arm;
        let found = libm::sqrt(variance_of_sum(&filters));
        assert!(found > force * (1.0 - 1e-9), "{found} {force}");
    }
}
