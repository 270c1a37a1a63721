//! The door of the estimator: readings and settings are converted into the [`Units`] of the robot,
//! in which one tuning holds for all, and estimates back.

use crate::contact::ContactEstimate;
use crate::estimate::{Estimate, KalmanReport, Parity, ReadingErrors};
use crate::frame::{LinkReading, SensorFrame};
use crate::friction::{SlipEvent, WheelFriction};
use crate::ground::GroundPoint;
use crate::settings::{EstimatorSettings, KalmanMethod, Method, NoiseBudget, PaperMethod};
use crate::statics::LOAD_PARAMETERS;
use robhaz_model::{LoadShift, Units};

// Each struct is taken apart field by field: a field that is added does not compile here until its
// unit is known.

/// Settings in these units.
pub(crate) fn settings_in(units: &Units, settings: &EstimatorSettings) -> EstimatorSettings {
    let EstimatorSettings {
        masses,
        sides,
        load_shift,
        method,
        viscous_damping,
        gear_efficiency,
        compression,
        moment_lever,
        nonnegative,
        budget,
    } = *settings;
    EstimatorSettings {
        method: method_in(units, method),
        viscous_damping: viscous_damping / (units.torque() * units.time),
        compression: compression / units.length,
        moment_lever: moment_lever / units.length,
        budget: budget_in(units, &budget),
        load_shift: load_shift_in(units, load_shift),
        // Choices and ratios.
        masses,
        sides,
        gear_efficiency,
        nonnegative,
    }
}

fn load_shift_in(units: &Units, shift: LoadShift) -> LoadShift {
    let LoadShift {
        height_over_half_track,
        off_centre,
        share_at,
        push_at,
        push_height,
    } = shift;
    LoadShift {
        share_at: share_at.map(|place| place / units.length),
        push_at: push_at.map(|place| place / units.length),
        push_height: push_height / units.length,
        height_over_half_track,
        off_centre,
    }
}

fn method_in(units: &Units, method: Method) -> Method {
    match method {
        Method::Paper(PaperMethod {
            observer_pole,
            crossover_time,
        }) => Method::Paper(PaperMethod {
            observer_pole: observer_pole * units.time,
            crossover_time: crossover_time / units.time,
        }),
        Method::Kalman(KalmanMethod {
            contact_angles,
            inertia,
            whitening,
            parity,
            rolling,
        }) => Method::Kalman(KalmanMethod {
            // Choices.
            contact_angles,
            inertia,
            whitening,
            parity,
            rolling,
        }),
    }
}

pub(crate) fn budget_in(units: &Units, budget: &NoiseBudget) -> NoiseBudget {
    let NoiseBudget {
        encoder_counts,
        jitter,
        torque_noise,
        torque_offset,
        torque_gain,
        gear_friction,
        rolling_resistance,
        pin_moment,
        inclination_noise,
        inclination_bias,
        specific_force,
        inclination_lag,
        inclination_place,
        rate_noise,
        rate_bias,
        rate_walk,
        contact_angle,
        contact_angle_time,
        body_cg,
        link_mass,
        payload,
        load_covariance,
        wheel_radius,
        toe,
        steering,
        cross_slope,
    } = *budget;
    NoiseBudget {
        jitter: jitter / units.time,
        torque_noise: torque_noise / units.torque(),
        torque_offset: torque_offset / units.torque(),
        gear_friction: gear_friction / units.torque(),
        pin_moment: pin_moment / units.torque(),
        inclination_lag: inclination_lag / units.time,
        inclination_place: inclination_place / units.length,
        rate_noise: rate_noise * units.time,
        rate_bias: rate_bias * units.time,
        rate_walk: rate_walk * units.time * robhaz_model::sqrt(units.time),
        contact_angle_time: contact_angle_time / units.time,
        body_cg: body_cg / units.length,
        payload: payload / units.mass,
        load_covariance: load_covariance.map(|covariance| {
            let mut of_loads = [units.mass * units.length; LOAD_PARAMETERS];
            of_loads[0] = units.mass;
            covariance.in_units(&of_loads)
        }),
        // Angles, counts, ratios and choices.
        encoder_counts,
        torque_gain,
        rolling_resistance,
        inclination_noise,
        inclination_bias,
        specific_force,
        contact_angle,
        link_mass,
        wheel_radius,
        toe,
        steering,
        cross_slope,
    }
}

/// Readings in these units.
pub(crate) fn frame_in(units: &Units, frame: &SensorFrame) -> SensorFrame {
    let SensorFrame {
        time,
        wheel_angle,
        motor_torque,
        link1,
        link2,
        contact_angle,
    } = *frame;
    let torque = 1.0 / units.torque();
    let link = |read: LinkReading| LinkReading {
        inclination: read.inclination,
        rate: read.rate.map(|rate| rate * units.time),
        rate_error: read.rate_error * units.time,
    };
    SensorFrame {
        time: time / units.time,
        motor_torque: motor_torque.map(|read| read.map(|t| t * torque)),
        link1: link(link1),
        link2: link(link2),
        // Angles.
        wheel_angle,
        contact_angle,
    }
}

/// Puts an estimate into SI, of the readings `at` a time, s.
pub(crate) fn estimate_out(units: &Units, estimate: &mut Estimate, at: f64) {
    let (length, force) = (units.length, units.force());
    estimate.scale_forces(force, 0.0);
    let Estimate {
        time,
        // Scaled above.
        normal_force: _,
        traction: _,
        pin_force: _,
        residual,
        // Angles.
        contact_angle: _,
        posture: _,
        pin_from_q,
        parity,
        kalman,
        flags: _,
    } = estimate;
    *time = at;
    // Moments, where the first two are forces.
    for moment in &mut residual[2..] {
        *moment *= length;
    }
    for pin in pin_from_q {
        *pin *= length;
    }
    if let Some(Parity { value, sigma }) = parity {
        (*value, *sigma) = (*value * force, *sigma * force);
    }
    if let Some(report) = kalman {
        report_out(units, report);
    }
}

fn report_out(units: &Units, report: &mut KalmanReport) {
    let KalmanReport {
        // Scaled with the forces.
        covariance: _,
        // Angles.
        contact_angle_sigma: _,
        angle_sigma: _,
        reading_errors,
        contact,
        friction,
        // Ratios and flags.
        health: _,
        torque_scale: _,
    } = report;
    for wheel in contact {
        let ContactEstimate {
            state: _,
            sliding: _,
            slip,
        } = wheel;
        *slip *= units.speed();
    }
    for wheel in friction {
        friction_out(units, wheel);
    }
    let ReadingErrors {
        torque_offset,
        gear_friction,
        // A ratio.
        rolling_resistance: _,
        contact_angle: _,
        rate_bias,
    } = reading_errors;
    let torque = units.torque();
    for (value, sigma) in torque_offset.iter_mut().chain([gear_friction]) {
        (*value, *sigma) = (*value * torque, *sigma * torque);
    }
    for (value, sigma) in rate_bias {
        (*value, *sigma) = (*value / units.time, *sigma / units.time);
    }
}

fn friction_out(units: &Units, wheel: &mut WheelFriction) {
    let WheelFriction {
        // Ratios T/N.
        needed: _,
        offset: _,
        peak: _,
        margin: _,
        // Over its limit.
        slip_noise: _,
        slid,
        slip_event,
    } = wheel;
    *slid = slid.map(|slid| slid * units.length);
    if let Some(event) = slip_event {
        let SlipEvent {
            // Ratios T/N.
            mu_max: _,
            sigma: _,
            systematic: _,
            load,
            age,
            place,
        } = event;
        *load *= units.force();
        *age *= units.time;
        *place = place.map(|place| place * units.length);
    }
}

/// A point of the ground in SI.
pub(crate) fn point_out(units: &Units, point: GroundPoint) -> GroundPoint {
    let GroundPoint {
        x,
        axle_x,
        sigma_x,
        height,
        sigma_height,
        slope,
        sigma_slope,
        friction,
        section,
    } = point;
    GroundPoint {
        x: x * units.length,
        axle_x: axle_x * units.length,
        sigma_x: sigma_x * units.length,
        height: height * units.length,
        sigma_height: sigma_height * units.length,
        // Angles, ratios, a number.
        slope,
        sigma_slope,
        friction,
        section,
    }
}
