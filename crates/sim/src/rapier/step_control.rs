//! Division of a step during impacts and where contact, friction or drive are stiff.
//!
//! The division depends on the state at the start of a step and on the division of the step before,
//! so that runs repeat.

use crate::contact::ContactLaw;
use crate::friction::FrictionLaw;
use crate::setup::PlantSetup;
use crate::stability::{
    MOST_PARTS, STABLE_SHARE, largest_integral_gain, largest_slope, longest_step_for_contact,
    longest_step_for_friction,
};

/// Largest number of pieces of a part. Pieces are needed if the normal force of an impact would
/// make the friction unstable: above 6.7 kN in 13 parts, with the default friction.
const MOST_PIECES: u32 = 32;
/// Rise of N in a step at which an impact ends, as a share of that at which it begins. Each change
/// of the step disturbs N by some tenths of a newton, because the gaps of the joints belong to a
/// step; at a share of 1 an impact that fades changed it many times.
const END_OF_IMPACT: f64 = 0.8;

/// Stiffness of the laws, and the loads at which it is evaluated.
pub(super) struct StepControl {
    contact: ContactLaw,
    /// Mean wheel load, N.
    mean_load: f64,
    /// Penetration under the mean wheel load, m.
    mean_penetration: f64,
    /// Longest step for the friction times N, N s.
    friction_limit: f64,
    /// Number of parts that contact and drive need.
    fewest: u32,
    /// Whether the last step was part of an impact.
    impact: bool,
}

/// The state of the wheels on which the division depends.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct WheelState {
    /// Largest N of a wheel, N.
    pub normal_force: f64,
    /// Largest speed of a wheel into the ground, m/s.
    pub approach: f64,
}

impl StepControl {
    /// For steps of the length `step`, s.
    pub fn new(setup: &PlantSetup, step: f64) -> Self {
        let stretches = setup.stretches.iter().map(|s| s.mu_s);
        let steepest = FrictionLaw {
            mu_s: stretches.fold(setup.friction.mu_s, f64::max),
            ..setup.friction
        };
        Self {
            contact: setup.contact,
            mean_load: setup.robot.mean_wheel_load(),
            mean_penetration: setup.contact.mean_penetration(&setup.robot),
            friction_limit: longest_step_for_friction(&steepest, &setup.robot, 1.0),
            fewest: (1..MOST_PARTS)
                .find(|parts| is_stable(setup, step / f64::from(*parts)))
                .unwrap_or(MOST_PARTS),
            impact: false,
        }
    }

    /// Upper bound of the rise of N in a step (s), N, from damping and from stiffness at the mean
    /// load.
    fn rise(&self, wheels: &WheelState, step: f64) -> f64 {
        let law = &self.contact;
        let tangent = law.stiffness * law.exponent * self.mean_penetration.powf(law.exponent - 1.0);
        (law.damping + tangent * step) * wheels.approach
    }

    /// Number of parts of the next step (s), and whether it is part of an impact. In an impact N
    /// could rise by more than the mean load in a step. It begins, too, where a contact is new or
    /// the step will find a new one: the step `knows` not all of its contacts.
    pub fn divide(&mut self, wheels: &WheelState, step: f64, knows: bool) -> (u32, bool) {
        let share = if self.impact { END_OF_IMPACT } else { 1.0 };
        self.impact = !knows || self.rise(wheels, step) > share * self.mean_load;
        let parts = if self.impact {
            MOST_PARTS
        } else {
            // Stability of the friction at the present N.
            (self.fewest..MOST_PARTS)
                .find(|parts| step < f64::from(*parts) * self.friction_limit / wheels.normal_force)
                .unwrap_or(MOST_PARTS)
        };
        (parts, self.impact)
    }

    /// Number of pieces of a part of a step, `part` (s). An impact of kilonewtons can make the
    /// friction unstable in this part, and can begin after the start of the step.
    pub fn pieces(&self, wheels: &WheelState, part: f64) -> u32 {
        let load = wheels.normal_force.max(self.rise(wheels, part));
        if part * load < self.friction_limit / STABLE_SHARE {
            return 1;
        }
        (1..MOST_PIECES)
            .find(|pieces| part * load < f64::from(*pieces) * self.friction_limit)
            .unwrap_or(MOST_PIECES)
    }
}

/// Whether contact and drive are stable with steps of this length, s.
fn is_stable(setup: &PlantSetup, step: f64) -> bool {
    let (drive, robot) = (&setup.drive, &setup.robot);
    step <= longest_step_for_contact(&setup.contact, robot)
        && largest_slope(robot, step).is_some_and(|largest| drive.slope() <= largest)
        && drive.ki <= largest_integral_gain(drive, step)
}
