//! Division of a step during impacts and where the friction is stiff.
//!
//! The division depends on the state at the start of a step alone, so that runs repeat.

use crate::contact::ContactLaw;
use crate::friction::FrictionLaw;
use crate::setup::PlantSetup;
use crate::stability::{STABLE_SHARE, longest_step_for_friction};

/// Largest number of parts of a step. An impact on an edge takes all of them: at the default step a part is 16 us, and
/// a wheel is stopped in 75 us. Stiff friction takes as many as it needs.
pub const MOST_PARTS: u32 = 8;
/// Largest number of pieces of a part. Pieces are needed if the normal force of an impact would make the friction
/// unstable: above 6.6 kN in eight parts, with the default friction.
const MOST_PIECES: u32 = 32;

/// Stiffness of the laws, and the loads at which it is evaluated.
pub(super) struct StepControl {
    contact: ContactLaw,
    /// Mean wheel load, N.
    mean_load: f64,
    /// Penetration under the mean wheel load, m.
    mean_penetration: f64,
    /// Longest step for the friction times N, N s.
    friction_limit: f64,
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
    pub fn new(setup: &PlantSetup) -> Self {
        let stretches = setup.stretches.iter().map(|s| s.mu_s);
        let steepest = FrictionLaw {
            mu_s: stretches.fold(setup.friction.mu_s, f64::max),
            ..setup.friction
        };
        Self {
            contact: setup.contact,
            mean_load: setup.robot.mean_wheel_load(),
            mean_penetration: setup.mean_penetration(),
            friction_limit: longest_step_for_friction(&steepest, &setup.rolling, &setup.robot, 1.0),
        }
    }

    /// Upper bound of the rise of N in a step (s), N, from damping and from stiffness at the mean load.
    fn rise(&self, wheels: &WheelState, step: f64) -> f64 {
        let law = &self.contact;
        let tangent = law.stiffness * law.exponent * self.mean_penetration.powf(law.exponent - 1.0);
        (law.damping + tangent * step) * wheels.approach
    }

    /// Number of parts of the next step (s). An impact is a step in which N could rise by more than the mean load.
    pub fn parts(&self, wheels: &WheelState, step: f64) -> u32 {
        if self.rise(wheels, step) > self.mean_load {
            return MOST_PARTS;
        }
        // Stability of the friction at the present N.
        (1..MOST_PARTS)
            .find(|parts| step < f64::from(*parts) * self.friction_limit / wheels.normal_force)
            .unwrap_or(MOST_PARTS)
    }

    /// Number of pieces of a part of a step, `part` (s). An impact of kilonewtons can make the friction unstable in
    /// this part, and can begin after the start of the step.
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
