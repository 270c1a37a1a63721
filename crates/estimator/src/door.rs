//! The door of the estimator: readings and settings are converted into the [`Units`] of the robot,
//! in which one tuning holds for all, and estimates back.

use crate::estimate::Estimate;
use crate::frame::{LinkReading, SensorFrame};
use crate::ground::GroundPoint;
use crate::settings::{EstimatorSettings, Method, NoiseBudget};
use crate::statics::LOAD_PARAMETERS;
use robhaz_model::Units;

/// Settings in these units.
pub(crate) fn settings_in(units: &Units, settings: &EstimatorSettings) -> EstimatorSettings {
    let mut method = settings.method;
    if let Method::Paper(paper) = &mut method {
        paper.observer_pole *= units.time;
        paper.crossover_time /= units.time;
    }
    EstimatorSettings {
        method,
        viscous_damping: settings.viscous_damping / (units.torque() * units.time),
        compression: settings.compression / units.length,
        moment_lever: settings.moment_lever / units.length,
        budget: budget_in(units, &settings.budget),
        // Choices.
        ..*settings
    }
}

fn budget_in(units: &Units, budget: &NoiseBudget) -> NoiseBudget {
    NoiseBudget {
        jitter: budget.jitter / units.time,
        torque_noise: budget.torque_noise / units.torque(),
        torque_offset: budget.torque_offset / units.torque(),
        gear_friction: budget.gear_friction / units.torque(),
        inclination_lag: budget.inclination_lag / units.time,
        inclination_place: budget.inclination_place / units.length,
        rate_noise: budget.rate_noise * units.time,
        rate_bias: budget.rate_bias * units.time,
        rate_walk: budget.rate_walk * units.time * robhaz_model::sqrt(units.time),
        contact_angle_time: budget.contact_angle_time / units.time,
        body_cg: budget.body_cg / units.length,
        load_covariance: budget.load_covariance.map(|covariance| {
            let mut of_loads = [units.mass * units.length; LOAD_PARAMETERS];
            of_loads[0] = units.mass;
            covariance.in_units(&of_loads)
        }),
        // Angles, counts and ratios.
        ..*budget
    }
}

/// Readings in these units.
pub(crate) fn frame_in(units: &Units, frame: &SensorFrame) -> SensorFrame {
    let torque = 1.0 / units.torque();
    let link = |reading: LinkReading| LinkReading {
        rate: reading.rate.map(|rate| rate * units.time),
        ..reading
    };
    SensorFrame {
        time: frame.time / units.time,
        motor_torque: frame.motor_torque.map(|read| read.map(|t| t * torque)),
        link1: link(frame.link1),
        link2: link(frame.link2),
        // Angles.
        ..*frame
    }
}

/// Puts an estimate into SI, of the readings at `time`, s.
pub(crate) fn estimate_out(units: &Units, estimate: &mut Estimate, time: f64) {
    let (length, force, torque) = (units.length, units.force(), units.torque());
    estimate.time = time;
    estimate.scale_forces(force);
    // Moments, where the first two are forces.
    for moment in &mut estimate.residual[2..] {
        *moment *= length;
    }
    for pin in &mut estimate.pin_from_q {
        *pin *= length;
    }
    if let Some(parity) = &mut estimate.parity {
        parity.value *= force;
        parity.sigma *= force;
    }
    for wheel in estimate.contact.iter_mut().flatten() {
        wheel.slip *= units.speed();
    }
    for wheel in estimate.friction.iter_mut().flatten() {
        wheel.slid = wheel.slid.map(|slid| slid * length);
        if let Some(event) = &mut wheel.slip_event {
            event.load *= force;
            event.age *= units.time;
            event.place = event.place.map(|place| place * length);
        }
    }
    if let Some(errors) = &mut estimate.reading_errors {
        let offsets = errors.torque_offset.iter_mut();
        for (value, sigma) in offsets.chain([&mut errors.gear_friction]) {
            (*value, *sigma) = (*value * torque, *sigma * torque);
        }
        for (value, sigma) in &mut errors.rate_bias {
            (*value, *sigma) = (*value / units.time, *sigma / units.time);
        }
    }
}

/// A point of the ground in SI.
pub(crate) fn point_out(units: &Units, mut point: GroundPoint) -> GroundPoint {
    point.x *= units.length;
    point.sigma_x *= units.length;
    point.height *= units.length;
    point.sigma_height *= units.length;
    point
}
