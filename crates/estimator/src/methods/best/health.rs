//! Health of the readings: what the monitor takes of one sample.

use super::BestFilters;
use crate::contact::{ContactEstimate, ContactState};
use crate::frame::{Held, Inputs, Instant};
use crate::health::{
    Channels, DRIVING_SPEED, Health, HealthSample, Innovations, RollingRobot, TurnReadings,
    WheelReadings,
};
use crate::nominal::Nominal;

impl BestFilters {
    /// Health after the innovations of this sample. They count while the robot drives and every
    /// wheel rolls on one contact: elsewhere the constraints do not hold.
    pub(super) fn check_health(
        &mut self,
        nominal: &Nominal,
        instant: &Instant<'_>,
        innovations: &Innovations,
        contact: &[ContactEstimate; 3],
    ) -> Health {
        let rolls = |contact: &ContactEstimate| {
            contact.state == ContactState::OneContact && !contact.sliding
        };
        let model_holds = contact.iter().all(rolls) && !self.motion.is_after_impact();
        let speed = self.motion.velocity().norm_squared();
        let drives = speed > DRIVING_SPEED * DRIVING_SPEED;
        let has_noise = nominal.settings.budget.torque_noise > 0.0;
        let rim = [0, 1, 2].map(|i| {
            let spin = self.wheels[i].settled_speed().unwrap_or(0.0);
            (nominal.robot.geometry.wheel_radius * spin).abs()
        });
        let varying = |i: usize| {
            let torque = instant.inputs.motor_torque[i].now();
            torque.filter(|_| has_noise && rim[i] > DRIVING_SPEED)
        };
        let sample = HealthSample {
            innovations,
            varying_torque: [varying(0), varying(1), varying(2)],
            links: [0, 1].map(|k| turn_readings(instant.inputs, k)),
            rim: rim.into_iter().fold(0.0, f64::max),
            rate_bias: nominal.settings.budget.rate_bias,
            wheels: wheel_readings(instant.inputs),
            drives,
            model_holds,
            dt: instant.dt,
        };
        let (mass, radius) = (&nominal.robot.mass, nominal.robot.geometry.wheel_radius);
        let of_wheels = 3.0 * (mass.wheel_inertia + mass.rotor_inertia);
        let robot = RollingRobot {
            inertia: of_wheels + mass.total() * radius * radius,
            damping: 3.0 * nominal.settings.viscous_damping,
        };
        self.health.update(&sample, &robot);
        let mut health = self.health.health(&nominal.robot.geometry.carriers);
        if self.scale.contradicts {
            health.faulty |= Channels::TORQUE_SCALE;
        }
        health
    }
}

/// Gyroscope and inclinometer of link `k`, held; `None` if one is stale or has not been read.
fn turn_readings(inputs: &Inputs, k: usize) -> Option<TurnReadings> {
    let (rate, inclination) = (&inputs.rate[k], &inputs.inclination[k]);
    let serves = |held: &Held| held.known && held.age <= Inputs::STALE_AFTER;
    (serves(rate) && serves(inclination)).then_some(TurnReadings {
        rate: rate.value,
        inclination: inclination.value,
    })
}

/// Torques and encoders, with held readings; `None` if one is stale or counts from a new zero.
fn wheel_readings(inputs: &Inputs) -> Option<WheelReadings> {
    let (torque, angle) = (&inputs.motor_torque, &inputs.wheel_angle);
    let stale = |held: &Held| held.age > Inputs::STALE_AFTER;
    if inputs.new_zero.contains(&true) || torque.iter().chain(angle).any(stale) {
        return None;
    }
    Some(WheelReadings {
        torque: torque.map(|held| held.value),
        angle: angle.map(|held| held.value),
    })
}
