//! The torques against the weight: what is taken of one sample, and what it changes.

use super::BestFilters;
use crate::contact::{ContactEstimate, ContactState};
use crate::flags::Flags;
use crate::frame::Instant;
use crate::health::DRIVING_SPEED;
use crate::nominal::Nominal;
use crate::settings::NoiseBudget;
use crate::statics::{Arms, Forces};
use crate::torque_scale::{Rolling, ScaleFilter};
use robhaz_model::{Bar, GRAVITY, Robot, Vec2, perp};

/// Steepest way of an axle, as dy/dx. On a steeper one an error of its place is one of its height,
/// and impacts take energy.
/// Chosen; held by `tests/check/torque_scale.rs`.
const STEEPEST: f64 = 0.6;

/// Longest step with which the torque of the ground is followed, s: 50 Hz.
/// Chosen; held by `tests/check/torque_scale.rs`.
const LONGEST_STEP: f64 = 0.0205;

/// For a robot whose torques err as the budget states.
pub(super) fn filter(robot: &Robot, budget: &NoiseBudget) -> ScaleFilter {
    let [front, middle, _] = &robot.geometry.axles;
    // Friction is common to all wheels; offsets are not.
    let torques = 3.0 * budget.gear_friction + robhaz_model::sqrt(3.0) * budget.torque_offset;
    let rolling = budget.rolling_resistance * 3.0 * robot.mean_wheel_load();
    let resisted = torques / robot.geometry.wheel_radius + rolling;
    let between = front.x - middle.x;
    ScaleFilter::new(between, resisted, budget.torque_gain, budget.payload)
}

impl BestFilters {
    /// Takes the sample of `instant`, in the posture of `arms`. Readings that are held for long do
    /// not count.
    pub(super) fn find_scale(
        &mut self,
        nominal: &Nominal,
        instant: &Instant<'_>,
        arms: &Arms,
        contact: &[ContactEstimate; 3],
    ) {
        let on_one = |contact: &ContactEstimate| contact.state == ContactState::OneContact;
        let holds = contact.iter().all(on_one)
            && instant.dt < LONGEST_STEP
            && !instant.flags.contains(Flags::SENSOR_STALE)
            && !self.motion.is_after_impact()
            && !self.standing.stands;
        let rolling = holds.then(|| self.rolling_robot(nominal, arms)).flatten();
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
        let [front, middle, _] = &arms.axles;
        Some(Rolling {
            power,
            damping: damped,
            speed: velocity.x,
            axles: [front.x, middle.x],
            energy: [front, middle].map(|axle| GRAVITY * (moment - total * axle.y)),
            kinetic,
        })
    }

    /// Adds what an error of the torques' scale and one of the mass would change to the covariance
    /// of the forces; `by_scale` is what an error of 1 of the scale changes, N.
    pub(super) fn consider_scale(&self, by_scale: &[f64; 6], forces: &mut Forces) {
        let deviation = self.scale.deviation;
        let ([t1, t2, t3], [n1, n2, n3]) = (forces.traction, forces.normal);
        forces.add_error(&by_scale.map(|force| deviation.tractions * force));
        forces.add_error(&[t1, n1, t2, n2, t3, n3].map(|force| deviation.forces * force));
    }
}
