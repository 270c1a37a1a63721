//! Whether the readings agree with each other, and the torques with the weight.

use super::KalmanFilters;
use crate::common::DRIVING_SPEED;
use crate::contact::{ContactEstimate, ContactState};
use crate::flags::{Channels, Flags};
use crate::frame::{Held, Inputs};
use crate::health::{Health, HealthSample, Innovations, RollingRobot, WheelReadings};
use crate::nominal::{Instant, Nominal};
use crate::settings::NoiseBudget;
use crate::statics::Arms;
use crate::torque_scale::{Rolling, ScaleFilter};
use robhaz_model::{Bar, GRAVITY, Robot, Vec2, perp};

/// Steepest way of an axle, as dy/dx. On a steeper one an error of its place is one of its height,
/// and impacts take energy.
/// Chosen; held by `tests/check/torque_scale.rs`.
const STEEPEST: f64 = 0.6;

/// For a robot whose torques err as the budget states, and whose `trailing` wheel (1 middle, 2 rear)
/// comes to where the front wheel was.
pub(super) fn scale_filter(robot: &Robot, budget: &NoiseBudget, trailing: usize) -> ScaleFilter {
    let [front, middle, rear] = &robot.geometry.axles;
    let trailing = if trailing == 2 { rear } else { middle };
    // Friction is common to all wheels; offsets are not.
    let torques = 3.0 * budget.gear_friction + robhaz_model::sqrt(3.0) * budget.torque_offset;
    let rolling = budget.rolling_resistance * 3.0 * robot.mean_wheel_load();
    let resisted = torques / robot.geometry.wheel_radius + rolling;
    let between = front.x - trailing.x;
    ScaleFilter::new(between, resisted, budget.torque_gain)
}

impl KalmanFilters {
    /// Health after the innovations of this sample. They count while the robot drives and every
    /// wheel rolls on one contact: elsewhere the constraints do not hold. A reading that has been missing
    /// for long has a flag of its own.
    pub(super) fn check_health(
        &mut self,
        instant: &Instant<'_>,
        innovations: &Innovations,
        contact: &[ContactEstimate; 3],
    ) -> Health {
        let nominal = instant.nominal;
        let on_one = |contact: &ContactEstimate| contact.state == ContactState::OneContact;
        let touches = contact.iter().all(on_one) && !instant.flags.contains(Flags::SENSOR_STALE);
        let model_holds = touches
            && !contact.iter().any(|contact| contact.sliding)
            && !self.motion.is_after_impact();
        let has_noise = nominal.settings.budget.torque_noise > 0.0;
        let rim = [0, 1, 2].map(|i| {
            let spin = self.wheels[i].settled_speed().unwrap_or(0.0);
            (nominal.robot.geometry.wheel_radius * spin).abs()
        });
        // A robot that settles moves, too, but its wheels do not.
        let fastest = rim.into_iter().fold(0.0, f64::max);
        let speed = self.motion.speed();
        // While it starts, its wheels roll from a greater speed on.
        let least = DRIVING_SPEED.max(self.motion.least_speed());
        let drives = speed > least && fastest > least;
        let varying = |i: usize| {
            let torque = instant.inputs.motor_torque[i].now();
            torque.filter(|_| has_noise && rim[i] > DRIVING_SPEED)
        };
        let (rate, inclination) = (&instant.inputs.rate, &instant.inputs.inclination);
        let sample = HealthSample {
            innovations,
            varying_torque: [varying(0), varying(1), varying(2)],
            links: [0, 1].map(|k| rate[k].recent().zip(inclination[k].recent())),
            rim: fastest,
            rate_bias: nominal.settings.budget.rate_bias,
            // Wheels that are commanded apart, or dragged, do not answer to their own speeds alone.
            wheels: wheel_readings(instant.inputs)
                .filter(|_| !(self.across.shares || self.across.turns)),
            drives,
            touching: (touches && !self.standing.stands).then_some(speed.min(fastest)),
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
        for (wheel, stuck) in self.wheels.iter_mut().zip(self.health.stuck()) {
            wheel.stuck = stuck;
        }
        let mut health = self.health.health(&nominal.robot.geometry.carriers);
        if self.scale.contradicts() {
            health.faulty |= Channels::TORQUE_SCALE;
        }
        health
    }

    /// Takes the sample of `instant`, in the posture of `arms`. Readings that are held for long do
    /// not count. The torques of one side of two do not hold its weight alone: nothing is found; of a
    /// whole rover both sides together find it, of what is noted here.
    pub(super) fn find_scale(
        &mut self,
        instant: &Instant<'_>,
        arms: &Arms,
        contact: &[ContactEstimate; 3],
    ) {
        let nominal = instant.nominal;
        let on_one = |contact: &ContactEstimate| contact.state == ContactState::OneContact;
        let holds = contact.iter().all(on_one)
            && !instant.flags.contains(Flags::SENSOR_STALE)
            && !self.motion.is_after_impact()
            && !self.standing.stands
            && (nominal.other_side.is_none() || self.across.shares);
        let rolling = holds.then(|| self.rolling_robot(nominal, arms)).flatten();
        if nominal.other_side.is_some() {
            self.rolling = rolling;
            return;
        }
        let (weight, mass) = (3.0 * nominal.mean_load, nominal.mass_sigma);
        let scale = &mut self.scale;
        if scale.update(rolling.as_ref(), weight, mass, instant.dt) {
            self.motion.discard_errors(&nominal.settings.budget);
        }
    }

    /// Power and energy; `None` where an axle hardly moves, or on a steep way.
    fn rolling_robot(&self, nominal: &Nominal, arms: &Arms) -> Option<Rolling> {
        let (geometry, masses) = (&nominal.robot.geometry, &nominal.masses);
        let velocity = self.motion.velocity();
        let damping = nominal.settings.viscous_damping;
        let (mut power, mut damped) = ([0.0; 3], 0.0);
        for (i, axle) in arms.axles.iter().enumerate() {
            let rate = self.links[geometry.carriers[i].index()].smooth_rate;
            let of_axle: Vec2 = velocity + perp(*axle) * rate;
            let ahead = of_axle.x.abs();
            // Written so that a NaN leaves, too.
            if !(ahead > DRIVING_SPEED && of_axle.y.abs() < STEEPEST * ahead) {
                return None;
            }
            let speed = libm::copysign(robhaz_model::sqrt(of_axle.norm_squared()), of_axle.x);
            let rim = speed / geometry.wheel_radius + rate;
            let torque = self.wheels[i].steady_torque(damping);
            power[i] = torque * rim;
            damped += (torque - self.wheels[i].observer.ground_torque().0) * rim;
        }
        let mut moment = masses.body * arms.centres[Bar::Body as usize].y;
        for bar in Bar::LINKS {
            moment += masses.links[bar as usize - 1] * arms.centres[bar as usize].y;
        }
        for axle in &arms.axles {
            moment += masses.wheel * axle.y;
        }
        let total = nominal.robot.mass.total();
        let kinetic = 0.5 * total * velocity.norm_squared();
        let (front, trailing) = (arms.axles.first()?, arms.axles.get(self.across.trailing)?);
        Some(Rolling {
            power,
            damping: damped,
            speed: velocity.x,
            axles: [front.x, trailing.x],
            energy: [front, trailing].map(|axle| GRAVITY * (moment - total * axle.y)),
            kinetic,
        })
    }
}

/// Torques and encoders, with held readings; `None` if one is stale or counts from a new zero.
fn wheel_readings(inputs: &Inputs) -> Option<WheelReadings> {
    let (torque, angle) = (&inputs.motor_torque, inputs.encoder.map(|e| e.angle));
    let stale = |held: &Held| held.age > Inputs::STALE_AFTER;
    if inputs.encoder.iter().any(|e| e.new_zero) || torque.iter().chain(&angle).any(stale) {
        return None;
    }
    Some(WheelReadings {
        torque: torque.map(|held| held.value),
        angle: angle.map(|held| held.value),
    })
}
